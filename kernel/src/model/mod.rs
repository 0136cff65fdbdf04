//! The model: trees of model parts with nodes, cells, conditions and properties.
//!
//! A root [`ModelPart`] owns nodes and cells as flat columns sorted by id; a [`SubModelPart`] only
//! lists indices into them. Names and ids live at the edges (input, output): inside there are
//! indices.

mod order;
mod part;
mod properties;

pub use order::kratos_order;
pub use part::{Cells, ModelPart, Nodes, SubModelPart};
pub use properties::{Properties, Table, Value};
