//! Faults of `solver_settings`.

use super::base::{PROJECT, refuse};

/// Names and kinds of the members.
#[test]
fn members() {
    refuse(&[
        (
            "key",
            |s| s.replace(PROJECT, "\"max_iteration\"", "\"max_iterations\""),
            &[
                "ProjectParameters.json:17:27 at /solver_settings/max_iterations",
                "the key \"max_iterations\" is unknown",
                "did you mean \"max_iteration\"?",
            ],
        ),
        (
            "wrong type",
            |s| s.replace(PROJECT, "\"max_iteration\": 20", "\"max_iteration\": \"20\""),
            &["at /solver_settings/max_iteration", "is the text \"20\"", "a whole number of at least 1"],
        ),
        (
            "fraction",
            |s| s.replace(PROJECT, "\"max_iteration\": 20", "\"max_iteration\": 2.5"),
            &["is the number 2.5", "a whole number of at least 1"],
        ),
        (
            "solver type",
            |s| s.replace(PROJECT, "\"dynamic\"", "\"dynamicc\""),
            &[
                "at /solver_settings/solver_type",
                "there is no solver type \"dynamicc\"",
                "did you mean \"dynamic\"?",
                "static, quasi_static, dynamic",
            ],
        ),
        (
            "no solver type",
            |s| s.replace(PROJECT, "\"solver_type\": \"dynamic\",", ""),
            &["at /solver_settings", "\"solver_type\" is missing", "static, quasi_static, dynamic"],
        ),
        (
            "no domain size",
            |s| s.replace(PROJECT, "\"domain_size\": 2,", ""),
            &["\"domain_size\" is missing", "2 or 3"],
        ),
        (
            "domain size 3",
            |s| s.replace(PROJECT, "\"domain_size\": 2", "\"domain_size\": 3"),
            &[
                "ProjectParameters.json:12:24 at /solver_settings/domain_size",
                "is 3, but grid element 1 is a Element2D4N",
            ],
        ),
        (
            "domain size 4",
            |s| s.replace(PROJECT, "\"domain_size\": 2", "\"domain_size\": 4"),
            &["is 4, must be 1, 2 or 3"],
        ),
        (
            "settings a text",
            |s| {
                let text = s.text(PROJECT);
                let (a, b) = (text.find("\"solver_settings\"").unwrap(), text.find("    \"processes\"").unwrap());
                s.write(PROJECT, format!("{}\"solver_settings\": \"dynamic\",\n{}", &text[..a], &text[b..]))
            },
            &["at /solver_settings", "is the text \"dynamic\", must be an object"],
        ),
        (
            "both names of a key",
            |s| {
                s.replace(
                    PROJECT,
                    "\"model_import_settings\": {",
                    "\"initial_model_import_settings\": {\"input_filename\": \"Body\"}, \"model_import_settings\": {",
                )
            },
            &["\"model_import_settings\" and its older name \"initial_model_import_settings\" are both given"],
        ),
    ]);
}

/// Choices that do not exist or do not go together.
#[test]
fn methods() {
    refuse(&[
        (
            "scheme",
            |s| s.replace(PROJECT, "\"newmark\"", "\"newmarkk\""),
            &["at /solver_settings/scheme_type", "did you mean \"newmark\"?", "bossak"],
        ),
        (
            "explicit",
            |s| s.replace(PROJECT, "\"scheme_type\"", "\"time_integration_method\": \"explicit\", \"scheme_type\""),
            &["at /solver_settings/scheme_type", "\"newmark\" is no explicit scheme", "central_difference"],
        ),
        (
            "implicit",
            |s| s.replace(PROJECT, "\"newmark\"", "\"forward_euler\""),
            &["at /solver_settings/scheme_type", "is no implicit scheme", "time_integration_method"],
        ),
        (
            "partitioned quadrature",
            |s| s.replace(PROJECT, "\"newmark\"", "\"newmark\", \"is_pqmpm\": true"),
            &["at /solver_settings/is_pqmpm", "not part of this build"],
        ),
        (
            "automatic step of an implicit run",
            |s| s.replace(PROJECT, "0.01}", "\"auto\"}"),
            &["/time_stepping/time_step", "\"auto\" is for explicit runs"],
        ),
        (
            "frozen volume",
            |s| {
                let explicit = "\"time_integration_method\": \"explicit\", \"compressible\": false";
                s.replace(PROJECT, "\"scheme_type\": \"newmark\"", explicit)
            },
            &["at /solver_settings/compressible", "takes its stress from the deformation gradient"],
        ),
        (
            "criterion",
            |s| s.replace(PROJECT, "\"residual_criterion\"", "\"residual\""),
            &["at /solver_settings/convergence_criterion", "residual_criterion, displacement_criterion"],
        ),
        (
            "axisymmetric in space",
            |s| {
                s.replace(PROJECT, "\"domain_size\": 2", "\"domain_size\": 3").replace(
                    PROJECT,
                    "\"axis_symmetric_flag\": false",
                    "\"axis_symmetric_flag\": true",
                )
            },
            &["at /solver_settings/axis_symmetric_flag", "needs domain_size 2"],
        ),
        (
            "pressure_dofs",
            |s| s.replace(PROJECT, "\"pressure_dofs\": false", "\"pressure_dofs\": true"),
            &["has no nodal pressure", "set \"pressure_dofs\" to false", "HyperElasticNeoHookeanPlaneStrainUP2DLaw"],
        ),
        (
            "stabilization",
            |s| s.replace(PROJECT, "\"ppp\"", "\"pppp\""),
            &["at /solver_settings/stabilization", "did you mean \"ppp\"?"],
        ),
    ]);
}

#[test]
fn linear_solvers() {
    refuse(&[
        (
            "linear solver",
            |s| s.replace(PROJECT, "sparse_lu", "sparse_lo"),
            &["at /solver_settings/linear_solver_settings/solver_type", "did you mean \"sparse_lu\"?"],
        ),
        (
            "linear solver a text",
            |s| s.replace(PROJECT, "{\"solver_type\": \"LinearSolversApplication.sparse_lu\"}", "\"amgcl\""),
            &["at /solver_settings/linear_solver_settings", "is the text \"amgcl\", must be an object"],
        ),
        (
            "linear solver key",
            |s| s.replace(PROJECT, "sparse_lu\"", "sparse_lu\", \"tolerence\": 1"),
            &["did you mean \"tolerance\"?"],
        ),
    ]);
}

#[test]
fn time_steps() {
    refuse(&[
        (
            "no time step",
            |s| s.replace(PROJECT, "{\"time_step\": 0.01}", "{}"),
            &["at /solver_settings/time_stepping", "neither \"time_step\" nor \"time_step_table\""],
        ),
        (
            "negative time step",
            |s| s.replace(PROJECT, "0.01}", "-0.01}"),
            &[
                "ProjectParameters.json:18:40 at /solver_settings/time_stepping/time_step",
                "is the number -0.01",
                "above 0",
            ],
        ),
        ("zero time step", |s| s.replace(PROJECT, "0.01}", "0}"), &["/time_step", "is the number 0", "above 0"]),
        (
            "step that vanishes",
            |s| s.replace(PROJECT, "0.01}", "1e-20}"),
            &["at /solver_settings/time_stepping", "the time step 1e-20 does not advance the time 0.02"],
        ),
        (
            "two steps",
            |s| s.replace(PROJECT, "0.01}", "0.01, \"time_step_table\": [[0, 1], [1, 1]]}"),
            &["at /solver_settings/time_stepping", "both \"time_step\" and \"time_step_table\""],
        ),
        (
            "bad table",
            |s| s.replace(PROJECT, "\"time_step\": 0.01}", "\"time_step_table\": [[0, 0.01], [1, -1]]}"),
            &["at /solver_settings/time_stepping/time_step_table/1", "must be a pair [time, time step]"],
        ),
        (
            "falling table",
            |s| s.replace(PROJECT, "\"time_step\": 0.01}", "\"time_step_table\": [[1, 0.01], [1, 0.02]]}"),
            &["at /solver_settings/time_stepping/time_step_table"],
        ),
        (
            "table dies out",
            |s| s.replace(PROJECT, "\"time_step\": 0.01}", "\"time_step_table\": [[0, 0.01], [0.01, 1e-30]]}"),
            &["/solver_settings/time_stepping", "does not advance the time 0.02"],
        ),
    ]);
}

#[test]
fn meshes() {
    refuse(&[
        (
            "no grid",
            |s| {
                s.replace(
                    PROJECT,
                    "\"grid_model_import_settings\": {\"input_type\": \"mdpa\", \"input_filename\": \"Grid\"},",
                    "",
                )
            },
            &["\"input_filename\" is missing", "/grid_model_import_settings"],
        ),
        (
            "modeler without",
            |s| {
                s.replace(
                    PROJECT,
                    "\"input_type\": \"mdpa\", \"input_filename\": \"Grid\"",
                    "\"input_type\": \"use_input_model_part\"",
                )
            },
            &["at /solver_settings/grid_model_import_settings", "no modeler makes the model part \"Background_Grid\""],
        ),
    ]);
}
