//! The bending and the twisting column of 1 m × 1 m × 6 m (Moreno, Contri and Larese 2022), incompressible,
//! E = 17 MPa, ρ = 1100 kg/m³, against an explicit spectral-element solution in displacements: order 5 to 6,
//! ν = 0.499 and 0.4999, energy kept to 4e-5.

use super::common::{Cell, Mesh, Scene, State, Table, fix, material, process, run_project};
use serde_json::json;
use tempfile::TempDir;

const LAW: &str = "HyperElasticNeoHookeanUP3DLaw";

/// A column of so many cells a side in dynamics from these velocities.
fn column(cell: Cell, n: usize, velocity: [&str; 3], step: f64, end: f64) -> Scene {
    let members = json!({"pressure_dofs": true, "stabilization": "asgs", "grid_reset": "never",
        "stabilization_parameters": {"c1": 2.0}, "solver_type": "dynamic", "scheme_type": "bossak",
        "damp_factor_m": -0.1, "consistent_mass_matrix": true, "residual_relative_tolerance": 1e-6,
        "time_stepping": {"time_step": step}});
    let body = Mesh::block(cell, [n, n, 6 * n], [-0.5, -0.5, 0.0], [0.5, 0.5, 6.0]);
    let grid = Mesh::block(cell, [5 * n, 2 * n, 7 * n], [-2.5, -1.0, 0.0], [2.5, 1.0, 7.0]);
    let points = if cell == Cell::Tetrahedron { 14 } else { 8 };
    Scene::new(grid, body, material(LAW, points, 1100.0, 1.7e7, 0.5), members, end - 0.5 * step)
        .part("Base", |x| x[2] == 0.0)
        .with(fix("Base", json!([0.0, 0.0, 0.0])))
        .with(process(
            "assign_initial_field_to_material_point_process",
            json!({"model_part_name": "MPM_Material", "value": velocity}),
        ))
}

const BENDING: [&str; 3] = ["5/3*z", "0", "0"];
const TWISTING: [&str; 3] = ["105*sin(pi*z/12)*y", "-105*sin(pi*z/12)*x", "0"];

/// Runs a scene: where `place` is at the end, carried along by the nearest point p as x_p + F_p (X − X_p),
/// and the energy over that of the start.
fn carried(scene: Scene, place: [f64; 3]) -> ([f64; 3], f64) {
    let folder = TempDir::new().unwrap();
    let variables = json!({"positions": [place], "output_variables": ["MP_COORD", "MP_DEFORMATION_GRADIENT"]});
    scene.with(process("mpm_point_output_process", variables)).write(folder.path());
    let record = run_project(folder.path(), &["--record-states", "1"]);
    let rows = Table::read(&folder.path().join("material_points.csv")).rows;
    // Time, id, place, and the gradient row by row.
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let arm: [f64; 3] = std::array::from_fn(|a| place[a] - first[2 + a]);
    let at = std::array::from_fn(|a| last[2 + a] + (0..3).map(|b| last[5 + 3 * a + b] * arm[b]).sum::<f64>());
    let total = |state: State| state.energy("kinetic") + state.energy("strain");
    (at, total(record.last()) / total(record.first()))
}

/// u_x of (0.5, 0, 6) is 2.845 m at 0.5 s, near its greatest. Linear tetrahedra of this size are stiff.
#[test]
fn a_bending_column_of_coarse_cells() {
    for (cell, tolerance) in [(Cell::Hexahedron, 0.03), (Cell::Tetrahedron, 0.3)] {
        let (tip, energy) = carried(column(cell, 3, BENDING, 0.02, 0.5), [0.5, 0.0, 6.0]);
        let told = format!("{cell:?}: {} m, energy {energy}", tip[0] - 0.5);
        assert!((tip[0] - 0.5 - 2.845).abs() < tolerance * 2.845 && (energy - 1.0).abs() < 0.1, "{told}");
    }
}

/// The corner (0.5, 0.5, 6) has turned by −5.981 rad at 0.09 s, nearly furthest. An order near 2 in the size of
/// the cells, less what the step of 2 ms loses.
#[test]
fn a_twisting_column_converges() {
    let turned = [2, 4].map(|n| {
        let (corner, energy) = carried(column(Cell::Hexahedron, n, TWISTING, 0.002, 0.09), [0.5, 0.5, 6.0]);
        assert!((0.93..1.0).contains(&energy), "energy {energy}");
        corner[1].atan2(corner[0]) - std::f64::consts::FRAC_PI_4 - std::f64::consts::TAU
    });
    let [coarse, fine] = turned.map(|turned| (turned / -5.981 - 1.0).abs());
    assert!(fine < 0.04 && fine < 0.45 * coarse, "{turned:?} rad, off by {coarse} and {fine}");
}

/// Points that reach into cells by 1e-8 of their size: the nodes behind have pressures that next to nothing
/// resists, and the block flies on all the same.
#[test]
fn a_block_flies_although_it_hardly_touches_its_last_nodes() {
    // The second layer of Gauss points lies at x = 1 + 1e-8.
    let low = 1.0 + 1e-8 - (0.5 + 0.5 / 3f64.sqrt());
    let body = Mesh::block(Cell::Hexahedron, [1, 1, 1], [low, 0.0, 0.0], [low + 1.0, 1.0, 1.0]);
    let grid = Mesh::block(Cell::Hexahedron, [5, 3, 3], [-1.0, -1.0, -1.0], [4.0, 2.0, 2.0]);
    for stabilization in ["ppp", "asgs", "osgs"] {
        let solver = json!({"pressure_dofs": true, "stabilization": stabilization, "solver_type": "dynamic",
            "scheme_type": "newmark", "time_stepping": {"time_step": 1e-3}});
        let velocity = json!({"model_part_name": "MPM_Material", "value": ["1", "0.5", "0"]});
        let scene = Scene::new(grid.clone(), body.clone(), material(LAW, 8, 1000.0, 1e6, 0.5), solver, 1.5e-3)
            .with(process("assign_initial_field_to_material_point_process", velocity));
        let record = scene.run(&["--record-states", "1"]);
        for velocity in record.last().points("MP_VELOCITY") {
            let off = (0..3).map(|a| (velocity[a] - [1.0, 0.5, 0.0][a]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{stabilization}: {velocity:?}");
        }
    }
}
