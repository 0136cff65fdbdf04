//! Projects that need this application, through the same analysis as the program's.

use bia_extension::register;
use bia_extension::solver::TEMPERATURE;
use bia_kernel::analysis::Analysis;
use bia_kernel::error::Error;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use std::f64::consts::PI;
use std::path::Path;

fn prepare(folder: &Path, project: &str) -> Analysis {
    std::fs::write(folder.join("p.json"), project).unwrap();
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    register(&mut registry);
    let options = RunOptions { folder: folder.into(), output: folder.into(), kratos_exact: false };
    let document = Document::read(&folder.join("p.json")).unwrap();
    Analysis::prepare(document, &registry, options, false).map_err(|errors| errors.to_string()).unwrap()
}

/// A square of the law's fluid falls; the process stops it when it is too fast.
#[test]
fn the_law_and_the_process_take_part_in_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let project = r#"{
        "problem_data": {"end_time": 0.05},
        "modelers": [
            {"name": "RegularGridModeler", "parameters": {"min": [0, 0, 0], "max": [3, 3, 0], "divisions": [1, 1]}},
            {"name": "BodyModeler", "parameters": {"bodies": [{"name": "Body", "divisions": [1, 1],
                "primitive": {"type": "box", "min": [1, 1, 0], "max": [2, 2, 0]}}]}}],
        "solver_settings": {
            "solver_type": "dynamic", "scheme_type": "newmark", "domain_size": 2, "time_stepping": {"time_step": 0.01},
            "model_import_settings": {"input_type": "use_input_model_part"},
            "grid_model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": [{
                "model_part_name": "Initial_MPM_Material.Body", "properties_id": 1, "Material": {
                    "constitutive_law": {"name": "ElasticFluid2D"},
                    "Variables": {"DENSITY": 1000, "BULK_MODULUS": 1e6, "THICKNESS": 1,
                                  "MATERIAL_POINTS_PER_ELEMENT": 4}}}]}},
        "processes": {"list": [
            {"python_module": "assign_gravity_to_material_point_process",
             "Parameters": {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0, -1, 0]}},
            {"python_module": "speed_limit_process", "Parameters": {"limit": 0.25}}]}}"#;
    // After three steps of 0.01 s the speed is 0.2943 m/s.
    let Err(Error::Failure(failure)) = prepare(folder.path(), project).run(&mut (), None) else {
        panic!("the limit was passed unseen")
    };
    let message = failure.to_string();
    assert!(message.contains("a speed of 0.2943") && message.contains("step 3"), "{message}");
}

/// Heat conduction on a grid of the unit square or cube.
fn heat(max: &str, divisions: &str, shape: &str, more: &str, ends: &[(&str, &str)]) -> String {
    let dimension = divisions.split(',').count();
    let held: Vec<String> = ends
        .iter()
        .map(|(part, value)| {
            format!(
                r#"{{"python_module": "assign_scalar_variable_process", "Parameters": {{"model_part_name": "Solid.{part}",
                    "variable_name": "TEMPERATURE", "constrained": true, "value": {value}}}}}"#
            )
        })
        .collect();
    format!(
        r#"{{"problem_data": {{"end_time": 0.1}},
            "modelers": [{{"name": "RegularGridModeler", "parameters": {{"model_part_name": "Solid", "min": [0, 0, 0],
                "max": {max}, "divisions": [{divisions}], "element_name": "HeatElement{shape}",
                "shape": "{}", "parts": [{{"name": "Left", "side": "min_x"}}, {{"name": "Right", "side": "max_x"}}]}}}}],
            "solver_settings": {{"solver_type": "heat", "domain_size": {dimension}, "time_stepping": {{"time_step": 0.1}},
                "model_import_settings": {{"input_type": "use_input_model_part"}}, {more}}},
            "processes": {{"list": [{}]}}}}"#,
        match shape {
            "2D3N" => "triangle",
            "2D4N" => "quadrilateral",
            "3D4N" => "tetrahedron",
            _ => "hexahedron",
        },
        held.join(",")
    )
}

/// Places and temperatures at the end.
fn temperatures(project: &str) -> Vec<([f64; 3], f64)> {
    let folder = tempfile::tempdir().unwrap();
    let mut analysis = prepare(folder.path(), project);
    analysis.run(&mut (), None).map_err(|error| error.to_string()).unwrap();
    let part = analysis.model.part("Solid").unwrap();
    part.nodes.coordinates.iter().copied().zip(part.node_fields.scalar(&TEMPERATURE).unwrap().to_vec()).collect()
}

/// Between two temperatures the steady field is linear, which every element holds exactly (patch test).
#[test]
fn steady_heat_is_linear() {
    for (max, divisions, shape) in [
        ("[1, 1, 0]", "3, 2", "2D3N"),
        ("[1, 1, 0]", "3, 2", "2D4N"),
        ("[1, 1, 1]", "3, 2, 2", "3D4N"),
        ("[1, 1, 1]", "3, 2, 2", "3D8N"),
    ] {
        let ends = [("Left", "300"), ("Right", "400")];
        for (x, temperature) in temperatures(&heat(max, divisions, shape, r#""conductivity": 45.0"#, &ends)) {
            assert!((temperature - 300.0 - 100.0 * x[0]).abs() < 1e-10, "{shape}: {temperature} at {x:?}");
        }
    }
}

/// A wall at 1 K whose faces are held at 0: after a while its middle cools as (4/π) exp(−π² k t/(c L²)).
#[test]
fn a_wall_cools_with_its_first_mode() {
    let more = r#""conductivity": 2.0, "heat_capacity": 2.0, "initial_temperature": 1.0"#;
    let project = heat("[1, 1, 0]", "40, 1", "2D4N", more, &[("Left", "0"), ("Right", "0")]);
    let middle = |step: f64| {
        let project = project.replace("\"time_step\": 0.1", &format!("\"time_step\": {step}"));
        let all = temperatures(&project);
        all.iter().find(|(x, _)| (x[0] - 0.5).abs() < 1e-9).unwrap().1
    };
    let exact = 4.0 / PI * (-PI * PI * 0.1f64).exp();
    let errors = [0.004, 0.002].map(|step| middle(step) - exact);
    // Without the error of the steps, (λ² t/2) Δt for the decay rate λ, that of the mesh is left.
    assert!((2.0 * errors[1] - errors[0]).abs() < 2e-3 * exact, "{errors:?}");
    assert!((errors[0] / errors[1] - 2.0).abs() < 0.3, "first order in time: {errors:?}");
}

/// Keys, variables and names from outside are checked as those from inside.
#[test]
fn outside_keys_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let project = heat("[1, 1, 0]", "1, 1", "2D4N", r#""conductvity": 1.0"#, &[]);
    std::fs::write(folder.path().join("p.json"), project).unwrap();
    let mut registry = Registry::with_kernel();
    register(&mut registry);
    let options = RunOptions { folder: folder.path().into(), output: folder.path().into(), kratos_exact: false };
    let document = Document::read(&folder.path().join("p.json")).unwrap();
    let Err(errors) = Analysis::prepare(document, &registry, options, false) else { panic!("the slip was not seen") };
    assert!(errors.to_string().contains("did you mean \"conductivity\""), "{errors}");
}
