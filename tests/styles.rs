//! The same scene written in the ways that Kratos projects are written must give the same bits.

mod common;

use common::run_project;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

const NAME: &str = "imp_newmark_quad4";

/// A copy of the case: its folder, project and materials, to be changed and run.
struct Copy {
    case: &'static str,
    folder: tempfile::TempDir,
    project: Value,
    materials: Value,
}

impl Copy {
    fn new() -> Self {
        Self::of(NAME)
    }

    fn of(case: &'static str) -> Self {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kratos").join(case);
        let read = |name: &str| serde_json::from_slice(&fs::read(source.join(name)).unwrap()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for name in [format!("{case}_Grid.mdpa"), format!("{case}_Body.mdpa")] {
            fs::copy(source.join(&name), folder.path().join(&name)).unwrap();
        }
        Self { case, folder, project: read("ProjectParameters.json"), materials: read("ParticleMaterials.json") }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Changes the text of a mesh file.
    fn edit(&self, name: &str, change: impl Fn(&str) -> String) {
        let path = self.file(&format!("{}_{name}.mdpa", self.case));
        fs::write(&path, change(&fs::read_to_string(&path).unwrap())).unwrap();
    }

    /// Runs it and returns its last state.
    fn run(&self) -> Value {
        fs::write(self.file("ProjectParameters.json"), self.project.to_string()).unwrap();
        fs::write(self.file("ParticleMaterials.json"), self.materials.to_string()).unwrap();
        let record = run_project(self.folder.path(), &["--record-states", "1"]);
        let last = record.last();
        json!({"x": last.points("MP_COORD"), "v": last.points("MP_VELOCITY"),
               "stress": last.points("MP_CAUCHY_STRESS_VECTOR"), "u": last.nodes("DISPLACEMENT"), "t": last.time()})
    }
}

#[test]
fn modelers_and_geometries() {
    let plain = Copy::new().run();
    let mut copy = Copy::new();
    for (name, element) in [("Grid", "Element2D4N"), ("Body", "MPMUpdatedLagrangian2D4N")] {
        copy.edit(name, |text| {
            let (begin, end) = (format!("Begin Elements {element}"), "End Elements");
            let (before, rest) = text.split_once(&begin).unwrap();
            let (rows, after) = rest.split_once(end).unwrap();
            let without_properties = |row: &str| {
                let words: Vec<&str> = row.split_whitespace().collect();
                if words.len() == 6 { [&words[..1], &words[2..]].concat().join(" ") } else { row.into() }
            };
            let rows: Vec<String> = rows.lines().map(without_properties).collect();
            format!("{before}Begin Geometries Quadrilateral2D4{}\nEnd Geometries{after}", rows.join("\n"))
                .replace("SubModelPartElements", "SubModelPartGeometries")
        });
    }
    for key in ["model_import_settings", "grid_model_import_settings"] {
        copy.project["solver_settings"][key] = json!({"input_type": "use_input_model_part"});
    }
    let import = |part: &str, name: &str| {
        json!({"name": "Modelers.KratosMultiphysics.ImportMDPAModeler",
               "parameters": {"input_filename": format!("{NAME}_{name}"), "model_part_name": part}})
    };
    copy.project["modelers"] = json!([
        import("Background_Grid", "Grid"),
        import("Initial_MPM_Material", "Body"),
        {"name": "Modelers.KratosMultiphysics.CreateEntitiesFromGeometriesModeler", "parameters": {"elements_list": [
            {"model_part_name": "Background_Grid.Parts_grid", "element_name": "Element2D4N"},
            {"model_part_name": "Initial_MPM_Material.Parts_body", "element_name": "MPMUpdatedLagrangian2D4N"}]}}
    ]);
    assert_eq!(copy.run(), plain);
}

#[test]
fn lists_at_the_root_and_names_of_old() {
    let plain = Copy::new().run();
    let mut copy = Copy::new();
    let processes = copy.project.as_object_mut().unwrap().remove("processes").unwrap();
    copy.project["constraints_process_list"] = processes["constraints_process_list"].clone();
    let mut gravity = processes["gravity"].clone();
    gravity[0]["python_module"] = json!("assign_gravity_to_particle_process");
    gravity[0]["kratos_module"] = json!("KratosMultiphysics.ParticleMechanicsApplication");
    copy.project["gravity"] = gravity;
    copy.project["list_other_processes"] = processes["initial_conditions_processes"].clone();
    let variables = copy.materials["properties"][0]["Material"]["Variables"].as_object_mut().unwrap();
    let points = variables.remove("MATERIAL_POINTS_PER_ELEMENT").unwrap();
    variables.insert("PARTICLES_PER_ELEMENT".into(), points);
    let law = &mut copy.materials["properties"][0]["Material"]["constitutive_law"]["name"];
    *law = json!(format!("KratosMultiphysics.MPMApplication.{}", law.as_str().unwrap()));
    copy.edit("Body", |text| text.replace("MPMUpdatedLagrangian2D4N", "UpdatedLagrangian2D4N"));
    assert_eq!(copy.run(), plain);
}

#[test]
fn supports_by_component_by_direction_and_in_the_mesh_file() {
    let plain = Copy::new().run();
    let floor = "Background_Grid.DISPLACEMENT_floor";
    let process = |module: &str, parameters: Value| json!({"python_module": module, "Parameters": parameters});

    let mut by_component = Copy::new();
    let component = |axis: &str| {
        let variable = format!("DISPLACEMENT_{axis}");
        process(
            "assign_scalar_variable_process",
            json!({"model_part_name": floor, "variable_name": variable, "value": "0*t"}),
        )
    };
    by_component.project["processes"]["constraints_process_list"] = json!([component("X"), component("Y")]);
    assert_eq!(by_component.run(), plain, "by component");

    let mut by_direction = Copy::new();
    by_direction.project["processes"]["constraints_process_list"] = json!([process(
        "assign_vector_by_direction_process",
        json!({"model_part_name": floor, "variable_name": "DISPLACEMENT", "modulus": 0.0, "direction": [0, 3, 0]}),
    )]);
    assert_eq!(by_direction.run(), plain, "by direction");

    // Kratos's fix processes take no value and leave what is there, here what another process assigned.
    let rising = |fixes: Option<Value>| {
        let mut copy = Copy::new();
        let value = json!([null, 1e-3, null]);
        let parameters = json!({"model_part_name": floor, "variable_name": "DISPLACEMENT", "value": value,
                                "constrained": [fixes.is_none(), fixes.is_none(), false]});
        let fixed = |axis: &str| {
            let parameters = json!({"model_part_name": floor, "variable_name": format!("DISPLACEMENT_{axis}")});
            process("fix_scalar_variable_process", parameters)
        };
        copy.project["processes"]["constraints_process_list"] = Value::from_iter(
            [process("assign_vector_variable_process", parameters), fixed("X")].into_iter().chain(fixes),
        );
        copy.run()
    };
    let parameters =
        json!({"model_part_name": floor, "variable_name": "DISPLACEMENT", "constrained": [false, true, false]});
    let by_fixing = rising(Some(process("fix_vector_variable_process", parameters)));
    let at_once = rising(None);
    assert!(by_fixing == at_once && at_once != plain, "fixed as it is");

    let mut in_file = Copy::new();
    in_file.project["processes"]["constraints_process_list"] = json!([]);
    in_file.edit("Grid", |text| {
        let part = text.split_once("Begin SubModelPart DISPLACEMENT_floor").unwrap().1;
        let nodes =
            part.split_once("Begin SubModelPartNodes").unwrap().1.split_once("End SubModelPartNodes").unwrap().0;
        let rows: Vec<String> = nodes.split_whitespace().map(|id| format!("{id} 1 0.0")).collect();
        let block = |axis: &str| format!("Begin NodalData DISPLACEMENT_{axis}\n{}\nEnd NodalData\n", rows.join("\n"));
        format!("{text}\n{}{}", block("X"), block("Y"))
    });
    assert_eq!(in_file.run(), plain, "in the mesh file");
}

/// A load per length on conditions that move with a free body gives it the impulse force × time.
#[test]
fn line_load_on_material_point_conditions() {
    let mut copy = Copy::new();
    // Two lines inside the body, 0.6 m long together.
    copy.edit("Grid", |text| {
        format!(
            "{}\nBegin Nodes\n 9001 0.6 0.7 0.0\n 9002 0.8 0.7 0.0\n 9003 1.2 0.7 0.0\nEnd Nodes\n\
             Begin Conditions LineCondition2D2N\n 1 0 9001 9002\n 2 0 9002 9003\nEnd Conditions\n\
             Begin SubModelPart Edge\nBegin SubModelPartNodes\n9001\n9002\n9003\nEnd SubModelPartNodes\n\
             Begin SubModelPartConditions\n1\n2\nEnd SubModelPartConditions\nEnd SubModelPart\n",
            text.trim_end()
        )
    });
    let load = |count: usize, even: bool| {
        json!([{"python_module": "apply_mpm_particle_neumann_condition_process",
                "Parameters": {"model_part_name": "Background_Grid.Edge", "variable_name": "LINE_LOAD",
                               "material_points_per_condition": count, "is_equal_distributed": even,
                               "modulus": 50.0, "direction": [1.0, 0.0, 0.0]}}])
    };
    copy.project["processes"] = json!({});
    copy.project["problem_data"]["end_time"] = json!(0.0999);
    for (count, even) in [(1, false), (3, false), (2, true)] {
        copy.project["processes"]["loads"] = load(count, even);
        fs::write(copy.file("ProjectParameters.json"), copy.project.to_string()).unwrap();
        fs::write(copy.file("ParticleMaterials.json"), copy.materials.to_string()).unwrap();
        let record = run_project(copy.folder.path(), &["--record-states", "1"]);
        // Newmark's trapezoidal rule starts from rest without acceleration: half a step is missing.
        let step = 0.01;
        let impulse = 50.0 * 0.6 * (record.last().time() - 0.5 * step);
        let momentum = record.last().total("momentum");
        let error = (momentum[0] - impulse).abs() / impulse;
        assert!(error < 1e-9 && momentum[1].abs() < 1e-9 * impulse, "{count} {even}: {momentum:?}, impulse {impulse}");
    }
}

/// A condition that stands in two parts is one load.
#[test]
fn a_load_in_two_parts_acts_once() {
    let plain = Copy::of("cond_grid_pressure_quad4").run();
    let copy = Copy::of("cond_grid_pressure_quad4");
    copy.edit("Grid", |text| {
        let rows = |part: &str| part.split("End SubModelPartConditions").next().unwrap_or("").trim().to_string();
        let lists = text.split("Begin SubModelPartConditions").skip(1).map(rows);
        let list = lists.filter(|rows| !rows.is_empty()).last().unwrap();
        format!("{}\nBegin SubModelPart Again\nBegin SubModelPartConditions\n{list}\nEnd SubModelPartConditions\nEnd SubModelPart\n", text.trim_end())
    });
    assert_eq!(copy.run(), plain);
}

/// Body accelerations add up, and one whose time is over takes nothing from another.
#[test]
fn body_accelerations_add_up() {
    let force = |value: f64, interval: [f64; 2]| {
        json!({"python_module": "assign_body_acceleration_to_material_point_process",
               "Parameters": {"model_part_name": "MPM_Material", "value": [value, 0.0, 0.0], "interval": interval}})
    };
    let run = |forces: Value| {
        let mut copy = Copy::new();
        copy.project["processes"] = json!({"forces": forces});
        copy.run()
    };
    let whole = run(json!([force(2.0, [0.0, 1.0])]));
    assert_eq!(run(json!([force(2.0, [0.0, 0.1]), force(2.0, [0.105, 1.0])])), whole, "one after the other");
    assert_eq!(run(json!([force(0.5, [0.0, 1.0]), force(1.5, [0.0, 1.0])])), whole, "together");
}
