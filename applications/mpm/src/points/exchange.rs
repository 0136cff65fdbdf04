//! Points to and from checkpoints: columns, and what processes set once before the loop.

use super::conditions::PointConditions;
use super::{Block, MaterialPoints};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};

impl Block {
    /// Saves or loads all points, of which some may have been erased.
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.column("ids", &mut self.ids)?;
        archive.column("cells", &mut self.cell)?;
        archive.slice("gravity", &mut self.gravity)?;
        let names = self.columns().map(|(name, _)| name);
        for (name, column) in names.into_iter().zip(self.columns_mut()) {
            column.exchange(name, archive)?;
        }
        let count = self.len();
        let differs = |name: &str, other: usize| {
            let (stored, expected) = (format!("one of {other} points"), format!("one of {count}"));
            Err(CheckpointError::Differs { name: name.into(), stored, expected })
        };
        if self.cell.len() != count {
            return differs("the column of cells", self.cell.len());
        }
        match self.columns().iter().find(|(_, column)| column.values().len() != column.width() * count) {
            Some((name, column)) => differs(name, column.values().len() / column.width().max(1)),
            None => Ok(()),
        }
    }
}

impl PointConditions {
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.slice("cells", &mut self.cell)?;
        archive.slice("local coordinates", &mut self.local)?;
        archive.slice("position", &mut self.position)?;
        archive.slice("displacement", &mut self.displacement)?;
        archive.slice("velocity", &mut self.velocity)?;
        archive.slice("load", &mut self.load)
    }
}

impl MaterialPoints {
    /// Saves or loads all points and conditions.
    ///
    /// # Errors
    /// The checkpoint has other columns.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.losses.exchange(archive)?;
        for (index, block) in self.blocks.iter_mut().enumerate() {
            archive.section(&format!("block {index}"), |archive| block.exchange(archive))?;
        }
        archive.section("conditions", |archive| self.conditions.exchange(archive))
    }
}
