//! Faults of the blocks of processes.

use super::base::{GRID, PROJECT, Scene, refuse};

/// Replaces the gravity process by another one.
fn load(scene: Scene, parameters: &str) -> Scene {
    scene
        .replace(PROJECT, "assign_gravity_to_material_point_process", "apply_mpm_particle_neumann_condition_process")
        .replace(PROJECT, "\"modulus\": 9.81,\n                \"direction\": [0.0, -1.0, 0.0]", parameters)
}

#[test]
fn blocks() {
    refuse(&[
        (
            "module",
            |s| s.replace(PROJECT, "assign_vector_variable_process", "assign_vektor_variable_process"),
            &[
                "ProjectParameters.json:26:30 at /processes/constraints/0/python_module",
                "there is no process \"assign_vektor_variable_process\"",
                "did you mean \"assign_vector_variable_process\"?",
            ],
        ),
        (
            "no module",
            |s| s.replace(PROJECT, "\"python_module\": \"assign_vector_variable_process\",", ""),
            &["at /processes/constraints/0", "\"python_module\" is missing"],
        ),
        (
            "no Parameters",
            |s| s.replace(PROJECT, "\"Parameters\": {\"model_part_name\": \"MPM_Material\"}", "\"check\": \"\""),
            &["at /output_processes/energy/0", "the key \"Parameters\" is missing"],
        ),
        (
            "a result in the place of the project",
            |s| {
                let file = "\"Parameters\": {\"output_file_settings\": {\"file_name\": \"ProjectParameters.json\"}, \"model_part";
                s.replace(
                    PROJECT,
                    "\"Parameters\": {\"model_part_name\": \"MPM_Material\"",
                    &format!("{file}_name\": \"MPM_Material\""),
                )
            },
            &["/output_processes/energy/0", "would overwrite an input file"],
        ),
        (
            "Parametres",
            |s| s.replace(PROJECT, "\"Parameters\": {\"model", "\"Parametres\": {\"model"),
            &["at /output_processes/energy/0", "the key \"Parametres\" is unknown", "did you mean \"Parameters\"?"],
        ),
        (
            "block a number",
            |s| s.replace(PROJECT, "\"gravity\": [{", "\"gravity\": [7, {"),
            &["at /processes/gravity/0", "is the number 7, must be an object"],
        ),
        (
            "key",
            |s| s.replace(PROJECT, "\"constrained\"", "\"constraind\""),
            &["at /processes/constraints/0/Parameters/constraind", "did you mean \"constrained\"?"],
        ),
        (
            "part",
            |s| s.replace(PROJECT, "Background_Grid.Floor", "Background_Grid.Flor"),
            &[
                "ProjectParameters.json:29:36 at /processes/constraints/0/Parameters/model_part_name",
                "there is no model part \"Background_Grid.Flor\"",
                "did you mean \"Background_Grid.Floor\"?",
            ],
        ),
        (
            "part of points",
            |s| {
                s.replace(
                    PROJECT,
                    "\"MPM_Material\",\n                \"modulus\"",
                    "\"MPM_Material.Qube\",\n                \"modulus\"",
                )
            },
            &["there is no part of points \"MPM_Material.Qube\"", "did you mean \"MPM_Material.Cube\"?"],
        ),
        (
            "part without nodes",
            |s| {
                s.replace(PROJECT, "Background_Grid.Floor", "Background_Grid.Empty")
                    .append(GRID, "Begin SubModelPart Empty\nEnd SubModelPart\n")
            },
            &["the model part \"Background_Grid.Empty\" has no nodes"],
        ),
        (
            "variable",
            |s| s.replace(PROJECT, "\"DISPLACEMENT\"", "\"DISPLACEMNT\""),
            &[
                "at /processes/constraints/0/Parameters/variable_name",
                "the variable \"DISPLACEMNT\" is unknown",
                "did you mean \"DISPLACEMENT\"?",
            ],
        ),
        (
            "rank",
            |s| s.replace(PROJECT, "\"DISPLACEMENT\"", "\"PRESSURE\""),
            &["\"PRESSURE\" is a scalar, must be a vector", "DISPLACEMENT"],
        ),
        (
            "interval",
            |s| s.replace(PROJECT, "[0.0, \"End\"]", "[2.0, 1.0]"),
            &["at /processes/constraints/0/Parameters/interval", "start <= end"],
        ),
        (
            "interval of texts",
            |s| s.replace(PROJECT, "[0.0, \"End\"]", "[0.0, \"Ende\"]"),
            &["where end may be \"End\""],
        ),
        (
            "gravity a text",
            |s| s.replace(PROJECT, "9.81", "\"much\""),
            &["at /processes/gravity/0/Parameters/modulus", "\"much\""],
        ),
        (
            "direction",
            |s| s.replace(PROJECT, "[0.0, -1.0, 0.0]", "[0.0, -1.0]"),
            &["at /processes/gravity/0/Parameters/direction", "three"],
        ),
        (
            "value of two",
            |s| s.replace(PROJECT, "[0.0, \"0.0*t\", 0.0]", "[0.0, 1.0]"),
            &["at /processes/constraints/0/Parameters/value", "the list [", "a list of three"],
        ),
        (
            "print format",
            |s| {
                s.replace(
                    PROJECT,
                    "{\"model_part_name\": \"MPM_Material\"}",
                    "{\"model_part_name\": \"MPM_Material\", \"print_format\": \"8\"}",
                )
            },
            &["print_format", "is no number format"],
        ),
    ]);
}

#[test]
fn functions() {
    refuse(&[
        (
            "broken",
            |s| s.replace(PROJECT, "\"0.0*t\"", "\"0.0*(t\""),
            &[
                "ProjectParameters.json:32:32 at /processes/constraints/0/Parameters/value/1",
                "the function \"0.0*(t\" is wrong",
                "at character 7 of",
            ],
        ),
        ("symbol", |s| s.replace(PROJECT, "\"0.0*t\"", "\"sinn(t)\""), &["/value/1", "sinn", "sin"]),
        ("empty", |s| s.replace(PROJECT, "\"0.0*t\"", "\"\""), &["/value/1", "is wrong"]),
        ("infinite", |s| s.replace(PROJECT, "\"0.0*t\"", "\"1/0\""), &["/value/1", "is not finite"]),
        ("deep", |s| s.replace(PROJECT, "0.0*t", &"(".repeat(30_000)), &["/value/1", "is wrong"]),
        ("letters of two bytes", |s| s.replace(PROJECT, "0.0*t", "é*ü + t*größe"), &["/value/1", "is wrong"]),
    ]);
}

#[test]
fn loads_on_conditions() {
    refuse(&[
        ("part", |s| load(s, "\"modulus\": 1.0"), &["is no first-level part of the grid with conditions"]),
        (
            "variable",
            |s| load(s, "\"variable_name\": \"POINT_LAOD\""),
            &["/variable_name", "did you mean \"POINT_LOAD\"?"],
        ),
        ("function", |s| load(s, "\"modulus\": \"2*\""), &["/modulus", "is wrong"]),
    ]);
}

/// Replaces the gravity process by a deformation at the start.
fn deform(scene: Scene, members: &str) -> Scene {
    let module = "assign_initial_deformation_to_material_point_process";
    scene.replace(PROJECT, "assign_gravity_to_material_point_process", module).replace(
        PROJECT,
        "\"modulus\": 9.81,\n                \"direction\": [0.0, -1.0, 0.0]",
        members,
    )
}

#[test]
fn initial_deformations() {
    refuse(&[
        (
            "neither",
            |s| {
                deform(s, "\"cauchy_stress\": [0, 0, 0]").replace(
                    PROJECT,
                    ",\n                \"cauchy_stress\": [0, 0, 0]",
                    "",
                )
            },
            &["names neither \"deformation_gradient\" nor \"cauchy_stress\""],
        ),
        (
            "both",
            |s| deform(s, "\"cauchy_stress\": [0, 0, 0], \"deformation_gradient\": [1, 0, 0, 0, 1, 0, 0, 0, 1]"),
            &["/cauchy_stress", "stands beside \"deformation_gradient\""],
        ),
        (
            "eight numbers",
            |s| deform(s, "\"deformation_gradient\": [1, 0, 0, 0, 1, 0, 0, 0]"),
            &["/deformation_gradient", "has 8 members, must have nine"],
        ),
        (
            "six components in the plane",
            |s| deform(s, "\"cauchy_stress\": [0, 0, 0, 0, 0, 0]"),
            &["/cauchy_stress", "has 6 components, must have 3: xx, yy, xy"],
        ),
        (
            "total frame",
            |s| {
                let total =
                    s.replace(PROJECT, "\"max_iteration\"", "\"frame\": \"total_lagrangian\", \"max_iteration\"");
                deform(total, "\"cauchy_stress\": [0, 0, 0]")
            },
            &["is for the updated frame"],
        ),
    ]);
}

/// What shows only at the points: a deformation that the plane does not have, a stress beyond the law.
#[test]
fn initial_deformations_that_cannot_be() {
    for (members, says) in [
        ("\"deformation_gradient\": [1, 0, 0, 0, 1, 0, 0, 0, 0.5]", "is no deformation in plane strain"),
        ("\"deformation_gradient\": [-1, 0, 0, 0, 1, 0, 0, 0, 1]", "is no deformation in plane strain"),
        ("\"cauchy_stress\": [\"log(x - 2)\", 0, 0]", "is not finite"),
    ] {
        let outcome = deform(Scene::base(), members).run(&[]);
        assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
        assert!(outcome.words().contains(says) && outcome.words().contains("material point "), "{}", outcome.stderr);
    }
}

/// Replaces the table of energies by another output.
fn output(scene: Scene, module: &str, parameters: &str) -> Scene {
    scene.replace(PROJECT, "mpm_write_energy_output_process", module).replace(
        PROJECT,
        "{\"model_part_name\": \"MPM_Material\"}",
        &format!("{{{parameters}}}"),
    )
}

#[test]
fn measurements() {
    const POINT: &str = "point_output_process";
    const POINTS: &str = "mpm_point_output_process";
    refuse(&[
        (
            "place",
            |s| {
                let keys = r#""model_part_name": "Background_Grid", "output_variables": ["VELOCITY"], "position": "#;
                output(s, POINT, &format!("{keys}[2.0, 0.5, 0.0]"))
            },
            &["no element of \"Background_Grid\" holds [2.0, 0.5, 0.0]"],
        ),
        (
            "node",
            |s| {
                let keys = r#""model_part_name": "Background_Grid.Floor", "output_variables": ["VELOCITY"],
                    "entity_type": "node", "position": "#;
                output(s, POINT, &format!("{keys}[0.5, 0.1, 0.0]"))
            },
            &["/search_tolerance", "the nearest, 3, is 1e-1 m off"],
        ),
        (
            "variable of points",
            |s| {
                let keys = r#""model_part_name": "Background_Grid", "position": [0.5, 0.5, 0.0], "#;
                output(s, POINT, &format!(r#"{keys}"output_variables": ["MP_VELOCITY"]"#))
            },
            &["/output_variables/0", "nobody in this scene provides \"MP_VELOCITY\""],
        ),
        (
            "id",
            |s| output(s, POINTS, r#""material_point_ids": [7], "output_variables": ["MP_VELOCITY"]"#),
            &["/material_point_ids", "there is no material point 7"],
        ),
        (
            "neither id nor place",
            |s| output(s, POINTS, r#""output_variables": ["MP_VELOCITY"]"#),
            &["needs either \"material_point_ids\" or \"positions\""],
        ),
        (
            "quantile",
            |s| output(s, "mpm_front_output_process", r#""quantiles": [0.5, 99.8]"#),
            &["/quantiles/1", "from 0 to 1"],
        ),
        (
            "total",
            |s| output(s, "mpm_totals_output_process", r#""quantities": ["mas"]"#),
            &["/quantities/0", "did you mean \"mass\"?"],
        ),
        (
            "blocks that cut cells",
            |s| {
                output(
                    s,
                    "mpm_totals_output_process",
                    r#""quantities": ["overfill"], "overfill_block": [0.6, 0.5, 0.0]"#,
                )
            },
            &["/overfill_block", "element 3 lies in several"],
        ),
        (
            "vector",
            |s| {
                let keys = r#""model_part_name": "Background_Grid", "output_variables": ["VELOCITY"]"#;
                output(s, "oscillation_output_process", keys)
            },
            &["/output_variables/0", "name a component"],
        ),
        (
            "time",
            |s| output(s, "mpm_front_output_process", r#""output_times": [0.01, "Ende"]"#),
            &["/output_times/1", "or \"End\""],
        ),
        (
            "two in one file",
            |s| {
                let block = r#"{"python_module": "mpm_front_output_process", "Parameters": {}}"#;
                let s = output(s, "mpm_front_output_process", "");
                s.replace(PROJECT, "\"energy\": [{", &format!("\"energy\": [{block}, {{"))
            },
            &["/output_processes/energy/1", "another process writes", "front.csv"],
        ),
    ]);
}

/// A part of conditions on the floor (nodes 1 to 5) and up the left side (1, 6, …), and a slip process there.
fn wall(scene: Scene, lines: &[[u32; 2]], parameters: &str) -> Scene {
    let numbered = || lines.iter().enumerate().map(|(i, [a, b])| (i + 1, a, b));
    let conditions: String = numbered().map(|(id, a, b)| format!("{id} 0 {a} {b}\n")).collect();
    let ids: String = numbered().map(|(id, ..)| format!("{id}\n")).collect();
    let text = format!(
        "Begin Conditions LineCondition2D2N\n{conditions}End Conditions\nBegin SubModelPart Wall\n\
         Begin SubModelPartConditions\n{ids}End SubModelPartConditions\nEnd SubModelPart\n"
    );
    scene
        .append(GRID, &text)
        .replace(PROJECT, "assign_gravity_to_material_point_process", "apply_mpm_slip_boundary_process")
        .replace(
            PROJECT,
            "\"model_part_name\": \"MPM_Material\",\n                \"modulus\": 9.81,\n                \
             \"direction\": [0.0, -1.0, 0.0]",
            parameters,
        )
}

#[test]
fn walls_to_slide_along() {
    refuse(&[
        (
            "friction",
            |s| wall(s, &[[1, 2]], r#""model_part_name": "Background_Grid.Wall", "friction_coefficient": 0.3"#),
            &["/friction_coefficient", "friction on walls is not there yet"],
        ),
        (
            "part without conditions",
            |s| wall(s, &[[1, 2]], r#""model_part_name": "Background_Grid.Floor""#),
            &["\"Background_Grid.Floor\" is no part of the grid with conditions"],
        ),
        (
            "edge",
            |s| wall(s, &[[6, 1], [1, 2]], r#""model_part_name": "Background_Grid.Wall""#),
            &["the wall has an edge at node 1", "a slip process of its own"],
        ),
        (
            "lines that run against each other",
            |s| wall(s, &[[1, 2], [3, 2]], r#""model_part_name": "Background_Grid.Wall""#),
            &["node 2 of \"Background_Grid.Wall\" has no normal"],
        ),
        (
            "splines",
            |s| {
                wall(s, &[[1, 2]], r#""model_part_name": "Background_Grid.Wall""#).replace(
                    PROJECT,
                    "\"solver_type\": \"dynamic\",",
                    "\"solver_type\": \"dynamic\", \"frame\": \"total_lagrangian\", \"basis\": \"b_spline\",",
                )
            },
            &["walls to slide along need the functions of the mesh"],
        ),
    ]);
}
