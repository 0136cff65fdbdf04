//! The number of threads changes no bit of any result (a promise of the design, which nothing else
//! than equality can test).

mod common;

use common::{Cell, Mesh, Scene, fix, gravity, material, process};
use serde_json::{Value, json};

/// Everything of a record but times, memory and the number of threads.
fn results(scene: &Scene, threads: &str) -> Value {
    let mut json = scene.run(&["--threads", threads, "--record-states", "3"]).json;
    assert_eq!(json["threads"].to_string(), threads, "the run used other threads than asked for");
    let members = json.as_object_mut().unwrap();
    members.retain(|key, _| !key.ends_with("_s") && !key.ends_with("_mb") && key != "threads");
    json
}

fn assert_same_bits(name: &str, scene: &Scene) {
    let one = results(scene, "1");
    let count = one["n_mp"].as_u64().unwrap();
    assert!(count > 1000, "{name}: {count} points are too few to be shared among threads");
    for threads in ["2", "8"] {
        let many = results(scene, threads);
        // Numbers are written so that different doubles have different texts.
        assert!(one == many, "{name}: {threads} threads give other results than one");
    }
}

fn dynamic(scheme: &str) -> Value {
    json!({"solver_type": "dynamic", "scheme_type": scheme, "time_stepping": {"time_step": 0.005},
           "residual_relative_tolerance": 1e-7})
}

fn velocity(functions: Value) -> Value {
    let parameters = json!({"model_part_name": "MPM_Material", "value": functions});
    process("assign_initial_field_to_material_point_process", parameters)
}

#[test]
fn plane_dynamics_with_two_laws_and_moving_points() {
    let grid = Mesh::block(Cell::Triangle, [24, 24, 1], [0.0; 3], [2.0, 2.0, 0.0]);
    let body = Mesh::block(Cell::Triangle, [18, 9, 1], [0.2, 0.1, 0.0], [1.7, 0.8, 0.0]);
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 3, 1000.0, 1e5, 0.3);
    let mut scene = Scene::new(grid, body, law, dynamic("newmark"), 0.049)
        .part("Floor", |x| x[1] == 0.0)
        .with(fix("Floor", json!([0.0, 0.0, 0.0])))
        .with(gravity([0.0, -9.81, 0.0]))
        .with(velocity(json!(["sin(5*y)", "-2 + cos(7*x)", 0.0])));
    let other = Mesh::block(Cell::Triangle, [9, 9, 1], [0.4, 0.9, 0.0], [1.1, 1.6, 0.0]);
    let law = material("LinearElasticIsotropicPlaneStrain2DLaw", 6, 700.0, 2e5, 0.2);
    scene.bodies.push(common::Body { name: "Other", mesh: other, material: law });
    assert_same_bits("plane, dynamic", &scene);
}

#[test]
fn space_dynamics_with_body_acceleration() {
    let grid = Mesh::block(Cell::Hexahedron, [8, 8, 8], [0.0; 3], [1.0; 3]);
    let body = Mesh::block(Cell::Hexahedron, [6, 6, 6], [0.1; 3], [0.8; 3]);
    let functions = json!(["sin(9*y)*t", "-9.81", "x*cos(z)"]);
    let acceleration = json!({"model_part_name": "MPM_Material", "value": functions});
    let scene =
        Scene::new(grid, body, material("HyperElasticNeoHookean3DLaw", 8, 1000.0, 1e5, 0.3), dynamic("bossak"), 0.014)
            .with(process("assign_body_acceleration_to_material_point_process", acceleration))
            .with(velocity(json!(["z", "-x", "y*x"])));
    assert_same_bits("space, dynamic", &scene);
}

#[test]
fn statics_with_loads() {
    let mesh = Mesh::block(Cell::Quadrilateral, [20, 16, 1], [0.0; 3], [2.0, 1.0, 0.0]);
    let solver = json!({"solver_type": "static", "compute_reactions": true, "residual_relative_tolerance": 1e-7});
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1000.0, 1e7, 0.3);
    let mut scene = Scene::new(mesh.clone(), mesh, law, solver, 2.0)
        .part("Clamp", |x| x[0] == 0.0)
        .with(fix("Clamp", json!([0.0, 0.0, 0.0])))
        .with(gravity([0.0, -9.81, 0.0]));
    let top = (0..20).map(|i| vec![16 * 21 + i, 16 * 21 + i + 1]).collect();
    scene.loads.push(("Top", "MPMGridLineLoadCondition2D2N", top));
    let load = json!({"model_part_name": "Background_Grid.Top", "variable_name": "LINE_LOAD",
                      "modulus": "2000*(1 + x)", "direction": [0.0, -1.0, 0.0]});
    assert_same_bits("plane, static", &scene.with(process("assign_vector_by_direction_to_condition_process", load)));
}

#[test]
fn iterative_solver_in_space() {
    let mesh = Mesh::block(Cell::Tetrahedron, [5, 5, 4], [0.0; 3], [1.0; 3]);
    let solver = json!({"solver_type": "quasi_static", "residual_relative_tolerance": 1e-6,
                        "linear_solver_settings": {"solver_type": "amgcl", "krylov_type": "cg", "tolerance": 1e-9}});
    let scene =
        Scene::new(mesh.clone(), mesh, material("LinearElasticIsotropic3DLaw", 4, 1000.0, 1e6, 0.3), solver, 2.0)
            .part("Floor", |x| x[2] == 0.0)
            .with(fix("Floor", json!([0.0, 0.0, 0.0])))
            .with(gravity([1.0, 0.0, -9.81]));
    assert_same_bits("space, quasi-static, iterative", &scene);
}
