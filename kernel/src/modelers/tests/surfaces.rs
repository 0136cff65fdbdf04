//! Bodies of STL files: volumes, inside and outside, faults of surfaces.

use super::super::surface::Surface;
use super::{bodies, build, check_mesh, close, measure};
use crate::io::stl::Triangle;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::PathBuf;

/// Two triangles of a face whose corners run counter-clockwise from outside.
fn face([a, b, c, d]: [[f64; 3]; 4]) -> [Triangle; 2] {
    [[a, b, c], [a, c, d]]
}

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<Triangle> {
    let x = |bits: usize| std::array::from_fn(|axis| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.into_iter().flat_map(|corners: [usize; 4]| face(corners.map(x))).collect()
}

/// A sphere of meridians and parallels about a centre; its corners lie on the sphere.
fn sphere(center: [f64; 3], radius: f64, parallels: usize) -> Vec<Triangle> {
    let meridians = 2 * parallels;
    let at = |i: usize, j: usize| -> [f64; 3] {
        let (theta, phi) = (PI * i as f64 / parallels as f64, TAU * (j % meridians) as f64 / meridians as f64);
        let ring = if i == 0 || i == parallels { 0.0 } else { theta.sin() };
        let direction = [ring * phi.cos(), ring * phi.sin(), theta.cos()];
        std::array::from_fn(|a| center[a] + radius * direction[a])
    };
    let mut triangles = Vec::new();
    for i in 0..parallels {
        for j in 0..meridians {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            if i + 1 < parallels {
                triangles.push([a, b, c]);
            }
            if i > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

fn turned(triangles: Vec<Triangle>) -> Vec<Triangle> {
    triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

/// A file with the triangles, in a folder that lives as long as the first value.
fn file(triangles: &[Triangle]) -> (tempfile::TempDir, PathBuf) {
    let mut text = String::from("solid test\n");
    for triangle in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in triangle {
            writeln!(text, "vertex {x:?} {y:?} {z:?}").unwrap();
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid\n");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("body.stl");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

#[test]
fn volumes_are_those_of_polyhedra() {
    let cube = Surface::new(cuboid([1.0, 2.0, 3.0], [2.0, 4.0, 6.0])).unwrap();
    close(cube.volume(), 6.0, 1e-14);
    // Inward normals enclose the same, a cavity is taken off.
    close(Surface::new(turned(cuboid([0.0; 3], [1.0; 3]))).unwrap().volume(), 1.0, 1e-14);
    let mut hollow = cuboid([0.0; 3], [3.0; 3]);
    hollow.extend(turned(cuboid([1.0; 3], [2.0; 3])));
    let hollow = Surface::new(hollow).unwrap();
    close(hollow.volume(), 26.0, 1e-14);
    assert!(hollow.contains([0.5; 3]) && !hollow.contains([1.5; 3]) && !hollow.contains([3.5, 1.0, 1.0]));
    // 4/3 π r³ with an error of second order in the angles.
    let error = |n| Surface::new(sphere([0.5; 3], 0.25, n)).unwrap().volume() / (4.0 / 3.0 * PI / 64.0) - 1.0;
    assert!(error(32) < 0.0 && (error(16) / error(32) - 4.0).abs() < 0.05, "{} {}", error(16), error(32));
}

/// Places on a lattice whose rays run exactly through edges, corners and poles.
#[test]
fn points_of_a_lattice_are_inside_or_outside() {
    let surface = Surface::new(sphere([0.0; 3], 1.0, 40)).unwrap();
    let inner = (PI / 80.0).cos().powi(2);
    for i in 0..=40 {
        for j in 0..=40 {
            for k in 0..=40 {
                let x = [i, j, k].map(|i| f64::from(i - 20) / 16.0);
                let radius = x.iter().map(|x| x * x).sum::<f64>().sqrt();
                if radius < inner - 1e-9 || radius > 1.0 + 1e-9 {
                    assert_eq!(surface.contains(x), radius < 1.0, "{x:?}");
                }
            }
        }
    }
    // Each cell of a lattice that tiles a box has its centre inside, whatever lies on the faces.
    let cube = Surface::new(cuboid([0.0; 3], [1.0; 3])).unwrap();
    let centers = (0..512).map(|i| [i % 8, i / 8 % 8, i / 64].map(|i| (f64::from(i) + 0.5) / 8.0));
    assert!(centers.clone().all(|x| cube.contains(x)));
    let count = |shift: f64| centers.clone().filter(|x| cube.contains(x.map(|x| x + shift))).count();
    // Half of the cells that the shift by half a cell puts on faces are inside: 7³ stay, none is lost or doubled.
    assert_eq!(count(0.0), 512);
    assert!((343..=512).contains(&count(1.0 / 16.0)));
}

fn stl_body(path: &std::path::Path, more: Value) -> Value {
    let mut body =
        json!({"name": "Body", "primitive": {"type": "stl", "file": path}, "fill": "grid", "cell_size": 0.1});
    body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    body
}

/// The cells of the lattice fill a box exactly and a sphere the better the smaller they are.
#[test]
fn bodies_fill_their_surface() {
    let (_folder, path) = file(&cuboid([0.0; 3], [1.0, 0.5, 0.3]));
    let part = bodies(json!([stl_body(&path, json!({}))]));
    assert_eq!(part.elements.len(), 150);
    close(measure(&part), 0.15, 1e-13);
    check_mesh(&part);
    let (_folder, path) = file(&sphere([0.0; 3], 1000.0, 30));
    let polyhedron = Surface::new(sphere([0.0; 3], 1.0, 30)).unwrap().volume();
    let scaled = json!({"type": "stl", "file": path, "scale": 0.001});
    let error = |size: f64| {
        let more = json!({"primitive": scaled, "cell_size": size, "translation": [0.013, 0.4, -0.2], "shape": "hexahedron",
                          "rotation": {"axis": [1, 2, 3], "angle": 33}});
        measure(&bodies(json!([stl_body(&path, more)]))) / polyhedron - 1.0
    };
    assert!(error(0.1).abs() < 0.01 && error(0.04).abs() < 0.002, "{} {}", error(0.1), error(0.04));
}

#[test]
fn surfaces_that_are_no_bodies_are_errors() {
    let fault = |triangles: Vec<Triangle>| Surface::new(triangles).unwrap_err().0;
    let cube = cuboid([0.0; 3], [1.0; 3]);
    assert!(fault(cube[1..].to_vec()).contains("open: 3 edges"));
    let mut turned_one = cube.clone();
    turned_one[0] = turned(vec![turned_one[0]])[0];
    assert!(fault(turned_one).contains("turned the same way"));
    let mut flat = cube.clone();
    flat.push([[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert!(fault(flat).contains("1 of 13 triangles have no area, the first is number 13"));
    let mut sheet = face([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).to_vec();
    sheet.extend(turned(sheet.clone()));
    assert!(fault(sheet).contains("volume"));
    assert!(fault(Vec::new()).contains("no triangle"));
}

#[test]
fn projects_with_surfaces_are_checked() {
    let fault = |list: Value| {
        let modeler = json!([{"name": "BodyModeler", "parameters": {"bodies": list}}]);
        build(modeler).err().unwrap().to_string()
    };
    let (_folder, path) = file(&cuboid([0.0; 3], [1.0; 3]));
    assert!(fault(json!([stl_body(&path, json!({"fill": "fitted"}))])).contains("a stl cannot be filled with fitted"));
    assert!(fault(json!([stl_body(&path, json!({"shape": "triangle"}))])).contains("has 2 dimensions"));
    let plane = json!({"name": "Plane", "primitive": {"type": "disc", "radius": 1}, "cell_size": 0.1});
    assert!(fault(json!([plane, stl_body(&path, json!({}))])).contains("has 3 dimensions, but the first body has 2"));
    assert!(fault(json!([stl_body(&path.join("no"), json!({}))])).contains("cannot be read"));
    let (_folder, open) = file(&cuboid([0.0; 3], [1.0; 3])[1..]);
    assert!(fault(json!([stl_body(&open, json!({}))])).contains("body.stl: the surface is open"));
}
