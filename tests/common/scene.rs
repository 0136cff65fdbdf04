//! Projects in temporary folders, and runs of the built program.

use super::{Cell, Mesh, Record};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A body: its mesh becomes points.
pub struct Body {
    pub name: &'static str,
    pub mesh: Mesh,
    pub material: Value,
}

/// A project.
pub struct Scene {
    pub grid: Mesh,
    /// Named sets of grid nodes.
    pub parts: Vec<(&'static str, Vec<usize>)>,
    /// Named sets of load conditions on the grid: the condition and the nodes of each.
    pub loads: Vec<(&'static str, &'static str, Vec<Vec<usize>>)>,
    pub bodies: Vec<Body>,
    pub end_time: f64,
    /// Members of solver_settings that differ from those in [`Scene::settings`].
    pub solver: Value,
    pub processes: Vec<Value>,
}

/// A material.
pub fn material(law: &str, points: usize, density: f64, young: f64, poisson: f64) -> Value {
    json!({
        "constitutive_law": {"name": law},
        "Variables": {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": points, "DENSITY": density,
                      "YOUNG_MODULUS": young, "POISSON_RATIO": poisson}
    })
}

/// A process block.
pub fn process(module: &str, parameters: Value) -> Value {
    json!({"python_module": module, "kratos_module": "KratosMultiphysics", "Parameters": parameters})
}

/// Displacement increments imposed on a part of the grid; null leaves a component free.
pub fn fix(part: &str, value: Value) -> Value {
    let constrained: Vec<bool> = value.as_array().unwrap().iter().map(|v| !v.is_null()).collect();
    let part = format!("Background_Grid.{part}");
    let parameters =
        json!({"model_part_name": part, "variable_name": "DISPLACEMENT", "constrained": constrained, "value": value});
    process("assign_vector_variable_process", parameters)
}

/// Gravity on all points.
pub fn gravity(vector: [f64; 3]) -> Value {
    let parameters = json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": vector});
    process("assign_gravity_to_material_point_process", parameters)
}

impl Scene {
    /// A grid and one body, without constraints or loads.
    pub fn new(grid: Mesh, body: Mesh, material: Value, solver: Value, end_time: f64) -> Self {
        let bodies = vec![Body { name: "Body", mesh: body, material }];
        Self { grid, parts: Vec::new(), loads: Vec::new(), bodies, end_time, solver, processes: Vec::new() }
    }

    /// Names a set of grid nodes.
    #[must_use]
    pub fn part(mut self, name: &'static str, nodes: impl Fn([f64; 3]) -> bool) -> Self {
        let found = self.grid.find(nodes);
        assert!(!found.is_empty(), "no node in {name}");
        self.parts.push((name, found));
        self
    }

    /// Adds a process.
    #[must_use]
    pub fn with(mut self, process: Value) -> Self {
        self.processes.push(process);
        self
    }

    fn settings(&self) -> Value {
        let mut settings = json!({
            "solver_type": "static", "domain_size": self.grid.cell.dimension(), "model_part_name": "MPM_Material",
            "time_stepping": {"time_step": 1.0}, "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": 1e-12, "residual_absolute_tolerance": 0.0, "max_iteration": 30,
            "model_import_settings": {"input_filename": "body"},
            "grid_model_import_settings": {"input_filename": "grid"},
            "material_import_settings": {"materials_filename": "materials.json"},
        });
        let members: &mut Map<String, Value> = settings.as_object_mut().unwrap();
        members.extend(self.solver.as_object().unwrap().clone());
        settings
    }

    fn project(&self) -> Value {
        json!({
            "problem_data": {"problem_name": "scene", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
                             "end_time": self.end_time},
            "solver_settings": self.settings(),
            "processes": {"list": self.processes},
        })
    }

    fn grid_file(&self) -> String {
        let (mut conditions, mut parts, mut id) = (String::new(), String::new(), 0);
        for (name, nodes) in &self.parts {
            write!(parts, "Begin SubModelPart {name}\nBegin SubModelPartNodes\n").unwrap();
            nodes.iter().for_each(|node| writeln!(parts, "{}", node + 1).unwrap());
            parts += "End SubModelPartNodes\nEnd SubModelPart\n";
        }
        for (part, condition, list) in &self.loads {
            writeln!(conditions, "Begin Conditions {condition}").unwrap();
            write!(parts, "Begin SubModelPart {part}\nBegin SubModelPartNodes\n").unwrap();
            let mut nodes: Vec<usize> = list.concat();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.iter().for_each(|node| writeln!(parts, "{}", node + 1).unwrap());
            parts += "End SubModelPartNodes\nBegin SubModelPartConditions\n";
            for nodes in list {
                id += 1;
                write!(conditions, "{id} 0").unwrap();
                nodes.iter().for_each(|node| write!(conditions, " {}", node + 1).unwrap());
                conditions.push('\n');
                writeln!(parts, "{id}").unwrap();
            }
            conditions += "End Conditions\n";
            parts += "End SubModelPartConditions\nEnd SubModelPart\n";
        }
        self.grid.mdpa("Element", 0, &conditions, &parts)
    }

    fn body_file(&self) -> String {
        let mut merged = Mesh { cell: self.bodies[0].mesh.cell, nodes: Vec::new(), cells: Vec::new() };
        let (first, mut parts) = (self.grid.nodes.len().max(self.grid.cells.len()), String::new());
        for body in &self.bodies {
            let (nodes, cells) = (merged.nodes.len(), merged.cells.len());
            merged.nodes.extend(&body.mesh.nodes);
            merged.cells.extend(body.mesh.cells.iter().map(|cell| cell.iter().map(|node| node + nodes).collect()));
            write!(parts, "Begin SubModelPart {}\nBegin SubModelPartNodes\n", body.name).unwrap();
            (nodes..merged.nodes.len()).for_each(|node| writeln!(parts, "{}", first + node + 1).unwrap());
            parts += "End SubModelPartNodes\nBegin SubModelPartElements\n";
            (cells..merged.cells.len()).for_each(|cell| writeln!(parts, "{}", first + cell + 1).unwrap());
            parts += "End SubModelPartElements\nEnd SubModelPart\n";
        }
        merged.mdpa("MPMUpdatedLagrangian", first, "", &parts)
    }

    fn materials(&self) -> Value {
        let entry = |(i, body): (usize, &Body)| {
            json!({"model_part_name": format!("Initial_MPM_Material.{}", body.name), "properties_id": i + 1,
                   "Material": body.material})
        };
        json!({"properties": self.bodies.iter().enumerate().map(entry).collect::<Vec<_>>()})
    }

    /// Writes the project to a folder.
    pub fn write(&self, folder: &Path) {
        let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
        write("grid.mdpa", self.grid_file());
        write("body.mdpa", self.body_file());
        write("materials.json", self.materials().to_string());
        write("ProjectParameters.json", self.project().to_string());
    }

    /// Runs the scene with these arguments beside `--record`.
    pub fn run(&self, arguments: &[&str]) -> Record {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        run_project(folder.path(), arguments)
    }
}

/// Runs the project in a folder and reads its record; stops the test unless the run succeeds and
/// every step converges.
pub fn run_project(folder: &Path, arguments: &[&str]) -> Record {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder).args(["run", "ProjectParameters.json", "--quiet", "--record", "record.json"]);
    if !arguments.contains(&"--threads") {
        command.args(["--threads", "1"]);
    }
    let output = command.args(arguments).output().expect("the built program starts");
    assert!(output.status.success(), "{}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    let record = Record::read(&folder.join("record.json"));
    let failed = &record.json["not_converged_steps"];
    assert!(failed.as_array().is_some_and(Vec::is_empty), "steps without convergence: {failed}");
    record
}

impl Cell {
    /// Name of a law for cells of this dimension.
    pub fn law(self, plane: &'static str, space: &'static str) -> &'static str {
        if self.dimension() == 2 { plane } else { space }
    }
}
