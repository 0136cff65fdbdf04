//! Patch test: an affine displacement imposed on the boundary of a distorted grid gives the affine
//! displacement inside, and everywhere the stress that the law gives for its gradient (Irons and
//! Razzaque 1972; Hughes, The Finite Element Method, §4.2). One static step, so that the points are
//! integration points of the body's cells.

use super::common::{Cell, Mesh, Scene, fix, largest_difference, material};
use serde_json::json;

type Tensor = [[f64; 3]; 3];

const YOUNG: f64 = 2.5e6;
const POISSON: f64 = 0.3;

fn lame() -> (f64, f64) {
    (YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON), YOUNG / 2.0 / (1.0 + POISSON))
}

fn tensor(entry: impl Fn(usize, usize) -> f64) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

fn product(a: &Tensor, b: &Tensor) -> Tensor {
    tensor(|i, j| (0..3).map(|k| a[i][k] * b[k][j]).sum())
}

fn transposed(a: &Tensor) -> Tensor {
    tensor(|i, j| a[j][i])
}

fn determinant(f: &Tensor) -> f64 {
    let minor = |i: usize, j: usize| f[1][i] * f[2][j] - f[1][j] * f[2][i];
    f[0][0] * minor(1, 2) - f[0][1] * minor(0, 2) + f[0][2] * minor(0, 1)
}

fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// σ = (λ ln J I + μ (F Fᵀ − I))/J (Bonet and Wood, §6.4.3).
fn neo_hookean(f: &Tensor) -> Tensor {
    let ((lambda, mu), j) = (lame(), determinant(f));
    let b = product(f, &transposed(f));
    tensor(|a, c| (lambda * j.ln() * delta(a, c) + mu * (b[a][c] - delta(a, c))) / j)
}

/// σ = F S Fᵀ/J, S = λ tr E I + 2 μ E, E = (Fᵀ F − I)/2 (Bonet and Wood, §6.3).
fn saint_venant_kirchhoff(f: &Tensor) -> Tensor {
    let (lambda, mu) = lame();
    let c = product(&transposed(f), f);
    let strain = tensor(|i, j| 0.5 * (c[i][j] - delta(i, j)));
    let trace: f64 = (0..3).map(|i| strain[i][i]).sum();
    let s = tensor(|i, j| lambda * trace * delta(i, j) + 2.0 * mu * strain[i][j]);
    let pushed = product(&product(f, &s), &transposed(f));
    tensor(|i, j| pushed[i][j] / determinant(f))
}

/// The same with S33 = 0, which makes λ* = 2λμ/(λ + 2μ), and F33 = 1 (Kratos's plane stress).
fn plane_stress(f: &Tensor) -> Tensor {
    let (lambda, mu) = lame();
    let lambda = 2.0 * lambda * mu / (lambda + 2.0 * mu);
    let c = product(&transposed(f), f);
    let strain = tensor(|i, j| 0.5 * (c[i][j] - delta(i, j)));
    let trace = strain[0][0] + strain[1][1];
    let s = tensor(|i, j| if i == 2 || j == 2 { 0.0 } else { lambda * trace * delta(i, j) + 2.0 * mu * strain[i][j] });
    let pushed = product(&product(f, &s), &transposed(f));
    tensor(|i, j| pushed[i][j] / determinant(f))
}

struct Patch {
    cell: Cell,
    points: usize,
    law: &'static str,
    stress: fn(&Tensor) -> Tensor,
    /// Displacement gradient.
    gradient: Tensor,
    axisymmetric: bool,
    low: f64,
}

/// Inner nodes are moved, boundary nodes stay.
fn distorted(patch: &Patch) -> Mesh {
    let (low, flat) = (patch.low, patch.cell.dimension() == 2);
    Mesh::block(patch.cell, [3, 4, 3], [low, 0.0, 0.0], [low + 1.0, 1.0, 1.0]).map(|[x, y, z]| {
        let hat = |s: f64| 4.0 * s * (1.0 - s);
        let inside = 0.05 * hat(x - low) * hat(y) * if flat { 1.0 } else { hat(z) };
        let z_moved = if flat { 0.0 } else { z + inside * (3.0 * x - 5.0 * y).cos() };
        [x + inside * (7.0 * y + 2.0 * z).sin(), y + inside * (5.0 * x + 3.0 * z + 1.0).cos(), z_moved]
    })
}

fn run(patch: &Patch) {
    let dimension = patch.cell.dimension();
    let mesh = distorted(patch);
    let far = patch.low + 1.0;
    let edge = |s: f64| s.abs() < 1e-12 || (s - 1.0).abs() < 1e-12;
    let boundary =
        |[x, y, z]: [f64; 3]| edge(x - patch.low) || edge(x - far + 1.0) || edge(y) || (dimension == 3 && edge(z));
    let row = |a: usize| {
        let [x, y, z] = patch.gradient[a];
        format!("{x:?}*x + {y:?}*y + {z:?}*z")
    };
    let solver = json!({"axis_symmetric_flag": patch.axisymmetric, "residual_relative_tolerance": 1e-14});
    let material = material(patch.law, patch.points, 1000.0, YOUNG, POISSON);
    let scene = Scene::new(mesh.clone(), mesh, material, solver, 1.0)
        .part("Boundary", boundary)
        .with(fix("Boundary", json!([row(0), row(1), row(2)])));
    let record = scene.run(&["--record-states", "1"]);
    let label = format!("{:?}, {} points, {}", patch.cell, patch.points, patch.law);

    let start = record.first().points("MP_COORD");
    let moved = |x: &Vec<f64>| (0..3).map(|a| (0..3).map(|b| patch.gradient[a][b] * x[b]).sum()).collect();
    let exact: Vec<Vec<f64>> = start.iter().map(moved).collect();
    let error = largest_difference(&record.last().points("MP_DISPLACEMENT"), &exact);
    assert!(error < 1e-13, "{label}: displacement is off by {error:e} m");

    let mut f = tensor(|i, j| delta(i, j) + patch.gradient[i][j]);
    let mut order = vec![(0, 0), (1, 1), (0, 1)];
    if patch.axisymmetric {
        f[2][2] = f[0][0];
        order = vec![(0, 0), (1, 1), (2, 2), (0, 1)];
    } else if dimension == 3 {
        order = vec![(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
    }
    let exact = (patch.stress)(&f);
    let exact: Vec<f64> = order.iter().map(|&(i, j)| exact[i][j]).collect();
    let size = exact.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
    let stress = record.last().points("MP_CAUCHY_STRESS_VECTOR");
    let error = largest_difference(&stress, &vec![exact; stress.len()]) / size;
    assert!(error < 1e-12, "{label}: stress is off by {error:e} of its size");
}

const PLANE: Tensor = [[0.04, 0.05, 0.0], [-0.03, -0.06, 0.0], [0.0; 3]];
const SPACE: Tensor = [[0.04, 0.05, -0.02], [-0.03, -0.06, 0.01], [0.02, -0.015, 0.05]];

#[test]
fn plane_strain() {
    for (law, stress) in [
        ("HyperElasticNeoHookeanPlaneStrain2DLaw", neo_hookean as fn(&Tensor) -> Tensor),
        ("LinearElasticIsotropicPlaneStrain2DLaw", saint_venant_kirchhoff),
    ] {
        for (cell, points) in [
            (Cell::Quadrilateral, 4),
            (Cell::Quadrilateral, 9),
            (Cell::Quadrilateral, 25),
            (Cell::Triangle, 1),
            (Cell::Triangle, 6),
            (Cell::Triangle, 12),
        ] {
            run(&Patch { cell, points, law, stress, gradient: PLANE, axisymmetric: false, low: 0.0 });
        }
    }
}

#[test]
fn plane_stress_of_the_linear_law() {
    let law = "LinearElasticIsotropicPlaneStress2DLaw";
    for (cell, points) in [(Cell::Quadrilateral, 16), (Cell::Triangle, 3)] {
        run(&Patch { cell, points, law, stress: plane_stress, gradient: PLANE, axisymmetric: false, low: 0.0 });
    }
}

/// u_r = a r, u_z = b z: the hoop stretch equals the radial one, all else would not be uniform.
#[test]
fn axisymmetric() {
    for (law, stress) in [
        ("HyperElasticNeoHookeanAxisym2DLaw", neo_hookean as fn(&Tensor) -> Tensor),
        ("LinearElasticIsotropicAxisym2DLaw", saint_venant_kirchhoff),
    ] {
        for low in [0.0, 0.7] {
            let gradient = [[0.04, 0.0, 0.0], [0.0, -0.06, 0.0], [0.0; 3]];
            run(&Patch { cell: Cell::Quadrilateral, points: 4, law, stress, gradient, axisymmetric: true, low });
            run(&Patch { cell: Cell::Triangle, points: 3, law, stress, gradient, axisymmetric: true, low });
        }
    }
}

#[test]
fn space() {
    for (law, stress) in [
        ("HyperElasticNeoHookean3DLaw", neo_hookean as fn(&Tensor) -> Tensor),
        ("LinearElasticIsotropic3DLaw", saint_venant_kirchhoff),
    ] {
        for (cell, points) in
            [(Cell::Hexahedron, 8), (Cell::Hexahedron, 27), (Cell::Tetrahedron, 1), (Cell::Tetrahedron, 8)]
        {
            run(&Patch { cell, points, law, stress, gradient: SPACE, axisymmetric: false, low: 0.0 });
        }
    }
}
