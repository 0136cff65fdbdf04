//! Velocity and acceleration of the grid at the start of a step, and the inertia they make.
//!
//! In the updated frame they are gathered from the points, Σ N m v / Σ N m. In the total frame the
//! functions stay with the material, so that the grid keeps its own motion from step to step: what
//! the transfer to the points and back would smooth, and order and energy of the time scheme with
//! it, is left as it is. A share of PIC ([`Implicit`]'s `flip_fraction`) brings the points' velocity
//! back in, and its dissipation.
//!
//! Held dofs move as their supports do in the total frame. In the updated frame points bring the motion of the
//! material beside, as in Kratos, which a support stops anew in each step, an error of first order in the
//! cells along it; `held_motion` "imposed" takes that of the support there, too.

use super::Implicit;
use super::mixed::Mixed;
use super::problem::Inertia;
use crate::points::MaterialPoints;
use crate::projection::{ConsistentMass, nearest_velocity};
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
    /// Velocity by which held functions moved in the last step, NaN where free; empty while none moves.
    pub held: Vec<[f64; 3]>,
}

/// How a held dof moves at the start of a step.
pub(super) struct HeldDof {
    dof: usize,
    velocity: f64,
    acceleration: f64,
}

impl Implicit {
    /// The motion of the held dofs at the start of a step, evenly accelerated from the velocity of the last step to
    /// that of this one, each the increment over the length of the step. Remembers the velocity of this one.
    /// Supports that begin to move have moved as the body did before; those at rest have been at rest,
    /// so that a body that is flung from them keeps its energy.
    fn held_motion(&mut self, points: &MaterialPoints, time_step: f64) -> Vec<HeldDof> {
        let moves = self.increments.iter().zip(self.dofs.fixed()).any(|(u, held)| *held && *u != 0.0);
        let of_body = if self.motion.held.is_empty() && moves {
            let by_mass = || self.by_mass(&self.sums.momentum);
            nearest_velocity(&points.blocks, &self.active, &self.scene.space, &self.dofs).unwrap_or_else(by_mass)
        } else {
            Vec::new()
        };
        let starts = self.mixed.as_ref().is_some_and(Mixed::starts);
        // Points take the acceleration of a jump with this weight now and with what is left of 1 in the next step;
        // the first step with pressures, backward Euler, has the weight 1.
        let late = if starts { 1.0 / (2.0 - self.scene.settings.point_gamma) } else { 0.5 };
        let (block, dofs, held) = (self.dofs.block(), &self.dofs, &mut self.motion.held);
        let of_step = |dof: usize| self.increments[dof] / time_step;
        let fixed = || dofs.fixed().iter().enumerate().filter(|(_, fixed)| **fixed).map(|(dof, _)| dof);
        let motion = |dof: usize| {
            let function = dofs.nodes()[dof / block] as usize;
            let remembered = || held.get(function).map(|last| last[dof % block]).filter(|last| last.is_finite());
            let before = of_body.get(dof).copied().filter(|_| of_step(dof) != 0.0);
            let last = before.or_else(remembered).unwrap_or_else(|| of_step(dof));
            let acceleration = (of_step(dof) - last) / time_step;
            HeldDof { dof, velocity: of_step(dof) - late * time_step * acceleration, acceleration }
        };
        let motions = fixed().map(motion).collect();
        if !held.is_empty() || moves {
            held.clear();
            held.resize(self.scene.space.len(), [f64::NAN; 3]);
            fixed().for_each(|dof| held[dofs.nodes()[dof / block] as usize][dof % block] = of_step(dof));
        }
        motions
    }

    /// Lets held dofs move as their supports do, and nodes slide along walls.
    fn hold(&self, held: &[HeldDof], [velocity, acceleration]: &mut [Vec<f64>; 2]) {
        for held in held {
            (velocity[held.dof], acceleration[held.dof]) = (held.velocity, held.acceleration);
        }
        self.frames.slide(velocity);
        self.frames.slide(acceleration);
    }

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
        let is_total = settings.discretisation.frame == Frame::Total;
        let gathers = !is_total && !settings.imposes_held_motion;
        let held = if gathers { Vec::new() } else { self.held_motion(points, time_step) };
        let motion = if is_total {
            let Some(mut system) = self.system.take() else { return Ok(()) };
            let kept = self.keep_motion(points, grid, time_step, &mut system, &held);
            self.system = Some(system);
            kept?;
            (self.motion.velocity.clone(), self.motion.acceleration.clone())
        } else {
            let mut motion = [self.by_mass(&self.sums.momentum), self.by_mass(&self.sums.inertia)];
            if !gathers {
                self.hold(&held, &mut motion);
            }
            let [velocity, acceleration] = motion;
            (velocity, acceleration)
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
        held: &[HeldDof],
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
        held.iter().for_each(|held| motion.velocity[held.dof] = held.velocity);
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
        held.iter().for_each(|held| motion.acceleration[held.dof] = held.acceleration);
        self.frames.slide(&mut motion.acceleration);
        self.motion = motion;
        Ok(())
    }
}
