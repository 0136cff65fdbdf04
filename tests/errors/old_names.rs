//! Old names of processes, keys and variables are taken and told, each once, with the present one.

use super::base::{MATERIALS, PROJECT, Scene};

fn aged() -> Scene {
    let output = |name: &str| {
        format!(
            "{{\"python_module\": \"mpm_vtk_output_process\", \"Parameters\": {{\"model_part_name\": \"MPM_Material\", \
             \"folder_name\": \"{name}\", \"output_interval\": 1.0}}}}, "
        )
    };
    let first = "\"energy\": [";
    Scene::base()
        .replace(PROJECT, "assign_gravity_to_material_point_process", "assign_gravity_to_particle_process")
        .replace(PROJECT, "\"model_import_settings\"", "\"initial_model_import_settings\"")
        .replace(PROJECT, first, &format!("{first}{}{}", output("a"), output("b")))
        .replace(MATERIALS, "MATERIAL_POINTS_PER_ELEMENT", "PARTICLES_PER_ELEMENT")
}

#[test]
fn old_names_are_taken_and_told_once() {
    let outcome = aged().run(&[]);
    let words = outcome.words();
    assert_eq!(outcome.code, Some(0), "{words}");
    let says = [
        "/processes/gravity/0/python_module: \"assign_gravity_to_particle_process\" is an old name of \
         \"assign_gravity_to_material_point_process\"",
        "/solver_settings/initial_model_import_settings: \"initial_model_import_settings\" is an old name of \
         \"model_import_settings\"",
        "/output_processes/energy/0/Parameters/folder_name: \"folder_name\" is an old name of \"output_path\", here and \
         at 1 more place",
        "/properties/0/Material/Variables/PARTICLES_PER_ELEMENT: \"PARTICLES_PER_ELEMENT\" is an old name of \
         \"MATERIAL_POINTS_PER_ELEMENT\"",
    ];
    for says in says {
        assert_eq!(words.matches(says).count(), 1, "{says:?} in\n{words}");
    }
    assert_eq!(words.matches("old name").count(), says.len(), "{words}");
}

/// Who repeats Kratos reads its warnings there.
#[test]
fn present_names_and_repeated_runs_of_kratos_are_told_nothing() {
    for (scene, arguments) in
        [(Scene::base(), &[][..]), (aged().replace(MATERIALS, "PARTICLES", "MATERIAL_POINTS"), &["--kratos-exact"])]
    {
        let outcome = scene.run(arguments);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert!(!outcome.words().contains("old name"), "{}", outcome.stderr);
    }
}
