use super::super::testing::{Random, position};
use super::*;

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

#[test]
fn round_trip_in_distorted_cells_anywhere() {
    let mut random = Random(11);
    for shape in Shape::ALL.into_iter().filter(|&shape| shape != Shape::Point1) {
        let amount = if shape.is_affine() { 0.2 } else { 0.4 };
        for _ in 0..2000 {
            // Small cells far from the origin lose digits in the coordinates, not in the map.
            let (size, offset) = (random.within(0.001, 2.0), random.within(-1.0, 1.0));
            let corners = random.distorted(shape, amount).into_iter().map(|x| {
                let mut x = x.map(|v| size * v);
                (0..shape.dimension()).for_each(|i| x[i] += offset);
                x
            });
            let corners: Vec<_> = corners.collect();
            let xi = random.inside(shape);
            let x = position(shape, &corners, xi);
            let found = local_coordinates(shape, &corners, x).expect("converges");
            let limit = 1e-14 * (1.0 + offset.abs() / size) * 10.0;
            assert!(distance(found, xi) < limit, "{shape:?} {xi:?} {found:?}");
        }
    }
}

#[test]
fn newton_converges_from_the_centre_in_every_convex_quadrilateral() {
    let (mut random, mut tested) = (Random(12), 0);
    while tested < 20_000 {
        let corners: [[f64; 2]; 4] = from_fn(|_| [random.within(-1.0, 1.0), random.within(-1.0, 1.0)]);
        let space = corners.map(|[x, y]| [x, y, 0.0]);
        let signed = |xi: &[f64; 3]| {
            let j = Shape::Quadrilateral4.jacobian(&space, *xi);
            j[0][0] * j[1][1] - j[0][1] * j[1][0]
        };
        if Shape::Quadrilateral4.reference_corners().iter().any(|xi| signed(xi) < 1e-3) {
            continue;
        }
        tested += 1;
        let xi = random.inside(Shape::Quadrilateral4);
        let [x, y, _] = position(Shape::Quadrilateral4, &space, xi);
        let found = inverse_map::<Quadrilateral4, 2, 4>(&corners, &[x, y]).expect("converges");
        assert!((found[0] - xi[0]).abs().max((found[1] - xi[1]).abs()) < 1e-11, "{corners:?} {xi:?} {found:?}");
    }
}

#[test]
fn points_off_a_surface_are_projected_along_its_normal() {
    let corners = [[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 4.0], [1.0, 0.0, 4.0]];
    let found = local_coordinates(Shape::Quadrilateral4, &corners, [7.0, 1.5, 1.0]).expect("inside");
    assert!(distance(found, [0.5, -0.5, 0.0]) < 1e-15);
    let found = local_coordinates(Shape::Triangle3, &corners[..3], [-3.0, 1.5, 1.0]).expect("inside");
    assert!(distance(position(Shape::Triangle3, &corners[..3], found), [1.0, 1.5, 1.0]) < 1e-15);
    let found = local_coordinates(Shape::Line2, &corners[..2], [0.0, 1.5, 9.0]).expect("inside");
    assert!(distance(found, [0.5, 0.0, 0.0]) < 1e-15);
}

#[test]
fn a_straight_corner_of_a_quadrilateral_can_be_mapped() {
    // Node 2 in the middle between nodes 1 and 3: det J = 0 there, where rounding halves the digits.
    let corners = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]];
    for (x, xi, limit) in [([1.0, 1.0], [1.0, 1.0], 1e-6), ([1.5, 0.5], [1.0, 0.0], 1e-14)] {
        let found = inverse_map::<Quadrilateral4, 2, 4>(&corners, &x).expect("converges");
        assert!((0..2).all(|i| (found[i] - xi[i]).abs() < limit), "{found:?}");
    }
}

#[test]
fn degenerate_cells_and_wrong_numbers_of_corners_have_no_local_coordinates() {
    for shape in Shape::ALL {
        assert_eq!(local_coordinates(shape, &vec![[1.0; 3]; shape.node_count()], [0.0; 3]), None, "{shape:?}");
        assert_eq!(local_coordinates(shape, &[[1.0; 3]; 9], [0.0; 3]), None, "{shape:?}");
        let corners = shape.reference_corners();
        assert_eq!(local_coordinates(shape, corners, [f64::NAN; 3]), None, "{shape:?}");
    }
}
