//! A few messages as a whole, as they are read where standard error is no terminal.

use super::base::{BODY, GRID, MATERIALS, PROJECT, Scene};

fn assert_says(scene: &Scene, expected: &str) {
    let outcome = scene.run(&["--quiet"]);
    assert_eq!(outcome.stderr.trim_end(), expected.trim_matches('\n'), "\n{}", outcome.stderr);
}

#[test]
fn a_misspelt_key() {
    let scene = Scene::base().replace(PROJECT, "\"constrained\"", "\"constraind\"");
    assert_says(
        &scene,
        r#"
  x ProjectParameters.json:31:31 at /processes/constraints/0/Parameters/constraind: the key "constraind" is unknown
    ,-[ProjectParameters.json:31:31]
 30 |                 "variable_name": "DISPLACEMENT",
 31 |                 "constraind": [true, true, true],
    :                               ^^^^^^^^^|^^^^^^^^^
    :                                        `-- here
 32 |                 "value": [0.0, "0.0*t", 0.0],
    `----
  help: did you mean "constrained"? Allowed: model_part_name, variable_name, interval, local_axes, help, mesh_id, constrained, value
1 error in the input; nothing was run or written.
"#,
    );
}

#[test]
fn a_modulus_of_zero() {
    assert_says(
        &Scene::base().replace(MATERIALS, "1e6", "0.0"),
        r#"
  x ParticleMaterials.json:11:34 at /properties/0/Material/Variables/YOUNG_MODULUS: YOUNG_MODULUS is 0
    ,-[ParticleMaterials.json:11:34]
 10 |                 "DENSITY": 1000.0,
 11 |                 "YOUNG_MODULUS": 0.0,
    :                                  ^^|^
    :                                    `-- here
 12 |                 "POISSON_RATIO": 0.3
    `----
  help: expected: Young's modulus at small strain, a number > 0 [Pa]
1 error in the input; nothing was run or written.
"#,
    );
}

#[test]
fn a_number_in_a_mesh() {
    assert_says(
        &Scene::base().replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 0.2x5 0.0"),
        r#"
  x Body.mdpa:8:9: "0.2x5" is not a number
   ,-[Body.mdpa:8:9]
 7 | 104 0.25 0.25 0.0
 8 | 105 0.5 0.2x5 0.0
   :         ^^^^|^^^^
   :             `-- here
 9 | 106 0.75 0.25 0.0
   `----
1 error in the input; nothing was run or written.
"#,
    );
}

#[test]
fn a_cell_inside_out() {
    assert_says(
        &Scene::base().replace(GRID, "\n6 0 7 8 13 12", "\n6 0 7 12 13 8"),
        r#"
  x Grid.mdpa:36: Element2D4N 6 is inside out (signed measure -6.25e-2): write its nodes in the order 1 4 3 2
    ,-[Grid.mdpa:36:1]
 35 | 5 0 6 7 12 11
 36 | 6 0 7 12 13 8
    : ^^^^^^|^^^^^^
    :       `-- here
 37 | 7 0 8 9 14 13
    `----
1 error in the input; nothing was run or written.
"#,
    );
}

#[test]
fn letters_of_more_than_one_byte() {
    let scene = Scene::base().replace(PROJECT, "\"0.0*t\"", &format!("\"{}\"", "ä".repeat(100)));
    let stderr = scene.run(&["--quiet"]).stderr;
    // The mark is as long as sixty letters and begins below the quote.
    let mark = stderr.lines().find(|line| line.contains('^')).unwrap();
    assert!(mark.starts_with(&format!("    : {}^", " ".repeat(31))), "{stderr}");
    assert_eq!(mark.matches(['^', '|']).count(), 60, "{stderr}");
}
