//! Every scene in `examples/` through the program, and the number that its README tells to expect.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

const GRAVITY: f64 = 9.81;
/// What Kratos 10.4.4 and Bia may differ by through round-off, relative.
const ROUND_OFF: f64 = 1e-10;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")
}

/// Runs an example into a folder of its own and returns its record with this many states.
fn run(name: &str, states: usize) -> Value {
    run_file(name, "ProjectParameters.json", states)
}

/// The same of one of its files.
fn run_file(name: &str, file: &str, states: usize) -> Value {
    run_into(tempfile::tempdir().unwrap().path(), name, file, states)
}

/// The same into a given folder.
fn run_into(output: &Path, name: &str, file: &str, states: usize) -> Value {
    let record = output.join("record.json");
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.args(["run", "--quiet", "--threads", "1", "--record-states", &states.to_string()]);
    command.arg("--record").arg(&record).arg("--output").arg(output);
    let ended = command.arg(examples().join(name).join(file)).output().unwrap();
    assert!(ended.status.success(), "{name}: {}", String::from_utf8_lossy(&ended.stderr));
    assert!(holds_vtk(output), "{name} writes no VTK file");
    let record: Value = serde_json::from_str(&std::fs::read_to_string(record).unwrap()).unwrap();
    assert_eq!(record["not_converged_steps"], Value::Array(Vec::new()), "{name}");
    record
}

/// Whether a folder, or one in it, holds a VTK file.
fn holds_vtk(folder: &Path) -> bool {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).any(|path| match path.extension() {
        Some(extension) => extension == "vtk" || extension == "vtu",
        None => path.is_dir() && holds_vtk(&path),
    })
}

fn states(record: &Value) -> &Vec<Value> {
    record["snapshots"].as_array().unwrap()
}

fn rows(state: &Value, kind: &str, field: &str) -> Vec<[f64; 3]> {
    let rows = state[kind][field].as_array().unwrap();
    rows.iter().map(|row| std::array::from_fn(|i| row[i].as_f64().unwrap())).collect()
}

fn number(state: &Value, pointer: &str) -> f64 {
    state.pointer(pointer).and_then(Value::as_f64).unwrap()
}

#[track_caller]
fn assert_close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected} to {relative:e}");
}

#[test]
fn each_example_has_its_number() {
    let folders = std::fs::read_dir(examples()).unwrap().map(|entry| entry.unwrap());
    // A crate has tests of its own, and so have studies, in tests/study.
    let scenes = folders.filter(|entry| !entry.path().join("Cargo.toml").exists());
    let mut found: BTreeSet<String> = scenes.map(|entry| entry.file_name().into_string().unwrap()).collect();
    found.remove("studies");
    let tested = [
        "bending_column",
        "cantilever",
        "colliding_discs",
        "cook",
        "cook_incompressible",
        "cube_million",
        "dam_break",
        "dgmpm_bar",
        "dgmpm_block",
        "dgmpm_notched_plate",
        "dgmpm_plate",
        "dgmpm_svk_bar",
        "falling_block",
        "falling_disc",
        "rotating_body",
        "sloshing_tank",
        "tlmpm_column",
        "tlmpm_energy",
        "tlmpm_step_bar",
        "twisting_column",
    ];
    let tested = tested.map(String::from);
    assert_eq!(found, BTreeSet::from(tested), "a new example needs a test of its number in this file");
    for name in found {
        assert!(examples().join(&name).join("README.md").is_file(), "{name} has no README.md");
    }
}

/// Deflection of a cantilever of rectangular section under its own weight at the distance x from
/// the clamp, by Timoshenko's beam theory with the shear coefficient 5/6 (in m, downwards):
/// w = q (x⁴ − 4 L x³ + 6 L² x²)/(24 E I) + q (L x − x²/2)/(κ G A), q = ρ g A.
fn deflection(x: f64) -> f64 {
    let (young, poisson, density, length, height) = (1e9, 0.3, 1000.0, 8.0_f64, 1.0_f64);
    let (load, inertia, shear) = (density * GRAVITY * height, height.powi(3) / 12.0, young / (2.0 * (1.0 + poisson)));
    let bending = load * (x.powi(4) - 4.0 * length * x.powi(3) + 6.0 * (length * x).powi(2)) / (24.0 * young * inertia);
    bending + load * (length * x - 0.5 * x * x) / (5.0 / 6.0 * shear * height)
}

#[test]
fn the_cantilever_bends_as_a_beam_does() {
    let record = run("cantilever", 1);
    let (first, last) = (&states(&record)[0], states(&record).last().unwrap());
    let start = rows(first, "mp", "MP_COORD");
    let tip = start.iter().map(|x| x[0]).fold(0.0, f64::max);
    let moved = rows(last, "mp", "MP_DISPLACEMENT");
    let column: Vec<f64> =
        start.iter().zip(&moved).filter(|(x, _)| (x[0] - tip).abs() < 1e-9).map(|(_, u)| u[1]).collect();
    assert_eq!(column.len(), 16);
    let mean = column.iter().sum::<f64>() / 16.0;
    // Eight bilinear cells over the height are too stiff in bending by 1.1 %; sixteen by 0.5 %.
    assert_close(-mean, deflection(tip), 0.015);
    assert_close(mean, -0.060300798879098255, ROUND_OFF); // Kratos 10.4.4
}

/// More of it, and its dynamic project, in tests/mixed/study.rs.
#[test]
fn the_incompressible_membrane_rises_as_its_reference_does() {
    let record = run("cook_incompressible", 1);
    let corner = *rows(states(&record).last().unwrap(), "nodes", "DISPLACEMENT").last().unwrap();
    // Taylor-Hood elements of order 5 and 4; 32 x 32 cells are too stiff by 0.84 %, 64 x 64 by 0.36 %.
    assert_close(corner[1], 0.69340, 0.009);
}

#[test]
fn cooks_membrane_shears_as_its_reference_does() {
    let record = run("cook", 1);
    let corner = *rows(states(&record).last().unwrap(), "nodes", "DISPLACEMENT").last().unwrap();
    // Converged finite elements of order 5: another neo-Hookean law, which at this load changes
    // 0.02 %; 32 x 32 bilinear cells are too stiff by 1.6 %, 64 x 64 by 0.7 %.
    assert_close(corner[0], -0.00502387 * 48.0, 0.03);
    assert_close(corner[1], 0.00669952 * 48.0, 0.02);
    // Kratos 10.4.4 on the same mesh.
    assert_close(corner[0], -0.23569899773480804, ROUND_OFF);
    assert_close(corner[1], 0.3165353992029921, ROUND_OFF);
}

/// Times and places of `place`, carried along by the nearest point p of an example of columns as
/// x_p + F_p (X − X_p), and the least and the greatest share of the energy after the first step.
fn carried(name: &str, place: [f64; 3]) -> (Vec<(f64, [f64; 3])>, [f64; 2]) {
    let folder = tempfile::tempdir().unwrap();
    run_into(folder.path(), name, "ProjectParameters.json", 1);
    let table = |file: &str, separator: char| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        let lines = text.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
        lines.map(|line| line.split(separator).map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    let tip = table("tip.csv", ',');
    let arm: [f64; 3] = std::array::from_fn(|a| place[a] - tip[0][2 + a]);
    let now =
        |row: &Vec<f64>| std::array::from_fn(|a| row[2 + a] + (0..3).map(|b| row[5 + 3 * a + b] * arm[b]).sum::<f64>());
    let energies = table("energy.dat", ' ');
    let shares = energies[1..].iter().map(|row| row[4] / energies[0][4]);
    let range = shares.fold([f64::MAX, 0.0], |[low, high], e| [e.min(low), e.max(high)]);
    (tip.iter().map(|row| (row[0], now(row))).collect(), range)
}

/// Spectral elements, ν = 0.499: displacements of the middle of the top's edge in m, good to 0.015 m.
#[test]
fn the_column_bends_as_its_reference_does() {
    let (tip, energy) = carried("bending_column", [0.5, 0.0, 6.0]);
    for (time, displacement) in [(0.25, 2.3313), (0.5, 2.8448), (0.75, 1.4592), (1.0, -1.1159), (1.25, -2.9139)] {
        let (_, x) = tip.iter().find(|(t, _)| (t - time).abs() < 1e-6).unwrap();
        assert!((x[0] - 0.5 - displacement).abs() < 0.03 * 2.9139, "{x:?} at {time} s");
    }
    assert!(energy[0] > 0.98 && energy[1] < 1.02, "{energy:?}");
}

/// Spectral elements, ν = 0.4999: the corner turns by −5.983 rad and is back after 0.18083 s.
#[test]
fn the_column_twists_as_its_reference_does() {
    let (corner, energy) = carried("twisting_column", [0.5, 0.5, 6.0]);
    let mut turned = vec![0.0];
    for (_, x) in &corner[1..] {
        let (angle, turn) = (x[1].atan2(x[0]) - std::f64::consts::FRAC_PI_4, std::f64::consts::TAU);
        let before = turned[turned.len() - 1];
        turned.push(angle - turn * ((angle - before) / turn).round());
    }
    assert_close(turned.iter().copied().fold(0.0, f64::min), -5.983, 0.02);
    let back = (50..turned.len()).find(|&i| turned[i] > 0.0).unwrap();
    assert_close(corner[back].0, 0.18083, 0.02);
    assert!(energy[0] > 0.98 && energy[1] < 1.0, "{energy:?}");
}

#[test]
fn the_block_falls_freely_until_its_lowest_points_reach_the_lowest_cells() {
    let record = run("falling_block", 500);
    let states = states(&record);
    // The lowest row of points stands at a Gauss point above y = 0.3; the first row of cells ends at y = 0.025.
    let lowest = 0.3 + 0.025 * 0.5 * (1.0 - 1.0 / 3.0_f64.sqrt());
    let contact = (2.0 * (lowest - 0.025) / GRAVITY).sqrt();
    let energy = number(&states[0], "/energies/total");
    assert_close(energy, 40.0 * GRAVITY * 0.4, 1e-12); // m g y
    for state in states {
        let time = number(state, "/time");
        // A step feels the floor if the points are in the lowest cells when it starts.
        let free = time - 0.001 < contact;
        let fallen = 0.4 - 0.5 * GRAVITY * time * time;
        assert_eq!((number(state, "/sums/com/1") - fallen).abs() < 1e-10, free, "centre of mass at {time} s");
        assert_eq!((number(state, "/energies/total") / energy - 1.0).abs() < 1e-10, free, "energy at {time} s");
    }
}

#[test]
fn the_disc_has_the_mass_of_a_polygon_and_falls_freely() {
    let record = run("falling_disc", 45);
    let states = states(&record);
    let polygon = 32.0 * 0.2 * 0.2 * (std::f64::consts::TAU / 64.0).sin();
    assert_close(number(&states[0], "/sums/mass"), 1000.0 * polygon, 1e-12);
    for state in states.iter().take_while(|state| number(state, "/time") <= 0.3) {
        let fallen = 0.7 - 0.5 * GRAVITY * number(state, "/time").powi(2);
        assert_close(number(state, "/sums/com/1"), fallen, 1e-10);
    }
}

#[test]
fn the_discs_keep_momentum_and_energy() {
    let record = run("colliding_discs", 32);
    let states = states(&record);
    let (mass, start) = (number(&states[0], "/sums/mass"), number(&states[0], "/energies/total"));
    assert_close(start, 2.513274122871835, 3e-3); // ρ π R² v² of circles, here polygons
    for state in states {
        for a in 0..2 {
            assert!(number(state, &format!("/sums/momentum/{a}")).abs() < 1e-12 * mass * 0.1);
        }
        assert!(number(state, "/sums/angular_momentum/2").abs() < 1e-12 * mass * 0.1);
        assert_close(number(state, "/energies/total"), start, 5e-3);
        // Free flight until the discs share cells.
        if number(state, "/time") < 1.2 {
            assert_close(number(state, "/energies/kinetic"), start, 1e-12);
        }
    }
    let least = states.iter().map(|state| number(state, "/energies/kinetic")).fold(f64::INFINITY, f64::min);
    assert!(least < 0.1 * start && number(states.last().unwrap(), "/energies/kinetic") > 0.9 * start, "{least}");
}

#[test]
fn the_rotating_body_keeps_energy_and_angular_momentum() {
    let record = run("rotating_body", 30);
    let moment = 500.0 * (2.0 * 2.0 + 0.25 * 0.25) / 12.0;
    for state in states(&record) {
        assert_close(number(state, "/energies/total"), 0.5 * moment * 10.0 * 10.0, 1e-4);
        assert_close(number(state, "/sums/angular_momentum/2"), moment * 10.0, 1e-12);
    }
    assert!(states(&record).iter().any(|state| number(state, "/energies/strain") > 100.0), "the beam must stretch");
}

/// It takes too long for a test: what it consists of is checked alone.
#[test]
fn the_cube_has_a_million_points_and_only_the_columns_it_needs() {
    let project = examples().join("cube_million/ProjectParameters.json");
    let checked = Command::new(env!("CARGO_BIN_EXE_bia")).arg("check").arg(project).output().unwrap();
    let text = String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success(), "{text}{}", String::from_utf8_lossy(&checked.stderr));
    assert!(text.contains("1000000 points") && text.contains("mass 1.000000e3 kg"), "{text}");
    let columns = text.lines().find_map(|line| line.trim().strip_prefix("columns in use")).map(str::trim);
    assert_eq!(columns, Some("position, velocity, mass, deformation gradient, Cauchy stress, volume"));
}

/// Displacement of the last point along x.
fn last_displacement(state: &Value) -> f64 {
    rows(state, "mp", "MP_DISPLACEMENT").last().unwrap()[0]
}

#[test]
fn the_column_is_where_equilibrium_has_it() {
    let last = |file: &str| last_displacement(states(&run_file("tlmpm_column", file, 1)).last().unwrap());
    // u(0.0975 m) of the exact equilibrium; the source's update is wrong by 5 % of u(L).
    assert_close(last("ProjectParameters.json"), -0.0571596843, 1e-6);
    let wrong = (last("ProjectParameters_document.json") + 0.0571596843) / -0.05862504;
    assert_close(wrong, 0.05, 0.02);
}

#[test]
fn the_step_loaded_bar_swings_by_twice_its_static_displacement() {
    let record = run("tlmpm_step_bar", 250);
    let peak = states(&record).iter().map(last_displacement).fold(0.0, f64::min);
    // The last point stands 0.013 mm before the end; the states are 0.0008 ms apart.
    assert_close(peak, -0.0508, 0.03);
}

#[test]
fn the_swinging_bar_keeps_its_energy_with_one_scheme_and_loses_it_with_the_other() {
    let energy = |state: &Value| number(state, "/energies/kinetic") + number(state, "/energies/strain");
    let conserving = run("tlmpm_energy", 500);
    for state in states(&conserving) {
        assert_close(energy(state), 5e-5, 1e-7);
    }
    let document = run_file("tlmpm_energy", "ProjectParameters_document.json", 1);
    assert_close(energy(states(&document).last().unwrap()) / 5e-5, 0.954, 1e-3);
}

/// Least stress along x of the points whose other coordinates at the start are below a bound, sorted by
/// x, up to the front, and the largest beyond it.
fn row_of_points(record: &Value, state: &Value, bound: f64) -> Vec<f64> {
    let start = rows(&states(record)[0], "mp", "MP_COORD");
    let stress = state["mp"]["MP_CAUCHY_STRESS_VECTOR"].as_array().unwrap();
    let mut row: Vec<(f64, f64)> = start
        .iter()
        .zip(stress)
        .filter(|(x, _)| x[1] < bound && x[2] < bound)
        .map(|(x, s)| (x[0], s[0].as_f64().unwrap()))
        .collect();
    row.sort_by(|a, b| a.0.total_cmp(&b.0));
    row.into_iter().map(|(_, stress)| stress).collect()
}

/// Behind a plane front that has passed so many points of a row the stress is one number, ahead of it none.
#[track_caller]
fn assert_plane_front(row: &[f64], passed: usize, stress: f64) {
    for (place, found) in row.iter().enumerate() {
        let expected = if place < passed { stress } else { 0.0 };
        assert!((found - expected).abs() < 1e-12 * stress.abs(), "point {place}: {found} Pa, not {expected} Pa");
    }
}

#[test]
fn the_front_in_the_elastic_bar_is_exact() {
    let record = run("dgmpm_bar", 190);
    for state in states(&record).iter().filter(|state| number(state, "/step") <= 150.0) {
        let row = row_of_points(&record, state, 1.0);
        assert_plane_front(&row, number(state, "/step") as usize, -1e9);
        let moving = rows(state, "mp", "MP_VELOCITY")[0][0];
        let speed = 1e9 / (7800.0 * (2e11_f64 / 7800.0).sqrt());
        assert!(number(state, "/step") == 0.0 || (moving / speed - 1.0).abs() < 1e-12, "{moving} m/s");
    }
}

#[test]
fn the_loaded_end_of_the_kirchhoff_bar_is_that_of_the_simple_wave() {
    let record = run("dgmpm_svk_bar", 1);
    let last = states(&record).last().unwrap();
    assert_close(rows(last, "mp", "MP_VELOCITY")[0][0], 20.316085, 1e-5);
    assert_close(last["mp"]["MP_DEFORMATION_GRADIENT"][0][0].as_f64().unwrap(), 0.995_975_740_6, 1e-7);
    for (file, load) in [("ProjectParameters_fan.json", -1e10), ("ProjectParameters_shock.json", 1e10)] {
        let record = run_file("dgmpm_svk_bar", file, 1);
        let stress = states(&record).last().unwrap()["mp"]["MP_PK1_STRESS_TENSOR"][0][0].as_f64().unwrap();
        assert_close(stress, load, 1e-3);
    }
}

/// −ρ c_p v of steel with these constants.
fn plane_wave(young: f64, density: f64, velocity: f64) -> f64 {
    -density * (young * 0.7 / (1.3 * 0.4) / density).sqrt() * velocity
}

#[test]
fn plane_fronts_in_plates_and_blocks_are_not_smeared() {
    for (name, steps, state, bound, stress) in [
        ("dgmpm_plate", 26, 7, 0.1, plane_wave(2e11, 7800.0, 5.0)),
        ("dgmpm_notched_plate", 170, 24, 0.001, plane_wave(1.9e11, 8000.0, 16.5)),
        ("dgmpm_block", 57, 11, 0.004, plane_wave(2e11, 7800.0, 10.0)),
    ] {
        let record = run(name, steps);
        let state = states(&record).iter().find(|found| number(found, "/step") as usize == state).unwrap();
        assert_plane_front(&row_of_points(&record, state, bound), number(state, "/step") as usize, stress);
    }
}

/// Height of the column at the wall as in Martin & Moyce (1952, table 6): H = η/(2 a) at τ = t sqrt(g/a).
#[test]
fn the_dam_breaks_as_in_the_experiment() {
    let record = run("dam_break", 90);
    let start = number(&states(&record)[0], "/energies/total");
    assert_close(start, 2000.0 * GRAVITY, 1e-12);
    for (tau, height) in [(0.93, 0.83), (1.46, 0.67), (2.0, 0.5), (2.45, 0.39)] {
        let time = tau / GRAVITY.sqrt();
        let state = states(&record).iter().find(|state| number(state, "/time") >= time).unwrap();
        let at_wall = rows(state, "mp", "MP_COORD").into_iter().filter(|x| x[0] < 0.1);
        let found = at_wall.map(|x| x[1]).fold(0.0, f64::max) / 2.0;
        assert!((found - height).abs() < 0.05, "height {found} for {height} at {tau}");
        assert!(number(state, "/energies/total") <= start);
    }
}

/// The half period in which the water's centre of mass comes back to the middle, π/ω, ω² = g k tanh(k H).
#[test]
fn the_tank_sloshes_with_its_first_frequency() {
    let record = run("sloshing_tank", 720);
    let aside: Vec<[f64; 2]> =
        states(&record).iter().map(|state| [number(state, "/time"), number(state, "/sums/com/0") - 0.5]).collect();
    let passes = aside.windows(2).filter(|pair| pair[0][0] > 0.1 && pair[0][1] * pair[1][1] < 0.0);
    let times: Vec<f64> = passes.map(|pair| pair[0][0]).collect();
    let k = std::f64::consts::PI;
    assert_eq!(times.len(), 6);
    assert_close((times[5] - times[0]) / 5.0, k / (GRAVITY * k * (0.5 * k).tanh()).sqrt(), 0.02);
}
