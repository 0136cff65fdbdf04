//! What the explicit solver keeps from step to step, to and from checkpoints.

use super::Explicit;
use crate::points::MaterialPoints;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};

impl Explicit {
    /// Points, their cells and which of them may leave theirs; nodes that are carried along; walls that
    /// move; what bounds the step.
    pub(super) fn exchange(
        &mut self,
        points: &mut MaterialPoints,
        archive: &mut Archive,
    ) -> Result<(), CheckpointError> {
        archive.section("points", |archive| points.exchange(archive))?;
        self.active.exchange_reached(archive)?;
        archive.number("work on bodies", &mut self.scene.work)?;
        archive.section("search", |archive| self.search.exchange(archive))?;
        archive.section("active cells", |archive| self.active.exchange(archive))?;
        if archive.is_loading() {
            self.renumber(points);
        }
        archive.section("nodes", |archive| self.nodes.exchange(archive))?;
        archive.number("wave speed", &mut self.limits.wave)?;
        archive.number("point speed", &mut self.limits.point)?;
        archive.number("shortening", &mut self.limits.shortening)?;
        archive.count("steps since the survey", &mut self.surveyed)?;
        archive.flag("told step", &mut self.told.step)?;
        archive.flag("told idle load", &mut self.told.idle_load)
    }
}
