//! Where points start, what they show, and what the grid shows of them.

mod common;

use common::{Cell, Mesh, Record, Scene, fix, material, process};
use nalgebra::Matrix3;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;

/// Runs a project that must fail on its input, and returns what it says.
fn refused(folder: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder).args(["check", "ProjectParameters.json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn read(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

/// A body of one cell of this size and so many even points, at rest.
fn even(cell: Cell, size: [f64; 3], count: usize) -> Scene {
    let grid = Mesh::block(cell, [2, 2, 2], [0.0; 3], [2.0, 4.0, 6.0]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let body = Mesh::block(cell, [1, 1, 1], [0.0; 3], size);
    let solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
                        "scheme_type": "forward_euler", "stress_update": "musl", "point_placement": "even",
                        "time_stepping": {"time_step": 1e-6}});
    Scene::new(grid, body, material(law, count, 2.0, YOUNG, POISSON), solver, 1e-6)
}

/// n × n (× n) points at (2 i + 1)/(2 n) of each edge, with equal shares of the mass.
#[test]
fn even_points_stand_at_the_centres_of_equal_parts() {
    let size = [1.0, 2.0, 3.0];
    for (cell, count) in [(Cell::Quadrilateral, 9), (Cell::Hexahedron, 27), (Cell::Hexahedron, 216)] {
        let record = even(cell, size, count).run(&[]);
        let n = if cell == Cell::Hexahedron { (count as f64).cbrt().round() } else { (count as f64).sqrt() };
        let (places, masses) = (record.first().points("MP_COORD"), record.first().scalars("MP_MASS"));
        assert_eq!(places.len(), count);
        let mass = 2.0 * size[..cell.dimension()].iter().product::<f64>() / count as f64;
        assert!(masses.iter().all(|m| (m / mass - 1.0).abs() < 1e-14));
        for (index, place) in places.iter().enumerate() {
            for axis in 0..cell.dimension() {
                let step = (index / (n as usize).pow(axis as u32) % n as usize) as f64;
                assert!((place[axis] - size[axis] * (2.0 * step + 1.0) / (2.0 * n)).abs() < 1e-14, "{index} {place:?}");
            }
        }
    }
}

/// Each of the two triangles holds n² points with equal shares whose centroid is its own.
#[test]
fn even_points_of_triangles_share_their_mass_and_centroid() {
    let record = even(Cell::Triangle, [1.0, 2.0, 0.0], 16).run(&[]);
    let (places, masses) = (record.first().points("MP_COORD"), record.first().scalars("MP_MASS"));
    assert_eq!(places.len(), 32);
    assert!(masses.iter().all(|m| (m / (2.0 * 2.0 / 32.0) - 1.0).abs() < 1e-14));
    for (points, centroid) in places.chunks(16).zip([[2.0 / 3.0, 2.0 / 3.0], [1.0 / 3.0, 4.0 / 3.0]]) {
        for axis in 0..2 {
            let mean = points.iter().map(|x| x[axis]).sum::<f64>() / 16.0;
            assert!((mean - centroid[axis]).abs() < 1e-14, "{mean} {centroid:?}");
        }
    }
}

#[test]
fn counts_that_cells_cannot_share_are_refused() {
    for (cell, count, advice) in [
        (Cell::Quadrilateral, 3, "allowed: a square number: 1, 4, 9, 16, 25"),
        (Cell::Hexahedron, 9, "allowed: a cubic number: 1, 8, 27, 64, 125"),
        (Cell::Tetrahedron, 8, "allowed: Gauss points, for which it has 1, 4, 8, 14 or 24"),
    ] {
        let folder = TempDir::new().unwrap();
        even(cell, [1.0, 2.0, 3.0], count).write(folder.path());
        let said = refused(folder.path());
        assert!(said.contains(advice) && said.contains("even"), "{said}");
    }
}

/// A turn by 0.2 about z after stretches along the axes.
fn deformation(stretches: [f64; 3]) -> (Matrix3<f64>, Matrix3<f64>) {
    let (sine, cosine) = 0.2f64.sin_cos();
    let turn = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    (turn * Matrix3::from_diagonal(&stretches.into()), turn)
}

/// Energy per volume of the Neo-Hookean law, ½ μ (I₁ − 3) − μ ln J + ½ λ ln² J.
fn neo_hookean(f: &Matrix3<f64>) -> f64 {
    let (mu, lambda) = lame();
    let log = f.determinant().ln();
    0.5 * mu * (f.norm_squared() - 3.0) - mu * log + 0.5 * lambda * log * log
}

fn lame() -> (f64, f64) {
    (YOUNG / (2.0 + 2.0 * POISSON), YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
}

/// P = ∂W/∂F by central differences.
fn first_piola_kirchhoff(f: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| {
        let at = |step: f64| {
            let mut moved = *f;
            moved[(i, j)] += step;
            neo_hookean(&moved)
        };
        (at(1e-5) - at(-1e-5)) / 2e-5
    })
}

/// A static step that deforms all points by F.
fn stretched(cell: Cell, f: &Matrix3<f64>, law: &str) -> Scene {
    let mesh = Mesh::block(cell, [2, 2, 2], [0.0; 3], [1.0; 3]);
    let gradient = f - Matrix3::identity();
    let value = |i: usize| match cell.dimension() > i {
        true => json!(format!("({:e})*x+({:e})*y+({:e})*z", gradient[(i, 0)], gradient[(i, 1)], gradient[(i, 2)])),
        false => Value::Null,
    };
    let edge = move |x: [f64; 3]| x[..cell.dimension()].iter().any(|x| *x < 1e-9 || *x > 1.0 - 1e-9);
    Scene::new(mesh.clone(), mesh, material(law, 4, 1.0, YOUNG, POISSON), json!({}), 1.0)
        .part("Edge", edge)
        .with(fix("Edge", json!([value(0), value(1), value(2)])))
}

/// All measures in the plane and in space against their definitions and the law's energy.
#[test]
fn strains_and_stresses_in_all_measures() {
    for (cell, law, stretches, voigt) in [
        (Cell::Triangle, "HyperElasticNeoHookeanPlaneStrain2DLaw", [1.3, 0.85, 1.0], &[0, 1, 3][..]),
        (Cell::Tetrahedron, "HyperElasticNeoHookean3DLaw", [1.3, 0.85, 1.1], &[0, 1, 2, 3, 4, 5]),
    ] {
        let (f, turn) = deformation(stretches);
        let mut scene = stretched(cell, &f, law);
        let count = if cell == Cell::Triangle { 3 } else { 4 };
        scene.bodies[0].material["Variables"]["MATERIAL_POINTS_PER_ELEMENT"] = json!(count);
        let spatial =
            |value: fn(f64) -> f64| turn * Matrix3::from_diagonal(&stretches.map(value).into()) * turn.transpose();
        let p = first_piola_kirchhoff(&f);
        let sigma = p * f.transpose() / f.determinant();
        let deviator = sigma - Matrix3::from_diagonal_element(sigma.trace() / 3.0);
        let pick = |t: &Matrix3<f64>, shear: f64| -> Vec<f64> {
            let all = [t[(0, 0)], t[(1, 1)], t[(2, 2)], shear * t[(0, 1)], shear * t[(1, 2)], shear * t[(0, 2)]];
            voigt.iter().map(|&i| all[i]).collect()
        };
        let full = |t: &Matrix3<f64>| -> Vec<f64> { t.transpose().iter().copied().collect() };
        let expected = [
            ("MP_GREEN_LAGRANGE_STRAIN_VECTOR", pick(&(0.5 * (f.transpose() * f - Matrix3::identity())), 2.0), 1.0),
            ("MP_ALMANSI_STRAIN_VECTOR", pick(&spatial(|s| 0.5 * (1.0 - s.powi(-2))), 2.0), 1.0),
            ("MP_HENCKY_STRAIN_VECTOR", pick(&spatial(f64::ln), 2.0), 1.0),
            ("MP_DEFORMATION_GRADIENT", full(&f), 1.0),
            ("MP_DETERMINANT_F", vec![f.determinant()], 1.0),
            ("MP_CAUCHY_STRESS_VECTOR", pick(&sigma, 1.0), YOUNG),
            ("MP_PK1_STRESS_TENSOR", full(&p), YOUNG),
            ("MP_PK2_STRESS_VECTOR", pick(&(f.try_inverse().unwrap() * p), 1.0), YOUNG),
            ("MP_EQUIVALENT_STRESS", vec![(1.5 * deviator.norm_squared()).sqrt()], YOUNG),
        ];
        let names: Vec<&str> = expected.iter().map(|(name, _, _)| *name).collect();
        let output = json!({"model_part_name": "MPM_Material", "output_file_name": "points.json",
                            "time_frequency": 0.5, "gauss_points_output_variables": names});
        let folder = TempDir::new().unwrap();
        scene.with(process("mpm_json_output_process", output)).write(folder.path());
        common::run_project(folder.path(), &[]);
        let shown = read(folder.path(), "points.json");
        let points: Vec<&Value> =
            shown.as_object().unwrap().iter().filter(|(k, _)| *k != "TIME").map(|(_, v)| v).collect();
        assert!(points.len() > 20);
        for point in points {
            for (name, expected, scale) in &expected {
                let last = point[*name].as_array().unwrap().last().unwrap();
                let found: Vec<f64> = match last.as_array() {
                    Some(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
                    None => vec![last.as_f64().unwrap()],
                };
                assert_eq!(found.len(), expected.len(), "{name}");
                for (a, b) in found.iter().zip(expected) {
                    // Differences of W lose half of the digits of the stresses.
                    let limit = if *scale > 1.0 { 1e-8 * scale } else { 1e-12 };
                    assert!((a - b).abs() < limit, "{cell:?} {name}: {found:?}, expected {expected:?}");
                }
            }
        }
    }
}

/// The strain energy is V₀ W(F); Kratos's ½ V σ:ε with the Almansi strain is far from it.
#[test]
fn large_strain_energy_is_that_of_the_law() {
    let (f, _) = deformation([1.3, 0.85, 1.0]);
    let scene = stretched(Cell::Quadrilateral, &f, "HyperElasticNeoHookeanPlaneStrain2DLaw");
    let energy = |record: &Record| record.last().energy("strain");
    assert!((energy(&scene.run(&[])) / neo_hookean(&f) - 1.0).abs() < 1e-12);
    let sigma = first_piola_kirchhoff(&f) * f.transpose() / f.determinant();
    let inverse = (f * f.transpose()).try_inverse().unwrap();
    let kratos = 0.25 * f.determinant() * sigma.dot(&(Matrix3::identity() - inverse));
    assert!((kratos / neo_hookean(&f) - 1.0).abs() > 0.02);
    // Supports that depend on place only are imposed in Kratos, too.
    assert!((energy(&scene.run(&["--kratos-exact"])) / kratos - 1.0).abs() < 1e-8);
}

/// Four cells a side on the unit square, filled with points whose velocity is linear in place.
fn flowing() -> Scene {
    let mesh = Mesh::block(Cell::Quadrilateral, [4, 4, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
                        "scheme_type": "forward_euler", "stress_update": "usf", "time_stepping": {"time_step": 1e-9}});
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1.0, 1.0, 0.0);
    let velocity = json!({"model_part_name": "MPM_Material", "value": ["1.0+2.0*x-y", "3.0*y", 0.0]});
    let grid = Mesh::block(Cell::Quadrilateral, [6, 6, 0], [0.0; 3], [1.5, 1.5, 0.0]);
    Scene::new(grid, mesh, law, solver, 1e-9).with(process("assign_initial_field_to_material_point_process", velocity))
}

fn extrapolation(variables: Value) -> Value {
    process("extrapolate_material_point_results_to_grid_process", json!({"variables": variables}))
}

fn histories() -> Value {
    let output = json!({"model_part_name": "Background_Grid", "output_file_name": "nodes.json", "time_frequency": 0.0,
                        "output_variables": ["MP_VELOCITY", "MP_DENSITY", "MP_DEFORMATION_GRADIENT"]});
    process("json_output_process", output)
}

/// Node by node: a linear field is kept inside, where functions and points are symmetric; at the
/// body's edge it is that of ∫ N x / ∫ N = h/3 from the edge; nodes away from the body have zeros.
#[test]
fn extrapolation_keeps_linear_fields() {
    let variables = json!(["MP_VELOCITY", "MP_DENSITY", "MP_DEFORMATION_GRADIENT", "MP_CAUCHY_STRESS_VECTOR"]);
    let scene = flowing().with(extrapolation(variables)).with(histories());
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    let path = folder.path().join("ProjectParameters.json");
    let mut project = read(folder.path(), "ProjectParameters.json");
    let vtk = json!({"model_part_name": "Background_Grid", "output_path": "grid", "file_format": "ascii",
                     "output_control_type": "step", "output_interval": 1,
                     "nodal_solution_step_data_variables": ["MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"]});
    project["output_processes"] = json!({"list": [process("vtk_output_process", vtk)]});
    std::fs::write(path, project.to_string()).unwrap();
    common::run_project(folder.path(), &[]);
    let nodes = read(folder.path(), "nodes.json");
    // The mean place of the points around a node, seen from the node.
    let seen = |x: f64| match x {
        _ if x < 1e-9 => 0.25 / 3.0,
        _ if x > 1.0 - 1e-9 => -0.25 / 3.0,
        _ => 0.0,
    };
    for (i, [x, y, _]) in scene.grid.nodes.iter().enumerate() {
        let node = &nodes[format!("NODE_{}", i + 1)];
        let inside = *x < 1.0 + 1e-9 && *y < 1.0 + 1e-9;
        let (px, py) = (x + seen(*x), y + seen(*y));
        let expected = if inside { [1.0 + 2.0 * px - py, 3.0 * py, 0.0] } else { [0.0; 3] };
        for (axis, name) in ["MP_VELOCITY_X", "MP_VELOCITY_Y", "MP_VELOCITY_Z"].into_iter().enumerate() {
            let found = node[name][0].as_f64().unwrap();
            assert!((found - expected[axis]).abs() < 1e-7, "{x} {y} {name}: {found}, expected {expected:?}");
        }
        assert!((node["MP_DENSITY"][0].as_f64().unwrap() - f64::from(inside)).abs() < 1e-7);
        let gradient = node["MP_DEFORMATION_GRADIENT"][0].as_array().unwrap();
        assert!(gradient.len() == 9 && (gradient[8].as_f64().unwrap() - f64::from(inside)).abs() < 1e-12);
    }
    let files = std::fs::read_dir(folder.path().join("grid")).unwrap();
    let texts: Vec<String> = files.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    assert!(texts.iter().any(|t| t.contains("MP_VELOCITY 3 49") && t.contains("MP_CAUCHY_STRESS_VECTOR 3 49")));
}

/// A body that flies, turns and crosses cells, against hat functions at the recorded places, or at
/// the first ones of a total-Lagrangian run.
#[test]
fn extrapolation_follows_the_points() {
    let implicit = json!({"solver_type": "dynamic", "time_stepping": {"time_step": 0.02}});
    let explicit = flowing().solver;
    let mut total = explicit.clone();
    total["frame"] = json!("total_lagrangian");
    for (mut solver, step) in [(explicit, 0.005), (implicit, 0.02), (total, 0.005)] {
        let frame = if solver["frame"] == "total_lagrangian" { Record::first } else { Record::last };
        solver["time_stepping"]["time_step"] = json!(step);
        let mut scene = flowing();
        (scene.solver, scene.end_time) = (solver, 0.16);
        scene.grid = Mesh::block(Cell::Quadrilateral, [10, 10, 0], [-0.75, -0.75, 0.0], [1.75, 1.75, 0.0]);
        scene.bodies[0].material["Variables"]["YOUNG_MODULUS"] = json!(10.0);
        scene.processes[0]["Parameters"]["value"] = json!(["1.0-2.0*y", "2.0*x-0.5", 0.0]);
        let output = json!({"model_part_name": "Background_Grid", "output_file_name": "nodes.json",
                            "time_frequency": 0.5 * step, "output_variables": ["MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"]});
        let scene = scene
            .with(extrapolation(json!(["MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"])))
            .with(process("json_output_process", output));
        let folder = TempDir::new().unwrap();
        scene.write(folder.path());
        let record = common::run_project(folder.path(), &[]);
        let nodes = read(folder.path(), "nodes.json");
        let last = |node: &Value, name: &str| node[name].as_array().unwrap().last().unwrap().clone();
        let (places, masses) = (frame(&record).points("MP_COORD"), record.last().scalars("MP_MASS"));
        let (velocities, stresses) =
            (record.last().points("MP_VELOCITY"), record.last().points("MP_CAUCHY_STRESS_VECTOR"));
        assert!(stresses.iter().flatten().any(|s| s.abs() > 0.1));
        for (i, node) in scene.grid.nodes.iter().enumerate() {
            let hat = |x: &[f64]| (0..2).map(|a| (1.0 - (x[a] - node[a]).abs() / 0.25).max(0.0)).product::<f64>();
            let weights: Vec<f64> = places.iter().zip(&masses).map(|(x, m)| m * hat(x)).collect();
            let mass: f64 = weights.iter().sum();
            let mean = |rows: &[Vec<f64>], c: usize| {
                let sum: f64 = rows.iter().zip(&weights).map(|(row, w)| row[c] * w).sum();
                if mass > 0.0 { sum / mass } else { 0.0 }
            };
            let shown = &nodes[format!("NODE_{}", i + 1)];
            let velocity = last(shown, "MP_VELOCITY_X").as_f64().unwrap();
            assert!((velocity - mean(&velocities, 0)).abs() < 1e-9, "{node:?}: {velocity}");
            for c in 0..3 {
                let stress = last(shown, "MP_CAUCHY_STRESS_VECTOR")[c].as_f64().unwrap();
                assert!((stress - mean(&stresses, c)).abs() < 1e-9, "{node:?}: {stress}");
            }
        }
    }
}

/// What would be read before it is written, or written twice, is refused; so is what nobody writes.
#[test]
fn extrapolation_comes_before_its_readers() {
    let variables = json!(["MP_VELOCITY", "MP_DENSITY", "MP_DEFORMATION_GRADIENT"]);
    for (scene, said) in [
        (flowing().with(histories()).with(extrapolation(variables.clone())), "a process before this one reads"),
        (flowing().with(extrapolation(variables.clone())).with(extrapolation(variables)), "another process writes"),
        (flowing().with(histories()), "nobody in this scene provides \"MP_VELOCITY\""),
        (flowing().with(extrapolation(json!(["MP_VELOCITY_X"]))), "name the whole vector"),
    ] {
        let folder = TempDir::new().unwrap();
        scene.write(folder.path());
        let text = refused(folder.path());
        assert!(text.contains(said), "{text}");
    }
}
