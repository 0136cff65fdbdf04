//! What is written to the grid's columns because someone reads it.

use super::Implicit;
use crate::points::MaterialPoints;
use crate::variables::{NODAL_MASS, REACTION};
use bia_kernel::error::Error;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::NonlinearSystem;

/// Nodal variables that are written to the grid's columns because someone reads them.
#[derive(Default, Clone, Copy)]
pub(super) struct NodalOutput {
    pub(super) mass: bool,
    pub(super) velocity: bool,
    pub(super) acceleration: bool,
    pub(super) reaction: bool,
}

impl Implicit {
    pub(super) fn write_nodal_mass(&self, grid: &mut ModelPart) {
        if !self.output.mass {
            return;
        }
        let count = grid.nodes.len();
        let column = grid.node_fields.scalar_mut(&NODAL_MASS, count);
        if !self.faults().piles_up_mass(self.scene.settings.regime) {
            column.fill(0.0);
        }
        let mass = &self.sums.mass;
        self.scene.space.spread(&self.dofs, |number, node, share| column[node] += share * mass[number]);
    }

    /// Forces that hold the fixed dofs: minus the residual at the solution.
    pub(super) fn write_reactions(
        &mut self,
        points: &MaterialPoints,
        grid: &mut ModelPart,
        time_step: f64,
    ) -> Result<(), Error> {
        let Some(mut system) = self.system.take() else { return Ok(()) };
        let mut mixed = self.mixed.take();
        let result = match &mut mixed {
            Some(mixed) => self.mixed_reactions(mixed, points, grid, time_step, &mut system),
            None => {
                let result = self.problem(points, grid, time_step).assemble(&mut system, false);
                result.map(|()| system.rhs.iter().map(|r| -r).collect())
            }
        };
        (self.system, self.mixed) = (Some(system), mixed);
        let mut reactions: Vec<f64> = result?;
        self.frames.keep_held(&self.dofs, &mut reactions);
        let (count, block) = (grid.nodes.len(), self.dofs.block());
        let column = grid.node_fields.vector_mut(&REACTION, count);
        column.fill([0.0; 3]);
        self.scene.space.spread(&self.dofs, |number, node, share| {
            (0..block).for_each(|a| column[node][a] += share * reactions[number * block + a]);
        });
        Ok(())
    }
}
