//! What is written to the grid's columns because someone reads it.

use super::Explicit;
use crate::variables::{ACCELERATION, DISPLACEMENT, NODAL_MASS, REACTION, VELOCITY};
use bia_kernel::model::ModelPart;
use bia_kernel::variables::Variable;

impl Explicit {
    pub(super) fn shows(&self, name: &str) -> bool {
        self.shown.contains(&name)
    }

    /// Writes what someone reads on the grid.
    pub(super) fn write_nodes(&self, grid: &mut ModelPart, increments: &[f64]) {
        let (count, space, dofs) = (grid.nodes.len(), &self.scene.space, &self.nodes.dofs);
        let keeps = self.faults.shows_old_nodes();
        if self.shows(NODAL_MASS.name) {
            let column = grid.node_fields.scalar_mut(&NODAL_MASS, count);
            if keeps {
                dofs.nodes().iter().for_each(|&node| column[node as usize] = 0.0);
            } else {
                column.fill(0.0);
            }
            space.spread(dofs, |number, node, share| column[node] += share * self.nodes.sums.mass[number]);
        }
        let reset = |grid: &mut ModelPart, variable: &Variable| {
            if !keeps {
                grid.node_fields.vector_mut(variable, count).fill([0.0; 3]);
            }
        };
        for (variable, values) in
            [(&DISPLACEMENT, increments), (&VELOCITY, &self.nodes.velocity), (&ACCELERATION, &self.nodes.acceleration)]
        {
            if self.shows(variable.name) {
                reset(grid, variable);
                space.write_field(grid, dofs, variable, values);
            }
        }
        if self.shows(REACTION.name) {
            reset(grid, &REACTION);
            let block = dofs.block();
            let column = grid.node_fields.vector_mut(&REACTION, count);
            dofs.nodes().iter().filter(|_| keeps).for_each(|&node| column[node as usize] = [0.0; 3]);
            space.spread(dofs, |number, node, share| {
                let reaction = &self.nodes.reaction[number * block..(number + 1) * block];
                reaction.iter().zip(&mut column[node]).for_each(|(r, sum)| *sum += share * r);
            });
        }
    }
}
