//! Named parts of a mesh: its sides, the nodes and cells in a box, its whole boundary; with conditions.

use super::mesh::{Mesh, face_shape};
use super::reading::{AXES, cell_name, part_name};
use crate::diagnostic::InputErrors;
use crate::geometry::Shape;
use crate::io::mdpa::Category;
use crate::model::{ModelPart, SubModelPart};
use crate::parameters::{Key, Kind, Parameters, Settings};
use crate::registry::Registry;
use serde_json::Value;

/// Keys of a box.
pub(crate) const BOX: &[Key] = &[
    Key::required("min", Kind::Vector3, "lowest corner [m]"),
    Key::required("max", Kind::Vector3, "highest corner [m]"),
];
pub(super) const PART: &[Key] = &[
    Key::required("name", Kind::Text, "name of the sub model part"),
    Key::optional("side", Kind::Any, "min_x, max_x, …, or boundary for all of it; one or a list"),
    Key::optional(
        "box",
        Kind::Object(BOX),
        "takes the nodes in this box, its surface included, and the cells between them",
    ),
    Key::optional(
        "conditions",
        Kind::Text,
        "registered condition to make of the part's boundary faces, in a box without thickness of all its faces, or nodes",
    ),
    Key::new(
        "orientation",
        Kind::Choice(&["outward", "inward"]),
        "\"outward\"",
        "where normals point: of a line to its right from its first node to its second, of a face by the right hand",
    ),
];

/// Share of the mesh's size by which a node may miss a side or box through round-off.
const MARGIN: f64 = 1e-9;

/// Which nodes a part holds.
#[derive(Debug, Clone)]
enum Choice {
    /// Those on one of these sides of the mesh's bounding box: (axis, upper side).
    Sides(Vec<(usize, bool)>),
    /// Those in a box.
    Box([f64; 3], [f64; 3]),
    /// Those of all boundary faces.
    Boundary,
}

/// A part to be made.
#[derive(Debug, Clone)]
pub(super) struct NamedPart {
    name: String,
    choice: Choice,
    condition: Option<(String, Shape)>,
    inward: bool,
    settings: Settings,
}

/// Reads the list of parts of a mesh whose cells have this shape.
pub(super) fn read(list: &Parameters, shape: Shape, registry: &Registry) -> Result<Vec<NamedPart>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut parts: Vec<NamedPart> = Vec::new();
    let mut names = Vec::new();
    for entry in list.entries() {
        let Some(settings) = errors.absorb(entry.read(PART)) else { continue };
        let name = errors.absorb(part_name(&settings, &names)).unwrap_or_default();
        names.push(name.clone());
        let choice = errors.absorb(choice(&settings, shape.dimension()));
        let condition = errors.absorb(condition(&settings, shape, registry)).flatten();
        if let Some(choice) = choice {
            let inward = settings.text("orientation") == "inward";
            parts.push(NamedPart { name, choice, condition, inward, settings });
        }
    }
    errors.or(parts)
}

fn choice(settings: &Settings, dimension: usize) -> Result<Choice, InputErrors> {
    match (settings.get("side"), settings.nested("box")) {
        (Some(side), None) => sides(side, dimension),
        (None, Some(nested)) => corners(nested).map(|(low, high)| Choice::Box(low, high)),
        (side, _) => {
            let found = if side.is_some() { "both are" } else { "neither is" };
            let message = format!("a part takes \"side\" or \"box\", and {found} given");
            Err(settings.parameters().error(message).into())
        }
    }
}

/// The lowest and the highest corner of a box in m.
///
/// # Errors
/// The highest lies below the lowest.
pub(crate) fn corners(nested: &Settings) -> Result<([f64; 3], [f64; 3]), InputErrors> {
    let (low, high) = (nested.vector("min"), nested.vector("max"));
    match (0..3).find(|&axis| low[axis] > high[axis]) {
        Some(axis) => {
            let (a, b, name) = (low[axis], high[axis], AXES[axis]);
            let message = format!("is {b} in {name}, must not be less than min, which is {a}");
            Err(nested.error("max", message).into())
        }
        None => Ok((low, high)),
    }
}

fn sides(given: &Parameters, dimension: usize) -> Result<Choice, InputErrors> {
    let known: Vec<(String, usize, bool)> = (0..dimension)
        .flat_map(|axis| {
            [("min", false), ("max", true)].map(|(end, upper)| (format!("{end}_{}", AXES[axis]), axis, upper))
        })
        .collect();
    let entries = if given.value().is_array() { given.entries() } else { vec![given.clone()] };
    let mut errors = InputErrors::default();
    let mut sides = Vec::new();
    for entry in &entries {
        let text = entry.value().as_str().unwrap_or("");
        match known.iter().find(|(name, _, _)| name == text) {
            _ if text == "boundary" => return Ok(Choice::Boundary),
            Some(&(_, axis, upper)) => sides.push((axis, upper)),
            None => {
                let names = known.iter().map(|(name, _, _)| name.as_str()).chain(["boundary"]);
                errors.push(entry.error(format!("there is no side {}", entry.value())).allowed(text, names));
            }
        }
    }
    if entries.is_empty() {
        errors.push(given.error("names no side"));
    }
    errors.or(Choice::Sides(sides))
}

fn condition(settings: &Settings, shape: Shape, registry: &Registry) -> Result<Option<(String, Shape)>, InputErrors> {
    let Some(name) = settings.get("conditions").and_then(|p| p.value().as_str().map(str::to_string)) else {
        return Ok(None);
    };
    let fitting = [Shape::Point1, face_shape(shape)];
    let shape = cell_name(settings, "conditions", registry, Category::Condition, &name, &fitting)?;
    Ok(Some((name, shape)))
}

impl NamedPart {
    /// Finds the part's nodes in `mesh` and adds its conditions to `root`, where the mesh's nodes
    /// begin at `first_node` and its cells at `first_cell`. A box holds the cells all of whose nodes it holds.
    pub fn add(
        &self,
        mesh: &Mesh,
        (first_node, first_cell): (u32, u32),
        root: &mut ModelPart,
    ) -> Result<SubModelPart, InputErrors> {
        let (low, high) = mesh.bounds();
        let margin = MARGIN * (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let on_side = |node: u32, (axis, upper): (usize, bool)| {
            let plane = if upper { high[axis] } else { low[axis] };
            (mesh.nodes[node as usize][axis] - plane).abs() <= margin
        };
        let in_box = |node: u32, low: &[f64; 3], high: &[f64; 3]| {
            let x = mesh.nodes[node as usize];
            (0..3).all(|axis| x[axis] >= low[axis] - margin && x[axis] <= high[axis] + margin)
        };
        // A face belongs to the part when all its nodes lie on the same side.
        let holds = |face: &[u32]| match &self.choice {
            Choice::Sides(sides) => sides.iter().any(|&side| face.iter().all(|&node| on_side(node, side))),
            Choice::Box(low, high) => face.iter().all(|&node| in_box(node, low, high)),
            Choice::Boundary => true,
        };
        let boundary = matches!(self.choice, Choice::Boundary);
        let has_faces = self.condition.as_ref().is_some_and(|(_, shape)| *shape != Shape::Point1);
        let is_plane = match &self.choice {
            Choice::Box(low, high) => (0..mesh.shape.dimension()).any(|axis| high[axis] - low[axis] <= margin),
            _ => false,
        };
        let faces = match boundary || has_faces {
            true if is_plane => mesh.faces_once(holds),
            true => mesh.boundary(holds),
            false => Vec::new(),
        };
        let nodes: Vec<u32> = if boundary {
            let mut nodes = faces.concat();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        } else {
            (0..mesh.nodes.len() as u32).filter(|&node| holds(&[node])).collect()
        };
        if nodes.is_empty() {
            return Err(self.empty("holds no node", mesh));
        }
        let mut part = SubModelPart { name: self.name.clone(), ..SubModelPart::default() };
        part.nodes = nodes.iter().map(|node| first_node + node).collect();
        if matches!(self.choice, Choice::Box(..)) {
            let inside = (0..mesh.len()).filter(|&cell| mesh.cell(cell).iter().all(|&node| holds(&[node])));
            part.elements = inside.map(|cell| first_cell + cell as u32).collect();
        }
        if let Some((name, shape)) = &self.condition {
            let cells: Vec<Vec<u32>> = if has_faces { faces } else { nodes.iter().map(|&node| vec![node]).collect() };
            if cells.is_empty() {
                return Err(self.empty("holds no boundary face for its conditions", mesh));
            }
            for mut cell in cells {
                if self.inward {
                    cell.reverse();
                }
                cell.iter_mut().for_each(|node| *node += first_node);
                let index = root.conditions.len() as u32;
                root.conditions.push(index + 1, name, *shape, 0, &cell);
                part.conditions.push(index);
            }
        }
        Ok(part)
    }

    fn empty(&self, what: &str, mesh: &Mesh) -> InputErrors {
        let (low, high) = mesh.bounds();
        let message = format!("the part {:?} {what}", self.name);
        let help = format!("the mesh spans {} to {}", Value::from(low.to_vec()), Value::from(high.to_vec()));
        self.settings.parameters().error(message).help(help).into()
    }
}

/// A root part with the nodes and cells of a mesh appended; gives the first node and element.
pub(super) fn append(root: &mut ModelPart, mesh: &Mesh, element: &str) -> (u32, u32) {
    let (first_node, first_cell) = (root.nodes.len() as u32, root.elements.len() as u32);
    root.nodes.ids.extend((0..mesh.nodes.len() as u32).map(|i| first_node + i + 1));
    root.nodes.coordinates.extend_from_slice(&mesh.nodes);
    let mut nodes = Vec::new();
    for index in 0..mesh.len() {
        nodes.clear();
        nodes.extend(mesh.cell(index).iter().map(|node| first_node + node));
        root.elements.push(first_cell + index as u32 + 1, element, mesh.shape, 0, &nodes);
    }
    (first_node, first_cell)
}
