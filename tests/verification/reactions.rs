//! Reactions of static bodies balance what acts on them, as Newton's third law has it.

use super::common::{Cell, Mesh, Scene, fix, gravity, material, process};
use serde_json::{Value, json};

/// Cook's membrane (Cook 1974): 48 long, 44 high at the clamped left and 16 at the right.
fn membrane(cell: Cell, counts: [usize; 3]) -> Mesh {
    Mesh::block(cell, counts, [0.0; 3], [1.0, 1.0, 1.0])
        .map(|[x, y, z]| [0.48 * x, 0.44 * x + y * (0.44 - 0.28 * x), 0.1 * z])
}

fn load(condition_part: &str, variable: &str, modulus: Value, direction: [f64; 3]) -> Value {
    let parameters = json!({"model_part_name": format!("Background_Grid.{condition_part}"), "variable_name": variable,
                            "modulus": modulus, "direction": direction});
    process("assign_vector_by_direction_to_condition_process", parameters)
}

fn clamped(cell: Cell, points: usize, counts: [usize; 3]) -> Scene {
    let mesh = membrane(cell, counts);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let solver = json!({"compute_reactions": true, "residual_relative_tolerance": 1e-9});
    Scene::new(mesh.clone(), mesh, material(law, points, 1200.0, 1e8, 0.3), solver, 2.0)
        .part("Clamp", |x| x[0] == 0.0)
        .with(fix("Clamp", json!([0.0, 0.0, 0.0])))
        .with(gravity([0.5, -9.81, 0.0]))
}

/// Runs and compares with the load; two steps, the second of which starts from moved points. The
/// displacements are small: loads on nodes without points around them would be lost.
fn assert_balance(scene: &Scene, load: [f64; 3]) {
    let record = scene.run(&["--record-states", "2"]);
    assert_eq!(record.states().len(), 3);
    for state in &record.states()[1..] {
        let weight = [0.5, -9.81, 0.0].map(|g| g * state.mass());
        let reactions = state.nodes("REACTION");
        let size = reactions.iter().flatten().fold(0.0, |m: f64, r| m.max(r.abs()));
        for a in 0..3 {
            let held: f64 = reactions.iter().map(|r| r[a]).sum();
            let rest = held + load[a] + weight[a];
            assert!(rest.abs() < 1e-9 * size, "{:?}: {rest:e} N along {a} are left over", scene.grid.cell);
        }
        for (node, reaction) in reactions.iter().enumerate() {
            let free = scene.grid.nodes[node][0] != 0.0;
            assert!(!free || reaction.iter().all(|r| *r == 0.0), "free node {} has a reaction", node + 1);
        }
    }
}

#[test]
fn lines_and_points_in_the_plane() {
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 6)] {
        let mut scene = clamped(cell, points, [8, 6, 1]);
        // The right side from bottom to top: nodes 9, 18, … of each row of nine.
        let right: Vec<Vec<usize>> = (0..6).map(|j| vec![9 * j + 8, 9 * j + 17]).collect();
        scene.loads.push(("Right", "MPMGridLineLoadCondition2D2N", right));
        scene.loads.push(("Tip", "MPMGridPointLoadCondition2D1N", vec![vec![62]]));
        let scene = scene.with(load("Right", "LINE_LOAD", json!(3000.0), [0.0, 1.0, 0.0])).with(load(
            "Tip",
            "POINT_LOAD",
            json!(40.0),
            [-1.0, 0.0, 0.0],
        ));
        assert_balance(&scene, [-40.0, 3000.0 * 0.16, 0.0]);
    }
}

#[test]
fn surfaces_in_space() {
    let mut scene = clamped(Cell::Hexahedron, 8, [5, 4, 2]);
    let node = |j: usize, k: usize| (k * 5 + j) * 6 + 5;
    let face = |j: usize, k: usize| vec![node(j, k), node(j + 1, k), node(j + 1, k + 1), node(j, k + 1)];
    let right = (0..2).flat_map(|k| (0..4).map(move |j| face(j, k))).collect();
    scene.loads.push(("Right", "MPMGridSurfaceLoadCondition3D4N", right));
    let scene = scene.with(load("Right", "SURFACE_LOAD", json!(5000.0), [0.0, 0.6, 0.8]));
    let area = 0.16 * 0.1;
    assert_balance(&scene, [0.0, 3000.0 * area, 4000.0 * area]);
}
