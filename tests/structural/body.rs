//! Projects of finite elements.

use super::common::{Mesh, Record, process, run_project};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use tempfile::TempDir;

/// A body with its constraints and loads.
pub struct Body {
    pub mesh: Mesh,
    /// Named sets of nodes.
    pub parts: Vec<(&'static str, Vec<usize>)>,
    /// Named sets of conditions: their name and the nodes of each.
    pub loads: Vec<(&'static str, &'static str, Vec<Vec<usize>>)>,
    pub material: Value,
    pub end_time: f64,
    /// Members of solver_settings that differ from those in [`Body::project`].
    pub solver: Value,
    pub processes: Vec<Value>,
    pub outputs: Vec<Value>,
}

/// A material.
pub fn material(law: &str, density: f64, young: f64, poisson: f64) -> Value {
    let variables = json!({"DENSITY": density, "YOUNG_MODULUS": young, "POISSON_RATIO": poisson});
    json!({"constitutive_law": {"name": law}, "Variables": variables})
}

/// A vector variable given to a part of the nodes, held if `constrained`; null leaves a component alone.
pub fn assign(part: &str, variable: &str, value: Value, constrained: bool) -> Value {
    let components: Vec<bool> = value.as_array().unwrap().iter().map(|v| constrained && !v.is_null()).collect();
    let parameters = json!({"model_part_name": format!("Structure.{part}"), "variable_name": variable,
                            "constrained": components, "value": value});
    process("assign_vector_variable_process", parameters)
}

/// Displacements that a part of the nodes is held at.
pub fn fix(part: &str, value: Value) -> Value {
    assign(part, "DISPLACEMENT", value, true)
}

/// A load on a part of the conditions.
pub fn load(part: &str, variable: &str, value: Value) -> Value {
    let part = format!("Structure.{part}");
    let parameters = json!({"model_part_name": part, "variable_name": variable, "value": value});
    process("assign_vector_variable_to_conditions_process", parameters)
}

impl Body {
    pub fn new(mesh: Mesh, material: Value, solver: Value, end_time: f64) -> Self {
        Self {
            mesh,
            parts: Vec::new(),
            loads: Vec::new(),
            material,
            end_time,
            solver,
            processes: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// Names a set of nodes.
    #[must_use]
    pub fn part(mut self, name: &'static str, nodes: impl Fn([f64; 3]) -> bool) -> Self {
        let found = self.mesh.find(nodes);
        assert!(!found.is_empty(), "no node in {name}");
        self.parts.push((name, found));
        self
    }

    /// Names a set of conditions.
    #[must_use]
    pub fn conditions(mut self, name: &'static str, condition: &'static str, nodes: Vec<Vec<usize>>) -> Self {
        self.loads.push((name, condition, nodes));
        self
    }

    /// Adds a process.
    #[must_use]
    pub fn with(mut self, process: Value) -> Self {
        self.processes.push(process);
        self
    }

    fn project(&self) -> Value {
        let mut settings = json!({
            "solver_type": "structural_static", "domain_size": self.mesh.cell.dimension(),
            "model_part_name": "Structure", "time_stepping": {"time_step": 1.0},
            "residual_relative_tolerance": 1e-12, "residual_absolute_tolerance": 1e-13, "max_iteration": 30,
            "model_import_settings": {"input_filename": "body"},
            "material_import_settings": {"materials": [
                {"model_part_name": "Structure", "properties_id": 1, "Material": self.material}]},
        });
        settings.as_object_mut().unwrap().extend(self.solver.as_object().unwrap().clone());
        json!({
            "problem_data": {"problem_name": "body", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
                             "end_time": self.end_time},
            "solver_settings": settings,
            "processes": {"list": self.processes},
            "output_processes": {"list": self.outputs},
        })
    }

    fn mdpa(&self) -> String {
        let (mut conditions, mut parts, mut id) = (String::new(), String::new(), 0);
        let open = |parts: &mut String, name: &str, nodes: &[usize]| {
            write!(parts, "Begin SubModelPart {name}\nBegin SubModelPartNodes\n").unwrap();
            nodes.iter().for_each(|node| writeln!(parts, "{}", node + 1).unwrap());
            *parts += "End SubModelPartNodes\n";
        };
        for (name, nodes) in &self.parts {
            open(&mut parts, name, nodes);
            parts += "End SubModelPart\n";
        }
        for (part, condition, list) in &self.loads {
            let mut nodes = list.concat();
            nodes.sort_unstable();
            nodes.dedup();
            open(&mut parts, part, &nodes);
            writeln!(conditions, "Begin Conditions {condition}").unwrap();
            parts += "Begin SubModelPartConditions\n";
            for nodes in list {
                id += 1;
                let nodes: Vec<String> = nodes.iter().map(|node| (node + 1).to_string()).collect();
                writeln!(conditions, "{id} 0 {}", nodes.join(" ")).unwrap();
                writeln!(parts, "{id}").unwrap();
            }
            conditions += "End Conditions\n";
            parts += "End SubModelPartConditions\nEnd SubModelPart\n";
        }
        self.mesh.mdpa("TotalLagrangianElement", 0, &conditions, &parts)
    }

    /// Writes the project to a folder.
    pub fn write(&self, folder: &Path) {
        std::fs::write(folder.join("body.mdpa"), self.mdpa()).unwrap();
        std::fs::write(folder.join("ProjectParameters.json"), self.project().to_string()).unwrap();
    }

    /// Runs with these arguments beside `--record`.
    pub fn run(&self, arguments: &[&str]) -> Record {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        run_project(folder.path(), arguments)
    }
}
