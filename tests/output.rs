//! Result files: what a run writes is read back and compared with what must be true.

mod common;

use common::{Cell, Mesh, Scene, fix, gravity, material, process};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;
use vtkio::model::{Attribute, Attributes, DataSet, Piece, UnstructuredGridPiece};

const GRAVITY: f64 = 10.0;
const DENSITY: f64 = 1000.0;
const SPEED: f64 = 2.0;

/// A 1 m square in the middle of a free grid of 4 m by 8 m: it rises at first, then falls.
fn free_fall(end_time: f64) -> Scene {
    let grid = Mesh::block(Cell::Quadrilateral, [8, 16, 0], [0.0; 3], [4.0, 8.0, 0.0]);
    let body = Mesh::block(Cell::Quadrilateral, [2, 2, 0], [1.5, 3.5, 0.0], [2.5, 4.5, 0.0]);
    let law = material("LinearElasticIsotropicPlaneStrain2DLaw", 4, DENSITY, 1e6, 0.3);
    let solver = json!({"solver_type": "dynamic", "time_integration_method": "implicit", "scheme_type": "newmark",
                        "time_stepping": {"time_step": 0.01}, "compute_reactions": true});
    let velocity = json!({"model_part_name": "MPM_Material", "modulus": SPEED, "direction": [0.0, 1.0, 0.0]});
    Scene::new(grid, body, law, solver, end_time)
        .part("Floor", |x| x[1] == 0.0)
        .with(fix("Floor", json!([0.0, 0.0, 0.0])))
        .with(gravity([0.0, -GRAVITY, 0.0]))
        .with(process("assign_initial_velocity_to_material_point_process", velocity))
}

/// Writes the scene with output processes to a new folder.
fn write(scene: &Scene, outputs: &[Value]) -> TempDir {
    let folder = TempDir::new().unwrap();
    scene.write(folder.path());
    let path = folder.path().join("ProjectParameters.json");
    let mut project: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    project["output_processes"] = json!({"list": outputs});
    std::fs::write(path, project.to_string()).unwrap();
    folder
}

fn bia(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder).args(["run", "ProjectParameters.json", "--quiet", "--threads", "1"]);
    command.args(arguments).output().expect("the built program starts")
}

fn runs(folder: &Path, arguments: &[&str]) {
    let output = bia(folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The run must end with this exit code; returns what it says, without line breaks.
fn fails(folder: &Path, code: i32) -> String {
    let output = bia(folder, &[]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A legacy VTK file of one piece.
struct VtkFile(UnstructuredGridPiece);

impl VtkFile {
    fn read(path: PathBuf) -> Self {
        let vtk = vtkio::Vtk::import(&path).unwrap_or_else(|error| panic!("{}: {error:?}", path.display()));
        let DataSet::UnstructuredGrid { mut pieces, .. } = vtk.data else { panic!("{} is no grid", path.display()) };
        let Some(Piece::Inline(piece)) = pieces.pop() else { panic!("{} has no piece", path.display()) };
        Self(*piece)
    }

    fn points(&self) -> Vec<[f64; 3]> {
        let numbers: Vec<f64> = self.0.points.cast_into().expect("numbers");
        numbers.chunks(3).map(|x| [x[0], x[1], x[2]]).collect()
    }

    /// The values of a field on points or on cells.
    fn field(&self, name: &str) -> Vec<f64> {
        let Attributes { point, cell } = &self.0.data;
        for attribute in point.iter().chain(cell) {
            match attribute {
                Attribute::DataArray(array) if array.name == name => return array.data.cast_into().expect("numbers"),
                Attribute::Field { data_array, .. } => {
                    if let Some(array) = data_array.iter().find(|array| array.name == name) {
                        return array.data.cast_into().expect("numbers");
                    }
                }
                _ => {}
            }
        }
        panic!("there is no field {name}")
    }
}

fn points_output(parameters: Value) -> Value {
    let mut all = json!({"model_part_name": "MPM_Material", "output_interval": 10,
                         "gauss_point_variables_in_elements": ["MP_VELOCITY", "MP_MASS"]});
    all.as_object_mut().unwrap().extend(parameters.as_object().unwrap().clone());
    process("mpm_vtk_output_process", all)
}

/// Compares positions and velocities with those of a free fall, up to single precision: Newmark's
/// rule with beta 1/4 is exact for constant acceleration.
fn check_free_fall(folder: &Path) {
    let accuracy = 2e-7;
    let start = VtkFile::read(folder.join("MPM_Material_0_0.vtk")).points();
    assert_eq!(start.len(), 16);
    for step in [10, 20, 30] {
        let file = VtkFile::read(folder.join(format!("MPM_Material_0_{step}.vtk")));
        let time = 0.01 * f64::from(step);
        let (rise, speed) = (SPEED * time - 0.5 * GRAVITY * time * time, SPEED - GRAVITY * time);
        for ((x, x0), v) in file.points().iter().zip(&start).zip(file.field("MP_VELOCITY").chunks(3)) {
            assert!((x[1] - x0[1] - rise).abs() < accuracy * x0[1], "{} {rise}", x[1] - x0[1]);
            assert!((x[0] - x0[0]).abs() < accuracy * x0[0] && x[2] == 0.0);
            assert!((v[1] - speed).abs() < accuracy * SPEED && v[0].abs() < accuracy, "{v:?}, {speed}");
        }
        let mass: f64 = file.field("MP_MASS").iter().sum();
        assert!((mass - DENSITY).abs() < 1e-12 * DENSITY, "{mass}");
    }
}

#[test]
fn points_in_free_fall_are_where_they_must_be() {
    let outputs = ["ascii", "binary", "vtu"]
        .map(|format| points_output(json!({"file_format": format, "output_path": format, "write_ids": true})));
    let folder = write(&free_fall(0.295), &outputs);
    runs(folder.path(), &[]);
    check_free_fall(&folder.path().join("ascii"));
    check_free_fall(&folder.path().join("binary"));
    let ids = VtkFile::read(folder.path().join("binary/MPM_Material_0_30.vtk")).field("KRATOS_ELEMENT_ID");
    assert!(ids.windows(2).all(|pair| pair[1] == pair[0] + 1.0) && ids[0] == 154.0, "153 grid nodes, then points");
    let files = names(&folder.path().join("vtu"));
    assert_eq!(files[..2], ["Background_Grid_0_0.vtu", "MPM_Material.pvd"]);
    assert_eq!(files.len(), 6, "{files:?}");
    let series = std::fs::read_to_string(folder.path().join("vtu/MPM_Material.pvd")).unwrap();
    for (step, time) in [(0, 0.0), (10, 0.1), (20, 0.2), (30, 0.3)] {
        let row = series.lines().find(|line| line.contains(&format!("MPM_Material_0_{step}.vtu"))).expect("a row");
        let written: f64 = row.split('"').nth(1).unwrap().parse().unwrap();
        assert!((written - time).abs() < 1e-12, "{row}");
    }
}

#[test]
fn the_grid_carries_the_mass_and_the_weight_of_the_body() {
    let grid = |part: &str, path: &str, format: &str, variables: Value| {
        process(
            "vtk_output_process",
            json!({"model_part_name": part, "output_path": path, "file_format": format, "output_interval": 1,
                   "nodal_solution_step_data_variables": variables, "output_sub_model_parts": part == "Background_Grid"}),
        )
    };
    let all = json!(["NODAL_MASS", "REACTION", "DISPLACEMENT_Y"]);
    let outputs = [
        grid("Background_Grid", "grid", "binary", all),
        grid("Background_Grid.Floor", "floor", "ascii", json!(["REACTION"])),
    ];
    // A block that fills the lower half of the grid and rests on its floor.
    let mesh = || Mesh::block(Cell::Quadrilateral, [2, 2, 0], [0.0; 3], [2.0, 2.0, 0.0]);
    let law = material("LinearElasticIsotropicPlaneStrain2DLaw", 4, DENSITY, 1e7, 0.3);
    let scene =
        Scene::new(mesh().map(|[x, y, z]| [x, 2.0 * y, z]), mesh(), law, json!({"compute_reactions": true}), 1.0)
            .part("Floor", |x| x[1] == 0.0)
            .with(fix("Floor", json!([0.0, 0.0, 0.0])))
            .with(gravity([0.0, -GRAVITY, 0.0]));
    let folder = write(&scene, &outputs);
    runs(folder.path(), &[]);
    let weight = 4.0 * DENSITY * GRAVITY;
    let file = VtkFile::read(folder.path().join("grid/Background_Grid_0_1.vtk"));
    let mass: f64 = file.field("NODAL_MASS").iter().sum();
    assert!((mass - 4.0 * DENSITY).abs() < 1e-9 * mass, "{mass}");
    let held = |reactions: &[f64]| reactions.chunks(3).map(|r| r[1]).sum::<f64>();
    // vtkio does not read files without cells, as Kratos writes them for parts of nodes alone.
    let text = std::fs::read_to_string(folder.path().join("floor/Floor_0_1.vtk")).unwrap();
    let rows = text.split_once("REACTION 3 3  float").expect("the reactions of three nodes").1;
    let floor: Vec<f64> = rows.split_whitespace().map(|word| word.parse().unwrap()).collect();
    for held in [held(&file.field("REACTION")), held(&floor)] {
        assert!((held - weight).abs() < 1e-6 * weight, "{held}");
    }
    assert!(file.field("DISPLACEMENT_Y").iter().any(|u| *u < -1e-4), "the block is compressed");
    assert_eq!(names(&folder.path().join("grid"))[..2], ["Background_Grid_0_1.vtk", "Background_Grid_Floor_0_1.vtk"]);
}

#[test]
fn unknown_variables_and_unsafe_folders_stop_before_anything_is_written() {
    let output = points_output(json!({"gauss_point_variables_in_elements": ["MP_VELOCTY"]}));
    let folder = write(&free_fall(0.05), &[output]);
    let text = fails(folder.path(), 2);
    assert!(text.contains("did you mean \"MP_VELOCITY\"?"), "{text}");
    assert_eq!(names(folder.path()).len(), 4, "only the project's files");

    let folder = write(&free_fall(0.05), &[points_output(json!({"output_path": "results"}))]);
    let results = folder.path().join("results");
    std::fs::create_dir(&results).unwrap();
    std::fs::write(results.join("old_0_1.vtk"), "old").unwrap();
    std::fs::write(results.join("notes.txt"), "mine").unwrap();
    let text = fails(folder.path(), 2);
    assert!(text.contains("notes.txt"), "{text}");
    assert_eq!(names(&results), ["notes.txt", "old_0_1.vtk"]);
    std::fs::remove_file(results.join("notes.txt")).unwrap();
    runs(folder.path(), &[]);
    assert_eq!(names(&results), ["Background_Grid_0_0.vtk", "MPM_Material_0_0.vtk"], "old files are removed");
}

/// A scene that writes points and nodes every other step.
fn with_histories() -> Scene {
    let points = json!({"model_part_name": "MPM_Material.Body", "output_file_name": "points.json", "time_frequency": 0.015,
                        "gauss_points_output_variables": ["MP_DISPLACEMENT", "MP_CAUCHY_STRESS_VECTOR", "MP_MASS"]});
    let nodes = json!({"model_part_name": "Background_Grid", "sub_model_part_name": "Floor", "time_frequency": 0.015,
                       "output_file_name": "new/nodes.json", "output_variables": ["DISPLACEMENT", "NODAL_MASS"]});
    let sums = json!({"model_part_name": "Background_Grid", "output_file_name": "sums.json", "time_frequency": 0.015,
                      "output_variables": ["NODAL_MASS"], "resultant_solution": true});
    free_fall(0.095)
        .with(process("mpm_json_output_process", points))
        .with(process("json_output_process", nodes))
        .with(process("json_output_process", sums))
}

#[test]
fn histories_hold_the_motion() {
    let folder = write(&with_histories(), &[]);
    runs(folder.path(), &[]);
    let read = |name: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(folder.path().join(name)).unwrap()).unwrap()
    };
    let points = read("points.json");
    let times: Vec<f64> = points["TIME"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap()).collect();
    assert_eq!(times.len(), 5, "{times:?}");
    for (k, time) in times.iter().enumerate() {
        assert!((time - 0.02 * (k + 1) as f64).abs() < 1e-12);
        for id in 154..170 {
            let rise = points[format!("MP_{id}")]["MP_DISPLACEMENT_Y"][k].as_f64().unwrap();
            assert!((rise - SPEED * time + 0.5 * GRAVITY * time * time).abs() < 1e-9, "{rise}");
        }
        assert_eq!(points["MP_154"]["MP_CAUCHY_STRESS_VECTOR"][k].as_array().unwrap().len(), 3);
        let mass = read("sums.json")["RESULTANT"]["NODAL_MASS"][k].as_f64().unwrap();
        assert!((mass - DENSITY).abs() < 1e-9 * DENSITY, "{mass}");
    }
    let nodes = read("new/nodes.json");
    assert_eq!(nodes.as_object().unwrap().len(), 1 + 9, "TIME and the nodes of the floor");
    assert_eq!(nodes["NODE_3"]["NODAL_MASS"], json!([0.0, 0.0, 0.0, 0.0, 0.0]));
}

/// A check that never compares has not passed.
#[test]
fn a_check_that_compares_nothing_fails_and_says_why() {
    let first = write(&with_histories(), &[]);
    runs(first.path(), &[]);
    let fails_with = |time_frequency: f64, variables: Value, why: &str| {
        let parameters = json!({"model_part_name": "MPM_Material", "input_file_name": "points.json",
                                "check_variables": variables, "time_frequency": time_frequency});
        let scene = free_fall(0.095).with(process("mpm_from_json_check_result_process", parameters));
        let second = write(&scene, &[]);
        std::fs::copy(first.path().join("points.json"), second.path().join("points.json")).unwrap();
        let text = fails(second.path(), 1);
        assert!(text.contains("nothing was compared with") && text.contains(why), "{text}");
    };
    fails_with(1.0, json!(["MP_DISPLACEMENT"]), "\"time_frequency\" is 1 s");
    fails_with(0.015, json!([]), "\"check_variables\" is empty");
}

/// One component of a vector, between other quantities, is written and checked as that number alone.
#[test]
fn a_component_of_a_vector_of_points_is_one_number() {
    let parameters = |file: &str, name: &str, list: &str| {
        json!({"model_part_name": "MPM_Material", "time_frequency": 0.015, file: name,
               list: ["MP_MASS", "MP_VELOCITY_Y", "MP_ACCELERATION_Y", "MP_DISPLACEMENT"]})
    };
    let output = parameters("output_file_name", "points.json", "gauss_points_output_variables");
    let scene = free_fall(0.095).with(process("mpm_json_output_process", output));
    let first = write(&scene, &[]);
    runs(first.path(), &[]);
    let text = std::fs::read_to_string(first.path().join("points.json")).unwrap();
    let mut points: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(points["MP_154"].as_object().unwrap().len(), 6, "{points}");
    for k in 0..5 {
        let time = 0.02 * (k + 1) as f64;
        let number = |name: &str| points["MP_154"][name][k].as_f64().unwrap();
        assert!((number("MP_MASS") - DENSITY / 16.0).abs() < 1e-9 * DENSITY);
        assert!((number("MP_VELOCITY_Y") - SPEED + GRAVITY * time).abs() < 1e-9);
        assert!((number("MP_ACCELERATION_Y") + GRAVITY).abs() < 1e-9);
        assert!(number("MP_DISPLACEMENT_X").abs() < 1e-9 && number("MP_DISPLACEMENT_Z") == 0.0);
        assert!((number("MP_DISPLACEMENT_Y") - SPEED * time + 0.5 * GRAVITY * time * time).abs() < 1e-9);
    }

    let check = parameters("input_file_name", "points.json", "check_variables");
    let second = write(&free_fall(0.095).with(process("mpm_from_json_check_result_process", check)), &[]);
    std::fs::write(second.path().join("points.json"), &text).unwrap();
    runs(second.path(), &[]);
    points["MP_154"]["MP_VELOCITY_Y"][2] = json!(0.5);
    std::fs::write(second.path().join("points.json"), points.to_string()).unwrap();
    let text = fails(second.path(), 1);
    assert!(text.contains("material point 154, MP_VELOCITY_Y, step 6"), "{text}");
}

#[test]
fn checks_pass_on_what_was_written_and_name_what_differs() {
    let check = |module: &str, part: &str, file: &str, variables: Value| {
        process(
            module,
            json!({"model_part_name": part, "input_file_name": file, "check_variables": variables,
                   "time_frequency": 0.015, "tolerance": 1e-12, "relative_tolerance": 1e-9}),
        )
    };
    let first = write(&with_histories(), &[]);
    runs(first.path(), &[]);
    let variables = json!(["MP_DISPLACEMENT", "MP_CAUCHY_STRESS_VECTOR"]);
    let scene = free_fall(0.095)
        .with(check("particle_from_json_check_result_process", "MPM_Material", "points.json", variables))
        .with(check("from_json_check_result_process", "Background_Grid.Floor", "nodes.json", json!(["DISPLACEMENT"])));
    let second = write(&scene, &[]);
    let text = fails(second.path(), 2);
    assert!(text.contains("points.json does not exist") && text.contains("nodes.json does not exist"), "{text}");

    let points = std::fs::read_to_string(first.path().join("points.json")).unwrap();
    std::fs::copy(first.path().join("new/nodes.json"), second.path().join("nodes.json")).unwrap();
    std::fs::write(second.path().join("points.json"), &points).unwrap();
    runs(second.path(), &[]);

    let mut changed: Value = serde_json::from_str(&points).unwrap();
    let value = changed["MP_160"]["MP_DISPLACEMENT_Y"][2].as_f64().unwrap();
    changed["MP_160"]["MP_DISPLACEMENT_Y"][2] = json!(value + 1e-8);
    std::fs::write(second.path().join("points.json"), changed.to_string()).unwrap();
    let text = fails(second.path(), 1);
    for part in ["material point 160, MP_DISPLACEMENT_Y, step 6", "by 1.000e-8", "1e-12", "1e-9"] {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
    changed.as_object_mut().unwrap().remove("MP_160");
    std::fs::write(second.path().join("points.json"), changed.to_string()).unwrap();
    let text = fails(second.path(), 1);
    assert!(text.contains("material point 160") && text.contains("holds no values of MP_160/"), "{text}");
}
