//! Meshes and fields in other formats: `bia convert`, bodies of STL files, initial fields from files, and what
//! output files hold, against analytic values.

use bia_kernel::io::dataset::{Dataset, FieldData};
use bia_kernel::io::vtu_read::read_vtu;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn bia(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bia")).current_dir(folder).args(arguments).output().unwrap()
}

/// What the program says, without line breaks; it must end with this exit code.
#[track_caller]
fn says(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = bia(folder, arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{text}");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[track_caller]
fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected} to {relative:e}");
}

fn values(data: &Dataset, name: &str) -> Vec<f64> {
    let field = data.point_fields.iter().chain(&data.cell_fields).find(|field| field.name == name);
    match &field.unwrap_or_else(|| panic!("there is no field {name}")).values {
        FieldData::F64(values) => values.clone(),
        FieldData::I32(values) => values.iter().map(|&value| f64::from(value)).collect(),
    }
}

fn project(folder: &Path, project: &Value) {
    std::fs::write(folder.join("P.json"), project.to_string()).unwrap();
}

fn process(module: &str, parameters: Value) -> Value {
    json!({"python_module": module, "Parameters": parameters})
}

/// A mesh of Gmsh through all formats and back: the command, its words, its exit codes.
#[test]
fn meshes_are_converted_and_losses_told() {
    let folder = TempDir::new().unwrap();
    let plate = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gmsh/plate_4.1_binary.msh");
    let plate = plate.to_str().unwrap();
    let convert = |arguments: &[&str], code| says(folder.path(), &[&["convert"], arguments].concat(), code);
    let first = convert(&[plate, "a.mdpa", "--element-prefix", "MPMUpdatedLagrangian"], 0);
    assert!(first.contains("93 nodes, 110 elements"), "{first}");
    assert!(first.contains("blanks in names: \"Floor of plate\" is written as \"Floor_of_plate\""), "{first}");
    let text = std::fs::read_to_string(folder.path().join("a.mdpa")).unwrap();
    assert!(text.contains("Begin Elements MPMUpdatedLagrangian2D3N") && text.contains("Begin SubModelPart Both"));
    for (from, to, options) in
        [("a.mdpa", "b.vtu", &[][..]), ("b.vtu", "c.msh", &["--msh-version", "2.2"]), ("c.msh", "d.vtu", &[])]
    {
        let said = convert(&[&[from, to], options].concat(), 0);
        assert!(said.contains("93 nodes, 110 elements"), "{said}");
        assert_eq!(said.contains("does not hold: element names"), to.ends_with("msh"), "{said}");
    }
    let parts = |name: &str| {
        let data = read_vtu(&folder.path().join(name)).unwrap();
        let fields = data.cell_fields.iter().filter(|field| field.name.starts_with("Part "));
        fields.map(|field| (field.name.clone(), values(&data, &field.name).iter().sum::<f64>())).collect::<Vec<_>>()
    };
    let (mut before, mut after) = (parts("b.vtu"), parts("d.vtu"));
    before.sort_by(|a, b| a.0.cmp(&b.0));
    after.sort_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(before, after, "the same cells in the same parts");
    assert!(convert(&["a.mdpa", "b.vtu"], 2).contains("is there already"));
    convert(&["a.mdpa", "b.vtu", "--force"], 0);
    assert!(convert(&["a.mdpa", "b.stl"], 2).contains("there is no format of meshes \"stl\""));
    assert!(convert(&["no.mdpa", "x.vtu"], 2).contains("cannot be read"));
    assert!(!folder.path().join("x.vtu").exists());
}

/// A cube with its corners at these places along each axis, as a text file.
fn stl_cube(low: f64, high: f64) -> String {
    let x = |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 0 { low } else { high });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid cube\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            triangle.map(x).iter().for_each(|[x, y, z]| text += &format!("vertex {x} {y} {z}\n"));
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid cube\n"
}

const LAME: [f64; 2] = [1e6, 5e5];

fn neo_hookean(part: &str, law: &str) -> Value {
    let [lambda, mu] = LAME;
    json!([{"model_part_name": part, "properties_id": 1, "Material": {
        "constitutive_law": {"name": law},
        "Variables": {"DENSITY": 1000.0, "YOUNG_MODULUS": mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
                      "POISSON_RATIO": 0.5 * lambda / (lambda + mu), "MATERIAL_POINTS_PER_ELEMENT": 8}}}])
}

/// A body in a grid of 2 m, without supports.
fn points_scene(body: Value, solver: Value, processes: Value, outputs: Value) -> Value {
    let mut settings = json!({
        "solver_type": "static", "domain_size": 3, "time_stepping": {"time_step": 1.0}, "max_iteration": 30,
        "residual_relative_tolerance": 1e-12, "residual_absolute_tolerance": 1e-9,
        "model_import_settings": {"input_type": "use_input_model_part"},
        "grid_model_import_settings": {"input_type": "use_input_model_part"},
        "material_import_settings": {"materials": neo_hookean("Initial_MPM_Material.Body", "HyperElasticNeoHookean3DLaw")}});
    settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
    json!({"problem_data": {"end_time": 1.0},
           "modelers": [grid("Background_Grid", "Element3D8N"),
                        {"name": "BodyModeler", "parameters": {"bodies": [body]}}],
           "solver_settings": settings, "processes": {"list": processes}, "output_processes": {"list": outputs}})
}

fn grid(part: &str, element: &str) -> Value {
    json!({"name": "RegularGridModeler", "parameters": {
        "model_part_name": part, "element_name": element, "min": [0, 0, 0], "max": [2, 2, 2], "divisions": [2, 2, 2],
        "parts": [{"name": "Boundary", "side": "boundary"}]}})
}

fn stretched(part: &str) -> Value {
    process(
        "assign_vector_variable_process",
        json!({"model_part_name": part, "variable_name": "DISPLACEMENT",
        "constrained": [true, true, true], "value": ["0.1*x", 0, 0]}),
    )
}

/// Von Mises stress, mean stress, J and energy density of the neo-Hookean law at F = diag(1.1, 1, 1), by its formulas.
fn expected() -> [f64; 4] {
    let ([lambda, mu], jacobian) = (LAME, 1.1f64);
    let logarithm = jacobian.ln();
    let energy = 0.5 * mu * (jacobian * jacobian - 1.0) - mu * logarithm + 0.5 * lambda * logarithm * logarithm;
    let mean = (3.0 * lambda * logarithm + mu * (jacobian * jacobian - 1.0)) / (3.0 * jacobian);
    [mu * (jacobian * jacobian - 1.0) / jacobian, mean, jacobian, energy]
}

fn output(module: &str, part: &str, names: &Value, more: Value) -> Value {
    let mut all = json!({"model_part_name": part, "file_format": "vtu", "output_path": "vtk"});
    let key = if module == "vtk_output_process" {
        "element_data_value_variables"
    } else {
        "gauss_point_variables_in_elements"
    };
    all[key] = names.clone();
    all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    process(module, all)
}

#[track_caller]
fn check_derived(file: &Path, names: &Value, relative: f64) {
    let data = read_vtu(file).unwrap();
    for (name, expected) in names.as_array().unwrap().iter().zip(expected()) {
        let found = values(&data, name.as_str().unwrap());
        assert!(!found.is_empty());
        found.into_iter().for_each(|found| close(found, expected, relative));
    }
}

/// The same four fields from material points, finite elements and discontinuous cells, in both precisions.
#[test]
fn derived_fields_are_those_of_the_law() {
    let of_points = json!(["MP_EQUIVALENT_STRESS", "MP_MEAN_STRESS", "MP_DETERMINANT_F", "MP_STRAIN_ENERGY_DENSITY"]);
    for (precision, relative) in [("float64", 1e-9), ("float32", 2e-6)] {
        let folder = TempDir::new().unwrap();
        let body =
            json!({"name": "Body", "primitive": {"type": "box", "min": [0, 0, 0], "max": [2, 2, 2]}, "cell_size": 1});
        let shown = output("mpm_vtk_output_process", "MPM_Material", &of_points, json!({"precision": precision}));
        let held = json!([stretched("Background_Grid.Boundary")]);
        project(folder.path(), &points_scene(body, json!({}), held, json!([shown])));
        says(folder.path(), &["run", "P.json", "--quiet"], 0);
        let file = folder.path().join("vtk/MPM_Material_0_1.vtu");
        check_derived(&file, &of_points, relative);
        let head = String::from_utf8_lossy(&std::fs::read(&file).unwrap()).into_owned();
        assert!(head.contains(&format!("type=\"F{}\" Name=\"MP_MEAN_STRESS\"", &precision[1..])));
    }

    let folder = TempDir::new().unwrap();
    let of_elements = json!(["VON_MISES_STRESS", "MEAN_STRESS", "DETERMINANT_F", "STRAIN_ENERGY_DENSITY"]);
    let structure = json!({"problem_data": {"end_time": 1.0},
        "modelers": [grid("Structure", "TotalLagrangianElement3D8N")],
        "solver_settings": {"solver_type": "structural_static", "domain_size": 3, "time_stepping": {"time_step": 1.0},
            "residual_relative_tolerance": 1e-12, "residual_absolute_tolerance": 1e-9,
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": neo_hookean("Structure", "HyperElasticNeoHookean3DLaw")}},
        "processes": {"list": [stretched("Structure.Boundary")]},
        "output_processes": {"list": [output("vtk_output_process", "Structure", &of_elements, json!({}))]}});
    project(folder.path(), &structure);
    says(folder.path(), &["run", "P.json", "--quiet"], 0);
    check_derived(&folder.path().join("vtk/Structure_0_1.vtu"), &of_elements, 1e-9);

    let folder = TempDir::new().unwrap();
    let state = process(
        "dgmpm_initial_state_process",
        json!({"model_part_name": "Background_Grid", "deformation_gradient": [1.1, 0, 0, 0, 1, 0, 0, 0, 1]}),
    );
    let galerkin = json!({"problem_data": {"end_time": 1e-6},
        "modelers": [grid("Background_Grid", "Element3D8N")],
        "solver_settings": {"solver_type": "dgmpm", "domain_size": 3, "time_stepping": {"time_step": "auto"},
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": neo_hookean("Background_Grid", "HyperElasticNeoHookean3DLaw")}},
        "processes": {"list": [state]},
        "output_processes": {"list": [output("dgmpm_vtk_output_process", "Background_Grid", &of_points, json!({}))]}});
    project(folder.path(), &galerkin);
    says(folder.path(), &["run", "P.json", "--quiet"], 0);
    check_derived(&folder.path().join("vtk/Background_Grid_0_0.vtu"), &of_points, 1e-12);
}

/// A body whose boundary is an STL file has the mass of the polyhedron where the cells fit it, and says its volume.
#[test]
fn a_body_of_an_stl_file_runs() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("cube.stl"), stl_cube(500.0, 1500.0)).unwrap();
    let body = json!({"name": "Body", "primitive": {"type": "stl", "file": "cube.stl", "scale": 0.001},
                      "fill": "grid", "cell_size": 0.25});
    let free = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.1}});
    let gravity = process(
        "assign_gravity_to_material_point_process",
        json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": [0, 0, -1]}),
    );
    let shown = output(
        "mpm_vtk_output_process",
        "MPM_Material",
        &json!(["MP_MASS", "MP_VELOCITY"]),
        json!({"output_control_type": "wall_time", "output_interval": 0.0}),
    );
    project(folder.path(), &points_scene(body, free, json!([gravity]), json!([shown])));
    let said = says(folder.path(), &["run", "P.json"], 0);
    assert!(said.contains("64 cells in a stl, volume 1.000000000e0 m³"), "{said}");
    let data = read_vtu(&folder.path().join("vtk/MPM_Material_0_10.vtu")).unwrap();
    close(values(&data, "MP_MASS").iter().sum(), 1000.0, 1e-12);
    assert_eq!(data.points.len(), 512);
    values(&data, "MP_VELOCITY").chunks(3).for_each(|v| close(v[2], -1.0, 1e-9));
    // Outputs by the time on the wall come each step when none must pass between them.
    assert!((0..=10).all(|step| folder.path().join(format!("vtk/MPM_Material_0_{step}.vtu")).exists()));

    std::fs::write(
        folder.path().join("cube.stl"),
        stl_cube(500.0, 1500.0).replacen("vertex 500 500 500", "vertex 0 0 0", 1),
    )
    .unwrap();
    let said = says(folder.path(), &["check", "P.json"], 2);
    assert!(said.contains("the surface is open"), "{said}");
}

/// The velocities that one run wrote are those with which the next one begins, point by point, and a linear field
/// on a coarse mesh is met everywhere.
#[test]
fn initial_fields_come_from_files() {
    let dynamic = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.01}});
    let body = || {
        json!({"name": "Body", "primitive": {"type": "box", "min": [0.5, 0.5, 0.5], "max": [1.5, 1.5, 1.5]},
                         "cell_size": 0.25})
    };
    let field = |more: Value| {
        let mut parameters = json!({"model_part_name": "MPM_Material.Body"});
        parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        process("assign_initial_field_to_material_point_process", parameters)
    };
    let shown = output("mpm_vtk_output_process", "MPM_Material", &json!(["MP_VELOCITY", "MP_ACCELERATION"]), json!({}));
    let start = |folder: &Path, process: Value| {
        project(folder, &points_scene(body(), dynamic.clone(), json!([process]), json!([shown.clone()])));
        let mut text: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("P.json")).unwrap()).unwrap();
        text["problem_data"]["end_time"] = 0.01.into();
        project(folder, &text);
        says(folder, &["run", "P.json", "--quiet"], 0);
        read_vtu(&folder.join("vtk/MPM_Material_0_0.vtu")).unwrap()
    };
    let folder = TempDir::new().unwrap();
    let first = start(folder.path(), field(json!({"value": ["sin(3*x)*y", "z*z", "x*y*z"]})));
    std::fs::copy(folder.path().join("vtk/MPM_Material_0_0.vtu"), folder.path().join("state.vtu")).unwrap();
    let again = start(folder.path(), field(json!({"file": "state.vtu", "tolerance": 1e-9})));
    assert_eq!(values(&again, "MP_VELOCITY"), values(&first, "MP_VELOCITY"));
    let given = start(
        folder.path(),
        field(json!({"file": "state.vtu", "field": "MP_VELOCITY",
                                                  "variable_name": "MP_ACCELERATION"})),
    );
    assert_eq!(values(&given, "MP_ACCELERATION"), values(&first, "MP_VELOCITY"));

    // Three numbers on the eight corners of the grid, written as text as another program would.
    let corners: Vec<[f64; 3]> = (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(2 * (i >> axis & 1)))).collect();
    let text = |of: &dyn Fn(&[f64; 3]) -> [f64; 3]| {
        corners.iter().flat_map(of).map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
    };
    let linear = |x: &[f64; 3]| [1.0 + x[0], x[1] - x[2], 2.0 * x[2]];
    let file = format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"8\" NumberOfCells=\"1\">\
        <PointData><DataArray type=\"Float64\" Name=\"v\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></PointData>\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points>\
        <Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 3 2 4 5 7 6</DataArray>\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">8</DataArray>\
        <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">12</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>",
        text(&linear),
        text(&|x| *x)
    );
    std::fs::write(folder.path().join("coarse.vtu"), file).unwrap();
    let met = start(folder.path(), field(json!({"file": "coarse.vtu", "field": "v", "match": "interpolated"})));
    for (x, v) in met.points.iter().zip(values(&met, "MP_VELOCITY").chunks(3)) {
        linear(x).iter().zip(v).for_each(|(expected, found)| assert!((expected - found).abs() < 1e-12, "{x:?}"));
    }

    let refused = |more: Value, code: i32| {
        project(folder.path(), &points_scene(body(), dynamic.clone(), json!([field(more)]), json!([])));
        says(folder.path(), &["run", "P.json", "--quiet"], code)
    };
    assert!(refused(json!({"file": "coarse.vtu"}), 2).contains("the file holds no field \"MP_VELOCITY\""));
    assert!(refused(json!({"file": "coarse.vtu", "field": "v", "value": [1, 0, 0]}), 2).contains("one of them gives"));
    assert!(refused(json!({"file": "coarse.vtu", "field": "v", "tolerance": 0.1}), 3).contains("has no value here"));
}

/// Who asks for what this scene does not have learns who has it.
#[test]
fn unprovided_variables_name_who_provides_them() {
    let folder = TempDir::new().unwrap();
    let body =
        json!({"name": "Body", "primitive": {"type": "box", "min": [0, 0, 0], "max": [2, 2, 2]}, "cell_size": 1});
    let ask = |module: &str, part: &str, name: &str| {
        let shown = output(module, part, &json!([name]), json!({}));
        let held = json!([stretched("Background_Grid.Boundary")]);
        project(folder.path(), &points_scene(body.clone(), json!({}), held, json!([shown])));
        says(folder.path(), &["run", "P.json", "--quiet"], 2)
    };
    let said = ask("mpm_vtk_output_process", "MPM_Material", "MP_PRESSURE");
    assert!(said.contains("the material point method with \"pressure_dofs\": true on points"), "{said}");
    let said = ask("vtk_output_process", "Background_Grid", "VON_MISES_STRESS");
    assert!(said.contains("provided by: structural solvers on elements"), "{said}");
    let shown = output(
        "mpm_vtk_output_process",
        "MPM_Material",
        &json!([]),
        json!({"precision": "float32", "file_format": "ascii"}),
    );
    project(folder.path(), &points_scene(body, json!({}), json!([]), json!([shown])));
    assert!(says(folder.path(), &["check", "P.json"], 2).contains("float32 is for files of the format vtu"));
}
