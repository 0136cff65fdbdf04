//! The account of a run, in the layout that Kratos's reference results have.

use crate::implicit::GRID;
use crate::points::MaterialPoints;
use crate::points::conditions::PointConditions;
use crate::points::fields::{CONDITION_VARIABLES, append, append_condition, energies, total_energies};
use crate::variables::{DISPLACEMENT, NODAL_MASS, REACTION};
use bia_kernel::analysis::number;
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::solving::solver::Snapshot;
use serde_json::{Map, Value, json};

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
pub fn account(model: &Model) -> Snapshot {
    let mut head = Map::new();
    if let (Some(points), Some(grid)) = (model.extension::<MaterialPoints>(), model.part(GRID)) {
        let mut laws: Vec<&str> = points.blocks.iter().map(|block| block.law_name.as_str()).collect();
        laws.sort_unstable();
        laws.dedup();
        head.insert("n_mp".into(), (points.len() + points.lost).into());
        head.insert("n_mpc".into(), (points.conditions.len() + points.conditions.grid.len()).into());
        head.insert("n_grid_nodes".into(), grid.nodes.len().into());
        head.insert("n_grid_elements".into(), grid.elements.len().into());
        head.insert("laws".into(), json!(laws));
    }
    Snapshot(head)
}

/// Energies, sums and fields of all points, conditions and grid nodes.
pub fn snapshot(model: &Model) -> Snapshot {
    let mut map = Map::new();
    let (Some(points), Some(grid)) = (model.extension::<MaterialPoints>(), model.part(GRID)) else {
        return Snapshot(map);
    };
    map.insert("n_mp".into(), points.len().into());
    let total = total_energies(points, None);
    map.insert(
        "energies".into(),
        json!({"potential": number(total.potential), "kinetic": number(total.kinetic),
               "strain": number(total.strain), "total": number(total.total())}),
    );
    map.insert("sums".into(), sums(points));
    map.insert("mp".into(), point_fields(points));
    if !points.conditions.is_empty() || !points.conditions.grid.is_empty() {
        map.insert("mpc".into(), condition_fields(&points.conditions));
    }
    map.insert("nodes".into(), node_fields(grid));
    Snapshot(map)
}

fn sums(points: &MaterialPoints) -> Value {
    let (mut mass, mut volume, mut momentum, mut moment) = (0.0, 0.0, [0.0; 3], [0.0; 3]);
    for block in &points.blocks {
        for point in 0..block.len() {
            let m = block.mass.row(point)[0];
            mass += m;
            volume += block.volume.row(point).first().copied().unwrap_or(0.0);
            block.velocity.row(point).iter().zip(&mut momentum).for_each(|(v, sum)| *sum += m * v);
            block.position.row(point).iter().zip(&mut moment).for_each(|(x, sum)| *sum += m * x);
        }
    }
    let kinetic: f64 =
        points.blocks.iter().map(|b| (0..b.len()).map(|p| energies(b, p).kinetic).sum::<f64>()).sum();
    json!({"mass": number(mass), "volume": number(volume), "momentum": momentum.map(number),
           "com": moment.map(|x| number(x / mass)), "kinetic_from_mp": number(kinetic)})
}

fn rows(values: &[f64], width: usize, vector: bool) -> Value {
    if vector {
        Value::Array(values.chunks(width.max(1)).map(|row| row.iter().map(|x| number(*x)).collect()).collect())
    } else {
        values.iter().map(|x| number(*x)).collect()
    }
}

fn point_fields(points: &MaterialPoints) -> Value {
    let order = points.by_id(None);
    let mut map = Map::new();
    let ids: Vec<u32> = order.iter().map(|&(b, p)| points.blocks[b as usize].ids[p as usize]).collect();
    map.insert("ids".into(), json!(ids));
    for &(name, vector) in POINT_FIELDS {
        let mut values = Vec::new();
        for &(block, point) in &order {
            append(&points.blocks[block as usize], point as usize, name, &mut values);
        }
        map.insert(name.into(), rows(&values, values.len() / order.len().max(1), vector));
    }
    Value::Object(map)
}

fn condition_fields(conditions: &PointConditions) -> Value {
    let mut map = Map::new();
    let ids: Vec<u32> = conditions.grid_ids.iter().chain(&conditions.ids).copied().collect();
    map.insert("ids".into(), json!(ids));
    if conditions.grid_ids.is_empty() {
        for name in CONDITION_VARIABLES {
            let mut values = Vec::new();
            (0..conditions.len()).for_each(|i| {
                append_condition(conditions, i, name, &mut values);
            });
            map.insert((*name).into(), rows(&values, 3, *name != "MPC_AREA"));
        }
    }
    Value::Object(map)
}

fn node_fields(grid: &ModelPart) -> Value {
    let mut map = Map::new();
    map.insert("ids".into(), json!(grid.nodes.ids));
    for variable in [&DISPLACEMENT, &REACTION] {
        if let Some(column) = grid.node_fields.vector(variable) {
            map.insert(variable.name.into(), column.iter().map(|v| json!(v.map(number))).collect());
        }
    }
    let zeros = vec![0.0; grid.nodes.len()];
    let mass = grid.node_fields.scalar(&NODAL_MASS).unwrap_or(&zeros);
    map.insert("NODAL_MASS".into(), mass.iter().map(|m| number(*m)).collect());
    Value::Object(map)
}
