//! The commands beside `run` and `check`: `new`, `info`, `schema`, `completions`.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn bia(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bia")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn each_template_is_a_project_that_is_right() {
    let folder = tempfile::tempdir().unwrap();
    for template in ["falling-disc", "colliding-discs", "rotating-body", "step-bar"] {
        let made = bia(folder.path(), &["new", template, "--template", template]);
        assert!(made.status.success(), "{}", text(&made.stderr));
        let checked = bia(folder.path(), &["check", &format!("{template}/ProjectParameters.json")]);
        assert!(checked.status.success(), "{template}: {}", text(&checked.stderr));
    }
    let again = bia(folder.path(), &["new", "falling-disc"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("is there already"));
}

/// A step above the stable one is told before the run, one below it is not, by the measure of each method.
#[test]
fn check_tells_a_step_above_the_stable_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let told = |project: &str, step: f64| {
        let set = format!("/solver_settings/time_stepping/time_step={step:e}");
        let checked = bia(root, &["check", project, "--set", &set]);
        let said = text(&checked.stderr);
        assert!(checked.status.success(), "{said}");
        let (_, stable) = said.split_once("is above the stable one, ")?;
        Some(stable.split_whitespace().next().unwrap().parse::<f64>().unwrap())
    };
    for project in [
        "examples/colliding_discs/ProjectParameters.json",
        "examples/tlmpm_step_bar/ProjectParameters.json",
        "tests/survey/X01/ProjectParameters_fem.json",
        "tests/survey/X01/ProjectParameters_dgmpm.json",
    ] {
        let stable = told(project, 1.0).unwrap_or_else(|| panic!("{project}: a step of 1 s is not told"));
        // The number is rounded to five digits.
        assert_eq!(told(project, 0.9999 * stable), None, "{project}, {stable}");
        assert!(told(project, 1.0001 * stable).is_some(), "{project}, {stable}");
    }
}

/// Each scene shows what it has and what it does without.
#[test]
fn explain_shows_columns_and_what_is_left_out() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = bia(root, &["explain", "examples/falling_disc/ProjectParameters.json", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let plan: Value = serde_json::from_slice(&output.stdout).unwrap();
    let left: Vec<&str> = plan["left_out"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(left.contains(&"pressure") && left.contains(&"law history"), "{left:?}");
    let columns = plan["columns"].as_array().unwrap();
    let position = columns.iter().find(|column| column["name"] == "position").unwrap();
    assert_eq!(position["bytes"], 2048 * 2 * 8);
    assert!(plan["stages"].as_array().unwrap().iter().any(|stage| stage == "linear solver"));
    let shown = text(&bia(root, &["explain", "examples/falling_disc/ProjectParameters.json"]).stdout);
    // An application that a scene does not use has no column in it.
    let columns_of = |example: &str| {
        let plan = bia(root, &["explain", &format!("examples/{example}/ProjectParameters.json"), "--json"]);
        let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
        plan["columns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    let (of_impact, of_points) = (columns_of("dgmpm_bar"), columns_of("colliding_discs"));
    let faces = |columns: &[String]| columns.iter().any(|name| name.starts_with("faces"));
    assert!(faces(&of_impact) && !faces(&of_points) && !of_impact.contains(&"acceleration".to_string()));
    assert!(shown.contains("left out") && shown.contains("points to grid -> assembly"), "{shown}");
}

#[test]
fn info_shows_keys_ranges_and_units() {
    let folder = Path::new(".");
    let all = text(&bia(folder, &["info"]).stdout);
    for name in ["RegularGridModeler", "HyperElasticNeoHookean3DLaw", "MP_VELOCITY", "vtk_output_process", "dynamic"] {
        assert!(all.contains(name), "{name} is missing");
    }
    let law = text(&bia(folder, &["info", "HyperElasticNeoHookean3DLaw"]).stdout);
    assert!(law.contains("YOUNG_MODULUS") && law.contains("[Pa], > 0"), "{law}");
    let solver = text(&bia(folder, &["info", "Dynamic"]).stdout);
    assert!(solver.contains("flip_fraction") && solver.contains("default 1.0"), "{solver}");
    let unknown = bia(folder, &["info", "RegularGridModler"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("did you mean \"RegularGridModeler\""));
}

/// That it accepts what runs and refuses slips is checked in CI, with a validator.
#[test]
fn the_schema_knows_every_component() {
    let schema: Value = serde_json::from_slice(&bia(Path::new("."), &["schema"]).stdout).unwrap();
    let definitions = schema["$defs"].as_object().unwrap();
    let step = &definitions["static"]["properties"]["time_stepping"]["properties"]["time_step"];
    assert!(step["description"].as_str().unwrap().contains("[s]"), "{step}");
    assert!(definitions.contains_key("BodyModeler") && definitions.contains_key("structural_static"));
}

#[test]
fn shells_get_completions() {
    for shell in ["bash", "zsh", "fish"] {
        let output = bia(Path::new("."), &["completions", shell]);
        assert!(output.status.success() && text(&output.stdout).contains("bia"), "{shell}");
    }
}
