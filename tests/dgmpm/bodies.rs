//! Bodies of several materials, and meshes that are no regular grids.

use super::common::{Cell, Mesh, process, run_project};
use super::scene::{constants, velocity};
use serde_json::{Value, json};
use std::fmt::Write;

/// A project on a mesh file; each body is a part of its elements with law and constants.
fn project(
    mesh: &Mesh,
    bodies: &[(&str, Vec<usize>, Value)],
    end: f64,
    solver: Value,
    processes: &[Value],
) -> (String, Value) {
    let mut parts = String::new();
    let mut materials = Vec::new();
    for (index, (name, elements, material)) in bodies.iter().enumerate() {
        write!(parts, "Begin SubModelPart {name}\nBegin SubModelPartElements\n").unwrap();
        elements.iter().for_each(|element| writeln!(parts, "{}", element + 1).unwrap());
        parts += "End SubModelPartElements\nEnd SubModelPart\n";
        materials.push(json!({"model_part_name": format!("Background_Grid.{name}"), "properties_id": index + 1,
                              "Material": material}));
    }
    let mut settings = json!({
        "solver_type": "dgmpm", "domain_size": mesh.cell.dimension(),
        "time_stepping": {"time_step": "auto", "courant_number": 1.0},
        "model_import_settings": {"input_filename": "mesh"},
        "material_import_settings": {"materials": materials},
    });
    settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
    let project = json!({
        "problem_data": {"problem_name": "bodies", "parallel_type": "OpenMP", "start_time": 0.0, "end_time": end},
        "solver_settings": settings,
        "processes": {"list": processes},
    });
    (mesh.mdpa("Element", 0, "", &parts), project)
}

fn run(project: &(String, Value), arguments: &[&str]) -> super::common::Record {
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::write(folder.path().join("mesh.mdpa"), &project.0).unwrap();
    std::fs::write(folder.path().join("ProjectParameters.json"), project.1.to_string()).unwrap();
    run_project(folder.path(), arguments)
}

/// Two bars of the same wave speed, the second with four times the impedance: of a velocity jump that
/// meets the joint 2 Z₁/(Z₁ + Z₂) = 0.4 goes on, and the stress is 2 Z₂/(Z₁ + Z₂) = 1.6 of what came.
#[test]
fn a_joint_of_two_bars_reflects_and_transmits_as_it_must() {
    let mesh = Mesh::block(Cell::Line, [100, 1, 1], [0.0; 3], [1.0, 0.0, 0.0]);
    let bar = |factor: f64| {
        json!({"constitutive_law": {"name": "LinearElasticIsotropic3DLaw"},
               "Variables": constants(1000.0 * factor, 1e9 * factor, 0.0, 1)})
    };
    let bodies = [("First", (0..50).collect(), bar(1.0)), ("Second", (50..100).collect(), bar(4.0))];
    // The second half of the first bar moves; its waves are T = ρ c v/2 each way.
    let start = velocity("Background_Grid.First", json!(["2*(x > 0.25)", 0.0, 0.0]));
    let (speed, v) = (1e3, 2.0);
    let scene = project(&mesh, &bodies, 34.5 * 0.01 / speed, json!({"strain": "small"}), &[start]);
    let record = run(&scene, &[]);
    let last = record.last();
    assert_eq!(last.step(), 35);
    let found = last.points("MP_CAUCHY_STRESS_VECTOR");
    // After 35 cells: the joint at 0.5 first met a body of 0.25 m that moved at v against one at rest.
    let stress = |cell: usize| found[cell][0] / (1e6 * v);
    // Joint stress of a moving bar against one at rest: −Z₁ Z₂/(Z₁ + Z₂) v = −0.8 Z₁ v. The front in the
    // second bar has gone 35 cells; 25 cells behind it follows what the rear of the moving part sends.
    for cell in 61..85 {
        assert!((stress(cell) + 0.8).abs() < 1e-12, "cell {cell}: {}", stress(cell));
    }
    for cell in 85..100 {
        assert!(stress(cell).abs() < 1e-12, "cell {cell}: {}", stress(cell));
    }
}

/// A mesh of skew quadrilaterals, or of hexahedra bent in no simple way, with points at Gauss points:
/// a constant velocity stays constant, momentum and mass are kept.
#[test]
fn skew_cells_keep_constant_states_and_momentum() {
    for (cell, count, law) in [
        (Cell::Quadrilateral, 4, "HyperElasticNeoHookeanPlaneStrain2DLaw"),
        (Cell::Quadrilateral, 1, "HyperElasticNeoHookeanPlaneStrain2DLaw"),
        (Cell::Hexahedron, 8, "HyperElasticNeoHookean3DLaw"),
        (Cell::Hexahedron, 1, "HyperElasticNeoHookean3DLaw"),
    ] {
        let mut mesh = Mesh::block(cell, [5, 5, 5], [0.0; 3], [1.0; 3]);
        let dimension = cell.dimension();
        for (index, node) in mesh.nodes.iter_mut().enumerate() {
            (0..dimension).for_each(|a| node[a] += 0.03 * ((7 * index + 5 * a) as f64).sin());
        }
        let material = json!({"constitutive_law": {"name": law}, "Variables": constants(1000.0, 1e6, 0.3, count)});
        let bodies = [("Body", (0..mesh.cells.len()).collect(), material)];
        let solver = json!({"point_placement": "gauss", "time_integration": "rk2",
                            "time_stepping": {"time_step": "auto", "courant_number": 0.5}});
        let constant = velocity("Background_Grid", json!([3.0, -2.0, 1.0]));
        let record = run(&project(&mesh, &bodies, 0.01, solver.clone(), &[constant]), &[]);
        let stress = record.last().points("MP_CAUCHY_STRESS_VECTOR").concat();
        let largest = stress.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        assert!(record.last().step() > 2 && largest < 1e-11 * 1e5, "{cell:?}, {count} points: {largest:e} Pa");
        let shaken = velocity("Background_Grid", json!(["sin(7*x)", "cos(5*y) - z", "x*y"]));
        let record = run(&project(&mesh, &bodies, 0.03, solver, &[shaken]), &["--record-states", "10"]);
        let (first, last) = (record.first(), record.last());
        assert!((last.mass() / first.mass() - 1.0).abs() < 1e-15 && last.energy("total") < first.energy("total"));
        for (now, then) in last.total("momentum").iter().zip(first.total("momentum")) {
            assert!((now - then).abs() < 1e-12 * 1000.0, "{cell:?}, {count} points: {now} and {then}");
        }
    }
}

/// A uniform body force accelerates a free block as a whole.
#[test]
fn body_forces_act_by_mass() {
    let mesh = Mesh::block(Cell::Quadrilateral, [6, 4, 1], [0.0; 3], [3.0, 2.0, 0.0]);
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    for scheme in ["euler", "rk2", "ssp_rk3"] {
        let material = json!({"constitutive_law": {"name": law}, "Variables": constants(1000.0, 1e6, 0.3, 4)});
        let bodies = [("Body", (0..24).collect(), material)];
        let gravity = process(
            "assign_vector_variable_process",
            json!({"model_part_name": "Background_Grid", "variable_name": "VOLUME_ACCELERATION", "constrained": false,
                   "value": [1.5, -9.81, 0.0]}),
        );
        let record = run(&project(&mesh, &bodies, 0.2, json!({"time_integration": scheme}), &[gravity]), &[]);
        let last = record.last();
        for (v, u) in last.points("MP_VELOCITY").iter().zip(last.points("MP_DISPLACEMENT")) {
            for (a, g) in [1.5, -9.81].into_iter().enumerate() {
                assert!((v[a] - g * last.time()).abs() < 1e-11, "{scheme}: {v:?}");
                assert!((u[a] - 0.5 * g * last.time().powi(2)).abs() < 1e-11, "{scheme}: {u:?}");
            }
        }
    }
}
