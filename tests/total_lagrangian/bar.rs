//! A bar along x that fills its grid, in one JSON file: fixed at x = 0, loaded or let go at x = L.

use super::common::{Record, run_project};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

/// Functions of the grid, with points enough for them.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    pub basis: &'static str,
    pub order: usize,
    pub points: usize,
}

pub const HATS: Functions = Functions { basis: "mesh", order: 1, points: 2 };
pub const QUADRATIC: Functions = Functions { basis: "lagrange", order: 2, points: 3 };
pub const SPLINE: Functions = Functions { basis: "b_spline", order: 2, points: 3 };
pub const CUBIC: Functions = Functions { basis: "b_spline", order: 3, points: 4 };

/// A bar.
#[derive(Clone, Debug)]
pub struct Bar {
    pub cells: usize,
    pub length: f64,
    pub area: f64,
    pub density: f64,
    pub young: f64,
    pub poisson: f64,
    pub law: &'static str,
    pub functions: Functions,
    pub placement: &'static str,
    /// Members of solver_settings.
    pub solver: Value,
    pub processes: Vec<Value>,
    pub end_time: f64,
}

pub const NEO_HOOKEAN: &str = "HyperElasticNeoHookean3DLaw";
pub const LINEAR: &str = "LinearElasticUniaxialStrain1DLaw";

impl Bar {
    /// Speed of waves of small amplitude, in m/s.
    pub fn wave_speed(&self) -> f64 {
        let (e, nu) = (self.young, self.poisson);
        (e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / self.density).sqrt()
    }

    /// Sets the time step to so many cells a wave crosses in it.
    #[must_use]
    pub fn at_courant(mut self, courant: f64) -> Self {
        let step = courant * self.length / self.cells as f64 / self.wave_speed();
        self.solver["time_stepping"] = json!({"time_step": step});
        self.end_time -= 0.5 * step;
        self
    }

    /// A force at x = L, a number or a function of t.
    #[must_use]
    pub fn pulled(mut self, force: Value) -> Self {
        self.processes.push(json!({"python_module": "assign_vector_by_direction_to_condition_process",
            "Parameters": {"model_part_name": "Background_Grid.Right", "variable_name": "POINT_LOAD",
                           "modulus": force, "direction": [1, 0, 0]}}));
        self
    }

    /// A velocity of all points, a function of x.
    #[must_use]
    pub fn flung(mut self, velocity: &str) -> Self {
        self.processes.push(json!({"python_module": "assign_initial_field_to_material_point_process",
            "Parameters": {"model_part_name": "MPM_Material", "value": [velocity, "0", "0"]}}));
        self
    }

    fn project(&self) -> Value {
        let mut solver = json!({
            "solver_type": "dynamic", "scheme_type": "newmark", "domain_size": 1, "frame": "total_lagrangian",
            "basis": self.functions.basis, "basis_order": self.functions.order, "point_placement": self.placement,
            "residual_relative_tolerance": 1e-9, "residual_absolute_tolerance": 0.0,
            "model_import_settings": {"input_type": "use_input_model_part"},
            "grid_model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": [{
                "model_part_name": "Initial_MPM_Material.Bar", "properties_id": 1,
                "Material": {"constitutive_law": {"name": self.law}, "Variables": {
                    "DENSITY": self.density, "CROSS_AREA": self.area, "YOUNG_MODULUS": self.young,
                    "POISSON_RATIO": self.poisson, "MATERIAL_POINTS_PER_ELEMENT": self.functions.points}}}]}
        });
        solver.as_object_mut().unwrap().extend(self.solver.as_object().unwrap().clone());
        let fixed = json!({"python_module": "assign_vector_variable_process", "Parameters": {
            "model_part_name": "Background_Grid.Left", "variable_name": "DISPLACEMENT",
            "constrained": [true, true, true], "value": [0, 0, 0]}});
        let processes = [vec![fixed], self.processes.clone()].concat();
        let (low, high) = ([0.0; 3], [self.length, 0.0, 0.0]);
        let point_load = "MPMGridPointLoadCondition1D1N";
        json!({
            "problem_data": {"end_time": self.end_time},
            "modelers": [
                {"name": "Modelers.Bia.RegularGridModeler", "parameters": {
                    "min": low, "max": high, "divisions": [self.cells], "parts": [
                        {"name": "Left", "side": "min_x"},
                        {"name": "Right", "side": "max_x", "conditions": point_load}]}},
                {"name": "Modelers.Bia.BodyModeler", "parameters": {"bodies": [
                    {"name": "Bar", "primitive": {"type": "box", "min": low, "max": high}, "divisions": [self.cells]}]}}],
            "solver_settings": solver,
            "processes": {"list": processes},
        })
    }

    fn write(&self) -> TempDir {
        let folder = TempDir::new().unwrap();
        std::fs::write(folder.path().join("ProjectParameters.json"), self.project().to_string()).unwrap();
        folder
    }

    /// Runs it; the record has so many states.
    pub fn run(&self, states: usize) -> Record {
        run_project(self.write().path(), &["--record-states", &states.to_string()])
    }

    /// The same; none if the run breaks down.
    pub fn try_run(&self, states: usize) -> Option<Record> {
        let folder = self.write();
        let (status, message) = launch(&folder, &["--record", "record.json", "--record-states", &states.to_string()]);
        assert!(matches!(status, Some(0 | 3)), "{message}");
        (status == Some(0)).then(|| Record::read(&folder.path().join("record.json")))
    }

    /// Exit status of a run, and what it says of its failure.
    pub fn failure(&self) -> (Option<i32>, String) {
        launch(&self.write(), &[])
    }
}

/// Settings of an explicit run: MUSL with these members on top.
pub fn explicit(members: Value) -> Value {
    let mut solver = json!({"time_integration_method": "explicit", "scheme_type": "forward_euler",
                            "stress_update": "musl"});
    solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    solver
}

fn launch(folder: &TempDir, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder.path()).args(["run", "ProjectParameters.json", "--quiet", "--threads", "1"]);
    let output = command.args(arguments).output().expect("the built program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// First components of a vector field.
pub fn along(rows: &[Vec<f64>]) -> Vec<f64> {
    rows.iter().map(|row| row[0]).collect()
}

/// Largest |E/E₀ − 1| of kinetic and strain energy over a record.
pub fn energy_drift(record: &Record) -> f64 {
    let energies: Vec<f64> = record.states().iter().map(|s| s.energy("kinetic") + s.energy("strain")).collect();
    energies.iter().map(|e| (e / energies[0] - 1.0).abs()).fold(0.0, f64::max)
}
