//! Bodies: analytic measures, convergence, conformity, placement, parts.

use super::{bodies, body, check_mesh, close, measure, sum_of_normals};
use crate::geometry::Shape;
use crate::model::ModelPart;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// Area of the regular polygon of n corners in a circle.
fn polygon(n: usize, radius: f64) -> f64 {
    0.5 * n as f64 * radius * radius * (TAU / n as f64).sin()
}

fn centroid(part: &ModelPart) -> [f64; 3] {
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for cell in 0..part.elements.len() {
        let (shape, corners) = (part.elements.shapes[cell], part.corners(&part.elements, cell));
        let points = match shape {
            Shape::Triangle3 => 1,
            Shape::Hexahedron8 => 8,
            _ => 4,
        };
        for point in crate::geometry::rule(shape, points).unwrap() {
            let mut n = [0.0; 8];
            shape.functions(point.xi, &mut n);
            let weight = point.weight * shape.jacobian_determinant(&corners, point.xi);
            total += weight;
            for (n, corner) in n.iter().zip(&corners) {
                (0..3).for_each(|i| sum[i] += weight * n * corner[i]);
            }
        }
    }
    sum.map(|x| x / total)
}

#[test]
fn boxes_are_exact_lattices() {
    for (shape, cells) in [("quadrilateral", 15), ("triangle", 30)] {
        let part = body(json!({"primitive": {"type": "box", "min": [1, 1, 0], "max": [2, 4, 0]},
                               "divisions": [3, 5], "shape": shape}));
        assert_eq!(part.elements.len(), cells);
        close(measure(&part), 3.0, 1e-14);
        check_mesh(&part);
    }
    for (shape, cells) in [("hexahedron", 24), ("tetrahedron", 144)] {
        let part = body(json!({"primitive": {"type": "box", "min": [0, 0, 0], "max": [1, 1.5, 2]}, "cell_size": 0.51,
                               "shape": shape, "rotation": {"axis": [1, 2, 3], "angle": 40}}));
        assert_eq!(part.elements.len(), cells, "0.51 m rounds to 2, 3 and 4 cells");
        close(measure(&part), 3.0, 1e-13);
        check_mesh(&part);
    }
    let part = body(json!({"primitive": {"type": "box", "min": [0, 0, 0], "max": [2, 0, 0]}, "divisions": [8]}));
    assert_eq!((part.elements.len(), part.elements.name_of(0)), (8, "MPMUpdatedLagrangian1D2N"));
    close(measure(&part), 2.0, 1e-14);
}

/// Cells of fitted plane bodies tile the polygon on the circle, to round-off.
#[test]
fn discs_and_rings_have_the_area_of_their_polygons() {
    for shape in ["quadrilateral", "triangle"] {
        for around in [4, 8, 40] {
            for radial in [1, 5] {
                let part = body(json!({"primitive": {"type": "disc", "center": [1, 2, 0], "radius": 0.3},
                                       "divisions": [around, radial], "shape": shape}));
                let n = around / 4;
                let cells = (n * n + around * radial) * if shape == "triangle" { 2 } else { 1 };
                assert_eq!(part.elements.len(), cells);
                close(measure(&part), polygon(around, 0.3), 1e-13);
                check_mesh(&part);
                let [x, y, _] = centroid(&part);
                assert!((x - 1.0).abs() < 1e-14 && (y - 2.0).abs() < 1e-14);
            }
        }
        let part = body(json!({"primitive": {"type": "annulus", "inner_radius": 0.2, "outer_radius": 0.5},
                               "divisions": [7, 3], "shape": shape}));
        close(measure(&part), polygon(7, 0.5) - polygon(7, 0.2), 1e-13);
        check_mesh(&part);
    }
}

/// The exact relative defect of the polygon is (2π/n)²/6 at first order.
#[test]
fn the_area_of_a_disc_converges_with_the_square_of_the_cell_size() {
    let defect = |size: f64| {
        let part = body(json!({"primitive": {"type": "disc", "radius": 1.0}, "cell_size": size}));
        1.0 - measure(&part) / PI
    };
    let defects: Vec<f64> = [0.2, 0.1, 0.05, 0.025].map(defect).into();
    for pair in defects.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order} of {defects:?}");
    }
    close(defects[3], (TAU / 252.0).powi(2) / 6.0, 1e-3);
}

#[test]
fn round_solids_conform_and_converge() {
    let cases: [(Value, f64); 4] = [
        (json!({"type": "cylinder", "radius": 0.5, "height": 2.0, "axis": "x"}), PI * 0.5),
        (json!({"type": "tube", "inner_radius": 0.3, "outer_radius": 0.5, "height": 2.0, "axis": "y"}), PI * 0.32),
        (json!({"type": "sphere", "radius": 0.5, "center": [1, 2, 3]}), PI / 6.0),
        (json!({"type": "spherical_shell", "inner_radius": 0.3, "outer_radius": 0.5}), 4.0 / 3.0 * PI * 0.098),
    ];
    for (primitive, exact) in cases {
        for shape in ["hexahedron", "tetrahedron"] {
            let mut defects = Vec::new();
            for size in [0.2, 0.1, 0.05] {
                let part = body(json!({"primitive": primitive.clone(), "cell_size": size, "shape": shape}));
                check_mesh(&part);
                defects.push(1.0 - measure(&part) / exact);
            }
            let order = (defects[1] / defects[2]).log2();
            assert!(defects[2] > 0.0 && defects[2] < 0.01, "{primitive} of {shape}: {defects:?}");
            assert!((order - 2.0).abs() < 0.35, "{primitive} of {shape}: order {order} of {defects:?}");
        }
    }
}

#[test]
fn cylinders_are_extruded_discs_along_their_axis() {
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let part = body(json!({"primitive": {"type": "cylinder", "radius": 0.5, "height": 2, "axis": name,
                               "center": [1, 1, 1]}, "divisions": [16, 2, 3]}));
        assert_eq!(part.elements.len(), (16 + 32) * 3);
        close(measure(&part), 2.0 * polygon(16, 0.5), 1e-13);
        let along: Vec<f64> = part.nodes.coordinates.iter().map(|x| x[axis]).collect();
        assert!(along.iter().all(|x| (0.0..=2.0).contains(x)) && along.contains(&2.0));
        centroid(&part).iter().for_each(|x| close(*x, 1.0, 1e-14));
    }
}

/// The smallest sine of a corner's angle tells of cells that are nearly folded.
#[test]
fn cells_of_discs_have_no_flat_corners() {
    for size in [0.4, 0.1, 0.03] {
        let part = body(json!({"primitive": {"type": "disc", "radius": 1.0}, "cell_size": size}));
        let mut least = 1.0f64;
        for cell in 0..part.elements.len() {
            let x = part.corners(&part.elements, cell);
            for i in 0..4 {
                let [a, b] = [(i + 1) % 4, (i + 3) % 4].map(|j| [x[j][0] - x[i][0], x[j][1] - x[i][1]]);
                let sine = (a[0] * b[1] - a[1] * b[0]) / (a[0].hypot(a[1]) * b[0].hypot(b[1]));
                least = least.min(sine);
            }
        }
        assert!(least > 0.5, "an angle of {:.0}°", 180.0 - least.asin().to_degrees());
    }
}

/// A staircase fills the disc with whole cells of a lattice through the origin.
#[test]
fn grid_fill_takes_cells_by_their_centres() {
    let primitive = json!({"type": "disc", "center": [0.05, 0.05, 0], "radius": 0.1501});
    let part = body(json!({"primitive": primitive, "fill": "grid", "cell_size": 0.1}));
    // Centres at distance 0, 0.1 and 0.1414 m of the disc's centre, which is itself one.
    assert_eq!((part.elements.len(), part.nodes.len()), (9, 16));
    close(measure(&part), 0.09, 1e-13);
    check_mesh(&part);
    for shape in ["triangle", "quadrilateral"] {
        let fine =
            body(json!({"primitive": {"type": "ring", "inner_radius": 0.4, "outer_radius": 1.0, "center": [3, 3, 0]},
                               "fill": "grid", "cell_size": 0.01, "shape": shape}));
        close(measure(&fine), PI * 0.84, 2e-3);
    }
    for shape in ["tetrahedron", "hexahedron"] {
        let ball = body(
            json!({"primitive": {"type": "sphere", "radius": 1.0}, "fill": "grid", "cell_size": 0.1, "shape": shape}),
        );
        close(measure(&ball), 4.0 / 3.0 * PI, 1e-2);
    }
}

/// The primitive turns, the cells stay on the lattice.
#[test]
fn grid_fill_of_turned_bodies() {
    let plain =
        json!({"primitive": {"type": "box", "min": [0, 0, 0], "max": [4, 2, 0]}, "fill": "grid", "cell_size": 1.0});
    assert_eq!(body(plain.clone()).elements.len(), 8);
    let mut turned = plain;
    turned["rotation"] = 90.into();
    let part = body(turned);
    assert_eq!(part.elements.len(), 8);
    let (low, high) = super::super::mesh::bounds(&part.nodes.coordinates);
    assert_eq!((low, high), ([1.0, -1.0, 0.0], [3.0, 3.0, 0.0]));
}

#[test]
fn polygons_are_filled_by_the_grid() {
    let vertices = json!([[0, 0], [0, 2], [1, 2], [1, 1], [3, 1], [3, 0]]); // clockwise L, area 4
    let part = body(json!({"primitive": {"type": "polygon", "vertices": vertices}, "fill": "grid", "cell_size": 0.25}));
    close(measure(&part), 4.0, 1e-13);
    check_mesh(&part);
}

#[test]
fn placement_turns_about_the_centre_and_then_moves() {
    let part = body(json!({"primitive": {"type": "box", "min": [1, 1, 0], "max": [3, 2, 0]}, "divisions": [2, 1],
                           "rotation": 90, "translation": [10, 20, 0]}));
    let x = part.nodes.coordinates[0];
    // (1, 1) is (−1, −0.5) from the centre (2, 1.5); turned (0.5, −1).
    assert!((x[0] - 12.5).abs() < 1e-14 && (x[1] - 20.5).abs() < 1e-14, "{x:?}");
    let part = body(json!({"primitive": {"type": "cylinder", "radius": 1, "height": 4}, "divisions": [16, 1, 2],
                           "rotation": {"axis": [0, 2, 0], "angle": 90}}));
    let (low, high) = super::super::mesh::bounds(&part.nodes.coordinates);
    assert!((high[0] - 2.0).abs() < 1e-14 && (low[2] + 1.0).abs() < 1e-14);
    check_mesh(&part);
}

#[test]
fn bodies_are_sub_model_parts_with_parts_of_their_own() {
    let part = bodies(json!([
        {"name": "A", "primitive": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 0]}, "divisions": [2, 2]},
        {"name": "B", "primitive": {"type": "disc", "radius": 1.0}, "divisions": [16, 2], "translation": [5, 0, 0],
         "parts": [{"name": "Skin", "side": "boundary", "conditions": "Line"}, {"name": "Tip", "side": "max_x"}]}
    ]));
    assert_eq!(part.paths(), ["A", "B", "B.Skin", "B.Tip"]);
    let (a, b) = (part.find("A").unwrap(), part.find("B").unwrap());
    assert_eq!((a.nodes.len(), a.elements.as_slice()), (9, &[0, 1, 2, 3][..]));
    assert_eq!(b.elements, (4..4 + 48).collect::<Vec<u32>>());
    assert!(b.elements.iter().all(|&e| part.elements.nodes_of(e as usize).iter().all(|n| b.nodes.contains(n))));
    let skin = part.find("B.Skin").unwrap();
    assert_eq!((skin.nodes.len(), skin.conditions.len()), (16, 16));
    assert_eq!(b.conditions, skin.conditions);
    for &node in &skin.nodes {
        let [x, y, _] = part.nodes.coordinates[node as usize];
        close((x - 5.0).hypot(y), 1.0, 1e-14);
    }
    let sum = sum_of_normals(&part, &part.conditions, &skin.conditions);
    assert!(sum.iter().all(|x| x.abs() < 1e-14));
    for &condition in &skin.conditions {
        let corners = part.corners(&part.conditions, condition as usize);
        let normal = super::area_vector(&corners);
        assert!(normal[0] * (corners[0][0] - 5.0) + normal[1] * corners[0][1] > 0.0, "outward");
    }
    let tip = part.find("B.Tip").unwrap();
    assert_eq!(tip.nodes.len(), 1);
}
