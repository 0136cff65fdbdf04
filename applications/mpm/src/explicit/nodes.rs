//! The nodes of the active cells in one step: boundary values, velocities, accelerations.

use super::kratos_faults::KratosFaults;
use super::to_grid::NodalSums;
use crate::active::ActiveCells;
use crate::space::Space;
use crate::variables::DISPLACEMENT;
use bia_kernel::error::Failure;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::{ActiveDofs, NodalFrames};

/// Share of the largest mass by which one may be negative: points may stand a little outside their cells.
const NEGLIGIBLE: f64 = 1e-5;

/// State of the active nodes; all vectors by active dof but `mass`, which `sums` holds by node.
#[derive(Default)]
pub struct Nodes {
    /// Numbers of the active nodes; fixed components.
    pub dofs: ActiveDofs,
    /// Frames of nodes that slide along walls.
    pub frames: NodalFrames,
    /// Mass, momentum, force.
    pub sums: NodalSums,
    /// Velocity; after the step, the one that deformed the points last.
    pub velocity: Vec<f64>,
    /// Velocity that carries the points.
    pub carrying: Vec<f64>,
    /// Displacement in the total frame, where the transfer asks for it; else empty.
    pub displacement: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
    /// Force that holds the fixed components.
    pub reaction: Vec<f64>,
    imposed: Vec<f64>,
    /// Velocities imposed in the last step by grid node, NaN where free; empty while none moves.
    last: Vec<[f64; 3]>,
    least_mass: f64,
    /// Fixed components of the mesh's nodes and of the functions, where these are not the same.
    fixed: Vec<[bool; 3]>,
    held: Vec<[bool; 3]>,
}

impl Nodes {
    /// Numbers the nodes of the active cells.
    pub fn renumber(&mut self, space: &Space, active: &ActiveCells, dimension: usize) {
        self.dofs = space.active_dofs(&active.cells, dimension);
    }

    /// Sets all to zero and reads the fixed components. A displacement u imposed on one acts as the
    /// velocity u/Δt; its acceleration is the change of that velocity since the last step.
    pub fn start(&mut self, grid: &ModelPart, space: &Space, time_step: f64, faults: KratosFaults) {
        self.sums.reset(&self.dofs);
        let (order, block) = (self.dofs.order(), self.dofs.block());
        for values in [&mut self.velocity, &mut self.acceleration, &mut self.imposed] {
            values.clear();
            values.resize(order, 0.0);
        }
        self.dofs.fixed_mut().fill(false);
        self.fix(grid, space, time_step, faults);
        let slides = if faults.ignores_walls() { &[] } else { grid.node_fields.slides(&DISPLACEMENT) };
        self.frames = NodalFrames::new(block, &self.dofs, slides);
    }

    fn fix(&mut self, grid: &ModelPart, space: &Space, time_step: f64, faults: KratosFaults) {
        let block = self.dofs.block();
        let Some(fixed) = grid.node_fields.fixed(&DISPLACEMENT) else { return };
        if !space.is_mesh() && self.fixed != fixed {
            (self.fixed, self.held) = (fixed.to_vec(), space.held(fixed).into_owned());
        }
        let fixed = if space.is_mesh() { fixed } else { &self.held[..] };
        let values = space.at_anchors(grid.node_fields.vector(&DISPLACEMENT).unwrap_or_default());
        let imposed =
            |node: usize, a: usize| values.get(node).map_or(0.0, |u| faults.imposed_velocity(u[a], time_step));
        for number in 0..self.dofs.nodes().len() {
            let node = self.dofs.nodes()[number] as usize;
            for a in (0..block).filter(|&a| fixed[node][a]) {
                let dof = number * block + a;
                self.dofs.fixed_mut()[dof] = true;
                self.imposed[dof] = imposed(node, a);
                let last = self.last.get(node).map_or(f64::NAN, |last| last[a]);
                if last.is_finite() {
                    self.acceleration[dof] = (self.imposed[dof] - last) / time_step;
                }
            }
        }
        // Only walls that move are remembered, and all their nodes, active or not.
        if !self.last.is_empty() || self.imposed.iter().any(|v| *v != 0.0) {
            self.last.resize(space.len(), [f64::NAN; 3]);
            for (node, last) in self.last.iter_mut().enumerate() {
                *last = std::array::from_fn(|a| if fixed[node][a] { imposed(node, a) } else { f64::NAN });
            }
        }
    }

    /// Fixes the mass below which nodes are left alone, once the masses are there.
    ///
    /// # Errors
    /// A function whose lumped mass is negative: with polynomials of degree 2 and more that change sign.
    pub fn weigh(&mut self, faults: KratosFaults) -> Result<(), Failure> {
        let largest = self.sums.mass.iter().copied().fold(0.0, f64::max);
        self.least_mass = faults.least_mass(largest);
        let least = self.sums.mass.iter().copied().fold(0.0, f64::min);
        if least >= -NEGLIGIBLE * largest {
            return Ok(());
        }
        let what = format!("a function of the grid has the negative lumped mass {least:e} kg");
        let advice = "\"consistent_mass_matrix\": true, more points in each cell, a lower basis_order or b_spline";
        Err(Failure::new(what, advice))
    }

    fn mass(&self, dof: usize) -> Option<f64> {
        Some(self.sums.mass[dof / self.dofs.block()]).filter(|mass| *mass > self.least_mass)
    }

    /// Velocity from momentum, imposed where fixed.
    pub fn find_velocity(&mut self) {
        for dof in 0..self.dofs.order() {
            self.velocity[dof] = match (self.dofs.fixed()[dof], self.mass(dof)) {
                (true, _) => self.imposed[dof],
                (false, Some(mass)) => self.sums.momentum[dof] / mass,
                (false, None) => 0.0,
            };
        }
        self.frames.slide(&mut self.velocity);
    }

    /// Momentum over mass, whatever is imposed.
    pub fn mean_velocity(&self) -> Vec<f64> {
        let of = |dof: usize| self.mass(dof).map_or(0.0, |mass| self.sums.momentum[dof] / mass);
        (0..self.dofs.order()).map(of).collect()
    }

    /// Replaces the accelerations of the free dofs.
    pub fn set_free_accelerations(&mut self, accelerations: &[f64]) {
        for (dof, acceleration) in self.acceleration.iter_mut().enumerate() {
            if !self.dofs.fixed()[dof] {
                *acceleration = accelerations[dof];
            }
        }
        self.frames.slide(&mut self.acceleration);
    }

    /// Accelerations, reactions, and momentum after the time `impulse`.
    pub fn accelerate(&mut self, impulse: f64) {
        self.reaction.clear();
        self.reaction.resize(self.dofs.order(), 0.0);
        for dof in 0..self.dofs.order() {
            let mass = self.mass(dof);
            if self.dofs.fixed()[dof] {
                let mass = mass.unwrap_or(0.0);
                self.reaction[dof] = mass * self.acceleration[dof] - self.sums.force[dof];
                self.sums.momentum[dof] = mass * self.imposed[dof];
            } else {
                self.acceleration[dof] = mass.map_or(0.0, |mass| self.sums.force[dof] / mass);
                self.sums.momentum[dof] += impulse * self.sums.force[dof];
            }
        }
        if self.frames.is_empty() {
            return;
        }
        self.frames.slide(&mut self.acceleration);
        self.frames.slide(&mut self.sums.momentum);
        for dof in 0..self.dofs.order() {
            self.reaction[dof] = self.mass(dof).unwrap_or(0.0) * self.acceleration[dof] - self.sums.force[dof];
        }
        self.frames.keep_held(&self.dofs, &mut self.reaction);
    }
}
