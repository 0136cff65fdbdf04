//! Faults of ProjectParameters.json beside those of its processes.

use super::base::{PROJECT, Scene, refuse};

#[test]
fn the_base_scene_runs() {
    let outcome = Scene::base().run(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(outcome.new_files, ["energy.dat"]);
    let outcome = Scene::base().command("check", &[]);
    assert_eq!((outcome.code, outcome.new_files.len()), (Some(0), 0), "{}", outcome.stderr);
}

#[test]
fn syntax() {
    refuse(&[
        (
            "trailing comma",
            |s| s.replace(PROJECT, "\"end_time\": 0.02", "\"end_time\": 0.02,"),
            &["ProjectParameters.json:7:5", "trailing comma", "is not JSON"],
        ),
        (
            "missing comma",
            |s| s.replace(PROJECT, "\"start_time\": 0.0,", "\"start_time\": 0.0"),
            &["ProjectParameters.json:6:", "expected `,` or `}`"],
        ),
        (
            "cut off",
            |s| {
                let text = s.text(PROJECT);
                s.write(PROJECT, text[..800].to_string())
            },
            &["ProjectParameters.json:", "EOF"],
        ),
        ("empty", |s| s.write(PROJECT, ""), &["ProjectParameters.json", "is not JSON", "EOF"]),
        ("a list", |s| s.write(PROJECT, "[1]"), &["a project must be a JSON object"]),
        ("not UTF-8", |s| s.write(PROJECT, *b"{\"a\": \"\xff\"}"), &["is not UTF-8 text (byte 7)"]),
        (
            "infinite number",
            |s| s.replace(PROJECT, "9.81", "1e999"),
            &["ProjectParameters.json:41:", "number out of range", "smaller than 1.8e308"],
        ),
        (
            "nan",
            |s| s.replace(PROJECT, "9.81", "nan"),
            &["ProjectParameters.json:41:", "is not JSON", "no nan or infinity"],
        ),
        (
            "key twice",
            |s| s.replace(PROJECT, "\"start_time\": 0.0,", "\"start_time\": 0.0, \"end_time\": 1.0,"),
            &["ProjectParameters.json:6:", "at /problem_data/end_time", "stands twice", "line 5"],
        ),
        (
            "after other letters",
            |s| s.replace(PROJECT, "\"problem_name\": \"base\",", "\"problem_name\": \"Ünïcödé größer\", \"oops\" 1,"),
            &["ProjectParameters.json:3:", "expected `:`"],
        ),
    ]);
}

#[test]
fn problem_data() {
    refuse(&[
        (
            "missing",
            |s| s.replace(PROJECT, "\"problem_data\"", "\"problem_dota\""),
            &["the key \"problem_dota\" is unknown", "did you mean \"problem_data\"?", "\"problem_data\" is missing"],
        ),
        (
            "no end",
            |s| s.replace(PROJECT, ",\n        \"end_time\": 0.02", ""),
            &["at /problem_data", "\"end_time\" is missing"],
        ),
        (
            "MPI",
            |s| s.replace(PROJECT, "\"OpenMP\"", "\"MPI\""),
            &["ProjectParameters.json:4:26 at /problem_data/parallel_type", "\"MPI\"", "must be one of OpenMP"],
        ),
        ("small letters", |s| s.replace(PROJECT, "\"OpenMP\"", "\"openmp\""), &["did you mean \"OpenMP\"?"]),
        (
            "end before start",
            |s| s.replace(PROJECT, "\"start_time\": 0.0", "\"start_time\": 5.0"),
            &["ProjectParameters.json:6:21 at /problem_data/end_time", "end_time is 0.02", "above the start_time 5"],
        ),
        (
            "end a text",
            |s| s.replace(PROJECT, "0.02", "\"late\""),
            &["at /problem_data/end_time", "is the text \"late\"", "must be a number"],
        ),
        (
            "problem_data a number",
            |s| {
                let text = s.text(PROJECT);
                let end = text.find("    \"solver_settings\"").unwrap();
                s.write(PROJECT, format!("{{\"problem_data\": 3,\n{}", &text[end..]))
            },
            &["at /problem_data", "is the number 3, must be an object"],
        ),
    ]);
}

#[test]
fn layout() {
    refuse(&[
        (
            "slip at the root",
            |s| s.replace(PROJECT, "\"output_processes\"", "\"output_process\""),
            &["ProjectParameters.json:46:23 at /output_process", "did you mean \"output_processes\"?"],
        ),
        (
            "processes a list",
            |s| {
                s.replace(
                    PROJECT,
                    "\"output_processes\": {\n        \"energy\": [{",
                    "\"output_processes\": [{\n        \"x\": [{",
                )
                .replace(
                    PROJECT,
                    "\"MPM_Material\"}\n        }]\n    }",
                    "\"MPM_Material\"}\n        }]\n    }]",
                )
            },
            &["at /output_processes", "must be an object of lists of processes"],
        ),
        (
            "group no list",
            |s| {
                s.replace(PROJECT, "\"energy\": [{", "\"energy\": {").replace(
                    PROJECT,
                    "\"MPM_Material\"}\n        }]\n    }",
                    "\"MPM_Material\"}\n        }\n    }",
                )
            },
            &["at /output_processes/energy", "\"energy\" must be a list of processes"],
        ),
        (
            "modelers no list",
            |s| s.replace(PROJECT, "    \"processes\"", "    \"modelers\": {},\n    \"processes\""),
            &["at /modelers", "is an object, must be a list"],
        ),
        (
            "unknown modeler",
            |s| {
                s.replace(
                    PROJECT,
                    "    \"processes\"",
                    "    \"modelers\": [{\"name\": \"ImportMDPAModeller\", \"parameters\": {}}],\n    \"processes\"",
                )
            },
            &["at /modelers/0/name", "did you mean \"ImportMDPAModeler\"?"],
        ),
        (
            "kratos_exact a text",
            |s| s.replace(PROJECT, "    \"processes\"", "    \"kratos_exact\": \"yes\",\n    \"processes\""),
            &["at /kratos_exact", "is the text \"yes\", must be true or false"],
        ),
        (
            "stranger",
            |s| s.replace(PROJECT, "    \"processes\"", "    \"strange\": 1,\n    \"processes\""),
            &["ProjectParameters.json:24:16 at /strange", "the key \"strange\" is unknown"],
        ),
        (
            "old list no list",
            |s| s.replace(PROJECT, "    \"processes\"", "    \"loads_process_list\": {},\n    \"processes\""),
            &["at /loads_process_list", "must be a list"],
        ),
        (
            "old lists too",
            |s| s.replace(PROJECT, "    \"processes\"", "    \"loads_process_list\": [{}],\n    \"processes\""),
            &["lists of processes at the root cannot stand beside \"processes\""],
        ),
    ]);
}

#[test]
fn all_faults_of_the_project_come_together() {
    refuse(&[(
        "five",
        |s| {
            s.replace(PROJECT, "\"max_iteration\"", "\"max_iterations\"")
                .replace(PROJECT, "\"newmark\"", "\"newmarkk\"")
                .replace(PROJECT, "0.01}", "-1}")
                .replace(PROJECT, "\"DISPLACEMENT\"", "\"DISPLACEMNT\"")
                .replace(PROJECT, "mpm_write_energy_output_process", "mpm_write_energy_output")
        },
        &[
            "\"max_iterations\"",
            "\"newmarkk\"",
            "number -1",
            "DISPLACEMNT",
            "mpm_write_energy_output\"",
            "5 errors in the input; nothing was run or written.",
        ],
    )]);
}

#[test]
fn what_has_no_effect_is_told() {
    let known =
        Scene::base().replace(PROJECT, "    \"processes\"", "    \"print_output_process\": {},\n    \"processes\"");
    let known = known.command("check", &[]);
    assert_eq!(known.code, Some(0), "{}", known.stderr);
    assert!(known.words().contains("\"print_output_process\" has no effect in Bia"), "{}", known.stderr);
    let text = Scene::base().text(PROJECT);
    let without = format!("{}\"_x\": 0}}", &text[..text.find("\"processes\"").unwrap()]);
    let bare = Scene::base().write(PROJECT, without).command("check", &[]);
    assert_eq!(bare.code, Some(0), "{}", bare.stderr);
    assert!(bare.words().contains("no processes"), "{}", bare.stderr);
}
