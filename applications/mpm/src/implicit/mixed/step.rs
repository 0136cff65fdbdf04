//! Where the implicit solver's step meets the pressures: start values, solution, reactions, results.

use super::spreading::{Spreading, excess};
use super::{Mixed, MixedProblem};
use crate::implicit::Implicit;
use crate::points::{Block, MaterialPoints, compress};
use crate::room::room;
use crate::settings::{Frame, Regime};
use crate::variables::{DISPLACEMENT, PRESSURE, PRESSURE_REACTION};
use bia_constitutive::Shear;
use bia_kernel::error::Error;
use bia_kernel::linalg::LinearSolver;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::{Newton, NodalFrames, NonlinearSystem, StepReport, System};
use nalgebra::Matrix3;

impl Implicit {
    /// Start values of the pressures, and which dofs are held.
    ///
    /// A held pressure keeps what stands on its node. The others start from those of the points, but in
    /// statics from the last solution.
    pub(in crate::implicit) fn predict_pressures(&mut self, points: &MaterialPoints, grid: &mut ModelPart) {
        let Some(mixed) = &mut self.mixed else { return };
        let space = &self.scene.space;
        mixed.sums.gather(&points.blocks, &self.active, space, &self.dofs);
        let count = grid.nodes.len();
        let held = grid.node_fields.fixed(&PRESSURE).map_or(Vec::new(), <[_]>::to_vec);
        let column = grid.node_fields.scalar_mut(&PRESSURE, count);
        let is_held = |node: usize| held.get(node).is_some_and(|held| held[0]);
        let keeps = self.scene.settings.regime == Regime::Static;
        if !keeps {
            (0..count).filter(|&node| !is_held(node)).for_each(|node| column[node] = 0.0);
        }
        let block = self.dofs.block();
        let mut pressures = Vec::with_capacity(self.dofs.nodes().len());
        for (number, &node) in self.dofs.nodes().iter().enumerate() {
            let node = node as usize;
            let stays = is_held(node) || keeps;
            pressures.push(if stays { column[node] } else { mixed.sums.pressure(number) });
            let fixed = &mut mixed.dofs.fixed_mut()[number * (block + 1)..][..=block];
            fixed[..block].copy_from_slice(&self.dofs.fixed()[number * block..][..block]);
            fixed[block] = is_held(node);
        }
        mixed.unknowns.join(block, &self.increments, &pressures);
    }

    /// What is too much at each node, multiplied by the share that a step takes out; empty for nothing.
    fn excess(&self, mixed: &mut Mixed, points: &MaterialPoints, grid: &ModelPart) -> Vec<f64> {
        let share = mixed.settings.volume_correction;
        let is_fluid = |block: &Block| block.law.mixed().is_some_and(|m| matches!(m.shear, Shear::Viscous(_)));
        let settings = &self.scene.settings;
        let moves = settings.regime == Regime::Dynamic && settings.discretisation.frame == Frame::Updated;
        if share == 0.0 || !moves || !points.blocks.iter().all(is_fluid) {
            return Vec::new();
        }
        if mixed.room.is_empty() {
            mixed.room = room(grid);
        }
        let mut excess = excess(&mixed.room, &mixed.sums, &self.dofs);
        if excess.iter().all(|e| *e == 0.0) {
            return Vec::new();
        }
        excess.iter_mut().for_each(|e| *e *= share);
        excess
    }

    /// Solves the step for displacements and pressures.
    pub(in crate::implicit) fn solve_mixed(
        &mut self,
        mixed: &mut Mixed,
        (points, grid): (&MaterialPoints, &ModelPart),
        time_step: f64,
        system: &mut System,
        linear: &mut dyn LinearSolver,
    ) -> Result<StepReport, Error> {
        let newton = &self.scene.settings.newton;
        let slides = grid.node_fields.slides(&DISPLACEMENT);
        let frames = NodalFrames::new(self.dofs.block(), &mixed.dofs, slides);
        let excess = self.excess(mixed, points, grid);
        let mut problem = mixed.problem(self.problem(points, grid, time_step));
        let report = frames.solve(newton, &mut problem, system, linear);
        let spread = match &report {
            Ok(report) if report.converged && !excess.is_empty() => {
                let mut spreading = Spreading { problem: &mut problem, excess, solution: Vec::new() };
                let once = Newton { criterion: None, max_iterations: 1 };
                frames.solve(&once, &mut spreading, system, linear)?;
                let displacements = spreading.solution.chunks_exact(self.dofs.block() + 1);
                displacements.flat_map(|node| &node[..self.dofs.block()]).copied().collect()
            }
            _ => Vec::new(),
        };
        let MixedProblem { base, unknowns, .. } = problem;
        let (increments, assembled) = (base.increments, base.assembled);
        mixed.unknowns = unknowns;
        mixed.spread = spread;
        (self.increments, self.assembled) = (increments, assembled);
        report
    }

    /// Writes the pressures to the grid.
    pub(in crate::implicit) fn write_pressures(&self, grid: &mut ModelPart) {
        let Some(mixed) = &self.mixed else { return };
        let count = grid.nodes.len();
        let column = grid.node_fields.scalar_mut(&PRESSURE, count);
        for (&node, pressure) in self.dofs.nodes().iter().zip(mixed.pressures()) {
            column[node as usize] = *pressure;
        }
    }

    /// Minus the residuals of displacement at the solution; writes those that hold pressures.
    pub(in crate::implicit) fn mixed_reactions(
        &mut self,
        mixed: &mut Mixed,
        points: &MaterialPoints,
        grid: &mut ModelPart,
        time_step: f64,
        system: &mut System,
    ) -> Result<Vec<f64>, Error> {
        let mut problem = mixed.problem(self.problem(points, grid, time_step));
        let assembled = problem.assemble(system, false);
        let unknowns = problem.unknowns;
        mixed.unknowns = unknowns;
        assembled?;
        let block = self.dofs.block();
        let residuals = system.rhs.chunks_exact(block + 1);
        if mixed.shows_reaction {
            let count = grid.nodes.len();
            let column = grid.node_fields.scalar_mut(&PRESSURE_REACTION, count);
            column.fill(0.0);
            let held = mixed.dofs.fixed().chunks_exact(block + 1);
            for ((&node, residuals), held) in self.dofs.nodes().iter().zip(residuals.clone()).zip(held) {
                column[node as usize] = if held[block] { -residuals[block] } else { 0.0 };
            }
        }
        Ok(residuals.flat_map(|node| &node[..block]).map(|r| -r).collect())
    }
}

/// Lets the volume of fluids follow their pressure: J becomes J(p), without memory of shape.
///
/// The constraint sees averages over nodes only, so that J of single points drifts apart; a solid resists
/// that by its shear stiffness, a fluid does not, and after a change of cells the new averages would ask
/// for a divergence of (J − 1)/Δt (spec 06 §6).
pub fn relax_fluids(points: &mut MaterialPoints) {
    for block in &mut points.blocks {
        let Some(moduli) = block.law.mixed().filter(|moduli| matches!(moduli.shear, Shear::Viscous(_))) else {
            continue;
        };
        let dimension = block.kinematics.dimension();
        for point in 0..block.len() {
            let jacobian = moduli.volumetric.jacobian(moduli.compressibility * block.pressure.row(point)[0]);
            let stretch = jacobian.powf(1.0 / dimension as f64);
            let mut gradient = Matrix3::identity();
            (0..dimension).for_each(|a| gradient[(a, a)] = stretch);
            compress(&gradient, block.gradient.row_mut(point));
            if block.volume.is_used() {
                let reference = block.mass.row(point)[0] / block.density;
                block.volume.set(point, [reference * jacobian]);
            }
        }
    }
}
