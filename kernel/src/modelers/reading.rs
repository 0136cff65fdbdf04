//! What the modelers of grids and bodies read alike: boxes, counts, cell shapes, element names.

use super::mesh::lattice_shape;
use crate::diagnostic::InputErrors;
use crate::geometry::{Shape, check_cells};
use crate::io::mdpa::{Category, CellNames};
use crate::model::{Model, ModelPart};
use crate::parameters::{Parameters, Settings};
use crate::registry::Registry;
use serde_json::Value;

/// Names of coordinate axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// Names of cell shapes.
pub(super) const SHAPES: &[&str] = &["line", "triangle", "quadrilateral", "tetrahedron", "hexahedron"];

/// An axis-aligned box; flat in the axes from `dimension` on, where it lies at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub dimension: usize,
}

impl Extent {
    /// From the keys `min` and `max`. Equal bounds of z make a plane box, of y and z a line. With
    /// faults the numbers are those of the input all the same, so that the rest can be checked.
    pub fn read(settings: &Settings, errors: &mut InputErrors) -> Self {
        let (low, high) = (settings.vector("min"), settings.vector("max"));
        let flat = |axis: usize| low[axis] == high[axis];
        let dimension = match (flat(1), flat(2)) {
            (_, false) => 3,
            (false, true) => 2,
            (true, true) => 1,
        };
        for axis in 0..3 {
            let (a, b, name) = (low[axis], high[axis], AXES[axis]);
            if axis < dimension && a >= b {
                errors.push(settings.error("max", format!("is {b} in {name}, must be greater than min, which is {a}")));
            } else if axis >= dimension && a != 0.0 {
                let message = format!("is {a} in {name}, must be 0 where min and max are equal");
                errors.push(settings.error("min", message).help("plane scenes lie in z = 0, lines on the x axis"));
            }
        }
        Self { low, high, dimension }
    }

    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }

    pub fn size(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }
}

/// The whole numbers above 0 of a list of `names.len()`.
pub(super) fn counts(list: &Parameters, names: &[&str]) -> Result<Vec<usize>, InputErrors> {
    let values = list.value().as_array().map_or(&[][..], Vec::as_slice);
    let numbers: Vec<u64> = values.iter().filter_map(Value::as_u64).filter(|&n| n > 0 && n <= 1 << 30).collect();
    if numbers.len() == values.len() && numbers.len() == names.len() {
        return Ok(numbers.into_iter().map(|n| n as usize).collect());
    }
    let message = format!("is {}, must be {} whole numbers of at least 1", list.value(), names.len());
    Err(list.error(message).help(format!("the numbers of cells [{}]", names.join(", "))).into())
}

/// `count` + 1 places from `low` to `high`, both met exactly; the last interval is `grading` times
/// the first one and the lengths between follow a geometric progression.
pub(super) fn places(low: f64, high: f64, count: usize, grading: f64) -> Vec<f64> {
    let ratio = if count > 1 { grading.powf(1.0 / (count as f64 - 1.0)) } else { 1.0 };
    let share = |i: usize| {
        if ratio == 1.0 {
            i as f64 / count as f64
        } else {
            (ratio.powi(i as i32) - 1.0) / (ratio.powi(count as i32) - 1.0)
        }
    };
    (0..=count).map(|i| if i == count { high } else { low + (high - low) * share(i) }).collect()
}

/// The cell shape of the key `shape`, by default the lattice cell of the dimension.
pub(super) fn cell_shape(settings: &Settings, dimension: usize, what: &str) -> Result<Shape, InputErrors> {
    if !settings.given("shape") {
        return Ok(lattice_shape(dimension));
    }
    let name = settings.text("shape");
    let shapes = [Shape::Line2, Shape::Triangle3, Shape::Quadrilateral4, Shape::Tetrahedron4, Shape::Hexahedron8];
    match SHAPES.iter().zip(shapes).find(|(known, _)| **known == name) {
        Some((_, shape)) if shape.dimension() == dimension => Ok(shape),
        Some((_, shape)) => {
            let message = format!("{name:?} has {} dimensions, but {what} has {dimension}", shape.dimension());
            let fitting = SHAPES.iter().zip(shapes).filter(|(_, s)| s.dimension() == dimension).map(|(name, _)| *name);
            Err(settings.error("shape", message).allowed(name, fitting).into())
        }
        None => {
            Err(settings.error("shape", format!("{name:?} is no shape")).allowed(name, SHAPES.iter().copied()).into())
        }
    }
}

/// The key `element_name`, checked, or `prefix` with the numbers of dimensions and nodes.
pub(super) fn element_name(
    settings: &Settings,
    registry: &Registry,
    prefix: &str,
    shape: Shape,
) -> Result<String, InputErrors> {
    let name = match settings.given("element_name") {
        true => settings.text("element_name").to_string(),
        false => format!("{prefix}{}D{}N", shape.dimension(), shape.node_count()),
    };
    cell_name(settings, "element_name", registry, Category::Element, &name, &[shape]).map(|_| name)
}

/// The shape of a registered name, which must be one of `fitting`.
pub(super) fn cell_name(
    settings: &Settings,
    key: &str,
    registry: &Registry,
    category: Category,
    name: &str,
    fitting: &[Shape],
) -> Result<Shape, InputErrors> {
    let names = registry.names(category);
    let fits = |name: &str| registry.shape(category, name).filter(|shape| fitting.contains(shape));
    let allowed = names.iter().map(String::as_str).filter(|name| fits(name).is_some());
    match (fits(name), registry.shape(category, name)) {
        (Some(shape), _) => Ok(shape),
        (None, Some(other)) => {
            let wanted: Vec<&str> = fitting.iter().map(|shape| shape.name()).collect();
            let message = format!("{name:?} is a {}, must be a {}", other.name(), wanted.join(" or a "));
            Err(settings.error(key, message).allowed(name, allowed).into())
        }
        (None, None) => Err(settings.error(key, format!("{name:?} is not registered")).allowed(name, allowed).into()),
    }
}

/// A name for a sub model part that `others` do not have yet.
pub(super) fn part_name(settings: &Settings, others: &[String]) -> Result<String, InputErrors> {
    let name = settings.text("name");
    if name.is_empty() || name.contains('.') {
        return Err(settings.error("name", format!("is {name:?}, must not be empty or hold a dot")).into());
    }
    if others.iter().any(|other| other == name) {
        return Err(settings.error("name", format!("{name:?} stands twice")).into());
    }
    Ok(name.to_string())
}

/// Adds a root part to the model after a look at its cells.
pub(super) fn insert(model: &mut Model, part: ModelPart, settings: &Settings) -> Result<(), InputErrors> {
    let mut errors = InputErrors::default();
    if model.part(&part.name).is_some() {
        let message = format!("the model part {:?} is there already", part.name);
        errors.push(settings.error("model_part_name", message).help("one modeler makes one root model part"));
    }
    let space = part.elements.shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
    for fault in check_cells(&part, &part.elements, space).into_iter().take(20) {
        errors.push(settings.parameters().error(fault.to_string()));
    }
    errors.or(())?;
    model.insert(part);
    Ok(())
}
