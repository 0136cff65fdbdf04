//! A scene whose grid and body Gmsh wrote: a block of tetrahedra stands on its clamped base under its own weight.

use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

const DENSITY: f64 = 2000.0;
const GRAVITY: f64 = 10.0;

#[test]
fn a_block_of_gmsh_rests_on_its_base() {
    for form in ["2.2_text", "4.1_binary"] {
        let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/gmsh/block_{form}.msh"));
        let source = json!({"input_type": "gmsh", "input_filename": mesh});
        let project = json!({
            "problem_data": {"end_time": 1.0},
            "modelers": [{"name": "ImportGmshModeler", "parameters": {"input_filename": mesh,
                "model_part_name": "Background_Grid"}}],
            "solver_settings": {
                "solver_type": "static", "domain_size": 3, "time_stepping": {"time_step": 1.0}, "compute_reactions": true,
                "residual_relative_tolerance": 1e-12, "residual_absolute_tolerance": 0.0, "max_iteration": 30,
                "model_import_settings": source, "grid_model_import_settings": {"input_type": "use_input_model_part"},
                "material_import_settings": {"materials": [{
                    "model_part_name": "Initial_MPM_Material.Block", "properties_id": 1, "Material": {
                        "constitutive_law": {"name": "HyperElasticNeoHookean3DLaw"},
                        "Variables": {"DENSITY": DENSITY, "YOUNG_MODULUS": 1e7, "POISSON_RATIO": 0.3,
                                      "MATERIAL_POINTS_PER_ELEMENT": 4}}}]}},
            "processes": {
                "supports": [{"python_module": "assign_vector_variable_process", "Parameters": {
                    "model_part_name": "Background_Grid.Base", "variable_name": "DISPLACEMENT",
                    "constrained": [true, true, true], "value": [0, 0, 0]}}],
                "gravity": [{"python_module": "assign_gravity_to_material_point_process", "Parameters": {
                    "model_part_name": "MPM_Material", "modulus": GRAVITY, "direction": [0, 0, -1]}}]}});
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ProjectParameters.json");
        std::fs::write(&file, project.to_string()).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
        command.current_dir(folder.path()).args(["run", "ProjectParameters.json", "--quiet", "--record", "r.json"]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(folder.path().join("r.json")).unwrap();
        let record: Value = serde_json::from_str(&text).unwrap();
        let last = record["snapshots"].as_array().unwrap().last().unwrap();
        assert_eq!(last["n_mp"], 4 * 91);
        let volume = last["sums"]["mass"].as_f64().unwrap() / DENSITY;
        assert!((volume - 2.0).abs() < 1e-12, "{volume}");
        let reactions = last["nodes"]["REACTION"].as_array().unwrap();
        let support: f64 = reactions.iter().map(|r| r[2].as_f64().unwrap()).sum();
        let weight = volume * DENSITY * GRAVITY;
        assert!((support / weight - 1.0).abs() < 1e-10, "{support} of {weight}");
    }
}
