//! `BodyModeler`: bodies of primitives without a mesh file.

use super::fitted;
use super::mapping::{MAP, Map};
use super::mesh::{Cubes, Diagonal, MOST_CELLS, Mesh, bounds, lattice_shape};
use super::parts::{self, NamedPart};
use super::placement::Placement;
use super::primitive::{Form, Primitive, TYPES};
use super::reading::{SHAPES, cell_shape, element_name, insert, part_name};
use crate::diagnostic::InputErrors;
use crate::model::{Model, ModelPart, Properties, SubModelPart};
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use crate::registry::{Building, Modeler, ModelerEntry, Registry};

const KEYS: &[Key] = &[
    Key::optional("model_part_name", Kind::Text, "root model part to make, by default the application's"),
    Key::required("bodies", Kind::List, "bodies, each a sub model part"),
];
const BODY: &[Key] = &[
    Key::required("name", Kind::Text, "name of the body's sub model part"),
    Key::required("primitive", Kind::Any, "type and measures of the primitive"),
    Key::new(
        "fill",
        Kind::Choice(&["fitted", "grid"]),
        "\"fitted\"",
        "cells that follow the boundary, or cells of a lattice through the origin whose centre lies inside",
    ),
    Key::optional(
        "cell_size",
        Kind::Number(Range::POSITIVE),
        "edge of the cells [m]; fitted cells only nearly have it",
    ),
    Key::optional(
        "divisions",
        Kind::List,
        "fitted: numbers of cells along the axes of a box, or [around, radial] and along of round ones",
    ),
    Key::optional("shape", Kind::Choice(SHAPES), "shape of the cells, by default quadrilateral or hexahedron"),
    Key::new(
        "diagonal",
        Kind::Choice(&["alternating", "fixed"]),
        "\"alternating\"",
        "triangles of boxes and lattices: the diagonal of each square, turned in every other one or not",
    ),
    Key::optional("element_name", Kind::Text, "registered element, by default that of the application for the shape"),
    Key::optional("rotation", Kind::Any, "degrees about z, or axis and angle; about the primitive's centre"),
    Key::new("translation", Kind::Vector3, "[0.0, 0.0, 0.0]", "motion after the rotation [m]"),
    MAP,
    Key::new("parts", Kind::List, "[]", "named sides and boxes of the body, with conditions if wanted"),
];

/// Registers the modeler of this file.
pub(super) fn register(registry: &mut Registry) {
    registry.modeler(ModelerEntry {
        name: "BodyModeler",
        keys: KEYS,
        lists: || {
            let primitives = TYPES.iter().map(|(name, keys)| (format!("a primitive of type {name}"), *keys));
            let (body, part) = (("an entry of bodies".into(), BODY), ("an entry of parts".into(), parts::PART));
            std::iter::once(body).chain(primitives).chain([part]).collect()
        },
        help: "makes bodies of primitives as the sub model parts of a new root model part",
        build: |building| Ok(Box::new(read(building)?)),
    });
}

struct Bodies {
    root: String,
    bodies: Vec<Body>,
    settings: Settings,
}

struct Body {
    name: String,
    primitive: Primitive,
    /// Before the map.
    mesh: Mesh,
    map: Option<Map>,
    element: String,
    parts: Vec<NamedPart>,
}

fn read(building: Building) -> Result<Bodies, InputErrors> {
    let mut errors = InputErrors::default();
    let mut names = Vec::new();
    let mut bodies: Vec<Body> = Vec::new();
    let list = building.settings.get("bodies").map_or(Vec::new(), Parameters::entries);
    if list.is_empty() {
        errors.push(building.settings.error("bodies", "names no body"));
    }
    for entry in list {
        let Some(settings) = errors.absorb(entry.read(BODY)) else { continue };
        let name = errors.absorb(part_name(&settings, &names)).unwrap_or_default();
        names.push(name.clone());
        let Some(body) = errors.absorb(read_body(&settings, name, &building)) else { continue };
        let (found, first) = (body.mesh.shape.dimension(), bodies.first().map(|b| b.mesh.shape.dimension()));
        if first.is_some_and(|first| first != found) {
            let first = first.unwrap_or(found);
            errors.push(settings.error("primitive", format!("has {found} dimensions, but the first body has {first}")));
        }
        bodies.push(body);
    }
    let by_application = building.registry.body_mesh_names().map(|names| names.0);
    let root = match building.settings.get("model_part_name") {
        Some(_) => building.settings.text("model_part_name").to_string(),
        None => by_application.unwrap_or_default().to_string(),
    };
    if root.is_empty() {
        errors.push(building.settings.error("model_part_name", "the key \"model_part_name\" is missing"));
    }
    errors.or(Bodies { root, bodies, settings: building.settings })
}

fn read_body(settings: &Settings, name: String, building: &Building) -> Result<Body, InputErrors> {
    let registry = building.registry;
    let mut errors = InputErrors::default();
    let primitive = settings.get("primitive").map(|primitive| Primitive::read(primitive, &building.options.folder));
    let Some(primitive) = primitive.and_then(|primitive| errors.absorb(primitive)) else { return Err(errors) };
    let dimension = primitive.dimension();
    let placement = errors.absorb(Placement::read(settings, primitive.center, dimension));
    let shape = errors.absorb(cell_shape(settings, dimension, &format!("a {}", primitive.name)));
    // The parts are checked even where the shape is wrong.
    let shape = shape.unwrap_or(lattice_shape(dimension));
    let element = errors.absorb(element_name(
        settings,
        registry,
        registry.body_mesh_names().map_or("Element", |names| names.1),
        shape,
    ));
    let parts = settings.get("parts").and_then(|list| errors.absorb(parts::read(list, shape, registry)));
    let is_grid = settings.text("fill") == "grid";
    let mesh = match (is_grid, &placement) {
        (true, Some(placement)) => errors.absorb(staircase(&primitive, placement, settings)),
        _ => errors.absorb(fitted::mesh(&primitive, settings)).zip(placement).map(|(mut mesh, placement)| {
            mesh.nodes.iter_mut().for_each(|x| *x = placement.apply(*x));
            mesh
        }),
    };
    let map = errors.absorb(Map::read(settings, dimension)).flatten();
    errors.or(())?;
    let is_lattice = is_grid || matches!(primitive.form, Form::Box(_));
    let diagonal = match (is_lattice, settings.text("diagonal")) {
        (true, "fixed") => Diagonal::Fixed,
        (true, _) => Diagonal::Alternating,
        _ => Diagonal::Shorter,
    };
    match (mesh.and_then(|mesh| mesh.into_shape(shape, diagonal, Cubes::Six)), element, parts) {
        (Some(mesh), Some(element), Some(parts)) => Ok(Body { name, primitive, mesh, map, element, parts }),
        _ => Err(settings.error("shape", "does not fit the body").into()),
    }
}

/// Cells with corners at multiples of `cell_size` whose centre lies in the placed primitive.
fn staircase(primitive: &Primitive, placement: &Placement, settings: &Settings) -> Result<Mesh, InputErrors> {
    let mut errors = InputErrors::default();
    if let Some(divisions) = settings.get("divisions") {
        errors.push(divisions.error("is for fitted bodies").help("a body with fill \"grid\" takes a cell_size"));
    }
    if !settings.given("cell_size") {
        errors.push(settings.parameters().error("a body with fill \"grid\" takes a cell_size, and none is given"));
    }
    errors.or(())?;
    let (size, dimension) = (settings.number("cell_size"), primitive.dimension());
    let (low, high) = primitive.bounds();
    let corner = |bits: usize| std::array::from_fn(|axis| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let corners: Vec<[f64; 3]> = (0..8).map(|bits| placement.apply(corner(bits))).collect();
    let (low, high) = bounds(&corners);
    let first = low.map(|x| (x / size).floor());
    let last = high.map(|x| (x / size).ceil());
    let total: f64 = (0..dimension).map(|axis| (last[axis] - first[axis]).max(1.0)).product();
    let far = first.iter().chain(&last).any(|index| index.abs() > 1e9);
    if far || total > MOST_CELLS as f64 {
        let message = format!("{size} is too small: {total:e} cells would have to be looked at");
        return Err(settings.error("cell_size", message).into());
    }
    let range = |axis: usize| if axis < dimension { first[axis] as i32..last[axis] as i32 } else { 0..1 };
    let mut places = Vec::new();
    for k in range(2) {
        for j in range(1) {
            for i in range(0) {
                let mut center = [i, j, k].map(|index| (f64::from(index) + 0.5) * size);
                center[dimension..].fill(0.0);
                if primitive.contains(placement.undo(center)) {
                    places.push([i, j, k]);
                }
            }
        }
    }
    if places.is_empty() {
        let message =
            format!("{size} leaves the body without cells: no centre of a cell lies in the {}", primitive.name);
        return Err(settings.error("cell_size", message).help("take smaller cells, or fill \"fitted\"").into());
    }
    Ok(Mesh::of_places(dimension, &places, size))
}

impl Body {
    /// Tells how well the mesh fills the primitive.
    fn report(&self) {
        let (measure, exact) = (self.mesh.measure(), self.primitive.measure());
        let (what, unit) = match self.primitive.dimension() {
            1 => ("length", "m"),
            2 => ("area", "m²"),
            _ => ("volume", "m³"),
        };
        tracing::info!(
            "body {:?}: {} cells in a {}, {what} {measure:.9e} {unit}, {:+.3e} of the exact {exact:.9e} {unit}",
            self.name,
            self.mesh.len(),
            self.primitive.name,
            measure / exact - 1.0
        );
    }
}

impl Modeler for Bodies {
    fn setup_geometry(&mut self, model: &mut Model, _: &Registry) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        let mut root = ModelPart::new(&self.root);
        root.properties.insert(0, Properties::default());
        for body in &self.bodies {
            let bent = body.map.as_ref().map(|map| map.bend(&body.mesh));
            let (node, cell) = parts::append(&mut root, bent.as_ref().unwrap_or(&body.mesh), &body.element);
            let mut part = SubModelPart { name: body.name.clone(), ..SubModelPart::default() };
            part.nodes = (node..node + body.mesh.nodes.len() as u32).collect();
            part.elements = (cell..cell + body.mesh.len() as u32).collect();
            for named in &body.parts {
                let child = errors.absorb(named.add(&body.mesh, (node, cell), &mut root));
                part.conditions.extend(child.iter().flat_map(|child| child.conditions.iter().copied()));
                part.children.extend(child);
            }
            root.children.push(part);
        }
        errors.or(())?;
        self.bodies.iter().filter(|body| body.map.is_none()).for_each(Body::report);
        insert(model, root, &self.settings)
    }
}
