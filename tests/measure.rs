//! Measurements against analytic values: each test reads the tables of a whole run.

mod common;

use common::{Body, Cell, Mesh, Scene, Table, fix, gravity, material, process, run_project};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";
const DENSITY: f64 = 1000.0;

/// A block of 1 m × 2 m in the air, 3 × 3 even points a cell of 0.5 m.
fn block(solver: Value, end: f64) -> Scene {
    let grid = Mesh::block(Cell::Quadrilateral, [8, 12, 1], [-1.0, -2.0, 0.0], [3.0, 4.0, 0.0]);
    let body = Mesh::block(Cell::Quadrilateral, [2, 4, 1], [0.0; 3], [1.0, 2.0, 0.0]);
    Scene::new(grid, body, material(LAW, 9, DENSITY, 1e6, 0.3), solver, end - 1e-6)
}

fn newmark(step: f64) -> Value {
    json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": step},
           "point_placement": "even"})
}

fn velocity(vector: [f64; 3]) -> Value {
    let parameters = json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": vector});
    process("assign_initial_velocity_to_material_point_process", parameters)
}

/// Runs a scene and reads these tables.
fn tables<const N: usize>(scene: &Scene, names: [&str; N]) -> [Table; N] {
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    run_project(folder.path(), &[]);
    names.map(|name| Table::read(&folder.path().join(name)))
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance, "{what}, row {i}: {a}, expected {b}");
    }
}

/// A block that is thrown: points, centre of mass and momenta in free flight, front and height.
#[test]
fn points_fronts_and_totals_in_free_flight() {
    let scene = block(newmark(0.01), 0.2)
        .with(gravity([0.0, -9.81, 0.0]))
        .with(velocity([1.5, 2.0, 0.0]))
        .with(process(
            "mpm_point_output_process",
            json!({"positions": [[0.9, 1.9, 0.0], [-5.0, -5.0, 0.0]],
                   "output_variables": ["MP_COORD", "MP_VELOCITY_Y", "MP_CAUCHY_STRESS_VECTOR"]}),
        ))
        .with(process("mpm_front_output_process", json!({"quantiles": [1.0, 0.5, 0.25]})))
        .with(process(
            "mpm_front_output_process",
            json!({"direction": [0.0, 2.0, 0.0], "quantiles": [1, 0.0], "high": [0.6, null, null],
                   "low": [null, 0.5, null], "output_file_settings": {"file_name": "height"}}),
        ))
        .with(process("mpm_totals_output_process", json!({"center": [1.0, -1.0, 0.0]})));
    let names = ["material_points.csv", "front.csv", "height.csv", "totals.csv"];
    let [points, front, height, totals] = tables(&scene, names);
    let time = front.column("TIME [s]");
    assert_eq!((time.len(), time[0]), (21, 0.0), "the start and 20 steps");
    let at = |of: &dyn Fn(f64) -> f64| time.iter().map(|t| of(*t)).collect::<Vec<f64>>();
    let fall = |t: f64| 2.0 * t - 0.5 * 9.81 * t * t;

    // Points are 1/6 m apart: those nearest to the places are the last and the first.
    let corner = |ids: usize| points.rows.iter().skip(ids).step_by(2).cloned().collect::<Vec<_>>();
    for (which, x, y) in [(0, 11.0 / 12.0, 23.0 / 12.0), (1, 1.0 / 12.0, 1.0 / 12.0)] {
        let rows = corner(which);
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        assert_close(&column(2), &at(&|t| x + 1.5 * t), 1e-12, "x of a point");
        assert_close(&column(3), &at(&|t| y + fall(t)), 1e-12, "y of a point");
        assert_close(&column(5), &at(&|t| 2.0 - 9.81 * t), 1e-11, "velocity of a point");
        assert_close(&column(8), &at(&|_| 0.0), 1e-5, "stress of a point");
    }
    assert_eq!(
        points.headings[5..],
        [
            "MP_VELOCITY_Y [m/s]",
            "MP_CAUCHY_STRESS_VECTOR_XX [Pa]",
            "MP_CAUCHY_STRESS_VECTOR_YY [Pa]",
            "MP_CAUCHY_STRESS_VECTOR_XY [Pa]"
        ]
    );

    // The points stand for parts of 1/6 m, so that quantiles are those of [0, 1] m.
    assert_close(&front.column("QUANTILE_1.0 [m]"), &at(&|t| 11.0 / 12.0 + 1.5 * t), 1e-12, "front");
    // Six columns: half of the mass lies behind the middle between the third and the fourth.
    for (heading, share) in [("QUANTILE_0.5 [m]", 0.5), ("QUANTILE_0.25 [m]", 0.25)] {
        // Columns of points at one place share their mass step by step: within half a point of them.
        let expected = at(&|t| share + 1.5 * t);
        assert_close(&front.column(heading), &expected, 1.0 / 12.0 + 1e-12, heading);
    }
    // At the wall x < 0.6 m there are columns until the last of them has left.
    let inside = at(&|t| 1.0 / 12.0 + 1.5 * t);
    let expected: Vec<f64> = inside.iter().zip(at(&fall)).map(|(_, y)| 23.0 / 12.0 + y).collect();
    assert_close(&height.column("QUANTILE_1.0 [m]"), &expected, 1e-12, "height");
    assert!(height.column("QUANTILE_0.0 [m]").iter().all(|y| (0.5..0.5 + 1.0 / 6.0 + 1e-9).contains(y)));

    let mass = 2.0 * DENSITY;
    assert_close(&totals.column("MASS [kg]"), &at(&|_| mass), 1e-9, "mass");
    assert_close(&totals.column("VOLUME [m³]"), &at(&|_| 2.0), 1e-9, "volume");
    assert_close(&totals.column("CENTER_OF_MASS_Y [m]"), &at(&|t| 1.0 + fall(t)), 1e-12, "centre of mass");
    assert_close(&totals.column("LINEAR_MOMENTUM_X [kg m/s]"), &at(&|_| 1.5 * mass), 1e-8, "momentum");
    assert_close(&totals.column("LINEAR_MOMENTUM_Y [kg m/s]"), &at(&|t| mass * (2.0 - 9.81 * t)), 1e-8, "momentum");
    // r × m v of the centre of mass about (1, −1).
    let angular = |t: f64| mass * ((0.5 + 1.5 * t - 1.0) * (2.0 - 9.81 * t) - (2.0 + fall(t)) * 1.5);
    assert_close(&totals.column("ANGULAR_MOMENTUM_Z [kg m²/s]"), &at(&angular), 1e-8, "angular momentum");
}

/// A bar of 4 m that a traction stretches, ν = 0: u = σ x / E with small strains; the wall holds the load.
#[test]
fn probes_lines_and_resultants_of_a_stretched_bar() {
    let mesh = || Mesh::block(Cell::Quadrilateral, [8, 2, 1], [0.0; 3], [4.0, 1.0, 0.0]);
    let (young, traction) = (1e9, 1e3);
    let mut scene = Scene::new(
        mesh(),
        mesh(),
        material("LinearElasticIsotropicPlaneStrain2DLaw", 4, 1.0, young, 0.0),
        json!({"compute_reactions": true, "residual_relative_tolerance": 1e-9}),
        1.0,
    )
    .part("Clamp", |x| x[0] == 0.0)
    .with(fix("Clamp", json!([0.0, 0.0, null])));
    scene.loads.push(("End", "MPMGridLineLoadCondition2D2N", vec![vec![8, 17], vec![17, 26]]));
    let load = json!({"model_part_name": "Background_Grid.End", "variable_name": "LINE_LOAD", "modulus": traction,
                      "direction": [1.0, 0.0, 0.0]});
    let scene = scene
        .with(process("assign_vector_by_direction_to_condition_process", load))
        .with(process(
            "extrapolate_material_point_results_to_grid_process",
            json!({"variables": ["MP_CAUCHY_STRESS_VECTOR"]}),
        ))
        .with(process(
            "point_output_process",
            json!({"model_part_name": "Background_Grid", "position": [3.3, 0.4, 0.0],
            "output_variables": ["DISPLACEMENT_X", "MP_CAUCHY_STRESS_VECTOR"]}),
        ))
        .with(process(
            "point_output_process",
            json!({"model_part_name": "Background_Grid", "entity_type": "node",
            "position": [4.0, 0.5, 0.0], "output_variables": ["DISPLACEMENT"],
            "output_file_settings": {"file_name": "tip", "output_path": "measured"}}),
        ))
        .with(process(
            "line_output_process",
            json!({"model_part_name": "Background_Grid", "start_point": [0.0, 0.3, 0.0],
            "end_point": [4.0, 0.3, 0.0], "sampling_points": 5, "output_variables": ["DISPLACEMENT_X"],
            "output_times": ["End"], "print_format": ".6e"}),
        ))
        .with(process(
            "multiple_points_output_process",
            json!({"model_part_name": "Background_Grid",
            "positions": [[1.0, 1.0, 0.0]], "output_variables": ["DISPLACEMENT_X"]}),
        ))
        .with(process(
            "resultant_output_process",
            json!({"model_part_name": "Background_Grid.Clamp",
            "output_variables": ["REACTION"], "moment_center": [0.0, 0.0, 0.0]}),
        ));
    let names = ["point.csv", "measured/tip.csv", "line.csv", "points.csv", "resultant.csv"];
    let [point, tip, line, points, resultant] = tables(&scene, names);
    let strain = traction / young;
    // Large rotations and the moved geometry are of the order of the strain, 1e-6.
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-5 * expected.abs();
    assert_eq!(point.rows[0][1..], [0.0; 4], "the start");
    assert!(near(point.rows[1][1], 3.3 * strain) && near(point.rows[1][2], traction), "{:?}", point.rows);
    assert!(point.rows[1][3].abs() < 1e-3 * traction && point.rows[1][4].abs() < 1e-3 * traction);
    assert!(near(tip.column("DISPLACEMENT_X [m]")[1], 4.0 * strain));
    assert_eq!((line.rows.len(), line.column("X [m]")), (5, vec![0.0, 1.0, 2.0, 3.0, 4.0]));
    for (x, u) in line.column("X [m]").into_iter().zip(line.column("DISPLACEMENT_X [m]")) {
        assert!((u - x * strain).abs() < 1e-5 * strain, "u = {u} at {x}");
    }
    assert!(near(points.column("DISPLACEMENT_X [m]")[1], strain));
    let last = resultant.rows.last().unwrap();
    assert!(near(last[1], -traction) && last[2].abs() < 1e-6 * traction, "{last:?}");
    // The force −σ at the mean height 0.5 m turns about the origin with −(0.5)(−σ).
    assert!(near(resultant.column("MOMENT_OF_REACTION_Z [N m]")[1], 0.5 * traction), "{:?}", resultant.rows);
}

/// Displacements imposed on all nodes of 6 × 4 unit squares: a checkerboard along x, (y/100)² along y.
#[test]
fn a_checkerboard_is_told_from_a_smooth_field() {
    let mesh = || Mesh::block(Cell::Quadrilateral, [6, 4, 1], [0.0; 3], [6.0, 4.0, 0.0]);
    let scene = Scene::new(mesh(), mesh(), material(LAW, 4, 1.0, 1.0, 0.3), json!({}), 1.0)
        .part("All", |_| true)
        .with(fix("All", json!(["0.01*cos(pi*x)*cos(pi*y)", "(y/100)**2", null])))
        .with(process(
            "oscillation_output_process",
            json!({"model_part_name": "Background_Grid",
            "output_variables": ["DISPLACEMENT_X", "DISPLACEMENT_Y"], "mask_variable": "NODAL_MASS"}),
        ));
    let [table] = tables(&scene, ["oscillation.csv"]);
    assert!(table.rows[0][1..].iter().all(|x| x.is_nan()), "no node has mass before the first step");
    let checkerboard = table.column("OSCILLATION_OF_DISPLACEMENT_X [1]")[1];
    // 35 nodes: the mean of ±1 is 1/35.
    let expected = 1.0 / (1.0 - 1.0 / 35.0f64.powi(2)).sqrt();
    assert!((checkerboard - expected).abs() < 1e-12, "{checkerboard}");
    // d = 1/2 along y and 0 along x, on 7 · 3 and 5 · 5 lines; variance of 0, 1, 4, 9, 16.
    let smooth = table.column("OSCILLATION_OF_DISPLACEMENT_Y [1]")[1];
    let expected = (0.25f64 * 21.0 / 46.0 / (354.0 / 5.0 - 36.0)).sqrt();
    assert!((smooth - expected).abs() < 1e-12, "{smooth}, expected {expected}");
}

/// Two bodies in the same cells: half of their volume is too much.
#[test]
fn bodies_on_top_of_each_other_overfill_their_cells() {
    let mut scene = block(newmark(0.01), 0.01);
    let mesh = Mesh::block(Cell::Quadrilateral, [2, 4, 1], [0.0; 3], [1.0, 2.0, 0.0]);
    scene.bodies.push(Body { name: "Other", mesh, material: material(LAW, 4, DENSITY, 1e6, 0.3) });
    let parameters = |part: &str, file: &str| {
        json!({"model_part_name": part, "quantities": ["volume", "overfill"], "overfill_block": [1.0, 1.0, 0.0],
               "output_file_settings": {"file_name": file}})
    };
    let scene = scene
        .with(process("mpm_totals_output_process", parameters("MPM_Material", "both")))
        .with(process("mpm_totals_output_process", parameters("MPM_Material.Other", "one")));
    let [both, one] = tables(&scene, ["both.csv", "one.csv"]);
    assert_close(&both.column("OVERFILL [1]"), &[0.5, 0.5], 1e-9, "both");
    assert_close(&both.column("VOLUME [m³]"), &[4.0, 4.0], 1e-9, "both");
    assert_close(&one.column("OVERFILL [1]"), &[0.0, 0.0], 1e-9, "one");
}

/// Times, intervals and output intervals choose the rows; a run that fails leaves whole ones.
#[test]
fn rows_come_when_they_are_asked_for_and_stay_when_the_run_fails() {
    let front = |name: &str, more: Value| {
        let mut parameters = json!({"output_file_settings": {"file_name": name}});
        parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        process("mpm_front_output_process", parameters)
    };
    let scene = block(newmark(0.01), 0.1)
        .with(front("times", json!({"output_times": [0.055, 0.0, "End"]})))
        .with(front("interval", json!({"interval": [0.035, 0.07]})))
        .with(front("steps", json!({"output_interval": 4})))
        .with(front("period", json!({"output_control_type": "time", "output_interval": 0.025})));
    let names = ["times.csv", "interval.csv", "steps.csv", "period.csv"];
    let steps = tables(&scene, names).map(|table| {
        let steps = table.column("TIME [s]").into_iter().map(|time| (time / 0.01).round());
        steps.collect::<Vec<f64>>()
    });
    assert_eq!(
        steps,
        [vec![0.0, 6.0, 10.0], vec![4.0, 5.0, 6.0, 7.0], vec![0.0, 4.0, 8.0], vec![0.0, 3.0, 5.0, 8.0, 10.0]]
    );

    let broken = json!({"model_part_name": "MPM_Material", "value": ["sqrt(0.035 - t)", 0.0, 0.0]});
    let scene = scene.with(process("assign_body_acceleration_to_material_point_process", broken));
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output =
        command.current_dir(folder.path()).args(["run", "ProjectParameters.json", "--quiet"]).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(Table::read(&folder.path().join("steps.csv")).rows.len(), 1);
    assert_eq!(Table::read(&folder.path().join("period.csv")).rows.len(), 2);
}

/// Measurements make the solver keep what they read and nothing else, and change no result.
#[test]
fn measurements_change_nothing() {
    let plain = block(newmark(0.01), 0.05).with(gravity([0.0, -9.81, 0.0]));
    let measured = block(newmark(0.01), 0.05)
        .with(gravity([0.0, -9.81, 0.0]))
        .with(process("mpm_totals_output_process", json!({})))
        .with(process("mpm_front_output_process", json!({})));
    let [plain, measured] = [plain, measured].map(|scene| scene.run(&[]));
    assert_eq!(plain.json["snapshots"], measured.json["snapshots"]);
}
