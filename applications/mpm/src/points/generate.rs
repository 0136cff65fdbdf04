//! Generation of material points from the body mesh (spec 02 §1-2).

use super::block::{Block, Columns, MaterialPoints, compress, gradient_width};
use super::conditions::PointConditions;
use super::layout::Layout;
use super::lost::Losses;
use crate::settings::Placement;
use bia_constitutive::{BodyMaterial, BuiltLaw, Catalogue, Deformation, Kinematics, Options, VolumetricLaw};
use bia_kernel::diagnostic::{Diagnostic, InputErrors, Place};
use bia_kernel::geometry::CellLocator;
use bia_kernel::io::mdpa;
use bia_kernel::model::{ModelPart, Properties, kratos_order};
use bia_kernel::variables::Column;
use nalgebra::Matrix3;
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
    /// Where the cells of the bodies hold their points.
    pub placement: Placement,
    /// Columns to allocate.
    pub columns: Columns,
    /// Reproduce Kratos to round-off.
    pub kratos_exact: bool,
    /// Laws are for an explicit solver.
    pub explicit: bool,
    /// Volumetric law of nodal pressures, if the formulation has them.
    pub mixed: Option<VolumetricLaw>,
    /// Name of the part of points.
    pub part: &'a str,
    /// The file of the body mesh, for messages; none if a modeler made it.
    pub file: Option<&'a Path>,
}

impl Plan<'_> {
    /// Where a body element stands.
    pub fn place(&self, element: usize) -> Place {
        let id = self.bodies.elements.ids[element];
        self.file.map_or_else(Place::default, |file| mdpa::place_of(file, mdpa::Category::Element, id))
    }
}

/// Elements of one body, one after the other, that have the same material and the same shape.
struct Run<'a> {
    elements: &'a [u32],
    block: usize,
    layout: usize,
}

/// Makes the points of all bodies: one for each place in each element that belongs to a first-level
/// part, with Kratos's ids, in Kratos's order.
///
/// # Errors
/// Elements without material, constants at fault, a number of points that the shape does not
/// have, points outside the grid: all together.
pub fn generate(plan: &Plan) -> Result<MaterialPoints, InputErrors> {
    let mut errors = InputErrors::default();
    let mut points = MaterialPoints {
        name: plan.part.into(),
        kinematics: plan.kinematics,
        dynamic: plan.dynamic,
        bodies: Vec::new(),
        blocks: Vec::new(),
        conditions: PointConditions::default(),
        losses: Losses::default(),
    };
    let mut layouts = Vec::new();
    let runs = runs(plan, &mut points, &mut layouts, &mut errors);
    let cells = plan.grid.elements.len() + plan.bodies.elements.len();
    let first_id = plan.grid.nodes.len().max(cells) + 1;
    let mut counts = vec![0; points.blocks.len()];
    runs.iter().for_each(|run| counts[run.block] += run.elements.len() * layouts[run.layout].places.len());
    if u32::try_from(first_id + counts.iter().sum::<usize>()).is_err() {
        let message = format!("{:e} material points are more than ids can count", counts.iter().sum::<usize>() as f64);
        return Err(Diagnostic::error(Default::default(), message).into());
    }
    points.blocks.iter_mut().zip(counts).for_each(|(block, count)| block.reserve(count));
    let mut next_id = first_id as u32;
    let mut outside = Outside::default();
    for run in &runs {
        let block = &mut points.blocks[run.block];
        errors.absorb(add_run(plan, block, &layouts[run.layout], run.elements, &mut next_id, &mut outside));
    }
    if let Some(diagnostic) = outside.diagnostic(plan) {
        errors.push(diagnostic);
    }
    if points.is_empty() && !errors.any_error() {
        let message = format!("the bodies have no elements in parts, so {:?} would have no material points", plan.part);
        let help = "each element of a body must belong to a sub model part of the first level";
        errors.push(Diagnostic::error(Default::default(), message).help(help));
    }
    points.blocks.iter_mut().for_each(|block| allocate(block, plan));
    errors.or(points)
}

/// Sorts the elements of all bodies into runs, and makes the blocks and layouts that they need.
fn runs<'a>(
    plan: &Plan<'a>,
    points: &mut MaterialPoints,
    layouts: &mut Vec<Layout>,
    errors: &mut InputErrors,
) -> Vec<Run<'a>> {
    let mut runs = Vec::new();
    let mut refused: Vec<u32> = Vec::new(); // one message for a material is enough
    let names: Vec<&str> = plan.bodies.children.iter().map(|child| child.name.as_str()).collect();
    let (materials, shapes) = (&plan.bodies.elements.properties, &plan.bodies.elements.shapes);
    let kind = |element: u32| (materials[element as usize], shapes[element as usize]);
    for index in kratos_order(&names) {
        let body = points.bodies.len();
        points.bodies.push(names[index].into());
        for elements in plan.bodies.children[index].elements.chunk_by(|a, b| kind(*a) == kind(*b)) {
            let (material, shape) = kind(elements[0]);
            if refused.contains(&material) {
                continue;
            }
            let known = points.blocks.iter().position(|block| block.body == body && block.material == material);
            let block = known.or_else(|| {
                points.blocks.push(errors.absorb(new_block(plan, body, material, elements[0]))?);
                Some(points.blocks.len() - 1)
            });
            // Where the block is at fault, its number of points may be, too.
            let checked = block.is_some() || has_count(plan, material);
            let known = layouts.iter().position(|layout| layout.material == material && layout.shape == shape);
            let layout = known.or_else(|| {
                let layout = checked.then(|| Layout::new(plan, material, elements[0] as usize))?;
                layouts.push(errors.absorb(layout)?);
                Some(layouts.len() - 1)
            });
            match (block, layout) {
                (Some(block), Some(layout)) => runs.push(Run { elements, block, layout }),
                _ => refused.push(material),
            }
        }
    }
    runs
}

/// Whether a material says how many points there are.
fn has_count(plan: &Plan, id: u32) -> bool {
    let material = plan.materials.iter().find(|m| m.properties.id == id);
    let count = material.and_then(|m| m.properties.number("MATERIAL_POINTS_PER_ELEMENT"));
    count.is_some_and(|count| count > 0.0)
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

/// The material of a body element.
///
/// # Errors
/// It has none.
pub fn material_of<'a>(plan: &'a Plan, id: u32, element: u32) -> Result<&'a BodyMaterial, InputErrors> {
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
    let options = Options { kratos_exact: plan.kratos_exact, explicit: plan.explicit, mixed: plan.mixed };
    let law = errors.absorb(material.law(plan.catalogue, plan.kinematics, &options));
    let undeformed = Deformation::from_gradient(Matrix3::identity());
    match law {
        Some(BuiltLaw { law, name, kinematics }) if !errors.any_error() => Ok(Block {
            body,
            material: id,
            kinematics,
            law_name: name,
            moments: false,
            has_energy: !plan.kratos_exact && law.energy(&undeformed).is_some(),
            density: density(properties),
            extent: across.and_then(|name| properties.number(name)).unwrap_or(1.0),
            starts_stressed: false,
            gravity: [0.0; 3],
            body_acceleration: Column::default(),
            transfer: Column::default(),
            affine_energy: Column::default(),
            ids: Vec::new(),
            cell: Vec::new(),
            local: Column::new(if plan.columns.local { kinematics.dimension() } else { 0 }, 0),
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
            pressure: Column::default(),
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

/// Adds the points of some elements with position, mass, cell and local coordinates.
fn add_run(
    plan: &Plan,
    block: &mut Block,
    layout: &Layout,
    elements: &[u32],
    next_id: &mut u32,
    outside: &mut Outside,
) -> Result<(), InputErrors> {
    let material = material_of(plan, block.material, elements[0])?;
    let extent = across(plan.kinematics).and_then(|name| material.properties.number(name)).unwrap_or(1.0);
    let (flat, ring) = (plan.kinematics.dimension() == 2, plan.kinematics == Kinematics::Axisymmetric);
    let mut corners = [[0.0; 3]; 8];
    for &element in elements {
        let nodes = plan.bodies.elements.nodes_of(element as usize);
        for (corner, &node) in corners.iter_mut().zip(nodes) {
            *corner = plan.bodies.nodes.coordinates[node as usize];
            if flat {
                // A plane scene lies at z = 0, whatever the file says.
                corner[2] = 0.0;
            }
        }
        for place in &layout.places {
            let x = place.table.position(&corners[..nodes.len()]);
            let mut volume = place.weight * place.table.jacobian_determinant(&corners[..nodes.len()]) * extent;
            if ring {
                if x[0] <= 0.0 {
                    return Err(negative_radius(plan, element as usize, x[0]));
                }
                volume *= TAU * x[0];
            }
            let id = *next_id;
            *next_id += 1;
            let Some((cell, xi)) = plan.locator.locate(x, None) else {
                outside.count += 1;
                outside.first.get_or_insert((x, element as usize));
                continue;
            };
            block.ids.push(id);
            block.cell.push(cell);
            block.local.push(&xi);
            block.position.push(&x);
            block.mass.push(&[volume * block.density]);
        }
    }
    Ok(())
}

fn negative_radius(plan: &Plan, element: usize, radius: f64) -> InputErrors {
    let id = plan.bodies.elements.ids[element];
    let message = format!("body element {id} has a material point at the negative radius {radius}");
    let help = "an axisymmetric body lies at x >= 0; y is the axis";
    Diagnostic::error(plan.place(element), message).help(help).into()
}

/// Allocates the other columns.
fn allocate(block: &mut Block, plan: &Plan) {
    let (count, dimension, columns) = (block.len(), plan.kinematics.dimension(), plan.columns);
    let column = |width: usize, used: bool| if used { Column::new(width, count) } else { Column::default() };
    let voigt = plan.kinematics.voigt().len();
    let work = columns.strain_energy && !block.has_energy;
    let shown = columns.strain && plan.kratos_exact;
    block.displacement = column(dimension, columns.displacement);
    block.velocity = column(dimension, columns.velocity);
    block.acceleration = column(dimension, columns.acceleration);
    // A strain is written where the stress is.
    block.stress = column(voigt, columns.stress || work || shown);
    block.strain = column(voigt, block.law.uses_strain() || work || shown);
    block.body_acceleration = column(dimension, columns.body_acceleration);
    block.pressure = column(1, columns.pressure);
    block.transfer = column(columns.transfer, columns.transfer > 0);
    block.affine_energy = column(1, columns.affine && columns.kinetic_energy);
    if columns.volume || work {
        block.volume = block.mass.clone();
        block.volume.values_mut().iter_mut().for_each(|volume| *volume /= block.density);
    }
    let width = gradient_width(plan.kinematics);
    let mut undeformed = vec![0.0; width];
    compress(&Matrix3::identity(), &mut undeformed);
    block.gradient = Column::repeated(&undeformed, count);
    block.state = column(block.law.state_len(), true);
    block.law.initial_state(block.state.values_mut());
}
