//! What the implicit solver keeps from step to step, to and from checkpoints.

use super::Implicit;
use crate::points::MaterialPoints;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};

impl Implicit {
    /// Points, the motion that the grid of the total frame keeps, and imposed displacements. Cells, dofs
    /// and systems are found anew.
    pub(super) fn exchange(
        &mut self,
        points: &mut MaterialPoints,
        archive: &mut Archive,
    ) -> Result<(), CheckpointError> {
        archive.section("points", |archive| points.exchange(archive))?;
        self.active.exchange_reached(archive)?;
        archive.flag("something has worked on bodies", &mut self.scene.was_worked_on)?;
        archive.column("velocity of the grid", &mut self.motion.velocity)?;
        archive.column("acceleration of the grid", &mut self.motion.acceleration)?;
        archive.column("velocity of what is held", &mut self.motion.held)?;
        archive.column("imposed displacements", &mut self.previous)?;
        self.mixed.as_mut().map_or(Ok(()), |mixed| mixed.exchange(archive))
    }
}
