//! Velocity and acceleration of the grid at the start of a step, and the inertia they make.
//!
//! In the updated frame they are gathered from the points, Σ N m v / Σ N m. In the total frame the
//! functions stay with the material, so that the grid keeps its own motion from step to step: what
//! the transfer to the points and back would smooth, and order and energy of the time scheme with
//! it, is left as it is. A share of PIC ([`Implicit`]'s `flip_fraction`) brings the points' velocity
//! back in, and its dissipation.

use super::Implicit;
use super::mixed::Mixed;
use super::problem::Inertia;
use crate::points::MaterialPoints;
use crate::projection::ConsistentMass;
use crate::settings::Frame;
use bia_kernel::error::Error;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::scheme::Coefficients;
use bia_kernel::solving::{NonlinearSystem, System};

/// What the grid keeps from step to step, entry `number * D + component`; empty before the first.
#[derive(Default)]
pub struct Motion {
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
}

impl Implicit {
    /// Gathers mass, and momentum where the motion comes from the points.
    pub(super) fn gather(&mut self, points: &MaterialPoints) {
        let dynamic = self.dynamic();
        if dynamic || self.output.mass {
            self.sums.gather(&points.blocks, &self.active, &self.scene.space, &self.dofs, dynamic);
        }
    }

    /// The inertia of the step, once the increments of the held dofs are known.
    pub(super) fn prepare_inertia(
        &mut self,
        points: &MaterialPoints,
        grid: &ModelPart,
        time_step: f64,
    ) -> Result<(), Error> {
        self.inertia = None;
        let settings = &self.scene.settings;
        if !self.dynamic() {
            return Ok(());
        }
        let (conserves, newmark) = (settings.conserves_energy, settings.newmark);
        let consistent = settings.consistent_mass || conserves;
        let motion = if settings.discretisation.frame == Frame::Total {
            let Some(mut system) = self.system.take() else { return Ok(()) };
            let kept = self.keep_motion(points, grid, time_step, &mut system);
            self.system = Some(system);
            kept?;
            (self.motion.velocity.clone(), self.motion.acceleration.clone())
        } else {
            (self.by_mass(&self.sums.momentum), self.by_mass(&self.sums.inertia))
        };
        let starts = self.mixed.as_ref().is_some_and(Mixed::starts);
        self.inertia = Some(Inertia {
            coefficients: match (starts, conserves) {
                (true, _) => Coefficients::backward_euler(time_step),
                (_, true) => Coefficients::midpoint(time_step),
                _ => newmark.coefficients(time_step),
            },
            alpha: if conserves || starts { 0.0 } else { newmark.alpha },
            consistent,
            velocity: motion.0,
            acceleration: motion.1,
        });
        Ok(())
    }

    /// Nodal sums divided by the nodal masses.
    fn by_mass(&self, sums: &[f64]) -> Vec<f64> {
        let block = self.dofs.block();
        let at = |(dof, value): (usize, &f64)| {
            let mass = self.sums.mass[dof / block];
            if mass > f64::EPSILON { value / mass } else { 0.0 }
        };
        sums.iter().enumerate().map(at).collect()
    }

    /// Completes the motion that the grid keeps: at first from the points and the forces on them. Held
    /// dofs go with the velocity that their increments ask for.
    fn keep_motion(
        &mut self,
        points: &MaterialPoints,
        grid: &ModelPart,
        time_step: f64,
        system: &mut System,
    ) -> Result<(), Error> {
        let settings = &self.scene.settings;
        let consistent = settings.consistent_mass || settings.conserves_energy;
        let is_first = self.motion.velocity.len() != self.dofs.order();
        let mut motion = std::mem::take(&mut self.motion);
        let mass = ConsistentMass {
            blocks: &points.blocks,
            active: &self.active,
            space: &self.scene.space,
            dofs: &self.dofs,
            frames: &self.frames,
        };
        let from_points = is_first || settings.flip_fraction < 1.0;
        if from_points {
            motion.velocity = if consistent { vec![0.0; self.dofs.order()] } else { self.by_mass(&self.sums.momentum) };
        }
        let held = || self.dofs.fixed().iter().zip(&self.increments).enumerate().filter(|(_, (held, _))| **held);
        held().for_each(|(dof, (_, u))| motion.velocity[dof] = u / time_step);
        self.frames.slide(&mut motion.velocity);
        let has_pressures = self.mixed.is_some();
        if from_points && consistent {
            match has_pressures {
                true => mass.project(&mut mass.system(), &mut motion.velocity)?,
                false => mass.project(system, &mut motion.velocity)?,
            }
        }
        if settings.conserves_energy || (has_pressures && is_first) {
            // Neither the mid-point rule nor the first step with pressures looks at it.
            motion.acceleration = vec![0.0; self.dofs.order()];
        } else if is_first {
            let mut problem = self.problem(points, grid, time_step);
            problem.increments.fill(0.0);
            problem.assemble(system, false)?;
            motion.acceleration = match consistent {
                true => mass.accelerations(system, &system.rhs.clone())?,
                false => self.by_mass(&system.rhs),
            };
        }
        held().for_each(|(dof, _)| motion.acceleration[dof] = 0.0);
        self.frames.slide(&mut motion.acceleration);
        self.motion = motion;
        Ok(())
    }
}
