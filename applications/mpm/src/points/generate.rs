//! Generation of material points from the body mesh (spec 02 §1-2).

use super::block::{Block, Columns, MaterialPoints, gradient_width};
use super::conditions::PointConditions;
use bia_constitutive::{BodyMaterial, BuiltLaw, Catalogue, Kinematics, Options};
use bia_kernel::diagnostic::{Diagnostic, InputErrors, Place};
use bia_kernel::geometry::{CellLocator, QuadraturePoint, rule};
use bia_kernel::io::mdpa;
use bia_kernel::model::{ModelPart, Properties, kratos_order};
use bia_kernel::variables::Column;
use std::f64::consts::TAU;
use std::path::Path;

/// What generation needs to know.
pub struct Plan<'a> {
    /// The background grid.
    pub grid: &'a ModelPart,
    /// The body mesh.
    pub bodies: &'a ModelPart,
    /// Materials by id.
    pub materials: &'a [BodyMaterial],
    /// Laws by name.
    pub catalogue: &'a Catalogue,
    /// Search on the grid.
    pub locator: &'a CellLocator,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// The points have inertia.
    pub dynamic: bool,
    /// Columns to allocate.
    pub columns: Columns,
    /// Reproduce Kratos to round-off.
    pub kratos_exact: bool,
    /// Laws are for an explicit solver.
    pub explicit: bool,
    /// Name of the part of points.
    pub part: &'a str,
    /// The file of the body mesh, for messages; none if a modeler made it.
    pub file: Option<&'a Path>,
}

impl Plan<'_> {
    /// Where a body element stands.
    fn place(&self, element: usize) -> Place {
        let id = self.bodies.elements.ids[element];
        self.file.map_or_else(Place::default, |file| mdpa::place_of(file, mdpa::Category::Element, id))
    }
}

/// Makes the points of all bodies: one for each integration point of each element that belongs to
/// a first-level part, with Kratos's ids, in Kratos's order.
///
/// # Errors
/// Elements without material, constants at fault, a number of points that the shape does not
/// have, points outside the grid: all together.
pub fn generate(plan: &Plan) -> Result<MaterialPoints, InputErrors> {
    let mut errors = InputErrors::default();
    let names: Vec<&str> = plan.bodies.children.iter().map(|child| child.name.as_str()).collect();
    let mut points = MaterialPoints {
        name: plan.part.into(),
        kinematics: plan.kinematics,
        dynamic: plan.dynamic,
        bodies: Vec::new(),
        blocks: Vec::new(),
        conditions: PointConditions::default(),
        lost: 0,
        lost_mass: 0.0,
    };
    let cells = plan.grid.elements.len() + plan.bodies.elements.len();
    let mut next_id = plan.grid.nodes.len().max(cells) as u32 + 1;
    let mut outside = Outside::default();
    let mut refused: Vec<u32> = Vec::new();
    for index in kratos_order(&names) {
        let body = points.bodies.len();
        points.bodies.push(names[index].into());
        let first_block = points.blocks.len();
        for &element in &plan.bodies.children[index].elements {
            let material = plan.bodies.elements.properties[element as usize];
            if refused.contains(&material) {
                continue; // one message for a material is enough
            }
            let mut of_body = points.blocks[first_block..].iter();
            let block = match of_body.position(|block| block.material == material) {
                Some(position) => &mut points.blocks[first_block + position],
                None => {
                    let Some(block) = errors.absorb(new_block(plan, body, material, element)) else {
                        // Its number of points may be at fault, too.
                        let of_material = plan.materials.iter().find(|m| m.properties.id == material);
                        let count = of_material.and_then(|m| m.properties.number("MATERIAL_POINTS_PER_ELEMENT"));
                        if count.is_some_and(|count| count > 0.0) {
                            errors.absorb(integration(plan, material, element as usize));
                        }
                        refused.push(material);
                        continue;
                    };
                    points.blocks.push(block);
                    let last = points.blocks.len() - 1;
                    &mut points.blocks[last]
                }
            };
            if errors.absorb(add_element(plan, block, element as usize, &mut next_id, &mut outside)).is_none() {
                refused.push(material);
            }
        }
    }
    if let Some(diagnostic) = outside.diagnostic(plan) {
        errors.push(diagnostic);
    }
    if points.is_empty() && !errors.any_error() {
        let message = format!("the bodies have no elements in parts, so {:?} would have no material points", plan.part);
        let help = "each element of a body must belong to a sub model part of the first level";
        errors.push(Diagnostic::error(Default::default(), message).help(help));
    }
    for block in &mut points.blocks {
        finish(block, plan);
    }
    errors.or(points)
}

/// Points that lie in no cell of the grid.
#[derive(Default)]
struct Outside {
    count: usize,
    first: Option<([f64; 3], usize)>,
}

impl Outside {
    fn diagnostic(&self, plan: &Plan) -> Option<Diagnostic> {
        let ([x, y, z], element) = self.first?;
        let id = plan.bodies.elements.ids[element];
        let message = format!(
            "{} material points lie outside the background grid, the first at ({x}, {y}, {z}) in body element {id}",
            self.count
        );
        let bound = |i: usize, pick: fn(f64, f64) -> f64, start: f64| {
            plan.grid.nodes.coordinates.iter().map(|c| c[i]).fold(start, pick)
        };
        let low: [f64; 3] = std::array::from_fn(|i| bound(i, f64::min, f64::INFINITY));
        let high: [f64; 3] = std::array::from_fn(|i| bound(i, f64::max, f64::NEG_INFINITY));
        Some(Diagnostic::error(plan.place(element), message).help(format!("the grid spans {low:?} to {high:?}")))
    }
}

fn material_of<'a>(plan: &'a Plan, id: u32, element: u32) -> Result<&'a BodyMaterial, InputErrors> {
    plan.materials.iter().find(|m| m.properties.id == id).ok_or_else(|| {
        let id = plan.bodies.elements.ids[element as usize];
        let names: Vec<String> = plan.bodies.paths();
        Diagnostic::error(plan.place(element as usize), format!("body element {id} has no material"))
            .help(format!("give every part a material in the materials file; parts: {}", names.join(", ")))
            .into()
    })
}

fn new_block(plan: &Plan, body: usize, id: u32, element: u32) -> Result<Block, InputErrors> {
    let material = material_of(plan, id, element)?;
    let properties = &material.properties;
    let entry = properties.law.as_deref().and_then(|name| plan.catalogue.find(name));
    let mut errors = InputErrors::default();
    let across = across(plan.kinematics);
    for name in ["DENSITY", "MATERIAL_POINTS_PER_ELEMENT", "THICKNESS", "CROSS_AREA"] {
        let by_law = entry.is_some_and(|entry| entry.variables.iter().any(|variable| variable.name == name));
        let needed = !["THICKNESS", "CROSS_AREA"].contains(&name) || across == Some(name);
        if !by_law {
            errors.absorb(material.positive(name, needed));
        }
    }
    let options = Options { kratos_exact: plan.kratos_exact, explicit: plan.explicit };
    let law = errors.absorb(material.law(plan.catalogue, plan.kinematics, &options));
    match law {
        Some(BuiltLaw { law, name, kinematics }) if !errors.any_error() => Ok(Block {
            body,
            material: id,
            kinematics,
            law_name: name,
            density: density(properties),
            gravity: [0.0; 3],
            body_acceleration: Column::default(),
            ids: Vec::new(),
            cell: Vec::new(),
            local: Column::new(kinematics.dimension(), 0),
            position: Column::new(kinematics.dimension(), 0),
            displacement: Column::default(),
            velocity: Column::default(),
            acceleration: Column::default(),
            mass: Column::new(1, 0),
            gradient: Column::default(),
            state: Column::default(),
            stress: Column::default(),
            strain: Column::default(),
            volume: Column::default(),
            law,
        }),
        _ => Err(errors),
    }
}

/// The material variable that gives the extent of a body across its mesh.
pub fn across(kinematics: Kinematics) -> Option<&'static str> {
    match kinematics {
        Kinematics::ThreeDimensional => None,
        Kinematics::UniaxialStrain => Some("CROSS_AREA"),
        _ => Some("THICKNESS"),
    }
}

fn density(properties: &Properties) -> f64 {
    properties.number("DENSITY").unwrap_or(f64::NAN)
}

/// The integration points of an element that become material points.
///
/// # Errors
/// A shape that does not fit the kinematics, a number of points that the shape does not have.
fn integration(plan: &Plan, id: u32, element: usize) -> Result<Vec<QuadraturePoint>, InputErrors> {
    let elements = &plan.bodies.elements;
    let material = material_of(plan, id, element as u32)?;
    let shape = elements.shapes[element];
    if shape.dimension() != plan.kinematics.dimension() {
        let message = format!(
            "body element {} is a {}, which does not fit {}",
            elements.ids[element],
            shape.name(),
            plan.kinematics
        );
        let diagnostic = Diagnostic::error(plan.place(element), message);
        return Err(diagnostic.help("check domain_size and the element names").into());
    }
    let wanted = material.properties.number("MATERIAL_POINTS_PER_ELEMENT").unwrap_or(0.0);
    let points = if wanted.fract() == 0.0 { rule(shape, wanted as usize).ok() } else { None };
    points.ok_or_else(|| {
        let counts = bia_kernel::geometry::allowed_counts(shape).iter().map(ToString::to_string).collect::<Vec<_>>();
        let place = material.place_of(Some("MATERIAL_POINTS_PER_ELEMENT"));
        let message = format!("MATERIAL_POINTS_PER_ELEMENT is {wanted}, which a {} does not have", shape.name());
        place.error(message).help(format!("allowed: {}", counts.join(", "))).into()
    })
}

/// Adds the points of one element with position, mass, cell and local coordinates.
fn add_element(
    plan: &Plan,
    block: &mut Block,
    element: usize,
    next_id: &mut u32,
    outside: &mut Outside,
) -> Result<(), InputErrors> {
    let elements = &plan.bodies.elements;
    let material = material_of(plan, block.material, element as u32)?;
    let shape = elements.shapes[element];
    let points = integration(plan, block.material, element)?;
    let mut corners = plan.bodies.corners(elements, element);
    if plan.kinematics.dimension() == 2 {
        // A plane scene lies at z = 0, whatever the file says.
        corners.iter_mut().for_each(|corner| corner[2] = 0.0);
    }
    let mut functions = vec![0.0; corners.len()];
    for point in &points {
        shape.functions(point.xi, &mut functions);
        let x: [f64; 3] = std::array::from_fn(|i| functions.iter().zip(&corners).map(|(n, c)| n * c[i]).sum());
        let mut volume = point.weight * shape.jacobian_determinant(&corners, point.xi);
        if let Some(across) = across(plan.kinematics) {
            volume *= material.properties.number(across).unwrap_or(1.0);
        }
        if plan.kinematics == Kinematics::Axisymmetric {
            if x[0] <= 0.0 {
                let id = elements.ids[element];
                let message = format!("body element {id} has a material point at the negative radius {}", x[0]);
                let help = "an axisymmetric body lies at x >= 0; y is the axis";
                return Err(Diagnostic::error(plan.place(element), message).help(help).into());
            }
            volume *= TAU * x[0];
        }
        let id = *next_id;
        *next_id += 1;
        let Some((cell, xi)) = plan.locator.locate(x, None) else {
            outside.count += 1;
            outside.first.get_or_insert((x, element));
            continue;
        };
        block.ids.push(id);
        block.cell.push(cell);
        block.local.push(&xi);
        block.position.push(&x);
        block.mass.push(&[volume * block.density]);
    }
    Ok(())
}

/// Allocates the other columns.
fn finish(block: &mut Block, plan: &Plan) {
    let (count, dimension, columns) = (block.len(), plan.kinematics.dimension(), plan.columns);
    let column = |width: usize, used: bool| if used { Column::new(width, count) } else { Column::default() };
    let voigt = plan.kinematics.voigt().len();
    block.displacement = column(dimension, columns.displacement);
    block.velocity = column(dimension, columns.motion);
    block.acceleration = column(dimension, columns.motion);
    block.stress = column(voigt, columns.stress);
    block.strain = column(voigt, columns.strain || block.law.uses_strain());
    block.volume = column(1, columns.volume);
    block.body_acceleration = column(dimension, columns.body_acceleration);
    if columns.volume {
        for point in 0..count {
            block.volume.set(point, [block.mass.row(point)[0] / block.density]);
        }
    }
    block.gradient = Column::new(gradient_width(plan.kinematics), count);
    for point in 0..count {
        super::block::compress(&nalgebra::Matrix3::identity(), block.gradient.row_mut(point));
    }
    block.state = Column::new(block.law.state_len(), count);
    block.law.initial_state(block.state.values_mut());
}
