//! Processes of the method.

mod cells;
mod energy;
mod initial;
mod vtk;

pub use cells::CellFields;

use crate::engine::Points;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::model::Model;
use bia_kernel::parameters::Settings;
use bia_kernel::registry::Registry;

/// Registers them.
pub fn register(registry: &mut Registry) {
    initial::register(registry);
    energy::register(registry);
    vtk::register(registry);
}

/// Elements of the part that `model_part_name` names.
///
/// # Errors
/// There is no such part, or it has no elements.
fn elements_of(model: &Model, settings: &Settings) -> Result<Vec<u32>, InputErrors> {
    let path = settings.text("model_part_name");
    let Some(members) = model.members(path) else {
        let diagnostic = settings.error("model_part_name", format!("there is no model part {path:?}"));
        return Err(model.suggest_part(diagnostic, path).into());
    };
    if members.elements.is_empty() {
        let message = format!("the model part {path:?} has no elements, and so no material points");
        return Err(settings.error("model_part_name", message).into());
    }
    Ok(members.elements)
}

/// The points of these elements.
fn points_of<'a>(points: &'a Points, elements: &'a [u32]) -> impl Iterator<Item = usize> + 'a {
    elements.iter().flat_map(|&element| {
        let [first, end] = points.body.points_of(element as usize);
        first..end
    })
}
