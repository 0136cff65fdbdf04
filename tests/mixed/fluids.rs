//! Fluids in motion, by the measurements of the runs: the dam break against the experiment, channel flows
//! against their series and a sloshing tank against linear theory. `python_scripts/study_fluids.py` runs
//! more of each.

use super::common::{Cell, Mesh, Scene, Table, fix, gravity, orders, process, run_project};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const GRAVITY: f64 = 9.81;
/// Martin & Moyce 1952, tables 2 and 6 (n² = 2, a = 2.25 in): front z/a at t sqrt(2 g/a), and height of
/// the column over 2 a at t sqrt(g/a).
const FRONT: [(f64, f64); 15] = [
    (0.41, 1.11),
    (0.84, 1.22),
    (1.19, 1.44),
    (1.43, 1.67),
    (1.63, 1.89),
    (1.83, 2.11),
    (1.98, 2.33),
    (2.20, 2.56),
    (2.32, 2.78),
    (2.51, 3.00),
    (2.65, 3.22),
    (2.83, 3.44),
    (2.98, 3.67),
    (3.11, 3.89),
    (3.33, 4.11),
];
const HEIGHT: [(f64, f64); 7] =
    [(0.56, 0.94), (0.93, 0.83), (1.28, 0.72), (1.66, 0.61), (2.00, 0.50), (2.45, 0.39), (2.70, 0.33)];

/// Runs an example with other values at these pointers; the iterations of the steps and the folder of the tables.
fn run_example(name: &str, settings: &[(&str, Value)]) -> (Vec<u64>, TempDir) {
    let folder = TempDir::new().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).join("ProjectParameters.json");
    let record = folder.path().join("record.json");
    command.arg("run").arg(project).args(["--quiet", "--threads", "1", "--output"]).arg(folder.path());
    command.arg("--record").arg(&record).args(["--set", "/output_processes/vtk_output=[]"]);
    for (pointer, value) in settings {
        command.arg("--set").arg(format!("{pointer}={value}"));
    }
    let ended = command.output().unwrap();
    assert!(ended.status.success(), "{settings:?}: {}", String::from_utf8_lossy(&ended.stderr));
    let record: Value = serde_json::from_str(&std::fs::read_to_string(record).unwrap()).unwrap();
    assert_eq!(record["not_converged_steps"], json!([]), "{settings:?}");
    let iterations = record["iterations"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap());
    (iterations.collect(), folder)
}

/// The second column at a time, linear between rows.
fn at(rows: &[Vec<f64>], time: f64) -> f64 {
    let next = rows.iter().position(|row| row[0] >= time).expect("the table reaches this time").max(1);
    let (before, after) = (&rows[next - 1], &rows[next]);
    before[1] + (after[1] - before[1]) * (time - before[0]) / (after[0] - before[0])
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = values.map(|v| v * v).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Total energies that the run writes.
fn energies(folder: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join("energy.dat")).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split_whitespace().nth(4).unwrap().parse().unwrap()).collect()
}

/// The front is ahead of the experiment, whose gate and friction hold it back, by less than 12 %, and 5 % with
/// a shift of the start by at most 0.2; nothing gains energy, and points do not gather.
#[test]
fn a_dam_breaks_as_in_the_experiment() {
    let coarse = [
        ("/modelers/0/parameters/cell_size", json!(0.2)),
        ("/modelers/1/parameters/bodies/0/cell_size", json!(0.2)),
        ("/output_processes/measurements/1/Parameters/high", json!([0.2, null, null])),
        ("/output_processes/measurements/2/Parameters/overfill_block", json!([0.4, 0.4, 0.0])),
    ];
    let water = "/solver_settings/material_import_settings/materials/0/Material/Variables/BULK_MODULUS";
    let asgs = ("/solver_settings/stabilization", json!("asgs"));
    let runs = [
        vec![asgs.clone()],
        vec![asgs, (water, json!(2.2e9))],
        vec![("/solver_settings/stabilization", json!("osgs"))],
        vec![("/solver_settings/stabilization", json!("ppp"))],
    ];
    for run in runs {
        let (iterations, folder) = run_example("dam_break", &[&coarse[..], &run].concat());
        // One step in a thousand, in which points meet that had parted, may need a fifth.
        let (slow, all) = (iterations.iter().filter(|n| !(2..=4).contains(*n)).count(), iterations.len());
        assert!(1000 * slow <= 2 * all && iterations.iter().all(|n| (2..=5).contains(n)), "{run:?}: {iterations:?}");
        let read = |name: &str| Table::read(&folder.path().join(name)).rows;
        let (front, height, totals) = (read("front.csv"), read("height.csv"), read("totals.csv"));
        let unit = GRAVITY.sqrt();
        let deviation = |shift: f64| {
            rms(FRONT.iter().map(|(time, place)| at(&front, (time + shift) / (2.0f64.sqrt() * unit)) / place - 1.0))
        };
        let shifted = (-20..=20).map(|k| deviation(0.01 * f64::from(k))).fold(f64::INFINITY, f64::min);
        assert!(deviation(0.0) < 0.12 && shifted < 0.05, "{run:?}: front {} {shifted}", deviation(0.0));
        for (time, place) in HEIGHT {
            let found = at(&height, time / unit) / 2.0;
            assert!((found - place).abs() < 0.05, "{run:?}: height {found} for {place} at {time}");
        }
        let energy = energies(folder.path());
        assert!(energy.iter().all(|e| *e <= energy[0] * (1.0 + 1e-9)), "{run:?}: energy grows");
        assert!(energy.last().unwrap() > &(0.97 * energy[0]), "{run:?}: {energy:?}");
        let overfill = totals.iter().map(|row| row[2]).fold(0.0, f64::max);
        assert!(overfill < 0.04, "{run:?}: overfill {overfill}");
    }
}

/// Frequency ω² = g k tanh(k H) of the first mode, k = π/L, by the times at which the centre of mass passes
/// the middle.
#[test]
fn a_tank_sloshes_with_its_first_frequency() {
    let (_, folder) = run_example("sloshing_tank", &[]);
    let rows = Table::read(&folder.path().join("totals.csv")).rows;
    let aside = |row: &Vec<f64>| row[1] - 0.5;
    let passes = |pair: &[Vec<f64>]| {
        let (a, b) = (aside(&pair[0]), aside(&pair[1]));
        (pair[0][0] > 0.1 && a * b < 0.0).then(|| pair[0][0] + (pair[1][0] - pair[0][0]) * a / (a - b))
    };
    let times: Vec<f64> = rows.windows(2).filter_map(passes).collect();
    let exact = PI / (GRAVITY * PI * (PI * 0.5).tanh()).sqrt();
    let half = (times.last().unwrap() - times[0]) / (times.len() - 1) as f64;
    assert!(times.len() == 6 && (half / exact - 1.0).abs() < 0.02, "{times:?}: {half} for {exact}");
    // The centre swings by 2 a/(π² H) L to each side.
    let swing = rows.iter().map(|row| aside(row).abs()).fold(0.0, f64::max);
    assert!((swing / (2.0 * 0.001 / (PI * PI * 0.5)) - 1.0).abs() < 0.03, "{swing}");
}

/// Flow between plates 1 m apart, of which the upper one does not hold the fluid; from rest, driven by f.
fn film(cell: Cell, mixed: Option<&str>, count: usize) -> f64 {
    let (length, step) = (0.5, 0.01);
    let size = 1.0 / count as f64;
    let columns = count / 2;
    let grid = Mesh::block(cell, [columns + 1, count, 0], [0.0; 3], [length + size, 1.0, 0.0]);
    let body = Mesh::block(cell, [columns, count, 0], [0.0; 3], [length, 1.0, 0.0]);
    let law =
        if mixed.is_some() { "DispNewtonianFluidPlaneStrainUP2DLaw" } else { "DispNewtonianFluidPlaneStrain2DLaw" };
    let points = if cell == Cell::Triangle { 6 } else { 4 };
    let mut variables = json!({"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": points, "DENSITY": 1.0,
                               "DYNAMIC_VISCOSITY": 1.0});
    let mut solver = json!({"solver_type": "dynamic", "time_stepping": {"time_step": step},
                            "residual_relative_tolerance": 1e-8, "residual_absolute_tolerance": 1e-16});
    match mixed {
        Some(kind) => (solver["pressure_dofs"], solver["stabilization"]) = (json!(true), json!(kind)),
        None => variables["BULK_MODULUS"] = json!(1000.0),
    }
    let material = json!({"constitutive_law": {"name": law}, "Variables": variables});
    let line = json!({"model_part_name": "Background_Grid", "start_point": [0.25, 0.0, 0.0],
        "end_point": [0.25, 1.0, 0.0], "sampling_points": 33, "output_variables": ["VELOCITY"],
        "output_times": ["End"], "output_file_settings": {"file_name": "profile"}});
    let inside = move |y: f64| y > 0.25 * size && y < 1.0 - 0.25 * size;
    let scene = Scene::new(grid, body, material, solver, 3.0 - 0.5 * step)
        .part("Bottom", |x| x[1] == 0.0)
        .part("Top", |x| x[1] == 1.0)
        .part("Ends", move |x| (x[0] == 0.0 || x[0] > length - 0.25 * size) && inside(x[1]))
        .with(fix("Bottom", json!([0.0, 0.0, null])))
        .with(fix("Top", json!([null, 0.0, null])))
        .with(fix("Ends", json!([null, 0.0, null])))
        .with(gravity([2e-3, 0.0, 0.0]))
        .with(process("line_output_process", line));
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    run_project(folder.path(), &[]);
    let rows = Table::read(&folder.path().join("profile.csv")).rows;
    let exact = |y: f64| 1e-3 * y * (2.0 - y);
    rms(rows.iter().map(|row| row[4] - exact(row[2]))) / rms(rows.iter().map(|row| exact(row[2])))
}

/// The steady profile of a film, f y (2 H − y)/(2 ν), to second order, asgs at these steps nearly: no slip
/// below, slip above.
#[test]
fn a_film_flows_with_a_parabola() {
    for (cell, mixed) in [
        (Cell::Triangle, None),
        (Cell::Quadrilateral, None),
        (Cell::Triangle, Some("asgs")),
        (Cell::Quadrilateral, Some("osgs")),
        (Cell::Quadrilateral, Some("ppp")),
    ] {
        let errors = [4, 8].map(|count| film(cell, mixed, count));
        assert!(errors[1] < 0.007 && orders(&errors)[0] > 1.7, "{cell:?} {mixed:?}: {errors:?}");
    }
}

/// Higher waves cross cells, and water sinks into itself unless points that are too many are moved apart.
#[test]
fn a_correction_of_volume_keeps_water_up() {
    let speed = 0.0231024;
    let start = json!([format!("{speed}*sin(pi*x)*cosh(pi*y)"), format!("-{speed}*cos(pi*x)*sinh(pi*y)"), 0.0]);
    let sunk = |share: f64| {
        let (_, folder) = run_example(
            "sloshing_tank",
            &[
                ("/problem_data/end_time", json!(2.0)),
                ("/solver_settings/flip_fraction", json!(0.99)),
                ("/solver_settings/stabilization_parameters", json!({"volume_correction": share})),
                ("/processes/start/0/Parameters/value", start.clone()),
            ],
        );
        let rows = Table::read(&folder.path().join("totals.csv")).rows;
        let overfill = rows.iter().map(|row| row[4]).fold(0.0, f64::max);
        (rows[0][2] - rows[rows.len() - 1][2], overfill)
    };
    let (without, corrected) = (sunk(0.0), sunk(0.1));
    assert!(without.0 > 0.02 && without.1 > 0.08, "{without:?}");
    assert!(corrected.0.abs() < 0.01 && corrected.1 < 0.04, "{corrected:?}");
}
