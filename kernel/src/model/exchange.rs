//! The model's part in checkpoints: values on meshes. The meshes themselves come from the input.

use super::{Cells, Model, ModelPart, SubModelPart};
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::variables::Variable;
use crc32fast::Hasher;

impl Model {
    /// Saves or loads the values on nodes, elements and conditions of all parts.
    ///
    /// # Errors
    /// What cannot be written or does not fit.
    pub fn exchange_state(&mut self, archive: &mut Archive, variables: &[Variable]) -> Result<(), CheckpointError> {
        for part in &mut self.parts {
            archive.section(&part.name, |archive| {
                archive.section("nodes", |archive| part.node_fields.exchange(archive, variables))?;
                archive.section("elements", |archive| part.element_fields.exchange(archive, variables))?;
                archive.section("conditions", |archive| part.condition_fields.exchange(archive, variables))
            })?;
        }
        Ok(())
    }

    /// A check sum of all meshes, by which a run tells others from its own.
    pub fn mesh_sum(&self) -> u32 {
        let mut sum = Hasher::new();
        self.parts.iter().for_each(|part| add_part(&mut sum, part));
        sum.finalize()
    }
}

fn add_part(sum: &mut Hasher, part: &ModelPart) {
    add(sum, part.name.as_bytes());
    add(sum, bytemuck::cast_slice(&part.nodes.ids));
    add(sum, bytemuck::cast_slice(&part.nodes.coordinates));
    [&part.elements, &part.conditions, &part.geometries].into_iter().for_each(|cells| add_cells(sum, cells));
    add(sum, format!("{:?} {:?}", part.properties, part.tables).as_bytes());
    part.children.iter().for_each(|child| add_child(sum, child));
}

fn add_cells(sum: &mut Hasher, cells: &Cells) {
    for list in [&cells.ids, &cells.properties, &cells.starts, &cells.nodes] {
        add(sum, bytemuck::cast_slice(list));
    }
    add(sum, bytemuck::cast_slice(&cells.kinds));
    cells.names.iter().for_each(|name| add(sum, name.as_bytes()));
}

fn add_child(sum: &mut Hasher, part: &SubModelPart) {
    add(sum, part.name.as_bytes());
    for list in [&part.nodes, &part.elements, &part.conditions, &part.geometries] {
        add(sum, bytemuck::cast_slice(list));
    }
    part.children.iter().for_each(|child| add_child(sum, child));
}

/// A list with its length, so that no entry can pass for one of the next list.
fn add(sum: &mut Hasher, bytes: &[u8]) {
    sum.update(&bytes.len().to_le_bytes());
    sum.update(bytes);
}
