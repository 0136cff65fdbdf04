//! Projects on regular grids.

use super::common::{Record, process, run_project};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A grid whose cells are filled with points.
#[derive(Clone)]
pub struct Scene {
    pub size: [f64; 3],
    pub divisions: Vec<usize>,
    pub parts: Vec<Value>,
    pub law: &'static str,
    pub variables: Value,
    pub end_time: f64,
    /// Members of solver_settings that differ from those in [`Scene::project`].
    pub solver: Value,
    pub processes: Vec<Value>,
    pub outputs: Vec<Value>,
}

/// Density, Young's modulus, Poisson's ratio, points of a cell.
pub fn constants(density: f64, young: f64, poisson: f64, points: usize) -> Value {
    json!({"DENSITY": density, "YOUNG_MODULUS": young, "POISSON_RATIO": poisson, "MATERIAL_POINTS_PER_ELEMENT": points})
}

/// Velocities that a part of the nodes is held at; null leaves a component free.
pub fn hold(part: &str, value: Value) -> Value {
    let constrained: Vec<bool> = value.as_array().unwrap().iter().map(|v| !v.is_null()).collect();
    let parameters = json!({"model_part_name": format!("Background_Grid.{part}"), "variable_name": "VELOCITY",
                            "constrained": constrained, "value": value});
    process("assign_vector_variable_process", parameters)
}

/// A load on a part of the conditions.
pub fn load(part: &str, variable: &str, value: Value) -> Value {
    let part = format!("Background_Grid.{part}");
    let parameters = json!({"model_part_name": part, "variable_name": variable, "value": value});
    process("assign_vector_variable_to_conditions_process", parameters)
}

/// Velocities at the start.
pub fn velocity(part: &str, value: Value) -> Value {
    process("dgmpm_initial_state_process", json!({"model_part_name": part, "value": value}))
}

impl Scene {
    /// From the origin to `size`, without conditions at the boundary.
    pub fn new(size: [f64; 3], divisions: &[usize], law: &'static str, variables: Value, end_time: f64) -> Self {
        Self {
            size,
            divisions: divisions.to_vec(),
            parts: Vec::new(),
            law,
            variables,
            end_time,
            solver: json!({}),
            processes: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// Sets members of solver_settings.
    #[must_use]
    pub fn solver(mut self, members: Value) -> Self {
        self.solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        self
    }

    /// Names a side of the grid, with conditions if wanted.
    #[must_use]
    pub fn side(mut self, name: &str, side: &str, conditions: Option<&str>) -> Self {
        let mut part = json!({"name": name, "side": side});
        if let Some(conditions) = conditions {
            part["conditions"] = conditions.into();
        }
        self.parts.push(part);
        self
    }

    /// Adds a process.
    #[must_use]
    pub fn with(mut self, process: Value) -> Self {
        self.processes.push(process);
        self
    }

    pub fn project(&self) -> Value {
        let dimension = self.divisions.len();
        let material = json!({"constitutive_law": {"name": self.law}, "Variables": self.variables});
        let mut settings = json!({
            "solver_type": "dgmpm", "domain_size": dimension,
            "time_stepping": {"time_step": "auto", "courant_number": 1.0},
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": [
                {"model_part_name": "Background_Grid", "properties_id": 1, "Material": material}]},
        });
        settings.as_object_mut().unwrap().extend(self.solver.as_object().unwrap().clone());
        let grid = json!({"min": [0.0, 0.0, 0.0], "max": self.size, "divisions": self.divisions, "parts": self.parts});
        json!({
            "problem_data": {"problem_name": "scene", "parallel_type": "OpenMP", "start_time": 0.0,
                             "end_time": self.end_time},
            "modelers": [{"name": "RegularGridModeler", "parameters": grid}],
            "solver_settings": settings,
            "processes": {"list": self.processes},
            "output_processes": {"list": self.outputs},
        })
    }

    pub fn write(&self, folder: &Path) {
        std::fs::write(folder.join("ProjectParameters.json"), self.project().to_string()).unwrap();
    }

    /// Runs with these arguments beside `--record`.
    pub fn run(&self, arguments: &[&str]) -> Record {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        run_project(folder.path(), arguments)
    }

    /// What a command of the program says of the project.
    pub fn ask(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
        command.current_dir(folder.path()).args(arguments).arg("ProjectParameters.json");
        let Output { status, stdout, stderr } = command.output().unwrap();
        (status.code(), String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr))
    }
}
