//! The reset of a grid that carries nothing from step to step.

use super::{Context, Process};
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::variables::Variable;
use rayon::prelude::*;

/// Nodes that one thread takes at a time.
const NODES: usize = 4096;

/// Sets vector variables of all nodes of a root part to zero at the start of each step, before
/// other processes write theirs; what is fixed for good (in the mesh file, say) keeps its value. Solvers whose grid is reset put it at the head of the pipeline.
pub struct ResetNodes {
    /// Root part.
    pub part: &'static str,
    /// Variables to reset; those without a column are left out.
    pub variables: Vec<Variable>,
}

impl Process for ResetNodes {
    fn name(&self) -> &str {
        "reset_nodes"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn execute_initialize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        if let Some(part) = context.model.part_mut(self.part) {
            for variable in &self.variables {
                let (values, fixed) = part.node_fields.vector_and_fixed(variable);
                values.par_chunks_mut(NODES).enumerate().for_each(|(chunk, values)| {
                    let fixed = fixed.get(chunk * NODES..).unwrap_or_default();
                    let held = fixed.iter().copied().chain(std::iter::repeat([false; 3]));
                    for (value, held) in values.iter_mut().zip(held) {
                        (0..3).for_each(|a| value[a] = if held[a] { value[a] } else { 0.0 });
                    }
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Model, ModelPart};
    use crate::processes::{Clock, RunOptions};

    #[test]
    fn only_existing_columns_and_free_components_are_reset() {
        const MOVED: Variable = Variable::vector("MOVED", "m", "");
        const OTHER: Variable = Variable::vector("OTHER", "m", "");
        let mut model = Model::default();
        let mut part = ModelPart::new("Grid");
        part.node_fields.vector_mut(&MOVED, 2)[1] = [1.0; 3];
        part.node_fields.fixed_mut(&MOVED, 2)[1][2] = true;
        model.insert(part);
        let (clock, options) = (Clock::default(), RunOptions::default());
        let mut context = Context { model: &mut model, clock: &clock, options: &options };
        let mut reset = ResetNodes { part: "Grid", variables: vec![MOVED, OTHER] };
        reset.execute_initialize_solution_step(&mut context).unwrap();
        let fields = &model.part("Grid").unwrap().node_fields;
        assert_eq!(fields.vector(&MOVED), Some(&[[0.0; 3], [0.0, 0.0, 1.0]][..]));
        assert!(fields.vector(&OTHER).is_none());
    }
}
