//! The account of a run, in the layout that Kratos's reference results have.

use crate::grid::GRID;
use crate::points::conditions::PointConditions;
use crate::points::fields::{CONDITION_VARIABLES, append, append_condition, energies, total_energies};
use crate::points::{MaterialPoints, Selection};
use crate::variables::{DISPLACEMENT, NODAL_MASS, PRESSURE, PRESSURE_REACTION, REACTION};
use bia_kernel::analysis::number;
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart};
use serde_json::{Map, Value, json};
use std::io::Result;

const POINT_FIELDS: &[(&str, bool)] = &[
    ("MP_COORD", true),
    ("MP_DISPLACEMENT", true),
    ("MP_VELOCITY", true),
    ("MP_ACCELERATION", true),
    ("MP_VOLUME_ACCELERATION", true),
    ("MP_CAUCHY_STRESS_VECTOR", true),
    ("MP_ALMANSI_STRAIN_VECTOR", true),
    ("MP_MASS", false),
    ("MP_VOLUME", false),
    ("MP_DENSITY", false),
    ("MP_MATERIAL_ID", false),
];

/// Counts and laws for the head of the account.
pub fn account(model: &Model) -> Map<String, Value> {
    let mut head = Map::new();
    if let (Some(points), Some(grid)) = (model.extension::<MaterialPoints>(), model.part(GRID)) {
        let mut laws: Vec<&str> = points.blocks.iter().map(|block| block.law_name.as_str()).collect();
        laws.sort_unstable();
        laws.dedup();
        head.insert("n_mp".into(), (points.len() + points.losses.count).into());
        head.insert("n_mpc".into(), (points.conditions.len() + points.conditions.grid.len()).into());
        head.insert("n_grid_nodes".into(), grid.nodes.len().into());
        head.insert("n_grid_elements".into(), grid.elements.len().into());
        head.insert("laws".into(), json!(laws));
        head.insert("lost_points".into(), points.losses.count.into());
        head.insert("lost_mass".into(), number(points.losses.mass));
        head.insert("lost_ids".into(), json!(points.losses.ids));
        head.insert("clamped_points".into(), points.losses.clamped.into());
    }
    head
}

/// Writes energies, sums and fields of all points, conditions and grid nodes.
///
/// # Errors
/// The file cannot be written.
pub fn snapshot(model: &Model, out: &mut JsonObject) -> Result<()> {
    let (Some(points), Some(grid)) = (model.extension::<MaterialPoints>(), model.part(GRID)) else {
        return Ok(());
    };
    out.value("n_mp", &points.len().into())?;
    let total = total_energies(points, Selection::All);
    let energies = json!({"potential": number(total.potential), "kinetic": number(total.kinetic),
        "strain": number(total.strain), "total": number(total.total())});
    out.value("energies", &energies)?;
    out.value("sums", &sums(points))?;
    out.object("mp", |out| point_fields(points, out))?;
    if !points.conditions.is_empty() || !points.conditions.grid.is_empty() {
        out.object("mpc", |out| condition_fields(&points.conditions, out))?;
    }
    out.object("nodes", |out| node_fields(grid, out))
}

fn sums(points: &MaterialPoints) -> Value {
    let (mut mass, mut volume, mut momentum, mut moment) = (0.0, 0.0, [0.0; 3], [0.0; 3]);
    let mut angular = [0.0; 3];
    let mut kinetic = 0.0;
    // In the order of ids, so that the last digits do not depend on how the solver keeps the points.
    for block in &points.blocks {
        for point in block.in_order_of_id().into_iter().map(|point| point as usize) {
            let m = block.mass.row(point)[0];
            mass += m;
            volume += block.volume.row(point).first().copied().unwrap_or(0.0);
            kinetic += energies(block, point).kinetic;
            block.velocity.row(point).iter().zip(&mut momentum).for_each(|(v, sum)| *sum += m * v);
            block.position.row(point).iter().zip(&mut moment).for_each(|(x, sum)| *sum += m * x);
            let of_point = block.angular_momentum(point, [0.0; 3]);
            angular.iter_mut().zip(of_point).for_each(|(sum, l)| *sum += l);
        }
    }
    json!({"mass": number(mass), "volume": number(volume), "momentum": momentum.map(number),
           "angular_momentum": angular.map(number), "com": moment.map(|x| number(x / mass)), "kinetic_from_mp": number(kinetic)})
}

fn point_fields(points: &MaterialPoints, out: &mut JsonObject) -> Result<()> {
    let order = points.by_id(Selection::All);
    let block_of = |b: u32| &points.blocks[b as usize];
    out.integers("ids", order.iter().map(|&(b, p)| block_of(b).ids[p as usize]))?;
    let mixed = points.blocks.iter().all(|block| block.pressure.is_used());
    let of_mixed = mixed.then_some(("MP_PRESSURE", false));
    for (name, vector) in POINT_FIELDS.iter().copied().chain(of_mixed) {
        let value = |&(b, p): &(u32, u32)| {
            let mut row = Vec::with_capacity(6);
            append(block_of(b), p as usize, name, &mut row);
            row
        };
        if vector {
            out.rows(name, order.iter().map(value))?;
        } else {
            out.numbers(name, order.iter().flat_map(value))?;
        }
    }
    Ok(())
}

fn condition_fields(conditions: &PointConditions, out: &mut JsonObject) -> Result<()> {
    out.integers("ids", conditions.grid_ids.iter().chain(&conditions.ids).copied())?;
    if conditions.grid_ids.is_empty() {
        for name in CONDITION_VARIABLES {
            let value = |i: usize| {
                let mut row = Vec::with_capacity(3);
                append_condition(conditions, i, name, &mut row);
                row
            };
            if *name == "MPC_AREA" {
                out.numbers(name, (0..conditions.len()).flat_map(value))?;
            } else {
                out.rows(name, (0..conditions.len()).map(value))?;
            }
        }
    }
    Ok(())
}

fn node_fields(grid: &ModelPart, out: &mut JsonObject) -> Result<()> {
    out.integers("ids", grid.nodes.ids.iter().copied())?;
    for variable in [&DISPLACEMENT, &REACTION] {
        if let Some(column) = grid.node_fields.vector(variable) {
            out.rows(variable.name, column)?;
        }
    }
    for variable in [&PRESSURE, &PRESSURE_REACTION] {
        if let Some(column) = grid.node_fields.scalar(variable) {
            out.numbers(variable.name, column.iter().copied())?;
        }
    }
    let zeros = vec![0.0; grid.nodes.len()];
    let mass = grid.node_fields.scalar(&NODAL_MASS).unwrap_or(&zeros);
    out.numbers(NODAL_MASS.name, mass.iter().copied())
}
