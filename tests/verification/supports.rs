//! The motion that supports have, and what of it reaches the points beside them.

use super::common::{Cell, Mesh, Record, Scene, fix, process};
use serde_json::{Value, json};

/// Fastest flow in m/s of y (1 − y)/4 of it.
const FLOW: &str = "0.004*y*(1-y)";

fn flow(y: f64) -> f64 {
    0.004 * y * (1.0 - y)
}

fn velocity(value: [&str; 3]) -> Value {
    let parameters = json!({"model_part_name": "MPM_Material", "value": value});
    process("assign_initial_field_to_material_point_process", parameters)
}

/// Poiseuille flow between walls 1 m apart, as it is when it has settled: a body force of 8e-3 μ holds it. Inlet and
/// outlet move with it.
fn poiseuille(cells: usize, viscosity: f64, held_motion: &str, end_time: f64) -> Record {
    let mesh = Mesh::block(Cell::Quadrilateral, [cells / 2, cells, 0], [0.0; 3], [0.5, 1.0, 0.0]);
    let fluid = json!({
        "constitutive_law": {"name": "DispNewtonianFluidPlaneStrain2DLaw"},
        "Variables": {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 4, "DENSITY": 1.0, "BULK_MODULUS": 1e4,
                      "DYNAMIC_VISCOSITY": viscosity}
    });
    let solver = json!({"solver_type": "dynamic", "scheme_type": "bossak", "point_velocity_rule": "scheme",
                        "held_motion": held_motion, "time_stepping": {"time_step": 0.1}});
    let force = json!({"model_part_name": "MPM_Material", "value": [8e-3 * viscosity, 0.0, 0.0]});
    let on_walls = |[_, y, _]: [f64; 3]| y == 0.0 || y == 1.0;
    Scene::new(mesh.clone(), mesh, fluid, solver, end_time - 0.05)
        .part("Walls", on_walls)
        .part("Sides", move |x| (x[0] == 0.0 || x[0] == 0.5) && !on_walls(x))
        .with(fix("Walls", json!([0.0, 0.0, null])))
        .with(fix("Sides", json!([format!("0.1*{FLOW}"), 0.0, null])))
        .with(process("assign_body_acceleration_to_material_point_process", force))
        .with(velocity([FLOW, "0", "0"]))
        .run(&["--record-states", "1"])
}

/// √(Σ |v − v_exact|² / Σ |v_exact|²) over the points at the end.
fn error(record: &Record) -> f64 {
    let state = record.last();
    let (mut difference, mut all) = (0.0, 0.0);
    for (x, v) in state.points("MP_COORD").iter().zip(state.points("MP_VELOCITY")) {
        difference += (v[0] - flow(x[1])).powi(2) + v[1] * v[1];
        all += flow(x[1]).powi(2);
    }
    (difference / all).sqrt()
}

/// Held nodes that start each step with the velocity of the points beside stop these points a little in each: an
/// error of first order in the cells along the wall, hence of order 3/2 in the mean. With the velocity of the support
/// it is that of hats, of second order.
#[test]
fn flow_along_walls_is_of_second_order_where_they_have_their_own_velocity() {
    let of = |held: &str| [4, 8, 16].map(|cells| error(&poiseuille(cells, 1.0, held, 3.0)));
    let (gathered, imposed) = (of("gathered"), of("imposed"));
    let orders = |errors: [f64; 3]| super::common::orders(&errors);
    assert!(orders(imposed).iter().all(|order| *order > 1.9), "{imposed:?}");
    assert!(orders(gathered).iter().all(|order| *order < 1.6), "{gathered:?}");
    assert!(imposed[1] < 0.02 && gathered[1] > 5.0 * imposed[1], "{imposed:?} {gathered:?}");
}

/// A flow that viscosity holds in balance from the first instant on does not start with the acceleration of its body
/// force, 8 m/s² here, of which half a step would be 400 times the flow.
#[test]
fn a_flow_in_balance_starts_without_acceleration() {
    let error = error(&poiseuille(8, 1000.0, "imposed", 0.1));
    assert!(error < 0.03, "{error}");
}

/// A block on a grid whose nodes are all held and move by `velocity` from the first step on. The largest difference
/// of the points' velocities from it after some steps.
fn carried(solver: Value, velocity: [&str; 2], start: [&str; 2], exact: impl Fn(&[f64]) -> [f64; 2]) -> f64 {
    let mesh = Mesh::block(Cell::Quadrilateral, [3, 3, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let law = super::common::material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1000.0, 1e4, 0.3);
    let increment = |v: &str| json!(format!("1e-3*({v})"));
    let record = Scene::new(mesh.clone(), mesh, law, solver, 0.01 - 5e-4)
        .part("All", |_| true)
        .with(fix("All", json!([increment(velocity[0]), increment(velocity[1]), null])))
        .with(self::velocity([start[0], start[1], "0"]))
        .run(&["--record-states", "1"]);
    let state = record.last();
    let pairs = state.points("MP_COORD").into_iter().zip(state.points("MP_VELOCITY"));
    pairs.flat_map(|(x, v)| [0, 1].map(|a| (v[a] - exact(&x)[a]).abs())).fold(0.0, f64::max)
}

/// Supports that set off take the points beside with them, and a body that has their motion already is left alone.
#[test]
fn points_go_with_supports_that_set_off() {
    let implicit = |held: &str| json!({"solver_type": "dynamic", "scheme_type": "newmark", "held_motion": held, "time_stepping": {"time_step": 1e-3}});
    let explicit = |frame: &str, update: &str| {
        json!({"solver_type": "dynamic", "time_integration_method": "explicit", "scheme_type": "forward_euler",
               "frame": frame, "stress_update": update, "time_stepping": {"time_step": 1e-3}})
    };
    let mut total = implicit("gathered");
    total["frame"] = "total_lagrangian".into();
    for solver in [
        implicit("imposed"),
        total,
        explicit("updated_lagrangian", "usl"),
        explicit("updated_lagrangian", "musl"),
        explicit("total_lagrangian", "musl"),
    ] {
        let off = carried(solver.clone(), ["0.1", "-0.2"], ["0", "0"], |_| [0.1, -0.2]);
        assert!(off < 1e-12, "{solver}: points beside supports that set off lag by {off:e}");
        // The field is one of places, or of first places in the total frame: a slope of 0.01 by a way of 1e-3 m, twice.
        let field = |x: &[f64]| [0.1 - 0.01 * x[1], 0.01 * x[0]];
        let along = carried(solver.clone(), ["0.1-0.01*y", "0.01*x"], ["0.1-0.01*y", "0.01*x"], field);
        assert!(along < 2e-5, "{solver}: points that go along differ by {along:e}");
    }
}

/// A column of twenty thin cells is pressed together by six times their thickness in one step: the top row would be
/// turned inside out if the rest stood still at first. All points move by the same share of their height.
#[test]
fn thin_cells_follow_a_support_that_moves_by_more_than_their_thickness() {
    let solver = |members: Value| {
        let mut solver = json!({"max_iteration": 30});
        solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        solver
    };
    let mixed = json!({"pressure_dofs": true, "stabilization": "ppp"});
    for (cell, points, law, members) in [
        (Cell::Quadrilateral, 4, "HyperElasticNeoHookeanPlaneStrain2DLaw", json!({})),
        (Cell::Triangle, 3, "HyperElasticNeoHookeanPlaneStrain2DLaw", json!({"frame": "total_lagrangian"})),
        (Cell::Hexahedron, 8, "HyperElasticNeoHookean3DLaw", json!({})),
        (Cell::Quadrilateral, 4, "HyperElasticNeoHookeanPlaneStrainUP2DLaw", mixed),
    ] {
        let mesh = Mesh::block(cell, [2, 20, 1], [0.0; 3], [0.2, 1.0, 0.1]);
        let law = super::common::material(law, points, 1000.0, 1e6, 0.3);
        let record = Scene::new(mesh.clone(), mesh, law, solver(members.clone()), 0.5)
            .part("Floor", |x| x[1] == 0.0)
            .part("Top", |x| x[1] == 1.0)
            .part("Sides", move |[x, y, _]| y > 0.0 && y < 1.0 && (x == 0.0 || x == 0.2 || cell == Cell::Hexahedron))
            .with(fix("Floor", json!([0.0, 0.0, 0.0])))
            .with(fix("Top", json!([0.0, -0.3, 0.0])))
            .with(fix("Sides", json!([0.0, null, 0.0])))
            .run(&["--record-states", "1"]);
        let places = record.first().points("MP_COORD").into_iter().zip(record.last().points("MP_COORD"));
        let off = places.map(|(x, now)| (now[1] - 0.7 * x[1]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{cell:?} {members}: {off:e}");
    }
}
