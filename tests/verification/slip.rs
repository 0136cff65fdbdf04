//! Walls along which bodies slide, against momentum balance and against the same scene with its walls
//! along the axes, where holding a component is enough.

use super::common::{Cell, Mesh, Record, Scene, fix, gravity, largest_difference, material, process};
use serde_json::{Value, json};

type Turn = fn([f64; 3]) -> [f64; 3];

fn along_the_axes(x: [f64; 3]) -> [f64; 3] {
    x
}

/// By 0.5 rad in the plane.
fn turned_in_the_plane([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (s, c) = 0.5f64.sin_cos();
    [c * x - s * y, s * x + c * y, z]
}

/// By two angles about two axes.
fn turned_in_space(x: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = turned_in_the_plane(x);
    let (s, c) = 0.8f64.sin_cos();
    [x, c * y - s * z, s * y + c * z]
}

/// A soft block in the corner of a tank, pressed into it by gravity; `walls` are the axes that have one.
fn block_in_a_corner(cell: Cell, solver: Value, walls: &[usize], turn: Turn) -> Scene {
    let box_of = |counts, high| Mesh::block(cell, counts, [0.0; 3], high);
    let grid = box_of([4, 4, 3], [2.0, 2.0, 1.5]);
    let body = box_of([2, 2, 1], [1.0, 1.0, 0.5]).map(turn);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let points = match cell {
        Cell::Triangle => 3,
        Cell::Hexahedron => 8,
        _ => 4,
    };
    let mut pull = [-3.0, -9.0, -2.0];
    pull[cell.dimension()..].fill(0.0);
    let mut scene = Scene::new(grid, body, material(law, points, 1000.0, 2e5, 0.3), solver, 0.1 - 1e-6);
    for (&axis, name) in walls.iter().zip(["Wall1", "Wall2", "Wall3"]) {
        let (condition, faces) = faces(&scene.grid, axis);
        scene.loads.push((name, condition, faces));
    }
    scene.grid = scene.grid.map(turn);
    scene.with(gravity(turn(pull)))
}

/// The faces of a grid at coordinate 0 of an axis, as conditions.
fn faces(grid: &Mesh, axis: usize) -> (&'static str, Vec<Vec<usize>>) {
    let on_wall = |cell: &Vec<usize>| -> Vec<usize> {
        cell.iter().copied().filter(|&node| grid.nodes[node][axis] == 0.0).collect()
    };
    let (count, condition) = match grid.cell {
        Cell::Tetrahedron => (3, "SurfaceCondition3D3N"),
        Cell::Hexahedron => (4, "SurfaceCondition3D4N"),
        _ => (2, "LineCondition2D2N"),
    };
    let faces = grid.cells.iter().map(on_wall).filter(|face| face.len() == count);
    (condition, faces.map(|face| outward(grid, axis, face)).collect())
}

/// Brings the corners of a face into an order in which its normal points along the negative axis.
fn outward(grid: &Mesh, axis: usize, mut face: Vec<usize>) -> Vec<usize> {
    let at = |node: usize| (grid.nodes[node][(axis + 1) % 3], grid.nodes[node][(axis + 2) % 3]);
    let middle = face.iter().fold((0.0, 0.0), |sum, &node| (sum.0 + at(node).0, sum.1 + at(node).1));
    let size = face.len() as f64;
    let angle = |&node: &usize| (at(node).1 - middle.1 / size).atan2(at(node).0 - middle.0 / size);
    if face.len() > 2 {
        face.sort_by(|a, b| angle(b).total_cmp(&angle(a)));
    } else if (axis == 0) == (grid.nodes[face[0]][1] < grid.nodes[face[1]][1]) {
        face.swap(0, 1);
    }
    face
}

fn slip(part: &str) -> Value {
    process("apply_mpm_slip_boundary_process", json!({"model_part_name": format!("Background_Grid.{part}")}))
}

fn settings(more: Value) -> Value {
    let mut settings = json!({"solver_type": "dynamic", "time_stepping": {"time_step": 0.01},
                              "compute_reactions": true, "residual_relative_tolerance": 1e-11,
                              "residual_absolute_tolerance": 1e-10});
    settings.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    settings
}

/// The run with walls along the axes, held by components, and the run turned, held by slip walls.
fn both(cell: Cell, solver: &Value) -> [(Record, Turn); 2] {
    let walls: &[usize] = if cell.dimension() == 3 { &[0, 1, 2] } else { &[0, 1] };
    let turn = if cell.dimension() == 3 { turned_in_space } else { turned_in_the_plane };
    let mut straight = block_in_a_corner(cell, solver.clone(), walls, along_the_axes);
    let mut turned = block_in_a_corner(cell, solver.clone(), walls, turn);
    for (&axis, name) in walls.iter().zip(["Wall1", "Wall2", "Wall3"]) {
        let held: Vec<Value> = (0..3).map(|a| if a == axis { json!(0.0) } else { Value::Null }).collect();
        straight = straight.with(fix(name, json!(held)));
        turned = turned.with(slip(name));
    }
    [(straight.run(&["--record-states", "2"]), along_the_axes), (turned.run(&["--record-states", "2"]), turn)]
}

/// The answer to the turned scene is the turned answer, in every solver and for every cell; corners of
/// two and three walls are held.
#[test]
fn a_turned_scene_gives_the_turned_answer() {
    let explicit = |update: &str| {
        settings(json!({"time_integration_method": "explicit", "scheme_type": "forward_euler", "stress_update": update,
                        "time_stepping": {"time_step": 0.001}}))
    };
    let total = json!({"scheme_type": "newmark", "frame": "total_lagrangian", "consistent_mass_matrix": true});
    let central = json!({"time_integration_method": "explicit", "scheme_type": "central_difference",
                         "frame": "total_lagrangian", "time_stepping": {"time_step": 0.001}});
    for (cell, solver) in [
        (Cell::Quadrilateral, settings(json!({"scheme_type": "newmark"}))),
        (Cell::Triangle, settings(json!({"scheme_type": "bossak", "consistent_mass_matrix": true}))),
        (Cell::Hexahedron, settings(json!({"scheme_type": "newmark"}))),
        (Cell::Tetrahedron, settings(json!({"solver_type": "quasi_static"}))),
        (Cell::Quadrilateral, settings(total)),
        (Cell::Quadrilateral, explicit("usf")),
        (Cell::Hexahedron, explicit("musl")),
        (Cell::Triangle, settings(central)),
    ] {
        let [(straight, _), (turned, turn)] = both(cell, &solver);
        let state = straight.last();
        for (kind, name, scale) in [("mp", "MP_COORD", 1.0), ("nodes", "REACTION", 1e4)] {
            let row = |row: Vec<f64>| turn([row[0], row[1], row[2]]).to_vec();
            let expected: Vec<Vec<f64>> = state.field(kind, name).into_iter().map(row).collect();
            let error = largest_difference(&turned.last().field(kind, name), &expected);
            assert!(error < 1e-9 * scale, "{cell:?}, {solver}: {name} is off by {error:e}");
        }
        let moved = largest_difference(&state.points("MP_COORD"), &straight.first().points("MP_COORD"));
        assert!(moved > 1e-3, "{cell:?}, {solver}: the block has moved by {moved:e} m only");
    }
}

/// A block on one tilted wall: whatever it does across it, along it momentum grows by m g sin θ t.
#[test]
fn momentum_along_a_wall_is_that_of_gravity_alone() {
    for (cell, solver) in [
        (Cell::Quadrilateral, settings(json!({"scheme_type": "newmark"}))),
        (
            Cell::Triangle,
            settings(json!({"time_integration_method": "explicit", "stress_update": "usl",
                                        "time_stepping": {"time_step": 0.001}})),
        ),
    ] {
        let scene = block_in_a_corner(cell, solver.clone(), &[1], turned_in_the_plane).with(slip("Wall1"));
        let record = scene.run(&["--record-states", "1"]);
        let (state, (s, c)) = (record.last(), 0.5f64.sin_cos());
        let [px, py, _] = state.total("momentum");
        let (along, across) = (c * px + s * py, c * py - s * px);
        let expected = 1000.0 * -3.0 * state.time();
        assert!((along - expected).abs() < 1e-9 * expected.abs(), "{cell:?}: {along} N s, expected {expected}");
        assert!(across.abs() < 0.7 * 1000.0 * 9.0 * state.time(), "the wall has pushed: {across} N s");
    }
}
