//! Pressures and surface loads, axisymmetry, output files, and the number of threads.

use super::body::{Body, fix, load, material};
use super::common::{Cell, Mesh, orders, process};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

/// A thick tube under internal pressure, so small that Lamé's linear solution holds:
/// u(r) = (1 + ν) p a²/(E (b² − a²)) ((1 − 2ν) r + b²/r).
#[test]
fn a_tube_under_pressure_widens_as_lame_says() {
    let (inner, outer, young, poisson, pressure) = (1.0, 2.0, 1e5, 0.3, 1e-2);
    let exact = |r: f64| {
        (1.0 + poisson) * pressure * inner * inner / (young * (outer * outer - inner * inner))
            * ((1.0 - 2.0 * poisson) * r + outer * outer / r)
    };
    for cell in [Cell::Quadrilateral, Cell::Triangle] {
        let errors = [4, 8, 16].map(|cells| {
            let mesh = Mesh::block(cell, [cells, cells / 2, 1], [inner, 0.0, 0.0], [outer, 0.5, 0.0]);
            // The right of a line is its normal, along which a pressure pushes: upwards the line runs.
            let side = (0..cells / 2).map(|j| vec![j * (cells + 1), (j + 1) * (cells + 1)]).collect();
            let law = "HyperElasticNeoHookeanAxisym2DLaw";
            let solver = json!({"axis_symmetric_flag": true, "residual_relative_tolerance": 1e-7});
            let pushed = json!({"model_part_name": "Structure.Inside", "variable_name": "POSITIVE_FACE_PRESSURE",
                                "value": pressure});
            let body = Body::new(mesh, material(law, 1.0, young, poisson), solver, 1.0)
                .part("Ends", |x| x[1] == 0.0 || x[1] == 0.5)
                .with(fix("Ends", json!([null, 0.0, null])))
                .conditions("Inside", "AxisymLineLoadCondition2D2N", side)
                .with(process("assign_scalar_variable_to_conditions_process", pushed));
            let record = body.run(&[]);
            let displacements = record.last().nodes("DISPLACEMENT");
            let each = body.mesh.nodes.iter().zip(&displacements);
            each.map(|(x, u)| (u[0] / exact(x[0]) - 1.0).abs()).fold(0.0, f64::max)
        });
        assert!(errors[2] < 4e-3 && orders(&errors).iter().all(|order| *order > 1.4), "{cell:?}: {errors:?}");
    }
}

/// A cube pulled at its top by a dead load: 16 faces, whatever they have become.
fn cube(cell: Cell, solver: Value) -> Body {
    let mesh = Mesh::block(cell, [4; 3], [0.0; 3], [1.0; 3]);
    let node = |i: usize, j: usize| (4 * 5 + j) * 5 + i;
    let corners = |i: usize, j: usize| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
    let all = (0..16).map(|k| corners(k % 4, k / 4));
    let (name, faces) = match cell {
        Cell::Tetrahedron => {
            ("SurfaceLoadCondition3D3N", all.flat_map(|[a, b, c, d]| [vec![a, b, c], vec![a, c, d]]).collect())
        }
        _ => ("SurfaceLoadCondition3D4N", all.map(|corners| corners.to_vec()).collect()),
    };
    Body::new(mesh, material("HyperElasticNeoHookean3DLaw", 1000.0, 1e6, 0.3), solver, 1.0)
        .part("Floor", |x| x[2] == 0.0)
        .with(fix("Floor", json!([0.0, 0.0, 0.0])))
        .conditions("Top", name, faces)
        .with(load("Top", "SURFACE_LOAD", json!([1e4, 0.0, 5e4])))
}

#[test]
fn reactions_balance_dead_surface_loads() {
    for cell in [Cell::Hexahedron, Cell::Tetrahedron] {
        let reactions = cube(cell, json!({})).run(&[]).last().nodes("REACTION");
        for (a, total) in [1e4, 0.0, 5e4].into_iter().enumerate() {
            let held: f64 = reactions.iter().map(|r| r[a]).sum();
            assert!((held + total).abs() < 1e-6, "{cell:?}: {held} N hold {total} N along {a}");
        }
    }
}

#[test]
fn results_have_the_same_bits_for_any_number_of_threads() {
    let explicit = json!({"solver_type": "structural_dynamic", "time_integration_method": "explicit",
                          "time_stepping": {"time_step": "auto"}});
    let implicit = json!({"solver_type": "structural_dynamic", "time_stepping": {"time_step": 0.25}});
    for solver in [explicit, implicit] {
        let body = cube(Cell::Hexahedron, solver);
        let [one, two, five] =
            ["1", "2", "5"].map(|threads| body.run(&["--threads", threads]).json["snapshots"].clone());
        assert!(one == two && one == five, "results differ");
    }
}

/// What outputs read is what the record holds.
#[test]
fn outputs_hold_nodes_and_elements() {
    let shown = json!({"model_part_name": "Structure", "file_format": "ascii", "output_precision": 17,
                       "nodal_solution_step_data_variables": ["DISPLACEMENT", "REACTION"],
                       "gauss_point_variables_in_elements": ["PK2_STRESS_VECTOR"],
                       "element_data_value_variables": ["GREEN_LAGRANGE_STRAIN_VECTOR"]});
    let history = json!({"model_part_name": "Structure.Top", "output_variables": ["DISPLACEMENT_Z"],
                         "output_file_name": "top.json", "time_frequency": 0.5});
    let mut body = cube(Cell::Hexahedron, json!({})).with(process("json_output_process", history));
    body.outputs.push(process("vtk_output_process", shown));
    let folder = TempDir::new().unwrap();
    body.write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder.path()).args(["run", "ProjectParameters.json", "--quiet", "--record", "record.json"]);
    assert!(command.status().unwrap().success());
    let record = super::common::Record::read(&folder.path().join("record.json"));
    let top: Value = serde_json::from_str(&std::fs::read_to_string(folder.path().join("top.json")).unwrap()).unwrap();
    let raised = record.last().nodes("DISPLACEMENT")[124][2];
    let file = std::fs::read_to_string(folder.path().join("VTK_Output/Structure_0_1.vtk")).unwrap();
    for name in ["PK2_STRESS_VECTOR", "GREEN_LAGRANGE_STRAIN_VECTOR"] {
        let after = file.split(&format!("{name} 6 64 ")).nth(1).unwrap_or_else(|| panic!("no field {name} in\n{file}"));
        let numbers = after.split_whitespace().skip(1).take(6 * 64).map(|word| word.parse().unwrap());
        let written: Vec<f64> = numbers.collect();
        let recorded = record.last().field("elements", name).concat();
        let size = recorded.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(written.iter().zip(&recorded).all(|(a, b)| (a - b).abs() < 1e-15 * size.max(1.0)), "{name}");
    }
    assert!(raised > 0.0 && top["NODE_125"]["DISPLACEMENT_Z"][0] == json!(raised), "{raised} m, {top}");
}
