//! Patch tests: under displacements of the boundary that are linear in the place, distorted cells of
//! every shape show the linear field and the stress of the law inside, and reactions that balance.

use super::body::{Body, fix, material};
use super::common::{Cell, Mesh, largest_difference};
use serde_json::{Value, json};

const YOUNG: f64 = 2e5;
const POISSON: f64 = 0.3;
/// Displacement gradient, as large as a law must bear.
const GRADIENT: [[f64; 3]; 3] = [[0.2, 0.1, -0.05], [-0.15, -0.1, 0.08], [0.06, -0.04, 0.12]];

fn linear(x: &[f64; 3], dimension: usize) -> Vec<f64> {
    (0..3).map(|a| if a < dimension { (0..dimension).map(|b| GRADIENT[a][b] * x[b]).sum() } else { 0.0 }).collect()
}

/// A block whose inner nodes are moved.
fn patch(cell: Cell) -> (Mesh, impl Fn([f64; 3]) -> bool) {
    let dimension = cell.dimension();
    let inside = move |x: [f64; 3]| (0..dimension).all(|a| x[a] > 1e-9 && x[a] < 3.0 - 1e-9);
    let mesh = Mesh::block(cell, [3; 3], [0.0; 3], [3.0; 3]).map(|x| {
        let shift =
            |a: usize| if a < dimension { 0.2 * (7.0 * x[0] + 3.0 * x[1] + 5.0 * x[2] + a as f64).sin() } else { 0.0 };
        if inside(x) { std::array::from_fn(|a| x[a] + shift(a)) } else { x }
    });
    (mesh, move |x| (0..dimension).any(|a| x[a] < 1e-9 || x[a] > 3.0 - 1e-9))
}

/// Neo-Hookean σ = (λ ln J I + μ (F Fᵀ − I))/J for an F of this dimension.
fn neo_hookean(dimension: usize) -> [[f64; 3]; 3] {
    let (lambda, mu) = (YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON), 0.5 * YOUNG / (1.0 + POISSON));
    let f: [[f64; 3]; 3] = std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let gradient = if a < dimension && b < dimension { GRADIENT[a][b] } else { 0.0 };
            gradient + if a == b { 1.0 } else { 0.0 }
        })
    });
    let j = f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) - f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0])
        + f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0]);
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let square: f64 = (0..3).map(|c| f[a][c] * f[b][c]).sum();
            let unit = if a == b { 1.0 } else { 0.0 };
            (lambda * j.ln() * unit + mu * (square - unit)) / j
        })
    })
}

fn expression(row: [f64; 3]) -> Value {
    json!(format!("{:?}*X + {:?}*Y + {:?}*Z", row[0], row[1], row[2]))
}

#[test]
fn linear_fields_are_exact_on_distorted_cells() {
    for cell in [Cell::Line, Cell::Triangle, Cell::Quadrilateral, Cell::Tetrahedron, Cell::Hexahedron] {
        let dimension = cell.dimension();
        let (mesh, boundary) = patch(cell);
        let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
        let imposed: Vec<Value> =
            (0..3).map(|a| if a < dimension { expression(GRADIENT[a]) } else { Value::Null }).collect();
        let body = Body::new(mesh, material(law, 1.0, YOUNG, POISSON), json!({}), 1.0)
            .part("Boundary", boundary)
            .with(fix("Boundary", json!(imposed)));
        let record = body.run(&[]);
        let expected: Vec<Vec<f64>> = body.mesh.nodes.iter().map(|x| linear(x, dimension)).collect();
        let error = largest_difference(&record.last().nodes("DISPLACEMENT"), &expected);
        assert!(error < 1e-12, "{cell:?}: displacement off by {error:e}");
        let s = neo_hookean(dimension);
        let stress = match dimension {
            1 => vec![s[0][0]],
            2 => vec![s[0][0], s[1][1], s[0][1]],
            _ => vec![s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[0][2]],
        };
        let shown = record.last().field("elements", "CAUCHY_STRESS_VECTOR");
        let error = largest_difference(&shown, &vec![stress; shown.len()]);
        assert!(error < 1e-12 * YOUNG, "{cell:?}: stress off by {error:e} Pa");
        let reactions = record.last().nodes("REACTION");
        for a in 0..3 {
            let sum: f64 = reactions.iter().map(|r| r[a]).sum();
            assert!(sum.abs() < 1e-12 * YOUNG, "{cell:?}: reactions leave {sum:e} N along {a}");
        }
    }
}

/// A strip pulled in plane stress is as thin as the law wants it and has the load of its thickness:
/// uniaxial stress of the same law in space.
#[test]
fn plane_stress_pulls_as_a_bar_in_space_does() {
    let pulled = |cell: Cell, law: &str, thickness: f64| {
        let mut stuff = material(law, 1.0, YOUNG, POISSON);
        stuff["Variables"]["THICKNESS"] = json!(thickness);
        let record = Body::new(Mesh::block(cell, [2, 1, 1], [0.0; 3], [2.0, 1.0, 0.5]), stuff, json!({}), 1.0)
            .part("Left", |x| x[0] == 0.0)
            .part("Floor", |x| x[1] == 0.0)
            .part("Back", |x| x[2] == 0.0)
            .part("Right", |x| x[0] == 2.0)
            .with(fix("Left", json!([0.0, null, null])))
            .with(fix("Floor", json!([null, 0.0, null])))
            .with(fix("Back", json!([null, null, 0.0])))
            .with(fix("Right", json!([0.8, null, null])))
            .run(&[]);
        let reactions = record.last().nodes("REACTION");
        reactions.iter().map(|r| r[0].max(0.0)).sum::<f64>()
    };
    let plane = pulled(Cell::Quadrilateral, "HyperElasticNeoHookeanPlaneStress2DLaw", 0.5);
    let space = pulled(Cell::Hexahedron, "HyperElasticNeoHookean3DLaw", 1.0);
    assert!((plane / space - 1.0).abs() < 1e-9, "{plane} N in plane stress, {space} N in space");
}

/// Thin cells pressed together by six times their thickness in each of two steps: alone the top row would be turned
/// inside out. All nodes move by the same share of their height.
#[test]
fn thin_cells_follow_a_support_that_moves_by_more_than_their_thickness() {
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 1.0, YOUNG, POISSON);
    let mesh = Mesh::block(Cell::Quadrilateral, [2, 20, 0], [0.0; 3], [0.2, 1.0, 0.0]);
    let body = Body::new(mesh, law, json!({}), 2.0)
        .part("Floor", |x| x[1] == 0.0)
        .part("Top", |x| x[1] == 1.0)
        .part("Sides", |[x, y, _]| y > 0.0 && y < 1.0 && (x == 0.0 || x == 0.2))
        .with(fix("Floor", json!([0.0, 0.0, null])))
        .with(fix("Top", json!([0.0, "-0.3*t", null])))
        .with(fix("Sides", json!([0.0, null, null])));
    let record = body.run(&[]);
    let expected: Vec<Vec<f64>> = body.mesh.nodes.iter().map(|x| vec![0.0, -0.6 * x[1], 0.0]).collect();
    let error = largest_difference(&record.last().nodes("DISPLACEMENT"), &expected);
    assert!(error < 1e-9, "displacement off by {error:e}");
}
