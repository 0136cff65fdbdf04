//! The account of a run, and the state after a failure.

use crate::engine::Engine;
use crate::fields::{OF_POINTS, append, energies};
use bia_kernel::analysis::number;
use bia_kernel::error::Error;
use bia_kernel::io::dataset::{Dataset, Field, FieldData};
use bia_kernel::io::json::JsonObject;
use bia_kernel::solving::solver::write_failed_state;
use bia_kernel::variables::{Rank, Variable};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes energies, sums and fields of all points.
///
/// # Errors
/// The file cannot be written.
pub fn snapshot(engine: &dyn Engine, out: &mut JsonObject) -> std::io::Result<()> {
    let (kinetic, strain) = energies(engine, 0..engine.len());
    let strain = strain.unwrap_or(f64::NAN);
    let all = json!({"kinetic": number(kinetic), "strain": number(strain), "total": number(kinetic + strain),
                     "boundary_work": number(engine.work())});
    out.value("energies", &all)?;
    out.value("sums", &sums(engine))?;
    out.object("mp", |out| {
        out.integers("ids", (1..=engine.len()).map(|id| id as u32))?;
        for variable in OF_POINTS {
            let value = |point: usize| {
                let mut row = Vec::with_capacity(9);
                append(engine, point, variable.name, &mut row);
                row
            };
            if variable.rank == Rank::Scalar {
                out.numbers(variable.name, (0..engine.len()).flat_map(value))?;
            } else {
                out.rows(variable.name, (0..engine.len()).map(value))?;
            }
        }
        Ok(())
    })
}

fn sums(engine: &dyn Engine) -> serde_json::Value {
    let (mut mass, mut volume, mut momentum, mut angular, mut moment) = (0.0, 0.0, [0.0; 3], [0.0; 3], [0.0; 3]);
    for point in (0..engine.len()).map(|index| engine.point(index)) {
        let x: [f64; 3] = std::array::from_fn(|a| point.initial[a] + point.displacement[a]);
        let p = point.velocity.map(|v| point.mass * v);
        mass += point.mass;
        volume += point.volume * point.gradient.determinant();
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            momentum[a] += p[a];
            moment[a] += point.mass * x[a];
            angular[a] += x[b] * p[c] - x[c] * p[b];
        }
    }
    json!({"mass": number(mass), "volume": number(volume), "momentum": momentum.map(number),
           "angular_momentum": angular.map(number), "com": moment.map(|x| number(x / mass))})
}

/// A field of chosen points.
pub fn field(engine: &dyn Engine, points: &[usize], variable: &Variable) -> Field {
    let mut values = Vec::new();
    points.iter().for_each(|&point| append(engine, point, variable.name, &mut values));
    let components = values.len().checked_div(points.len()).unwrap_or(1).max(1);
    Field { name: variable.name.into(), components, values: FieldData::F64(values) }
}

/// Chosen points where they are now, without fields.
pub fn dataset(engine: &dyn Engine, points: &[usize]) -> Dataset {
    let place = |&index: &usize| {
        let point = engine.point(index);
        std::array::from_fn(|a| point.initial[a] + point.displacement[a])
    };
    Dataset::vertices(points.iter().map(place).collect())
}

/// Writes the points with all their variables to `failed_state.vtu`.
///
/// # Errors
/// The folder cannot be written.
pub fn save_state(engine: &dyn Engine, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let all: Vec<usize> = (0..engine.len()).collect();
    let mut data = dataset(engine, &all);
    data.point_fields = OF_POINTS.iter().map(|variable| field(engine, &all, variable)).collect();
    write_failed_state(&data, folder)
}
