//! The largest stable step of explicit schemes: c Δt/h on a bar of ten cells.

use super::bar::{Bar, CUBIC, Functions, HATS, LINEAR, QUADRATIC, SPLINE, explicit};
use super::common::{Cell, Mesh, Scene, material, process};
use serde_json::{Value, json};

/// A bar with c = 1 that starts with a velocity of all wavelengths.
fn bar(functions: Functions, members: Value, time_step: Value, end_time: f64) -> Bar {
    let mut solver = explicit(members);
    solver["time_stepping"] = time_step;
    Bar {
        cells: 10,
        length: 1.0,
        area: 1.0,
        density: 1.0,
        young: 1.0,
        poisson: 0.0,
        law: LINEAR,
        functions,
        placement: "even",
        solver,
        processes: Vec::new(),
        end_time,
    }
    .flung("1e-6*sin(37*x*x + 1)")
}

/// Largest energy at five times of 2000 steps, relative to that at the start; infinite if the run is
/// reported as unstable.
fn growth(functions: Functions, members: &Value, courant: f64) -> f64 {
    let step = courant / 10.0;
    let bar = bar(functions, members.clone(), json!({"time_step": step}), 1999.5 * step);
    let Some(record) = bar.try_run(4) else { return f64::INFINITY };
    let energies: Vec<f64> = record.states().iter().map(|s| s.energy("kinetic") + s.energy("strain")).collect();
    energies.iter().copied().fold(0.0, f64::max) / energies[0]
}

fn cases() -> Vec<(Functions, Value, f64)> {
    let points = |functions: Functions, points: usize| Functions { points, ..functions };
    let (flip, pic, last) = (json!({}), json!({"flip_fraction": 0.0}), json!({"stress_update": "usl"}));
    let consistent = json!({"scheme_type": "velocity_verlet", "consistent_mass_matrix": true});
    let cubic = Functions { basis: "lagrange", order: 3, points: 4 };
    let mut cases = vec![
        (points(HATS, 1), flip.clone(), 2.04),
        (HATS, flip.clone(), 1.74),
        (points(HATS, 3), flip.clone(), 1.69),
        (HATS, pic.clone(), 1.48),
        (points(QUADRATIC, 2), flip.clone(), 0.5),
        (QUADRATIC, flip.clone(), 0.55),
        (cubic, flip.clone(), 0.32),
        (points(SPLINE, 2), flip.clone(), 1.56),
        (SPLINE, flip.clone(), 1.45),
        (SPLINE, pic, 1.24),
        (points(CUBIC, 2), flip.clone(), 1.43),
        (points(CUBIC, 3), flip.clone(), 1.23),
        (HATS, last.clone(), 0.76),
        (QUADRATIC, last.clone(), 0.31),
        (SPLINE, last.clone(), 0.67),
        (points(CUBIC, 3), last, 0.52),
        (HATS, consistent.clone(), 0.51),
        (points(HATS, 3), consistent.clone(), 0.553),
        (QUADRATIC, consistent.clone(), 0.195),
        (cubic, consistent.clone(), 0.098),
        (points(SPLINE, 2), consistent.clone(), 0.376),
        (SPLINE, consistent.clone(), 0.407),
        (points(CUBIC, 3), consistent.clone(), 0.245),
        (HATS, json!({"consistent_mass_matrix": true}), 0.51),
        (HATS, json!({"scheme_type": "yoshida"}), 1.74 * 1.5734 / 2.0),
    ];
    for (functions, affine, filtered) in [(HATS, 1.0, 1.72), (SPLINE, 0.95, 1.41)] {
        cases.push((functions, json!({"transfer": "apic"}), affine));
        cases.push((functions, json!({"transfer": "tpic"}), affine));
        cases.push((functions, json!({"transfer": "xpic"}), filtered));
    }
    for (scheme, update) in [("forward_euler", "usf"), ("central_difference", "usf"), ("velocity_verlet", "usf")] {
        cases.push((HATS, json!({"scheme_type": scheme, "stress_update": update}), 1.74));
    }
    cases
}

/// Spectral radii of the maps from step to step of an independent prototype (NumPy).
#[test]
fn runs_are_stable_up_to_the_spectral_limit_and_not_beyond() {
    for (functions, members, limit) in cases() {
        let below = growth(functions, &members, 0.95 * limit);
        // Symplectic steps near their limit keep an energy that is not Σ ½mv² + U.
        assert!(below < 20.0, "{functions:?}, {members}: energy grows {below:e} times at 0.95 of {limit}");
        let above = growth(functions, &members, 1.08 * limit);
        assert!(above > 1e3, "{functions:?}, {members}: energy grows {above:e} times at 1.08 of {limit}");
    }
}

/// The step that "auto" takes at Courant number 1 is within these limits, and not far below them.
#[test]
fn the_automatic_step_is_stable_and_not_wasteful() {
    for (functions, members, limit) in cases() {
        // The guaranteed limit is that of any number of points, evenly placed or at Gauss points.
        if functions.points == 1 {
            continue;
        }
        let auto = json!({"time_step": "auto", "courant_number": 1.0});
        let record = bar(functions, members.clone(), auto, 50.0).run(4);
        let courant = 10.0 * 50.0 / record.json["steps"].as_f64().unwrap();
        assert!(courant <= 1.001 * limit && courant > 0.6 * limit, "{functions:?}, {members}: {courant} of {limit}");
        let energies: Vec<f64> = record.states().iter().map(|s| s.energy("kinetic") + s.energy("strain")).collect();
        assert!(energies.iter().all(|e| e / energies[0] < 20.0), "{functions:?}, {members}: {energies:?}");
    }
}

/// In the plane and in space waves of shear and pressure add up: the limits are lower. In space without
/// the consistent mass, whose systems would take most of the time.
#[test]
fn the_automatic_step_is_stable_in_the_plane_and_in_space() {
    let bases = [("mesh", 1, 2), ("lagrange", 2, 3), ("b_spline", 2, 3), ("b_spline", 3, 3)];
    let consistent = json!({"scheme_type": "velocity_verlet", "consistent_mass_matrix": true});
    let choices = [
        json!({}),
        json!({"flip_fraction": 0.0}),
        json!({"stress_update": "usl"}),
        consistent.clone(),
        json!({"transfer": "apic"}),
    ];
    for cell in [Cell::Quadrilateral, Cell::Hexahedron] {
        for (basis, order, points) in bases {
            for members in &choices {
                let solves = *members == consistent && cell == Cell::Hexahedron;
                if solves || (basis, &members["transfer"]) == ("lagrange", &json!("apic")) {
                    continue;
                }
                let cells = if cell == Cell::Quadrilateral { 5 } else { 3 };
                let mut solver = explicit(members.clone());
                solver.as_object_mut().unwrap().extend(
                    json!({"solver_type": "dynamic", "frame": "total_lagrangian", "basis": basis, "basis_order": order,
                           "point_placement": "even", "time_stepping": {"time_step": "auto", "courant_number": 1.0}})
                    .as_object()
                    .unwrap()
                    .clone(),
                );
                let block = Mesh::block(cell, [cells; 3], [0.0; 3], [cells as f64; 3]);
                let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
                let count = points_of(cell, points);
                let wave = "1e-4*sin(37*x*x + 29*y + 11*z)";
                let velocity = json!({"model_part_name": "MPM_Material", "value": [wave, wave, wave]});
                let record = Scene::new(block.clone(), block, material(law, count, 1.0, 0.5, 0.4), solver, 50.0)
                    .with(process("assign_initial_field_to_material_point_process", velocity))
                    .run(&["--record-states", "3"]);
                let energies: Vec<f64> =
                    record.states().iter().map(|s| s.energy("kinetic") + s.energy("strain")).collect();
                let grown = energies.iter().copied().fold(0.0, f64::max) / energies[0];
                assert!(grown < 20.0, "{cell:?} {basis} {order} {members}: energy grows {grown:e} times");
            }
        }
    }
}

fn points_of(cell: Cell, each_way: usize) -> usize {
    each_way.pow(cell.dimension() as u32)
}

/// What no step makes stable is refused: projections with functions that change sign amplify.
#[test]
fn what_amplifies_at_any_step_is_refused() {
    let cubic = Functions { basis: "lagrange", order: 3, points: 4 };
    for (functions, members) in [
        (QUADRATIC, json!({"transfer": "tpic"})),
        (QUADRATIC, json!({"transfer": "apic"})),
        (cubic, json!({"flip_fraction": 0.5})),
        (cubic, json!({"transfer": "xpic"})),
        (cubic, json!({"stress_update": "usl"})),
        (Functions { order: 6, points: 7, ..cubic }, json!({})),
    ] {
        let (status, message) = bar(functions, members.clone(), json!({"time_step": 1e-3}), 0.1).failure();
        assert_eq!(status, Some(2), "{members}: {message}");
        assert!(message.contains("degree"), "{members}: {message}");
    }
}

/// A single point in the middle of a cubic cell: the outer functions are negative there.
#[test]
fn negative_lumped_masses_stop_the_run() {
    let cubic = Functions { basis: "lagrange", order: 3, points: 1 };
    let (status, message) = bar(cubic, json!({}), json!({"time_step": 1e-3}), 0.1).failure();
    assert_eq!(status, Some(3), "{message}");
    assert!(message.contains("negative lumped mass"), "{message}");
}
