//! The explicit material point method against exact solutions and conservation laws.

mod common;

use common::{Cell, Mesh, Record, Scene, fix, gravity, largest_difference, material, process};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

const SCHEMES: [(&str, &str); 4] =
    [("forward_euler", "usf"), ("forward_euler", "usl"), ("forward_euler", "musl"), ("central_difference", "usf")];

/// Solver settings of a scheme.
fn explicit((scheme, update): (&str, &str), time_step: impl Into<Value>) -> Value {
    json!({"solver_type": "dynamic", "time_integration_method": "explicit", "scheme_type": scheme,
           "stress_update": update, "time_stepping": {"time_step": time_step.into()}})
}

fn initial_velocity(part: &str, velocity: [f64; 3]) -> Value {
    let parameters = json!({"model_part_name": part, "modulus": 1.0, "direction": velocity});
    process("assign_initial_velocity_to_material_point_process", parameters)
}

/// A bar of unit length and density along x, ν = 0 and E = 1, hence c = 1: one row of square cells,
/// with room for its end to move into. Lateral motion is held everywhere, the left end if `clamped`.
fn bar(cells: usize, end_time: f64, solver: Value) -> Scene {
    let h = 1.0 / cells as f64;
    let grid = Mesh::block(Cell::Quadrilateral, [cells + 2, 1, 0], [0.0; 3], [1.0 + 2.0 * h, h, 0.0]);
    let body = Mesh::block(Cell::Quadrilateral, [cells, 1, 0], [0.0; 3], [1.0, h, 0.0]);
    let law = material("LinearElasticIsotropicPlaneStrain2DLaw", 4, 1.0, 1.0, 0.0);
    let scene = Scene::new(grid, body, law, solver, end_time);
    scene.part("All", |_| true).part("Left", |x| x[0] < 1e-9).with(fix("All", json!([null, 0.0, null])))
}

fn clamped(scene: Scene) -> Scene {
    scene.with(fix("Left", json!([0.0, null, null])))
}

/// Mean displacement along x of the points beyond x (where they started).
fn mean_displacement(record: &common::State, start: &[Vec<f64>], beyond: f64) -> f64 {
    let displacements = record.points("MP_DISPLACEMENT");
    let chosen: Vec<f64> = displacements.iter().zip(start).filter(|(_, x)| x[0] > beyond).map(|(u, _)| u[0]).collect();
    chosen.iter().sum::<f64>() / chosen.len() as f64
}

/// Runs a scene that must fail and returns the exit status and what it says.
fn failing(scene: &Scene, arguments: &[&str]) -> (Option<i32>, String) {
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder.path()).args(["run", "ProjectParameters.json", "--quiet"]).args(arguments);
    let output = command.output().expect("the built program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A point alone starts on a node and meets faces and nodes exactly again and again, where the
/// nodes beyond it get no mass: it flies on as if there were no grid.
#[test]
fn a_point_flies_along_faces_and_nodes() {
    let body = Mesh::block(Cell::Quadrilateral, [1, 1, 0], [0.5, 0.5, 0.0], [1.5, 1.5, 0.0]);
    let grid = Mesh::block(Cell::Quadrilateral, [14, 8, 0], [0.0; 3], [14.0, 8.0, 0.0]);
    for frame in ["updated_lagrangian", "total_lagrangian"] {
        for scheme in SCHEMES {
            let mut solver = explicit(scheme, 0.25);
            solver["frame"] = frame.into();
            let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 1, 1.0, 1e-3, 0.3);
            let scene = Scene::new(grid.clone(), body.clone(), law, solver, 10.0);
            let record = scene.with(initial_velocity("MPM_Material", [1.0, 0.5, 0.0])).run(&[]);
            let (x, v) = (record.last().points("MP_COORD"), record.last().points("MP_VELOCITY"));
            let told = format!("{frame} {scheme:?}: {x:?} {v:?}");
            assert!((x[0][0] - 11.0).abs() < 1e-12 && (x[0][1] - 6.0).abs() < 1e-12, "{told}");
            assert!((v[0][0] - 1.0).abs() < 1e-12 && (v[0][1] - 0.5).abs() < 1e-12, "{told}");
        }
    }
}

/// No force acts on a flying body: its momentum stays, while it deforms, turns and crosses cells.
#[test]
fn free_flight_keeps_momentum() {
    for scheme in SCHEMES {
        for (cell, points) in
            [(Cell::Quadrilateral, 4), (Cell::Triangle, 3), (Cell::Hexahedron, 8), (Cell::Tetrahedron, 4)]
        {
            let grid = Mesh::block(cell, [8, 8, 4], [0.0; 3], [4.0, 4.0, 2.0]);
            let body = Mesh::block(cell, [4, 3, 2], [0.9, 1.2, 0.3], [2.5, 2.4, 1.1]);
            let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
            let mut scene =
                Scene::new(grid, body, material(law, points, 1000.0, 1e6, 0.3), explicit(scheme, 1e-3), 0.2);
            // A second body moves the other way: both meet and deform.
            let second = Mesh::block(cell, [2, 2, 2], [2.6, 1.3, 0.3], [3.3, 2.2, 1.1]);
            scene.bodies.push(common::Body {
                name: "Second",
                mesh: second,
                material: scene.bodies[0].material.clone(),
            });
            let scene = scene
                .with(initial_velocity("MPM_Material.Body", [2.0, -0.5, 0.3]))
                .with(initial_velocity("MPM_Material.Second", [-1.0, 0.8, 0.1]));
            let record = scene.run(&[]);
            let (before, after) = (record.first().total("momentum"), record.last().total("momentum"));
            let scale = record.first().mass() * 2.0;
            for a in 0..3 {
                let change = (after[a] - before[a]).abs() / scale;
                assert!(change < 1e-12, "{scheme:?} {cell:?}: momentum {a} changes by {change:e}");
            }
            let stress = record.last().points("MP_CAUCHY_STRESS_VECTOR").concat();
            assert!(stress.iter().any(|s| s.abs() > 1e3), "{scheme:?} {cell:?}: the bodies must have met");
        }
    }
}

/// A sudden traction p at the end of a clamped bar: by d'Alembert, the end moves at p/(ρ c) to
/// 2 p L/E at t = 2 L/c and back. The error falls with the cells.
#[test]
fn a_sudden_load_travels_as_dalembert_says() {
    const LOAD: f64 = -1e-4;
    let error = |cells: usize, scheme: (&str, &str)| {
        let h = 1.0 / cells as f64;
        let mut scene = clamped(bar(cells, 4.0, explicit(scheme, 0.2 * h)));
        let end = scene.grid.find(|x| (x[0] - 1.0).abs() < 1e-9);
        scene.loads.push(("End", "MPMGridPointLoadCondition2D1N", end.iter().map(|&node| vec![node]).collect()));
        let parameters = json!({"model_part_name": "Background_Grid.End", "variable_name": "POINT_LOAD",
            "modulus": LOAD * h / 2.0, "direction": [1.0, 0.0, 0.0]});
        let record = scene
            .with(process("assign_vector_by_direction_to_condition_process", parameters))
            .run(&["--record-states", "40"]);
        let start = record.first().points("MP_COORD");
        let beyond = 1.0 - h;
        let squares: f64 = record
            .states()
            .iter()
            .map(|state| {
                let t = state.time() % 4.0;
                let exact = LOAD * if t < 2.0 { t } else { 4.0 - t };
                (mean_displacement(state, &start, beyond) - exact).powi(2)
            })
            .sum();
        (squares / 41.0).sqrt() / (2.0 * LOAD.abs())
    };
    for scheme in SCHEMES {
        let errors = [error(20, scheme), error(40, scheme)];
        assert!(errors[1] < 0.02 && errors[1] < 0.65 * errors[0], "{scheme:?}: {errors:?}");
    }
}

/// A clamped bar that starts with a uniform velocity vibrates for ever. Over five periods schemes that are
/// symplectic but for the map to the points keep the energy up to their order in the step: forward Euler
/// with the stress first gains and with mapped velocities loses with first order, central differences
/// are of second; with the stress last energy is lost all the time (Bardenhagen 2002), less with shorter steps.
#[test]
fn energy_is_kept_with_the_order_of_the_scheme() {
    let changes = |scheme: (&str, &str), step: f64| -> Vec<f64> {
        let velocity = initial_velocity("MPM_Material", [1e-4, 0.0, 0.0]);
        let record = clamped(bar(40, 20.0, explicit(scheme, step))).with(velocity).run(&["--record-states", "10"]);
        let total = |state: common::State| state.energy("kinetic") + state.energy("strain");
        let start = total(record.first());
        record.states().into_iter().skip(1).map(|state| total(state) / start - 1.0).collect()
    };
    let mean = |changes: &[f64]| changes.iter().sum::<f64>() / changes.len() as f64;
    let [first, last, mapped, central] = SCHEMES.map(|scheme| [0.005, 0.0025].map(|step| changes(scheme, step)));
    let ratio = |[long, short]: &[Vec<f64>; 2]| mean(long) / mean(short);
    assert!(first.iter().flatten().all(|change| *change > 0.0), "{first:?}");
    assert!(mapped.iter().flatten().all(|change| *change < 0.0), "{mapped:?}");
    // Ten states take the oscillation at chance phases: means of a third more or less shift an order by as much.
    for (name, changes, order) in [("usf", &first, 1.0), ("musl", &mapped, 1.0), ("central", &central, 2.0)] {
        let found = ratio(changes).log2();
        assert!((found - order).abs() < 0.35, "{name}: order {found}: {changes:?}");
    }
    for changes in &last {
        assert!(changes.windows(2).all(|pair| pair[1] < pair[0]) && changes[0] < 0.0, "{changes:?}");
    }
    assert!(ratio(&last) > 1.2, "{last:?}");
}

#[test]
fn results_have_the_same_bits_for_any_number_of_threads() {
    let grid = Mesh::block(Cell::Hexahedron, [12, 12, 12], [0.0; 3], [3.0; 3]);
    let body = Mesh::block(Cell::Hexahedron, [8, 8, 8], [0.4, 0.1, 0.5], [2.3, 2.0, 2.4]);
    for scheme in [SCHEMES[2], SCHEMES[3]] {
        let law = material("HyperElasticNeoHookean3DLaw", 8, 1000.0, 1e6, 0.3);
        let scene = Scene::new(grid.clone(), body.clone(), law, explicit(scheme, 1e-3), 0.1)
            .part("Floor", |x| x[1] < 1e-9)
            .with(fix("Floor", json!([0.0, 0.0, 0.0])))
            .with(gravity([0.0, -9.81, 0.0]))
            .with(initial_velocity("MPM_Material", [0.3, -2.0, 0.1]));
        let run = |threads: &str| scene.run(&["--threads", threads]).json["snapshots"].clone();
        let one = run("1");
        assert!(one == run("2") && one == run("8"), "{scheme:?}: the number of threads changes the result");
    }
}

/// h/(c + v) times the Courant number, cut to end at the end.
#[test]
fn the_automatic_step_is_the_stable_one() {
    let mut solver = explicit(SCHEMES[2], "auto");
    solver["time_stepping"]["courant_number"] = json!(0.5);
    let mut scene = bar(20, 0.99, solver).with(initial_velocity("MPM_Material", [0.25, 0.0, 0.0]));
    // Room for the flight.
    scene.grid = Mesh::block(Cell::Quadrilateral, [40, 1, 0], [0.0; 3], [2.0, 0.05, 0.0]);
    scene.parts[0].1 = scene.grid.find(|_| true);
    scene.parts[1].1 = scene.grid.find(|x| x[0] < 1e-9);
    let record = scene.run(&["--record-states", "4"]);
    let step = 0.5 * 0.05 / 1.25;
    assert_eq!(record.json["steps"].as_f64().unwrap(), (0.99f64 / step).ceil());
    assert!((record.last().time() - 0.99).abs() < 1e-12, "the run ends at {}", record.last().time());
    assert_eq!(record.states().len(), 5);
}

/// Before the run, when no point moves yet: h/c = 0.05 s.
#[test]
fn check_knows_the_stable_step() {
    let told = |step: f64| {
        let folder = TempDir::new().unwrap();
        bar(20, 10.0, explicit(SCHEMES[2], step)).write(folder.path());
        let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
        let output = command.current_dir(folder.path()).args(["check", "ProjectParameters.json"]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(told(0.0501).contains("5.0100e-2 s is above the stable one, 5.0000e-2 s"), "{}", told(0.0501));
    assert!(!told(0.0499).contains("stable"), "{}", told(0.0499));
}

#[test]
fn an_unstable_run_stops_and_names_the_step_it_needs() {
    let scene = |policy: &str| {
        let mut solver = explicit(SCHEMES[2], 0.2);
        solver["time_stepping"]["time_step_policy"] = json!(policy);
        clamped(bar(20, 40.0, solver)).with(initial_velocity("MPM_Material", [0.02, 0.0, 0.0]))
    };
    let (status, message) = failing(&scene("warn"), &[]);
    assert_eq!(status, Some(3), "{message}");
    for part in ["unstable", "step ", "material point ", "J = ", "velocity: ", "stable ", "time step of at most"] {
        assert!(message.contains(part), "{part:?} is missing:\n{message}");
    }
    let (status, message) = failing(&scene("strict"), &[]);
    assert_eq!(status, Some(3), "{message}");
    assert!(message.contains("step 0") && message.contains("above the stable one"), "{message}");
}

/// A wall that moves at V sends the stress −ρ c V into the bar; Kratos holds such a wall still.
#[test]
fn a_moving_wall_drives_the_bar() {
    const VELOCITY: f64 = 1e-4;
    for scheme in SCHEMES {
        let time_step = 0.005;
        let scene =
            bar(50, 0.6, explicit(scheme, time_step)).with(fix("Left", json!([VELOCITY * time_step, null, null])));
        let behind_the_front = |record: &Record| {
            let (stress, position) =
                (record.last().points("MP_CAUCHY_STRESS_VECTOR"), record.last().points("MP_COORD"));
            let plateau = |x: f64| (0.1..0.5).contains(&x);
            let chosen: Vec<f64> =
                stress.iter().zip(&position).filter(|(_, x)| plateau(x[0])).map(|(s, _)| s[0]).collect();
            chosen.iter().sum::<f64>() / chosen.len() as f64
        };
        let stress = behind_the_front(&scene.run(&[]));
        assert!((stress / -VELOCITY - 1.0).abs() < 0.03, "{scheme:?}: stress {stress:e}");
        assert_eq!(behind_the_front(&scene.run(&["--kratos-exact"])), 0.0);
    }
}

/// Grid velocities that are linear in space carry and deform every point exactly.
#[test]
fn imposed_stretching_is_exact() {
    const RATE: f64 = 0.2;
    let time_step = 0.01;
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 3), (Cell::Hexahedron, 8), (Cell::Tetrahedron, 4)]
    {
        for scheme in SCHEMES {
            let grid = Mesh::block(cell, [5, 4, 3], [0.0; 3], [2.5, 2.0, 1.5]);
            let body = Mesh::block(cell, [2, 2, 2], [0.3, 0.4, 0.2], [1.2, 1.1, 0.9]);
            let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
            let scene =
                Scene::new(grid, body, material(law, points, 1.0, 1.0, 0.25), explicit(scheme, time_step), 0.495)
                    .part("All", |_| true)
                    .with(fix("All", json!([format!("{}*x", RATE * time_step), 0.0, 0.0])));
            let record = scene.run(&[]);
            let stretch = (1.0 + RATE * time_step).powi(50);
            let start = record.first().points("MP_COORD");
            let exact: Vec<Vec<f64>> = start.iter().map(|x| vec![stretch * x[0], x[1], x[2]]).collect();
            let error = largest_difference(&record.last().points("MP_COORD"), &exact);
            assert!(error < 1e-12, "{scheme:?} {cell:?}: positions are off by {error:e} m");
            // Uniaxial strain with λ = μ = 0.4: σ = (λ ln J + μ (J² − 1))/J along the stretching.
            let exact = 0.4 * (stretch.ln() + stretch * stretch - 1.0) / stretch;
            for stress in record.last().points("MP_CAUCHY_STRESS_VECTOR") {
                assert!((stress[0] - exact).abs() < 1e-12, "{scheme:?} {cell:?}: stress {} for {exact}", stress[0]);
            }
        }
    }
}

/// A fluid that is sheared at a constant rate resists with μ times that rate, however far it has come.
#[test]
fn a_sheared_fluid_resists_with_its_viscosity() {
    const RATE: f64 = 0.5;
    let time_step = 0.01;
    let grid = Mesh::block(Cell::Quadrilateral, [8, 2, 0], [0.0; 3], [4.0, 1.0, 0.0]);
    let body = Mesh::block(Cell::Quadrilateral, [2, 2, 0], [0.5, 0.0, 0.0], [1.5, 1.0, 0.0]);
    let mut fluid = material("DispNewtonianFluidPlaneStrain2DLaw", 4, 1.0, 1.0, 0.25);
    fluid["Variables"]["BULK_MODULUS"] = json!(100.0);
    fluid["Variables"]["DYNAMIC_VISCOSITY"] = json!(3.0);
    let scene = Scene::new(grid, body, fluid, explicit(SCHEMES[2], time_step), 0.995)
        .part("All", |_| true)
        .with(fix("All", json!([format!("{}*y", RATE * time_step), 0.0, null])));
    let shear = |record: Record| record.last().points("MP_CAUCHY_STRESS_VECTOR")[0][2];
    let stress = shear(scene.run(&[]));
    assert!((stress - 3.0 * RATE).abs() < 1e-9, "shear stress {stress}");
}
