//! What is registered: components with their keys, what they do, and how to build them.

use super::Registry;
use crate::diagnostic::InputErrors;
use crate::model::Model;
use crate::parameters::{Key, Parameters, Settings};
use crate::processes::{Location, Process, RunOptions};
use crate::solving::solver::Solver;
use std::path::PathBuf;

/// What a component is built from.
pub struct Building<'a> {
    /// Its checked settings.
    pub settings: Settings,
    /// All components, for names that the settings mention.
    pub registry: &'a Registry,
    /// Choices of the run.
    pub options: &'a RunOptions,
    /// The whole project, for the few components that look beside their own settings.
    pub project: &'a Parameters,
}

impl Building<'_> {
    /// A result file, refused where it would take the place of an input file.
    ///
    /// # Errors
    /// The file is the project, its materials or a mesh.
    pub fn result_file(&self, path: PathBuf) -> Result<PathBuf, InputErrors> {
        match self.project.is_input(&path) {
            true => {
                let message = format!("the result {} would overwrite an input file", path.display());
                Err(self.settings.parameters().error(message).help("choose another name or folder").into())
            }
            false => Ok(path),
        }
    }
}

/// A process and how to build it.
#[derive(Clone, Copy)]
pub struct ProcessEntry {
    /// Its `python_module`.
    pub name: &'static str,
    /// Older names.
    pub aliases: &'static [&'static str],
    /// The application it belongs to; none for the kernel.
    pub application: Option<&'static str>,
    /// Keys of its `Parameters`.
    pub keys: &'static [Key],
    /// What it does.
    pub help: &'static str,
    /// Builds it.
    pub build: fn(Building) -> Result<Box<dyn Process>, InputErrors>,
}

/// Makes or changes model parts before the solver sees them.
pub trait Modeler: Send {
    /// Creates model parts and reads or makes their meshes.
    ///
    /// # Errors
    /// Faults of the input, all together.
    fn setup_geometry(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors>;

    /// Turns geometries into elements and conditions.
    ///
    /// # Errors
    /// Faults of the input, all together.
    #[allow(unused_variables)]
    fn setup_model_part(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        Ok(())
    }
}

/// A modeler and how to build it.
#[derive(Clone, Copy)]
pub struct ModelerEntry {
    /// Its name; leading module names are ignored in the input.
    pub name: &'static str,
    /// Keys of its `parameters`.
    pub keys: &'static [Key],
    /// Keys of the objects in its lists, with words for which they are.
    pub lists: fn() -> Vec<(String, &'static [Key])>,
    /// What it does.
    pub help: &'static str,
    /// Builds it.
    pub build: fn(Building) -> Result<Box<dyn Modeler>, InputErrors>,
}

/// Builds a solver from `solver_settings`.
pub type BuildSolver = fn(&Parameters, &Registry, &RunOptions) -> Result<Box<dyn Solver>, InputErrors>;

/// A solver and how to build it.
#[derive(Clone, Copy)]
pub struct SolverEntry {
    /// Values of `solver_type` that choose it (compared without regard to case, `-` and `_`).
    pub types: &'static [&'static str],
    /// Keys of `solver_settings`.
    pub keys: &'static [Key],
    /// What it does.
    pub help: &'static str,
    /// Builds it from `solver_settings`.
    pub build: BuildSolver,
}

/// A component of an application's own kind, such as a constitutive law, as a user may ask for it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    /// Its name.
    pub name: String,
    /// Other names.
    pub aliases: Vec<String>,
    /// What it is.
    pub help: String,
    /// What it takes: name, unit, range, meaning.
    pub values: Vec<[String; 4]>,
}

/// A kind of components that an application keeps in a catalogue of its own.
#[derive(Clone, Copy)]
pub struct Kinds {
    /// What they are called together, such as "laws".
    pub title: &'static str,
    /// Describes them.
    pub describe: fn(&Registry) -> Vec<Description>,
}

/// What a kind of solver can show, so that who asks another one for it learns where it is.
#[derive(Debug, Clone, Copy)]
pub struct Provider {
    /// The solver in words, such as "structural solvers".
    pub who: &'static str,
    /// Where the variables are.
    pub location: Location,
    /// Their names.
    pub variables: fn() -> Vec<&'static str>,
}
