//! The model: trees of model parts with nodes, cells, conditions and properties.
//!
//! A root [`ModelPart`] owns nodes and cells as flat columns sorted by id; a [`SubModelPart`] only
//! lists indices into them. Names and ids live at the edges (input, output): inside there are
//! indices.

mod data;
mod exchange;
mod order;
mod part;
mod points;
mod properties;

pub use order::kratos_order;
pub use part::{Cells, ModelPart, Nodes, SubModelPart};
pub use points::{PointAccess, PointHandle, PointPlace, PointSet};
pub use properties::{Properties, Table, Value};

use crate::diagnostic::Diagnostic;
use std::any::{Any, TypeId};
use std::collections::HashMap;

/// All model parts of a run, and whatever applications keep beside them.
#[derive(Default)]
pub struct Model {
    parts: Vec<ModelPart>,
    extensions: HashMap<TypeId, Box<dyn Any + Send>>,
    points: Option<PointAccess>,
}

impl Model {
    /// Adds a root model part, or replaces the one of that name.
    pub fn insert(&mut self, part: ModelPart) {
        match self.parts.iter_mut().find(|p| p.name == part.name) {
            Some(old) => *old = part,
            None => self.parts.push(part),
        }
    }

    /// The root model parts.
    pub fn parts(&self) -> &[ModelPart] {
        &self.parts
    }

    /// The root model parts, to be changed.
    pub fn parts_mut(&mut self) -> &mut [ModelPart] {
        &mut self.parts
    }

    /// The root part of this name.
    pub fn part(&self, name: &str) -> Option<&ModelPart> {
        self.parts.iter().find(|part| part.name == name)
    }

    /// The root part of this name, to be changed.
    pub fn part_mut(&mut self, name: &str) -> Option<&mut ModelPart> {
        self.parts.iter_mut().find(|part| part.name == name)
    }

    /// Puts an application's data beside the model parts; one value of each type.
    pub fn extend<T: Any + Send>(&mut self, value: T) {
        self.extensions.insert(TypeId::of::<T>(), Box::new(value));
    }

    /// An application's data.
    pub fn extension<T: Any + Send>(&self) -> Option<&T> {
        self.extensions.get(&TypeId::of::<T>()).and_then(|value| value.downcast_ref())
    }

    /// An application's data, to be changed.
    pub fn extension_mut<T: Any + Send>(&mut self) -> Option<&mut T> {
        self.extensions.get_mut(&TypeId::of::<T>()).and_then(|value| value.downcast_mut())
    }

    /// Takes an application's data out, so that it and the model can be changed together.
    pub fn take<T: Any + Send>(&mut self) -> Option<Box<T>> {
        self.extensions.remove(&TypeId::of::<T>()).and_then(|value| value.downcast().ok())
    }

    /// Puts back what [`Model::take`] took.
    pub fn put<T: Any + Send>(&mut self, value: Box<T>) {
        self.extensions.insert(TypeId::of::<T>(), value);
    }

    /// Adds to `diagnostic` which model parts there are, nearest first.
    pub fn suggest_part(&self, diagnostic: Diagnostic, path: &str) -> Diagnostic {
        let names: Vec<String> = self
            .parts
            .iter()
            .flat_map(|root| {
                let below = root.paths().into_iter().map(|path| format!("{}.{path}", root.name));
                std::iter::once(root.name.clone()).chain(below)
            })
            .collect();
        diagnostic.allowed(path, names.iter().map(String::as_str))
    }

    /// Indices of nodes and conditions of the part with this dotted path, root name first.
    pub fn members(&self, path: &str) -> Option<Members> {
        let (root, below) = path.split_once('.').map_or((path, None), |(root, below)| (root, Some(below)));
        let part = self.part(root)?;
        let (nodes, elements, conditions) = match below {
            None => (all(part.nodes.len()), all(part.elements.len()), all(part.conditions.len())),
            Some(below) => {
                let sub = part.find(below)?;
                (sub.nodes.clone(), sub.elements.clone(), sub.conditions.clone())
            }
        };
        Some(Members { root: root.into(), nodes, elements, conditions })
    }
}

fn all(count: usize) -> Vec<u32> {
    (0..count as u32).collect()
}

/// What a dotted part path selects of its root part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Members {
    /// Name of the root part.
    pub root: String,
    /// Indices of nodes.
    pub nodes: Vec<u32>,
    /// Indices of elements.
    pub elements: Vec<u32>,
    /// Indices of conditions.
    pub conditions: Vec<u32>,
}
