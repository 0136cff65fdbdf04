//! The limits against the theory and against the table of Renaud's thesis as recomputed independently.

use super::*;
use crate::stages::TimeIntegration::{self, Euler, MidPoint, StrongStability3};
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4, Shape, even_rule};

fn method(time_integration: TimeIntegration, transverse: bool) -> Method {
    Method { time_integration, riemann: RiemannSolver::Linearized, transverse }
}

/// Steel with a Poisson's ratio; in one dimension the modulus alone counts.
fn hooke(dimension: usize, poisson: f64) -> Hooke {
    let mu = 1e11 / (1.0 + poisson);
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    match dimension {
        1 => Hooke { lambda: lambda + 2.0 * mu, mu: 0.0, across: 0.0 },
        _ => Hooke { lambda, mu, across: lambda },
    }
}

fn line(positions: &[f64], time_integration: TimeIntegration) -> Limits {
    let weight = 2.0 / positions.len() as f64;
    let places: Vec<Place> = positions.iter().map(|x| Place { local: [2.0 * x - 1.0, 0.0, 0.0], weight }).collect();
    let (hooke, method) = (hooke(1, 0.3), method(time_integration, false));
    limits::<Line2, 1, 2>(&Lattice { edges: [0.3], places: &places, hooke, density: 7800.0, method }).unwrap()
}

fn natural(shape: Shape, count: usize) -> Vec<Place> {
    let points = even_rule(shape, count).unwrap();
    points.iter().map(|point| Place { local: point.xi, weight: point.weight }).collect()
}

fn square(points: usize, poisson: f64, method: Method) -> f64 {
    let places = natural(Shape::Quadrilateral4, points);
    let lattice = Lattice { edges: [0.5; 2], places: &places, hooke: hooke(2, poisson), density: 7800.0, method };
    limits::<Quadrilateral4, 2, 4>(&lattice).unwrap().spectral
}

fn cube(poisson: f64, method: Method) -> f64 {
    let places = natural(Shape::Hexahedron8, 1);
    let lattice = Lattice { edges: [2.0; 3], places: &places, hooke: hooke(3, poisson), density: 1.0, method };
    limits::<Hexahedron8, 3, 8>(&lattice).unwrap().spectral
}

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance + 1e-9, "{found} is not {expected}");
}

/// Sums of |D| of both directions, so that of two mirrored layouts the smaller figure counts.
#[test]
fn no_value_overshoots_up_to_the_limits_of_the_table() {
    for (positions, euler, mid_point) in [
        (&[0.5][..], 1.0, 1.0),
        (&[0.25, 0.75], 0.425, 0.75),
        (&[0.35, 0.85], 0.395, 0.545),
        (&[0.0, 0.5], 0.30, 0.36),
        (&[0.15, 0.85], 0.265, 0.36),
        (&[1.0 / 6.0, 0.5, 5.0 / 6.0], 0.29, 0.415),
        (&[0.0, 1.0 / 3.0, 2.0 / 3.0], 0.22, 0.26),
        (&[0.125, 0.375, 0.625, 0.875], 0.225, 0.29),
    ] {
        assert_near(line(positions, Euler).no_overshoot.unwrap(), euler, 0.005);
        assert_near(line(positions, MidPoint).no_overshoot.unwrap(), mid_point, 0.005);
    }
}

#[test]
fn no_wave_grows_up_to_the_limits_of_the_table() {
    for (positions, euler, mid_point, third_order) in [
        (&[0.5][..], 1.0, 1.0, 1.22),
        (&[0.25, 0.75], 0.685, 1.0, 1.25),
        (&[0.35, 0.85], 0.66, 0.98, 1.10),
        (&[1.0 / 6.0, 0.5, 5.0 / 6.0], 0.645, 1.0, 1.26),
        (&[0.0, 1.0 / 3.0, 2.0 / 3.0], 0.59, 0.875, 1.0),
        (&[0.125, 0.375, 0.625, 0.875], 0.63, 1.0, 1.26),
    ] {
        assert_near(line(positions, Euler).spectral, euler, 0.005);
        assert_near(line(positions, MidPoint).spectral, mid_point, 0.015);
        assert_near(line(positions, StrongStability3).spectral, third_order, 0.005);
    }
}

/// c₁ Δt/h ≤ 1/max(1 + (d − 1) c₂/c₁, 1 + (d − 1) λ/(λ + 2μ)) without transverse correction, 1 with it.
#[test]
fn elastic_waves_in_the_plane_and_in_space() {
    for poisson in [0.0, 0.3, 0.45] {
        let Hooke { lambda, mu, .. } = hooke(2, poisson);
        let ratio = (mu / (lambda + 2.0 * mu)).sqrt().max(lambda / (lambda + 2.0 * mu));
        for (dimension, found) in
            [(2.0, square(1, poisson, method(Euler, false))), (3.0, cube(poisson, method(Euler, false)))]
        {
            assert_near(found, 1.0 / (1.0 + (dimension - 1.0) * ratio), 0.005);
        }
        assert_near(square(1, poisson, method(Euler, true)), 1.0, 0.0);
        assert_near(square(1, poisson, method(MidPoint, false)), 1.0, 0.0);
        assert_near(cube(poisson, method(Euler, true)), 1.0, 0.0);
    }
    for (poisson, expected) in [(0.0, 0.63), (0.3, 0.76), (0.49, 0.52)] {
        assert_near(cube(poisson, method(MidPoint, false)), expected, 0.015);
    }
    assert_near(cube(0.3, method(StrongStability3, false)), 0.97, 0.01);
}

/// Waves along an axis see the layout of two points; the transverse correction and the schemes of higher
/// order were computed independently.
#[test]
fn four_points_in_a_square() {
    assert_near(square(4, 0.3, method(Euler, false)), 0.685, 0.015);
    assert_near(square(4, 0.3, method(Euler, true)), 0.67, 0.01);
    assert_near(square(4, 0.3, method(MidPoint, false)), 1.0, 0.0);
    assert_near(square(4, 0.3, method(StrongStability3, false)), 1.02, 0.01);
}
