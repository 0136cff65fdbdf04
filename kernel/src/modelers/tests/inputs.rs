//! Faults of the input: found together, each with its place.

use super::build;
use serde_json::{Value, json};

fn message(modelers: Value) -> String {
    match build(modelers) {
        Ok(_) => "no fault".into(),
        Err(errors) => errors.to_string(),
    }
}

fn grid(parameters: Value) -> String {
    message(json!([{"name": "RegularGridModeler", "parameters": parameters}]))
}

fn body(mut entry: Value) -> String {
    entry["name"] = "A".into();
    message(json!([{"name": "BodyModeler", "parameters": {"bodies": [entry]}}]))
}

fn expect(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in\n{message}");
    }
}

#[test]
fn faults_of_a_grid_come_together() {
    let text = grid(json!({"min": [0, 0, 0], "max": [1.05, 1, 0], "cell_size": 0.1, "shape": "hexahedron",
        "parts": [{"name": "A", "side": "min_z"}, {"name": "A", "side": "max_x", "conditions": "Face3"}, {"name": "a.b"}]}));
    expect(
        &text,
        &[
            "/0/parameters/cell_size: 0.1 does not divide the box in x: 1.05 / 0.1 = 10.5 cells",
            "divisions take any box",
            "\"hexahedron\" has 3 dimensions, but the grid has 2",
            "there is no side \"min_z\"",
            "\"A\" stands twice",
            "\"Face3\" is a Triangle3, must be a Point1 or a Line2",
            "must not be empty or hold a dot",
            "neither is given",
        ],
    );
}

#[test]
fn faults_of_single_keys() {
    let square = |options: Value| {
        let mut parameters = json!({"min": [0, 0, 0], "max": [1, 1, 0]});
        parameters.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        grid(parameters)
    };
    expect(&square(json!({"divisions": [4, 0]})), &["is [4,0], must be 2 whole numbers of at least 1"]);
    expect(&square(json!({"divisions": [4, 4, 4]})), &["[x, y]"]);
    expect(&square(json!({"divisions": [1000000, 1000000]})), &["more than 100000000 cells"]);
    expect(&square(json!({"divisions": [4, 4], "cell_size": 0.25})), &["both are given"]);
    expect(&square(json!({})), &["neither is given"]);
    expect(&square(json!({"divsions": [4, 4]})), &["did you mean \"divisions\""]);
    expect(&square(json!({"cell_size": 0.25, "grading": [2, 1, 1]})), &["does not fit a constant cell_size"]);
    expect(&square(json!({"divisions": [4, 4], "grading": [0, 1, 1]})), &["three numbers above 0"]);
    expect(&square(json!({"divisions": [4, 4], "element_name": "Elment2D4N"})), &["did you mean \"Element2D4N\""]);
    expect(&square(json!({"divisions": [4, 4], "tetrahedra_per_cube": 7})), &["must be 5 or 6"]);
    expect(&square(json!({"divisions": [4, 4], "map": [[0, 0], [1, "a"], [1, 1]]})), &["is [1,\"a\"]", "must have 4"]);
    expect(
        &square(json!({"divisions": [4, 4], "parts": [{"name": "A", "box": {"min": [2, 0, 0], "max": [3, 1, 0]}}]})),
        &["holds no node", "[1.0,1.0,0.0]"],
    );
    expect(
        &square(json!({"divisions": [2, 2], "parts": [
            {"name": "A", "box": {"min": [0.4, 0.4, 0], "max": [0.6, 0.6, 0]}, "conditions": "Line"}]})),
        &["holds no boundary face"],
    );
    expect(
        &grid(json!({"min": [0, 2, 0], "max": [0, 1, 5], "divisions": [1, 1, 1]})),
        &["is 0 in x, must be greater than min, which is 0", "is 1 in y, must be greater than min, which is 2"],
    );
    expect(&grid(json!({"min": [0, 0, 1], "max": [1, 1, 1], "divisions": [1, 1]})), &["is 1 in z, must be 0"]);
}

#[test]
fn faults_of_bodies() {
    let disc = |options: Value| {
        let mut entry = json!({"primitive": {"type": "disc", "radius": 1.0}});
        entry.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        body(entry)
    };
    expect(&disc(json!({})), &["divisions or cell_size, and neither is given", "[around, radial]"]);
    expect(&disc(json!({"divisions": [6, 1]})), &["6 cells around, must be a multiple of 4"]);
    expect(&disc(json!({"cell_size": 0.1, "shape": "tetrahedron"})), &["3 dimensions, but a disc has 2", "triangle"]);
    expect(&disc(json!({"cell_size": 3.0, "fill": "grid"})), &["leaves the body without cells"]);
    expect(&disc(json!({"divisions": [8, 1], "fill": "grid"})), &["is for fitted bodies", "takes a cell_size"]);
    expect(&disc(json!({"cell_size": 1e-9, "fill": "grid"})), &["too small"]);
    expect(&disc(json!({"cell_size": 1e-9})), &["more than 100000000 cells"]);
    expect(
        &disc(json!({"cell_size": 0.1, "rotation": {"axis": [1, 0, 0], "angle": 5}, "translation": [0, 0, 1]})),
        &["turn a body of 2 dimensions out of its space", "is 1 in z, must be 0"],
    );
    expect(&body(json!({"primitive": {"type": "disk"}, "cell_size": 1})), &["did you mean \"disc\""]);
    expect(&body(json!({"primitive": {"type": "disc", "radius": -1}, "cell_size": 1})), &["above 0"]);
    expect(&body(json!({"primitive": {"type": "disc", "radius": 1, "center": [0, 0, 1]}, "cell_size": 1})), &["in z"]);
    for kind in ["ring", "spherical_shell"] {
        let primitive = json!({"type": kind, "inner_radius": 2, "outer_radius": 1});
        expect(
            &body(json!({"primitive": primitive, "cell_size": 1})),
            &["is 2, must be less than outer_radius, which is 1"],
        );
    }
    let primitive = json!({"type": "polygon", "vertices": [[0, 0], [1, 1], [2, 2]]});
    expect(&body(json!({"primitive": primitive, "cell_size": 1})), &["must enclose an area"]);
}

#[test]
fn faults_between_bodies_and_between_modelers() {
    let text = message(json!([{"name": "BodyModeler", "parameters": {"bodies": [
        {"name": "A", "primitive": {"type": "disc", "radius": 1}, "cell_size": 0.5},
        {"name": "A", "primitive": {"type": "sphere", "radius": 1}, "cell_size": 0.5}]}}]));
    expect(&text, &["\"A\" stands twice", "has 3 dimensions, but the first body has 2"]);
    let one =
        json!({"name": "RegularGridModeler", "parameters": {"min": [0, 0, 0], "max": [1, 1, 0], "divisions": [1, 1]}});
    expect(&message(json!([one.clone(), one])), &["\"Background_Grid\" is there already"]);
    expect(&message(json!([{"name": "BodyModeler", "parameters": {"bodies": []}}])), &["names no body"]);
}
