//! Means over the cells' points, put where output processes read them.

use crate::engine::Points;
use crate::fields::write_cells;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::processes::{Context, Process};

/// Writes the wanted columns of elements before each output. The solver puts it at the head.
pub struct CellFields {
    /// Root part with the cells.
    pub part: String,
}

impl CellFields {
    fn write(&self, model: &mut Model) {
        let Some(points) = model.take::<Points>() else { return };
        if let Some(part) = model.part_mut(&self.part) {
            write_cells(points.body.as_ref(), part, &points.wanted);
        }
        model.put(points);
    }
}

impl Process for CellFields {
    fn name(&self) -> &str {
        "dgmpm_cell_fields"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.write(context.model);
        Ok(())
    }

    fn execute_before_output_step(&mut self, context: &mut Context) -> Result<(), Error> {
        self.write(context.model);
        Ok(())
    }
}
