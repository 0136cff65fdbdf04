//! The good scene whose files the targets replace: a square on a grid of one cell.

use bia_kernel::analysis::Analysis;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use std::sync::OnceLock;
use tempfile::TempDir;

pub const PROJECT: &str = r#"{
    "problem_data": {"end_time": 0.02},
    "solver_settings": {
        "solver_type": "dynamic", "domain_size": 2, "time_stepping": {"time_step": 0.01},
        "model_import_settings": {"input_filename": "Body"},
        "grid_model_import_settings": {"input_filename": "Grid"},
        "material_import_settings": {"materials_filename": "Materials.json"}
    },
    "processes": {"loads": [{
        "python_module": "assign_vector_variable_process",
        "Parameters": {"model_part_name": "Background_Grid", "variable_name": "DISPLACEMENT",
            "value": [0.0, {"name": "csv_table", "filename": "table.csv"}, null]}
    }]}
}"#;
const MATERIALS: &str = r#"{"properties": [{
    "model_part_name": "Initial_MPM_Material.Body", "properties_id": 1,
    "Material": {"constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"}, "Variables": {
        "THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 4, "DENSITY": 1e3, "YOUNG_MODULUS": 1e6, "POISSON_RATIO": 0.3}}
}]}"#;
const NODES: &str = "Begin Properties 0\nEnd Properties\nBegin Nodes\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\nEnd Nodes\n";

/// Reads the good scene with one file that is not; whatever it holds, the answer is a scene or a list of faults.
pub fn read_with(file: &str, content: &[u8]) {
    static SCENE: OnceLock<(TempDir, Registry)> = OnceLock::new();
    let (folder, registry) = SCENE.get_or_init(|| {
        let mut registry = Registry::with_kernel();
        bia_mpm::register(&mut registry);
        (TempDir::new().expect("a folder for the scene"), registry)
    });
    let body = format!(
        "{NODES}Begin Elements MPMUpdatedLagrangian2D4N\n1 0 1 2 3 4\nEnd Elements\n\
         Begin SubModelPart Body\nBegin SubModelPartElements\n1\nEnd SubModelPartElements\nEnd SubModelPart\n"
    );
    let grid = format!("{NODES}Begin Elements Element2D4N\n1 0 1 2 3 4\nEnd Elements\n");
    let files = [("Project.json", PROJECT), ("Materials.json", MATERIALS), ("Body.mdpa", &body), ("Grid.mdpa", &grid)];
    for (name, good) in files.into_iter().chain([("table.csv", "0, 0\n1, 1\n")]) {
        let content = if name == file { content } else { good.as_bytes() };
        std::fs::write(folder.path().join(name), content).expect("a file of the scene");
    }
    let options = RunOptions { folder: folder.path().into(), output: folder.path().join("out"), kratos_exact: false };
    let read = Document::read(&folder.path().join("Project.json"))
        .and_then(|document| Analysis::prepare(document, registry, options, false));
    if let Err(errors) = read {
        assert!(errors.any_error());
    }
}
