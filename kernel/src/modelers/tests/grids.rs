//! Grids: counts, measures, conformity, parts.

use super::{area_vector, body, check_mesh, close, grid, measure, sum_of_normals};
use serde_json::json;

#[test]
fn counts_measures_and_conformity_of_all_shapes() {
    for (options, nodes, cells, name) in [
        (json!({"divisions": [3, 4]}), 20, 12, "Element2D4N"),
        (json!({"cell_size": 0.5}), 35, 24, "Element2D4N"),
        (json!({"divisions": [3, 4], "shape": "triangle"}), 20, 24, "Element2D3N"),
        (json!({"divisions": [3, 4], "shape": "triangle", "diagonal": "fixed"}), 20, 24, "Element2D3N"),
    ] {
        let mut parameters = json!({"min": [-1.0, 2.0, 0.0], "max": [2.0, 4.0, 0.0]});
        parameters.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        let part = grid(parameters);
        assert_eq!((part.nodes.len(), part.elements.len()), (nodes, cells));
        assert_eq!(part.elements.name_of(0), name);
        close(measure(&part), 6.0, 1e-14);
        check_mesh(&part);
    }
    for (options, cells, name) in [
        (json!({}), 24, "Element3D8N"),
        (json!({"shape": "tetrahedron"}), 24 * 6, "Element3D4N"),
        (json!({"shape": "tetrahedron", "tetrahedra_per_cube": 5}), 24 * 5, "Element3D4N"),
        (json!({"shape": "tetrahedron", "tetrahedra_per_cube": 5, "grading": [3.0, 1.0, 0.2]}), 24 * 5, "Element3D4N"),
    ] {
        let mut parameters = json!({"min": [0.0, 0.0, 0.0], "max": [1.0, 2.0, 3.0], "divisions": [2, 3, 4]});
        parameters.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        let part = grid(parameters);
        assert_eq!((part.nodes.len(), part.elements.len()), (60, cells));
        assert_eq!(part.elements.name_of(0), name);
        close(measure(&part), 6.0, 1e-14);
        check_mesh(&part);
    }
}

#[test]
fn a_line_of_cells() {
    let part = grid(json!({"min": [1.0, 0.0, 0.0], "max": [3.0, 0.0, 0.0], "cell_size": 0.1,
                           "parts": [{"name": "Left", "side": "min_x", "conditions": "Point"}]}));
    assert_eq!((part.nodes.len(), part.elements.len(), part.elements.name_of(0)), (21, 20, "Element1D2N"));
    close(measure(&part), 2.0, 1e-14);
    assert_eq!((part.children[0].nodes.as_slice(), part.conditions.len()), (&[0][..], 1));
}

/// Diagonals of the union-jack pattern meet in every other node: 8 triangles or 4, never 6.
#[test]
fn alternating_diagonals_turn_in_every_other_square() {
    let neighbours = |diagonal: &str| {
        let part = grid(json!({"min": [0, 0, 0], "max": [4, 4, 0], "divisions": [4, 4], "shape": "triangle",
                               "diagonal": diagonal}));
        let (starts, _) = part.cells_of_nodes(&part.elements);
        let inner = [6, 7, 8, 11, 12, 13, 16, 17, 18];
        inner.map(|node| starts[node + 1] - starts[node])
    };
    assert_eq!(neighbours("fixed"), [6; 9]);
    assert_eq!(neighbours("alternating"), [8, 4, 8, 4, 8, 4, 8, 4, 8]);
}

#[test]
fn grading_gives_the_ratio_of_last_to_first_cell() {
    let part = grid(json!({"min": [0, 0, 0], "max": [1, 5, 0], "divisions": [6, 1], "grading": [4.0, 1.0, 1.0]}));
    let x: Vec<f64> = part.nodes.coordinates[..7].iter().map(|x| x[0]).collect();
    let edges: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    close(edges[5] / edges[0], 4.0, 1e-13);
    edges.windows(2).for_each(|pair| close(pair[1] / pair[0], 4f64.powf(0.2), 1e-13));
    assert_eq!((x[0], x[6]), (0.0, 1.0));
    check_mesh(&part);
}

#[test]
fn sides_and_boxes_hold_the_right_nodes() {
    let part = grid(json!({"min": [0.1, 0, 0], "max": [0.7, 0.3, 0], "cell_size": 0.1, "parts": [
        {"name": "Floor", "side": "min_y"},
        {"name": "Walls", "side": ["min_x", "max_x"]},
        {"name": "Clamp", "box": {"min": [0.3, 0.1, 0], "max": [0.5, 0.2, 0]}},
        {"name": "All", "side": "boundary"}]}));
    assert_eq!(part.find("Floor").unwrap().nodes, [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(part.find("Walls").unwrap().nodes, [0, 6, 7, 13, 14, 20, 21, 27]);
    assert_eq!(part.find("Clamp").unwrap().nodes, [9, 10, 11, 16, 17, 18]);
    assert_eq!(part.find("All").unwrap().nodes.len(), 18);
    assert!(part.conditions.is_empty());
}

/// A grid one cell wide: the floor's faces have all nodes on the walls, yet are no wall.
#[test]
fn conditions_are_the_faces_of_their_side_and_point_outward() {
    let part = grid(json!({"min": [0, 0, 0], "max": [1, 4, 0], "divisions": [1, 4], "parts": [
        {"name": "Walls", "side": ["min_x", "max_x"], "conditions": "Line"},
        {"name": "Top", "side": "max_y", "conditions": "Line"},
        {"name": "In", "side": "max_y", "conditions": "Line", "orientation": "inward"},
        {"name": "Points", "side": "max_x", "conditions": "Point"}]}));
    let find = |name: &str| part.find(name).unwrap().conditions.clone();
    assert_eq!(find("Walls").len(), 8);
    for condition in find("Walls") {
        let corners = part.corners(&part.conditions, condition as usize);
        let outward = if corners[0][0] == 0.0 { -1.0 } else { 1.0 };
        assert_eq!(area_vector(&corners), [outward, 0.0, 0.0]);
    }
    assert_eq!(sum_of_normals(&part, &part.conditions, &find("Top")), [0.0, 1.0, 0.0]);
    assert_eq!(sum_of_normals(&part, &part.conditions, &find("In")), [0.0, -1.0, 0.0]);
    assert_eq!(find("Points").len(), 5);
    assert_eq!(part.conditions.ids, (1..=15).collect::<Vec<u32>>());
}

#[test]
fn faces_of_solid_grids_point_outward() {
    for (shape, condition, count) in [("hexahedron", "Face4", 6), ("tetrahedron", "Face3", 12)] {
        let sides = ["min_x", "max_x", "min_y", "max_y", "min_z", "max_z"];
        let parts: Vec<_> = sides.map(|side| json!({"name": side, "side": side, "conditions": condition})).into();
        let part = grid(json!({"min": [0, 0, 0], "max": [1, 1, 1], "divisions": [2, 3, 1], "shape": shape,
                               "parts": parts}));
        for (i, side) in sides.iter().enumerate() {
            let conditions = &part.find(side).unwrap().conditions;
            let sum = sum_of_normals(&part, &part.conditions, conditions);
            let outward = if i % 2 == 0 { -1.0 } else { 1.0 };
            (0..3).for_each(|axis| {
                let expected = if axis == i / 2 { outward } else { 0.0 };
                assert!((sum[axis] - expected).abs() < 1e-14, "{side} of {shape}: {sum:?}");
            });
            if *side == "max_z" {
                assert_eq!(conditions.len(), count);
            }
        }
    }
}

/// Cook's membrane with a margin of cells around it: sides and boxes are those of the unit square.
#[test]
fn mapped_grids_and_bodies_lie_on_each_other() {
    let corners = json!([[0, 0], [48, 44], [48, 60], [0, 44]]);
    let part = grid(json!({"min": [0, -0.25, 0], "max": [1.25, 1.25, 0], "divisions": [10, 12], "map": corners,
        "parts": [{"name": "Clamp", "side": "min_x"},
                  {"name": "Load", "box": {"min": [1, 0, 0], "max": [1, 1, 0]}, "conditions": "Line"}]}));
    check_mesh(&part);
    let place = |node: u32| part.nodes.coordinates[node as usize];
    assert!(part.find("Clamp").unwrap().nodes.iter().all(|&node| place(node)[0] == 0.0));
    let load = &part.find("Load").unwrap().nodes;
    assert_eq!((load.len(), place(load[0]), place(load[8])), (9, [48.0, 44.0, 0.0], [48.0, 60.0, 0.0]));
    // A load between cells, on faces that are those of the left cells.
    assert_eq!(
        (part.conditions.len(), sum_of_normals(&part, &part.conditions, &part.find("Load").unwrap().conditions)),
        (8, [16.0, 0.0, 0.0])
    );
    let unit = json!({"type": "box", "min": [0, 0, 0], "max": [1, 1, 0]});
    for shape in ["quadrilateral", "triangle"] {
        let body = body(json!({"primitive": unit, "divisions": [8, 8], "map": corners, "shape": shape,
                               "diagonal": "fixed"}));
        check_mesh(&body);
        close(measure(&body), 1440.0, 1e-13);
        let at = |x: &[f64; 3]| x.map(|x| (x * 1e9).round() as i64);
        let of_grid: std::collections::HashSet<_> = part.nodes.coordinates.iter().map(at).collect();
        assert!(body.nodes.coordinates.iter().all(|x| of_grid.contains(&at(x))));
    }
    let cube: Vec<[f64; 3]> = super::super::mesh::corners_of(3).iter().map(|c| c.map(|i| 2.0 * i as f64)).collect();
    let part = grid(json!({"min": [0, 0, 0], "max": [1, 1, 1], "divisions": [2, 2, 2], "map": cube}));
    close(measure(&part), 8.0, 1e-15);
}

/// Materials are given to parts: a box holds the cells that lie in it.
#[test]
fn a_box_holds_its_cells() {
    let part = grid(json!({"min": [-1, 0, 0], "max": [1, 1, 0], "divisions": [4, 2], "parts": [
        {"name": "Left", "box": {"min": [-1, 0, 0], "max": [0, 1, 0]}},
        {"name": "Middle", "box": {"min": [-0.6, 0, 0], "max": [0.6, 0.5, 0]}},
        {"name": "Floor", "box": {"min": [-1, 0, 0], "max": [1, 0, 0]}}]}));
    let cells: Vec<&[u32]> = part.children.iter().map(|child| child.elements.as_slice()).collect();
    assert_eq!(cells, [&[0, 1, 4, 5][..], &[1, 2], &[]]);
}
