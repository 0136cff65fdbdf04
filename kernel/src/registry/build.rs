//! Components from the blocks of an input file that name them.

use super::{Building, Modeler, Registry};
use crate::diagnostic::{InputErrors, nearest};
use crate::parameters::Parameters;
use crate::processes::{Process, RunOptions};
use crate::solving::solver::Solver;

/// Members of a block of a process.
const BLOCK: &[&str] = &[
    "python_module",
    "kratos_module",
    "Parameters",
    "process_name",
    "help",
    "check",
    "implemented_in_file",
    "implemented_in_module",
];

/// Refuses members of a block that look like a slip of a known one.
fn check_block(block: &Parameters) -> Result<(), InputErrors> {
    let mut errors = InputErrors::default();
    for (name, value) in block.members() {
        if !BLOCK.contains(&name.as_str()) && nearest(&name, BLOCK.iter().copied()).is_some() {
            errors.push(value.error(format!("the key {name:?} is unknown")).allowed(&name, BLOCK.iter().copied()));
        }
    }
    errors.or(())
}

impl Registry {
    /// The process of a block: `{"python_module": …, "kratos_module": …, "Parameters": {…}}`.
    ///
    /// # Errors
    /// An unknown module, or faults of its parameters.
    pub fn build_process(
        &self,
        block: &Parameters,
        project: &Parameters,
        options: &RunOptions,
    ) -> Result<Box<dyn Process>, InputErrors> {
        check_block(block)?;
        let name = block.text("python_module")?;
        let last = name.rsplit('.').next().unwrap_or(&name);
        let Some(entry) = self.process_named(&name) else {
            let place = block.child("python_module").unwrap_or_else(|| block.clone());
            let message = format!("there is no process {name:?}");
            return Err(place.error(message).allowed(last, self.processes.iter().map(|e| e.name)).into());
        };
        let Some(parameters) = block.child("Parameters") else {
            return Err(block.error("the key \"Parameters\" is missing").into());
        };
        let settings = parameters.read(entry.keys)?;
        (entry.build)(Building { settings, registry: self, options, project })
    }

    /// The modeler of a block, in the new (`name`, `parameters`) or old (`modeler_name`,
    /// `Parameters`) form.
    ///
    /// # Errors
    /// An unknown name, or faults of its parameters.
    pub fn build_modeler(
        &self,
        block: &Parameters,
        project: &Parameters,
        options: &RunOptions,
    ) -> Result<Box<dyn Modeler>, InputErrors> {
        let key = if block.child("name").is_some() { "name" } else { "modeler_name" };
        let name = block.text(key)?;
        let last = name.rsplit('.').next().unwrap_or(&name);
        let Some(entry) = self.modelers.iter().find(|e| e.name == last) else {
            let place = block.child(key).unwrap_or_else(|| block.clone());
            let message = format!("there is no modeler {name:?}");
            return Err(place.error(message).allowed(last, self.modelers.iter().map(|e| e.name)).into());
        };
        let Some(parameters) = block.child("parameters").or_else(|| block.child("Parameters")) else {
            return Err(block.error("the key \"parameters\" is missing").into());
        };
        let settings = parameters.read(entry.keys)?;
        (entry.build)(Building { settings, registry: self, options, project })
    }

    /// The solver that `solver_settings.solver_type` names.
    ///
    /// # Errors
    /// An unknown type, or faults of the settings.
    pub fn build_solver(&self, settings: &Parameters, options: &RunOptions) -> Result<Box<dyn Solver>, InputErrors> {
        let names = || self.solvers.iter().flat_map(|e| e.types.iter().copied());
        if settings.value().is_object() && settings.child("solver_type").is_none() {
            let list = names().collect::<Vec<_>>().join(", ");
            return Err(settings.error("\"solver_type\" is missing").help(format!("allowed: {list}")).into());
        }
        let name = settings.text("solver_type")?;
        match self.solver_of_type(&name) {
            Some(entry) => (entry.build)(settings, self, options),
            None => {
                let place = settings.child("solver_type").unwrap_or_else(|| settings.clone());
                Err(place.error(format!("there is no solver type {name:?}")).allowed(&name, names()).into())
            }
        }
    }
}
