//! Columns to and from checkpoints.

use super::{Column, Fields, Variable};
use crate::io::checkpoint::{Archive, CheckpointError};
use std::collections::BTreeMap;

impl Column {
    /// Saves or loads the numbers of all points, of which there may be others than before.
    ///
    /// # Errors
    /// The checkpoint has no such column, or one of another width.
    pub fn exchange(&mut self, name: &str, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut width = self.width;
        archive.section(name, |archive| {
            archive.count("width", &mut width)?;
            if width != self.width {
                let (stored, expected) = (format!("{width} wide"), self.width.to_string());
                return Err(CheckpointError::Differs { name: name.into(), stored, expected });
            }
            archive.column("values", &mut self.values)
        })
    }
}

impl Fields {
    /// Saves or loads all columns and what is fixed; `variables` tells the names of columns that are to
    /// be made. Walls to slide along are part of the scene and stay.
    ///
    /// # Errors
    /// A variable that nobody knows, or what cannot be written.
    pub(crate) fn exchange(&mut self, archive: &mut Archive, variables: &[Variable]) -> Result<(), CheckpointError> {
        let Self { scalars, vectors, rows, fixed, .. } = self;
        each(archive, "scalars", variables, scalars, |archive, name, column| archive.column(name, column))?;
        each(archive, "vectors", variables, vectors, |archive, name, column| archive.column(name, column))?;
        each(archive, "fixed", variables, fixed, |archive, name, column| archive.switches(name, column))?;
        each(archive, "rows", variables, rows, |archive, name, column| {
            archive.count(&format!("{name}/wide"), &mut column.width)?;
            column.exchange(name, archive)
        })
    }
}

/// Exchanges the columns of one kind, made where the checkpoint has one and the run has none yet.
fn each<T: Default>(
    archive: &mut Archive,
    kind: &str,
    variables: &[Variable],
    columns: &mut BTreeMap<&'static str, T>,
    exchange: impl Fn(&mut Archive, &str, &mut T) -> Result<(), CheckpointError>,
) -> Result<(), CheckpointError> {
    let mut names: Vec<String> = columns.keys().map(|name| (*name).to_string()).collect();
    archive.section(kind, |archive| {
        archive.texts("names", &mut names)?;
        for name in names {
            let known = columns.keys().copied().chain(variables.iter().map(|variable| variable.name));
            let mut known = known.filter(|known| *known == name);
            let known = known.next().ok_or_else(|| CheckpointError::Unsupported(format!("the variable {name}")))?;
            exchange(archive, &name, columns.entry(known).or_default())?;
        }
        Ok(())
    })
}
