//! What the transfers between points and grid keep, and how accurate they are: both frames, all
//! functions of the grid, explicit schemes.

#[path = "../common/mod.rs"]
mod common;
mod inventory;
mod manufactured;
mod momentum;
mod rotation;
mod start;
mod unstable;

use common::{Cell, Mesh, Scene, material, process};
use serde_json::{Map, Value, json};

const NEO_HOOKEAN: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";

/// Functions of the grid, with points a cell that determine them.
#[derive(Clone, Copy, Debug)]
struct Functions {
    basis: &'static str,
    order: usize,
    points: usize,
}

const HATS: Functions = Functions { basis: "mesh", order: 1, points: 4 };
const QUADRATIC: Functions = Functions { basis: "lagrange", order: 2, points: 9 };
const SPLINE: Functions = Functions { basis: "b_spline", order: 2, points: 9 };
const CUBIC: Functions = Functions { basis: "b_spline", order: 3, points: 9 };

#[derive(Clone, Copy, Debug, PartialEq)]
enum Frame {
    Updated,
    Total,
}

/// Settings of an explicit run; `members` add to them or replace them.
fn explicit(frame: Frame, functions: Functions, time_step: f64, members: &Value) -> Value {
    let frame = if frame == Frame::Total { "total_lagrangian" } else { "updated_lagrangian" };
    let mut settings = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
        "scheme_type": "forward_euler", "frame": frame, "basis": functions.basis, "basis_order": functions.order,
        "time_stepping": {"time_step": time_step}});
    let known: &mut Map<String, Value> = settings.as_object_mut().unwrap();
    known.extend(members.as_object().unwrap().clone());
    settings
}

/// The velocity that the points of a part start with.
fn initial_velocity(part: &str, value: [&str; 3]) -> Value {
    let parameters = json!({"model_part_name": part, "value": value});
    process("assign_initial_field_to_material_point_process", parameters)
}

/// A soft block of 1 m in 4 by 4 cells, free: it turns once in 0.6 s and swings. In the updated frame
/// the grid has room about it, so that points cross cells.
fn turning_block(frame: Frame, functions: Functions, solver: Value, end_time: f64) -> Scene {
    let body = Mesh::block(Cell::Quadrilateral, [4, 4, 0], [-0.5, -0.5, 0.0], [0.5, 0.5, 0.0]);
    let room = Mesh::block(Cell::Quadrilateral, [8, 8, 0], [-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]);
    let grid = if frame == Frame::Total { body.clone() } else { room };
    let law = material(NEO_HOOKEAN, functions.points, 1000.0, 1e6, 0.3);
    Scene::new(grid, body, law, solver, end_time)
        .with(initial_velocity("MPM_Material", ["1 - 10*y + 2*x*x", "10*x - y", "0"]))
}
