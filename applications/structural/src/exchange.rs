//! What the solver keeps from step to step, to and from checkpoints.

use crate::solver::{State, Structural};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};

impl State {
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.column("displacement", &mut self.displacement)?;
        archive.column("displacement at the start", &mut self.start)?;
        archive.column("velocity", &mut self.velocity)?;
        archive.column("acceleration", &mut self.acceleration)?;
        archive.column("mass", &mut self.mass)?;
        archive.column("external forces", &mut self.external)?;
        archive.column("reaction", &mut self.reaction)
    }
}

impl Structural {
    /// Motion and forces of the nodes, the history of the laws, and the stable step, which is not
    /// found anew in each step.
    pub(crate) fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.section("nodes", |archive| self.state.exchange(archive))?;
        let mut fixed: Vec<u8> = self.dofs.fixed().iter().map(|fixed| u8::from(*fixed)).collect();
        archive.slice("fixed", &mut fixed)?;
        self.dofs.fixed_mut().iter_mut().zip(fixed).for_each(|(fixed, stored)| *fixed = stored != 0);
        if let Some(body) = &mut self.body {
            archive.slice("law history", &mut body.states)?;
        }
        archive.section("stability", |archive| self.stability.exchange(archive))
    }
}
