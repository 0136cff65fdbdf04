//! `RegularGridModeler`: the background grid without a mesh file.

use super::mapping::{MAP, Map};
use super::mesh::{Cubes, Diagonal, MOST_CELLS, Mesh, lattice_shape};
use super::parts::{self, NamedPart};
use super::reading::{AXES, Extent, SHAPES, cell_shape, counts, element_name, insert, places};
use crate::diagnostic::InputErrors;
use crate::model::{Model, ModelPart, Properties};
use crate::parameters::{Key, Kind, Range, Settings};
use crate::registry::{Building, Modeler, ModelerEntry, Registry};

const KEYS: &[Key] = &[
    Key::new("model_part_name", Kind::Text, "\"Background_Grid\"", "root model part to make"),
    Key::required("min", Kind::Vector3, "lowest corner [m]; the z of plane grids is 0 in both corners"),
    Key::required("max", Kind::Vector3, "highest corner [m]"),
    Key::optional("divisions", Kind::List, "numbers of cells along the axes"),
    Key::optional("cell_size", Kind::Number(Range::POSITIVE), "edge of the cells [m], which must divide the box"),
    Key::optional("shape", Kind::Choice(SHAPES), "shape of the cells, by default quadrilateral or hexahedron"),
    Key::optional("element_name", Kind::Text, "registered element, by default Element2D4N and so on"),
    Key::new(
        "diagonal",
        Kind::Choice(&["alternating", "fixed"]),
        "\"alternating\"",
        "triangles: the diagonal of each square, turned in every other one or not",
    ),
    Key::new("tetrahedra_per_cube", Kind::Integer { min: 5 }, "6", "tetrahedra: 5 or 6"),
    Key::new("grading", Kind::Vector3, "[1.0, 1.0, 1.0]", "last to first edge along each axis, with divisions only"),
    MAP,
    Key::new("parts", Kind::List, "[]", "named sides and boxes, with conditions if wanted"),
];

/// Share of a cell by which the box may miss a whole number of cells through round-off.
const MARGIN: f64 = 1e-6;

/// Registers the modeler of this file.
pub(super) fn register(registry: &mut Registry) {
    registry.modeler(ModelerEntry {
        name: "RegularGridModeler",
        keys: KEYS,
        lists: || vec![("an entry of parts".into(), parts::PART)],
        help: "makes a regular grid with named sides as a new root model part",
        build: |building| Ok(Box::new(read(building)?)),
    });
}

struct RegularGrid {
    mesh: Mesh,
    element: String,
    parts: Vec<NamedPart>,
    map: Option<Map>,
    settings: Settings,
}

fn read(building: Building) -> Result<RegularGrid, InputErrors> {
    let settings = building.settings;
    let mut errors = InputErrors::default();
    if settings.integer("tetrahedra_per_cube") > 6 {
        errors.push(settings.error("tetrahedra_per_cube", "must be 5 or 6"));
    }
    let extent = Extent::read(&settings, &mut errors);
    let lines = errors.absorb(lines(&settings, &extent));
    let shape = errors.absorb(cell_shape(&settings, extent.dimension, "the grid"));
    // The parts are checked even where the shape is wrong.
    let shape = shape.unwrap_or(lattice_shape(extent.dimension));
    let element = errors.absorb(element_name(&settings, building.registry, "Element", shape));
    let parts = settings.get("parts").and_then(|list| errors.absorb(parts::read(list, shape, building.registry)));
    let diagonal = if settings.text("diagonal") == "fixed" { Diagonal::Fixed } else { Diagonal::Alternating };
    let cubes = if settings.integer("tetrahedra_per_cube") == 5 { Cubes::Five } else { Cubes::Six };
    let map = errors.absorb(Map::read(&settings, extent.dimension)).flatten();
    errors.or(())?;
    match (lines.and_then(|lines| Mesh::lattice(&lines).into_shape(shape, diagonal, cubes)), element, parts) {
        (Some(mesh), Some(element), Some(parts)) => Ok(RegularGrid { mesh, element, parts, map, settings }),
        _ => Err(settings.error("shape", "does not fit the grid").into()),
    }
}

/// Places of the grid lines along each axis.
fn lines(settings: &Settings, extent: &Extent) -> Result<Vec<Vec<f64>>, InputErrors> {
    let mut errors = InputErrors::default();
    let grading = settings.vector("grading");
    if settings.given("grading") {
        let place = settings.parameters().child("grading").unwrap_or_else(|| settings.parameters().clone());
        if grading.iter().any(|&g| g <= 0.0) {
            errors.push(place.error("must be three numbers above 0"));
        } else if settings.given("cell_size") && grading != [1.0; 3] {
            errors.push(place.error("does not fit a constant cell_size").help("give divisions instead of cell_size"));
        }
    }
    let numbers = match (settings.get("divisions"), settings.given("cell_size")) {
        (Some(list), false) => errors.absorb(counts(list, &AXES[..extent.dimension])),
        (None, true) => errors.absorb(whole_counts(settings, extent)),
        (given, _) => {
            let found = if given.is_some() { "both are" } else { "neither is" };
            errors.push(settings.parameters().error(format!("a grid takes divisions or cell_size, and {found} given")));
            None
        }
    };
    let total = numbers.iter().flatten().fold(1usize, |product, n| product.saturating_mul(*n));
    if total > MOST_CELLS {
        errors.push(settings.parameters().error(format!("the grid would have more than {MOST_CELLS} cells")));
    }
    errors.or(())?;
    let line = |(axis, n): (usize, &usize)| places(extent.low[axis], extent.high[axis], *n, grading[axis]);
    Ok(numbers.iter().flatten().enumerate().map(line).collect())
}

/// Numbers of cells of the size `cell_size`, which must divide the box: a grid that changed its
/// size or its cells unasked would shift the results.
fn whole_counts(settings: &Settings, extent: &Extent) -> Result<Vec<usize>, InputErrors> {
    let size = settings.number("cell_size");
    let mut errors = InputErrors::default();
    let mut numbers = Vec::new();
    for axis in (0..extent.dimension).filter(|&axis| extent.size(axis) > 0.0) {
        let cells = extent.size(axis) / size;
        let whole = cells.round().max(1.0);
        if (cells - whole).abs() > MARGIN * whole {
            let (low, name) = (extent.low[axis], AXES[axis]);
            let message =
                format!("{size} does not divide the box in {name}: {} / {size} = {cells} cells", extent.size(axis));
            let help = format!(
                "max in {name} could be {}, or cell_size {}; divisions take any box",
                low + whole * size,
                extent.size(axis) / whole
            );
            errors.push(settings.error("cell_size", message).help(help));
        }
        numbers.push(whole as usize);
    }
    errors.or(numbers)
}

impl Modeler for RegularGrid {
    fn setup_geometry(&mut self, model: &mut Model, _: &Registry) -> Result<(), InputErrors> {
        let mut root = ModelPart::new(self.settings.text("model_part_name"));
        root.properties.insert(0, Properties::default());
        let bent = self.map.as_ref().map(|map| map.bend(&self.mesh));
        let first = parts::append(&mut root, bent.as_ref().unwrap_or(&self.mesh), &self.element);
        let mut errors = InputErrors::default();
        for part in &self.parts {
            let made = errors.absorb(part.add(&self.mesh, first, &mut root));
            root.children.extend(made);
        }
        errors.or(())?;
        insert(model, root, &self.settings)
    }
}
