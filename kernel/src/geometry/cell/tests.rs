use super::super::testing::{Random, position};
use super::*;

#[test]
fn functions_are_one_at_their_node_and_sum_to_one() {
    let mut random = Random(1);
    for shape in Shape::ALL {
        for (a, &corner) in shape.reference_corners().iter().enumerate() {
            let mut n = [0.0; 8];
            shape.functions(corner, &mut n);
            for b in 0..shape.node_count() {
                assert_eq!(n[b], f64::from(a == b), "{shape:?} {a} {b}");
            }
        }
        for _ in 0..50 {
            let xi = random.inside(shape);
            let (mut n, mut dn) = ([0.0; 8], [[0.0; 3]; 8]);
            shape.functions(xi, &mut n);
            shape.gradients(xi, &mut dn);
            assert!((n.iter().sum::<f64>() - 1.0).abs() < 4e-16, "{shape:?}");
            for j in 0..3 {
                assert!(dn.iter().map(|g| g[j]).sum::<f64>().abs() < 4e-16, "{shape:?}");
            }
        }
    }
}

#[test]
fn gradients_are_the_differences_of_the_functions() {
    let (mut random, h) = (Random(2), 0.25);
    for shape in Shape::ALL {
        for _ in 0..20 {
            let xi = random.inside(shape);
            let mut dn = [[0.0; 3]; 8];
            shape.gradients(xi, &mut dn);
            for j in 0..shape.dimension() {
                let (mut above, mut below) = ([0.0; 8], [0.0; 8]);
                let mut moved = xi;
                moved[j] = xi[j] + h;
                shape.functions(moved, &mut above);
                moved[j] = xi[j] - h;
                shape.functions(moved, &mut below);
                for a in 0..shape.node_count() {
                    // Exact for any step: each function is linear in each local coordinate.
                    let difference = (above[a] - below[a]) / (2.0 * h);
                    assert!((difference - dn[a][j]).abs() < 1e-14, "{shape:?} {a} {j}");
                }
            }
        }
    }
}

fn reproduces_linear_fields<S: CellShape<D, N>, const D: usize, const N: usize>() {
    let mut random = Random(3);
    for _ in 0..50 {
        let corners = random.distorted(S::SHAPE, 0.2);
        let flat: [[f64; D]; N] = from_fn(|a| from_fn(|i| corners[a][i]));
        let xi = random.inside(S::SHAPE);
        let slope: [f64; D] = from_fn(|_| random.within(-1.0, 1.0));
        let field = |x: &[f64]| 0.7 + (0..D).map(|i| slope[i] * x[i]).sum::<f64>();
        let local: [f64; D] = from_fn(|i| xi[i]);
        let n = S::functions(&local);
        let (gradients, determinant) = physical_gradients::<S, D, N>(&flat, &local);
        let value: f64 = (0..N).map(|a| n[a] * field(&flat[a])).sum();
        assert!((value - field(&position(S::SHAPE, &corners, xi))).abs() < 1e-14);
        for i in 0..D {
            let derivative: f64 = (0..N).map(|a| gradients[a][i] * field(&flat[a])).sum();
            assert!((derivative - slope[i]).abs() < 1e-13, "{:?}", S::SHAPE);
        }
        let expected = S::SHAPE.jacobian_determinant(&corners, xi);
        assert!((determinant - expected).abs() < 1e-14 && determinant > 0.0, "{:?}", S::SHAPE);
    }
}

#[test]
fn linear_fields_and_their_gradients_are_reproduced_in_distorted_cells() {
    reproduces_linear_fields::<Line2, 1, 2>();
    reproduces_linear_fields::<Triangle3, 2, 3>();
    reproduces_linear_fields::<Quadrilateral4, 2, 4>();
    reproduces_linear_fields::<Tetrahedron4, 3, 4>();
    reproduces_linear_fields::<Hexahedron8, 3, 8>();
}

#[test]
fn measures_of_known_cells() {
    let scaled = |shape: Shape| -> Vec<[f64; 3]> {
        shape.reference_corners().iter().map(|x| [3.0 * x[0] + 1.0, 0.5 * x[1], 2.0 * x[2]]).collect()
    };
    for (shape, measure) in [
        (Shape::Point1, 1.0),
        (Shape::Line2, 6.0),
        (Shape::Triangle3, 0.75),
        (Shape::Quadrilateral4, 6.0),
        (Shape::Tetrahedron4, 0.5),
        (Shape::Hexahedron8, 24.0),
    ] {
        assert!((shape.measure(&scaled(shape)) - measure).abs() < 1e-14, "{shape:?}");
    }
    // A trapezium, and its mirror image, which only the plane area tells apart.
    let mut corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
    let quadrilateral = Shape::Quadrilateral4;
    assert!((quadrilateral.measure(&corners) - 6.0).abs() < 1e-14);
    assert_eq!(quadrilateral.plane_area(&corners), 6.0);
    corners.swap(1, 3);
    assert!((quadrilateral.measure(&corners) - 6.0).abs() < 1e-14);
    assert_eq!(quadrilateral.plane_area(&corners), -6.0);
    // A square pyramid's frustum as a hexahedron: V = h/3 (A + B + √(AB)); inside out: −V.
    let ring = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    let frustum = [ring(2.0, 0.0), ring(1.0, 3.0)].concat();
    assert!((Shape::Hexahedron8.measure(&frustum) - 28.0).abs() < 1e-13);
    let inverted = [ring(1.0, 3.0), ring(2.0, 0.0)].concat();
    assert!((Shape::Hexahedron8.measure(&inverted) + 28.0).abs() < 1e-13);
    // A triangle in space: half the norm of (1,0,1) × (0,1,1).
    let tilted = [[0.0; 3], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    assert!((Shape::Triangle3.measure(&tilted) - 0.5 * 3f64.sqrt()).abs() < 1e-15);
}

#[test]
fn containment_follows_the_tolerance() {
    let t = 1e-5;
    for (shape, xi) in [
        (Shape::Line2, [1.0, 9.0, 9.0]),
        (Shape::Triangle3, [0.5, 0.5, 9.0]),
        (Shape::Quadrilateral4, [-1.0, 0.3, 9.0]),
        (Shape::Tetrahedron4, [0.2, 0.0, 0.8]),
        (Shape::Hexahedron8, [0.0, 0.0, -1.0]),
    ] {
        assert!(shape.contains(xi, 0.0), "{shape:?}");
        let outwards = |amount: f64| {
            let center = shape.center();
            let mut moved = xi;
            (0..shape.dimension()).for_each(|i| moved[i] += amount * (xi[i] - center[i]));
            moved
        };
        assert!(!shape.contains(outwards(0.5 * t), 0.0), "{shape:?}");
        assert!(shape.contains(outwards(0.5 * t), t), "{shape:?}");
        assert!(!shape.contains(outwards(6.0 * t), t), "{shape:?}");
        assert!(!shape.contains([f64::NAN; 3], t), "{shape:?}");
    }
}

/// det J of a trilinear cell is quadratic in each coordinate, so five Gauss points a direction give
/// the measure in any case; blocks take a shorter way to it.
#[test]
fn measures_of_blocks_and_warped_cells_agree_with_integration() {
    for shape in [Shape::Quadrilateral4, Shape::Hexahedron8] {
        for warp in [0.0, 1e-14, 1e-3, 0.3] {
            let place = |x: &[f64; 3]| {
                let lift = if shape == Shape::Hexahedron8 { x[2] } else { 0.0 };
                [5.0 + x[0] + 0.3 * x[1], x[1] - 0.2 * lift + warp * x[0] * x[1], lift + 0.1 * x[0]]
            };
            let corners: Vec<[f64; 3]> = shape.reference_corners().iter().map(place).collect();
            let points = crate::geometry::rule(shape, 5usize.pow(shape.dimension() as u32)).unwrap();
            let sum: f64 = points.iter().map(|p| p.weight * shape.jacobian_determinant(&corners, p.xi)).sum();
            let difference = shape.measure(&corners) / sum - 1.0;
            // A quadrilateral that leaves its plane has a root in its measure.
            let limit = if shape == Shape::Quadrilateral4 { 1e-3 * warp } else { 0.0 } + 1e-14;
            assert!(difference.abs() < limit, "{shape:?} {warp}: {difference:e}");
        }
    }
}
