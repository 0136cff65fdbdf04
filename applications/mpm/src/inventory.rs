//! What a scene consists of, and its state after a failure.

use crate::active::{ActiveCells, NO_CELL};
use crate::grid::GRID;
use crate::points::across;
use crate::points::fields::append;
use crate::points::{Block, MaterialPoints, Selection};
use crate::room::crowding;
use crate::scene::{Scene, points_of};
use crate::settings::Frame;
use crate::space::Space;
use bia_constitutive::Kinematics;
use bia_kernel::error::Error;
use bia_kernel::io::dataset::{CellsOf, Dataset, Field, FieldData};
use bia_kernel::model::Model;
use bia_kernel::solving::solver::{ColumnUse, Counts, Inventory, write_failed_state};
use bia_kernel::variables::Column;
use std::path::{Path, PathBuf};

impl Scene {
    /// What the scene consists of.
    pub fn inventory(&self, model: &Model) -> Inventory {
        let mut inventory = Inventory::default();
        let mut line = |what: &str, text: String| inventory.lines.push((what.into(), text));
        let (Some(grid), Some(points)) = (model.part(GRID), points_of(model)) else {
            return inventory;
        };
        let locator = self.locator.as_ref().map_or(String::new(), |locator| format!(", {}", locator.describe()));
        line("grid", format!("{} nodes, {} cells{locator}", grid.nodes.len(), grid.elements.len()));
        if let Some(summary) = self.space.summary() {
            line("functions", summary);
        }
        line("grid parts", grid.paths().join(", "));
        for (index, body) in points.bodies.iter().enumerate() {
            for block in points.blocks.iter().filter(|block| block.body == index) {
                line(&format!("body {body}"), describe(block));
            }
        }
        if let Some(volume) = body_measure(model, points) {
            line("volume of the body mesh", format!("{volume:.6e} m³"));
        }
        if !points.conditions.is_empty() {
            line("material-point conditions", points.conditions.len().to_string());
        }
        if !points.conditions.grid.is_empty() {
            line("grid loads", points.conditions.grid.len().to_string());
        }
        let mut active = ActiveCells::default();
        active.gather(&points.blocks, grid.elements.len());
        let unknowns = points.dimension() + usize::from(self.settings.mixed.is_some());
        let dofs = self.space.active_dofs(&active.cells, unknowns);
        line("dofs at the start", format!("{} on {} active cells", dofs.order(), active.len()));
        let bytes: usize = points.blocks.iter().map(Block::bytes).sum();
        let each = bytes as f64 / points.len().max(1) as f64;
        line("memory of the points", format!("{:.3} MB, {each:.0} bytes a point", bytes as f64 / 1e6));
        line("columns in use", columns(points, true));
        line("left out", columns(points, false));
        inventory.columns = column_uses(points);
        let (cells, nodes) = (grid.elements.len(), grid.nodes.len());
        inventory.counts = Counts { cells, nodes, points: points.len(), unknowns: dofs.order() };
        inventory.warnings = self.warnings(points, model);
        inventory
    }

    /// Points that were lost on the way, and points that lie in each other at its end.
    pub fn remarks(&self, model: &Model) -> Vec<String> {
        let Some(losses) = points_of(model).map(|points| &points.losses) else { return Vec::new() };
        let mut remarks = Vec::new();
        if losses.count > 0 {
            remarks.push(format!("{} and were erased, in the whole run", losses.since((0, 0.0))));
        }
        if losses.clamped > 0 {
            remarks.push(format!("material points were put back to the border of the grid {} times", losses.clamped));
        }
        if self.settings.discretisation.frame == Frame::Updated {
            remarks.extend(crowding(model, self.locator.as_ref()));
        }
        remarks
    }

    /// Legal but suspicious facts.
    fn warnings(&self, points: &MaterialPoints, model: &Model) -> Vec<String> {
        let is_mixed = self.settings.mixed.is_some();
        let mut warnings = body_warnings(model, points, is_mixed);
        warnings.extend(self.settings.unread());
        if self.settings.discretisation.frame == Frame::Total {
            warnings.extend(contact_warning(points, &self.space));
        }
        warnings.extend(self.materials.iter().flat_map(|material| material.warnings(!is_mixed)));
        let volume: f64 = points.blocks.iter().map(volume_of).sum();
        if let Some(body) = body_measure(model, points)
            && (volume / body - 1.0).abs() > 1e-6
            && points.losses.count == 0
        {
            warnings.push(format!("the volume of the points, {volume}, differs from that of the body mesh, {body}"));
        }
        warnings
    }
}

/// Several bodies in the total frame: no point ever leaves its cell, and bodies meet through cells.
fn contact_warning(points: &MaterialPoints, space: &Space) -> Option<String> {
    let mut owners = vec![None; space.len()];
    let mut joined = None;
    for block in &points.blocks {
        for &node in block.cell.iter().filter(|cell| **cell != NO_CELL).flat_map(|cell| space.nodes_of(*cell as usize))
        {
            let owner = *owners[node as usize].get_or_insert(block.body);
            if owner != block.body {
                joined.get_or_insert((owner, block.body));
            }
        }
    }
    let names = &points.bodies;
    match joined {
        Some((a, b)) => Some(format!(
            "{} and {} share nodes of the grid: in the total frame they stick together for good; updated_lagrangian lets bodies part",
            names[a], names[b]
        )),
        None if names.len() > 1 => {
            let help = "in the total frame bodies that share no node do not feel each other: updated_lagrangian lets them meet";
            Some(help.to_owned())
        }
        None => None,
    }
}

/// Elements of the bodies that make no points, or make them twice; names that promise another
/// formulation than the scene's.
fn body_warnings(model: &Model, points: &MaterialPoints, is_mixed: bool) -> Vec<String> {
    let Some(bodies) = model.part(&format!("Initial_{}", points.name)) else { return Vec::new() };
    let mut owners = vec![0u32; bodies.elements.len()];
    for &element in bodies.children.iter().flat_map(|child| &child.elements) {
        owners[element as usize] += 1;
    }
    let mut warnings = Vec::new();
    let mut tell = |count: usize, text: &str| match count {
        0 => {}
        1 => warnings.push(format!("1 element of the bodies belongs to {text}")),
        _ => warnings.push(format!("{count} elements of the bodies belong to {text}")),
    };
    let count = |wanted: fn(u32) -> bool| owners.iter().filter(|owners| wanted(**owners)).count();
    tell(count(|owners| owners == 0), "no sub model part and makes no material points");
    tell(count(|owners| owners > 1), "several sub model parts of the first level and makes material points in each");
    let axisymmetric = points.kinematics == Kinematics::Axisymmetric;
    for name in bodies.elements.names.iter().filter(|name| name.starts_with("MPM")) {
        if name.contains("Axisymmetry") && !axisymmetric {
            warnings.push(format!("{name} is computed as {}: set axis_symmetric_flag to true", points.kinematics));
        } else if name.contains("UP") && !is_mixed {
            warnings.push(format!("{name} is computed without pressure dofs, as pressure_dofs is false"));
        }
    }
    warnings
}

fn volume_of(block: &Block) -> f64 {
    block.mass.values().iter().sum::<f64>() / block.density
}

/// Volume of the body mesh from its cells and what their materials say of the extent across them;
/// none under axisymmetry, where quadrature does not give the exact volume.
fn body_measure(model: &Model, points: &MaterialPoints) -> Option<f64> {
    let bodies = model.part(&format!("Initial_{}", points.name))?;
    if points.kinematics == Kinematics::Axisymmetric {
        return None;
    }
    let measure = |&element: &u32| {
        let element = element as usize;
        let (shape, corners) = (bodies.elements.shapes[element], bodies.corners(&bodies.elements, element));
        let size = if shape.dimension() == 2 { shape.plane_area(&corners) } else { shape.measure(&corners) };
        let material = bodies.properties.get(&bodies.elements.properties[element]);
        let extent = across(points.kinematics).and_then(|name| material.and_then(|m| m.number(name)));
        size * extent.unwrap_or(1.0)
    };
    Some(bodies.children.iter().flat_map(|child| &child.elements).map(measure).sum())
}

fn describe(block: &Block) -> String {
    let mass: f64 = block.mass.values().iter().sum();
    format!(
        "{} points, {}, {}, mass {mass:.6e} kg, volume {:.6e} m³, wave speed {:.4e} m/s",
        block.len(),
        block.kinematics,
        block.law_name,
        mass / block.density,
        block.law.wave_speed(block.density)
    )
}

fn columns(points: &MaterialPoints, used: bool) -> String {
    let Some(block) = points.blocks.first() else { return String::new() };
    let names = block.columns().into_iter().filter(|(_, column)| column.is_used() == used).map(|(name, _)| name);
    names.collect::<Vec<_>>().join(", ")
}

/// All columns with their sizes over all blocks.
fn column_uses(points: &MaterialPoints) -> Vec<ColumnUse> {
    let mut uses = vec![ColumnUse { name: "ids and cells", bytes: 8 * points.len() }];
    for (name, bytes) in points.blocks.iter().flat_map(|block| block.columns().map(|(name, c)| (name, c.bytes()))) {
        match uses.iter_mut().find(|known| known.name == name) {
            Some(known) => known.bytes += bytes,
            None => uses.push(ColumnUse { name, bytes }),
        }
    }
    uses
}

/// Writes the points with every column in use to `failed_state.vtu`.
pub fn save_state(model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let Some(points) = points_of(model) else { return Ok(Vec::new()) };
    let order = points.by_id(Selection::All);
    let mut data = Dataset {
        points: order.iter().map(|&(b, p)| points.blocks[b as usize].coordinates(p as usize)).collect(),
        cells: CellsOf::Vertices,
        point_fields: Vec::new(),
        cell_fields: Vec::new(),
    };
    let ids = order.iter().map(|&(b, p)| points.blocks[b as usize].ids[p as usize] as i32).collect();
    data.point_fields.push(Field { name: "ID".into(), components: 1, values: FieldData::I32(ids) });
    let jacobians =
        order.iter().map(|&(b, p)| points.blocks[b as usize].deformation_gradient(p as usize).determinant());
    data.point_fields.push(Field { name: "J".into(), components: 1, values: FieldData::F64(jacobians.collect()) });
    let used = |column: fn(&Block) -> &Column| points.blocks.iter().all(|block| column(block).is_used());
    for (variable, used) in [
        ("MP_DISPLACEMENT", used(|block| &block.displacement)),
        ("MP_VELOCITY", used(|block| &block.velocity)),
        ("MP_CAUCHY_STRESS_VECTOR", used(|block| &block.stress)),
        ("MP_PRESSURE", used(|block| &block.pressure)),
    ] {
        if used {
            let mut values = Vec::new();
            order.iter().for_each(|&(b, p)| {
                append(&points.blocks[b as usize], p as usize, variable, &mut values);
            });
            let components = values.len() / order.len().max(1);
            data.point_fields.push(Field { name: variable.into(), components, values: FieldData::F64(values) });
        }
    }
    write_failed_state(&data, folder)
}
