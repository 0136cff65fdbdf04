use super::*;

fn factorial(n: i32) -> f64 {
    (1..=n).map(f64::from).product()
}

/// ∫ ξ^i η^j ζ^k over the reference cell.
fn exact(shape: Shape, powers: [i32; 3]) -> f64 {
    let dimension = shape.dimension() as i32;
    match shape {
        Shape::Triangle3 | Shape::Tetrahedron4 => {
            powers.iter().map(|&p| factorial(p)).product::<f64>() / factorial(powers.iter().sum::<i32>() + dimension)
        }
        _ => {
            powers[..shape.dimension()].iter().map(|&p| if p % 2 == 1 { 0.0 } else { 2.0 / f64::from(p + 1) }).product()
        }
    }
}

/// Largest error of a rule over the monomials whose degree (total for simplices, in each
/// coordinate for the others) is exactly `degree`.
fn error_at(shape: Shape, count: usize, degree: i32) -> f64 {
    let points = rule(shape, count).expect("an allowed count");
    let top = |axis: usize| if axis < shape.dimension() { degree } else { 0 };
    let simplex = matches!(shape, Shape::Triangle3 | Shape::Tetrahedron4);
    let mut largest = 0f64;
    for i in 0..=top(0) {
        for j in 0..=top(1) {
            for k in 0..=top(2) {
                let reached = if simplex { i + j + k } else { i.max(j).max(k) };
                if reached == degree {
                    let term = |p: &QuadraturePoint| p.weight * p.xi[0].powi(i) * p.xi[1].powi(j) * p.xi[2].powi(k);
                    let sum: f64 = points.iter().map(term).sum();
                    largest = largest.max((sum - exact(shape, [i, j, k])).abs());
                }
            }
        }
    }
    largest
}

#[test]
fn every_rule_has_its_degree_and_no_more() {
    let degrees: [(Shape, &[i32]); 5] = [
        (Shape::Line2, &[1, 3, 5, 7, 9]),
        (Shape::Triangle3, &[1, 2, 4, 6]),
        (Shape::Quadrilateral4, &[1, 3, 5, 7, 9]),
        (Shape::Tetrahedron4, &[1, 2, 3, 5, 6]),
        (Shape::Hexahedron8, &[1, 3, 5, 7, 9]),
    ];
    for (shape, degrees) in degrees {
        for (&count, &degree) in allowed_counts(shape).iter().zip(degrees) {
            // The 8 digits of the tetrahedral rule with 4 points.
            let limit = if (shape, count) == (Shape::Tetrahedron4, 4) { 1e-9 } else { 4e-15 };
            for below in 0..=degree {
                let error = error_at(shape, count, below);
                assert!(error < limit, "{shape:?} {count}: degree {below}, error {error:e}");
            }
            assert!(error_at(shape, count, degree + 1) > 1e-7, "{shape:?} {count}");
        }
    }
}

#[test]
fn weights_sum_to_the_reference_measure_and_points_lie_inside() {
    for shape in Shape::ALL {
        for &count in allowed_counts(shape) {
            let points = rule(shape, count).expect("an allowed count");
            assert_eq!(points.len(), count);
            let sum: f64 = points.iter().map(|p| p.weight).sum();
            assert!((sum - shape.reference_measure()).abs() < 1e-15 * (1.0 + sum), "{shape:?} {count}: {sum}");
            assert!(points.iter().all(|p| p.weight > 0.0 && shape.contains(p.xi, 0.0)), "{shape:?} {count}");
        }
    }
}

#[test]
fn gauss_and_legendre_to_the_last_digit() {
    for n in 1..=5usize {
        // Legendre's recurrence, and Newton's method for the roots of P_n.
        let legendre = |x: f64| {
            let (mut p, mut before) = (x, 1.0);
            for k in 2..=n {
                let k = k as f64;
                (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
            }
            (p, n as f64 * (before - x * p) / (1.0 - x * x))
        };
        for (i, &(abscissa, weight)) in gauss_legendre(n).iter().enumerate() {
            let mut x = -((i as f64 + 0.75) / (n as f64 + 0.5) * std::f64::consts::PI).cos();
            for _ in 0..20 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let (_, slope) = legendre(x);
            assert!((x - abscissa).abs() <= 2.3e-16, "{n} {i}: {x} {abscissa}");
            assert!((weight - 2.0 / ((1.0 - x * x) * slope * slope)).abs() < 2e-15, "{n} {i}");
        }
    }
}

#[test]
fn points_stand_in_the_order_of_kratos() {
    let xi = |shape, count, i: usize| rule(shape, count).expect("an allowed count")[i].xi;
    let (s, t) = ((1.0 / 3f64).sqrt(), 0.6f64.sqrt());
    // Around the cell for 4 points, ξ fastest for 9, η fastest for 16 and 25.
    assert_eq!(xi(Shape::Quadrilateral4, 4, 2), [s, s, 0.0]);
    assert_eq!(xi(Shape::Quadrilateral4, 4, 3), [-s, s, 0.0]);
    assert_eq!(xi(Shape::Quadrilateral4, 9, 1), [0.0, -t, 0.0]);
    for count in [16, 25] {
        assert_eq!(xi(Shape::Quadrilateral4, count, 1)[0], xi(Shape::Quadrilateral4, count, 0)[0]);
    }
    assert_eq!(xi(Shape::Hexahedron8, 8, 3), [-s, s, -s]);
    assert_eq!(xi(Shape::Hexahedron8, 8, 4), [-s, -s, s]);
    assert_eq!(xi(Shape::Hexahedron8, 27, 1), [0.0, -t, -t]);
    assert_eq!(xi(Shape::Hexahedron8, 27, 3), [-t, 0.0, -t]);
    assert_eq!(xi(Shape::Line2, 3, 0), [-t, 0.0, 0.0]);
    assert_eq!(xi(Shape::Tetrahedron4, 4, 1), [0.1381966, 0.5854102, 0.1381966]);
    assert_eq!(xi(Shape::Triangle3, 6, 1)[1], 0.091576213509771);
}

#[test]
fn other_counts_are_refused_with_the_list_of_allowed_ones() {
    let error = rule(Shape::Triangle3, 4).expect_err("no such rule").to_string();
    assert_eq!(error, "no integration rule with 4 points for a Triangle3: choose 1, 3, 6 or 12");
    let error = rule(Shape::Point1, 0).expect_err("no such rule").to_string();
    assert_eq!(error, "no integration rule with 0 points for a Point1: choose 1");
}

/// Equal weights that sum to the measure, points inside, and linear functions exact, quadratic ones
/// not: the error of ξ² over n equal parts of [−1, 1] is the relative 1/n².
#[test]
fn even_parts_share_the_cell_and_are_exact_for_linear_functions_only() {
    for (shape, power) in
        [(Shape::Line2, 1), (Shape::Triangle3, 2), (Shape::Quadrilateral4, 2), (Shape::Hexahedron8, 3)]
    {
        for n in 1..=7usize {
            let points = even_rule(shape, n.pow(power)).expect("a whole power");
            assert_eq!(points.len(), n.pow(power));
            assert!(points.iter().all(|p| p.weight == points[0].weight && shape.contains(p.xi, 0.0)));
            let moment = |powers: [i32; 3]| {
                let term = |p: &QuadraturePoint| p.weight * (0..3).map(|a| p.xi[a].powi(powers[a])).product::<f64>();
                points.iter().map(term).sum::<f64>()
            };
            for axis in 0..shape.dimension() {
                for degree in 0..=1 {
                    let mut powers = [0; 3];
                    powers[axis] = degree;
                    let error = moment(powers) - exact(shape, powers);
                    assert!(error.abs() < 1e-13, "{shape:?} {n} {powers:?}: {error:e}");
                }
                let mut square = [0; 3];
                square[axis] = 2;
                let relative = 1.0 - moment(square) / exact(shape, square);
                let order = relative * (n * n) as f64;
                let expected = if shape == Shape::Triangle3 { 1.0 / 3.0 } else { 1.0 };
                assert!((order - expected).abs() < 1e-11, "{shape:?} {n}: {order}");
            }
        }
    }
}

#[test]
fn even_parts_run_along_the_first_coordinate_first() {
    let xi = |shape, count, i: usize| even_rule(shape, count).expect("a whole power")[i].xi;
    assert_eq!(xi(Shape::Line2, 4, 0), [-0.75, 0.0, 0.0]);
    assert_eq!(xi(Shape::Quadrilateral4, 4, 1), [0.5, -0.5, 0.0]);
    assert_eq!(xi(Shape::Hexahedron8, 8, 4), [-0.5, -0.5, 0.5]);
    assert_eq!(even_rule(Shape::Triangle3, 1).unwrap(), rule(Shape::Triangle3, 1).unwrap());
}

#[test]
fn counts_without_equal_parts_are_refused() {
    for (shape, count) in [
        (Shape::Line2, 0),
        (Shape::Triangle3, 3),
        (Shape::Quadrilateral4, 2),
        (Shape::Quadrilateral4, 0),
        (Shape::Hexahedron8, 4),
        (Shape::Hexahedron8, usize::MAX),
        (Shape::Tetrahedron4, 8),
        (Shape::Point1, 2),
    ] {
        assert_eq!(even_rule(shape, count), Err(UnevenCount { shape, count }));
    }
    let error = even_rule(Shape::Hexahedron8, 4).expect_err("no such parts").to_string();
    assert_eq!(error, "a Hexahedron8 has no 4 equal parts: choose a cubic number: 1, 8, 27, 64, 125, and so on");
}
