//! Processes: what a scene does beside solving, driven by the hooks of the analysis.

pub mod assign;
mod csv_table;
pub mod json;
pub mod measure;
pub mod quantity;
mod reset;
pub mod sampled;
mod value;
pub mod vtk;

pub use reset::ResetNodes;
pub use value::{Interval, SpaceTimeValue, not_finite};

use crate::diagnostic::{Diagnostic, InputErrors};
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::model::Model;
use crate::parameters::Parameters;
use crate::registry::Provider;
use crate::variables::Variable;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Step and time of the analysis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Steps done or being done; 0 before the loop.
    pub step: usize,
    /// Time at the end of the step, in seconds.
    pub time: f64,
    /// Size of the step, in seconds.
    pub time_step: f64,
    /// When in the step loads act, as the solver's scheme means it, in seconds.
    pub load_time: f64,
    /// First time, in seconds.
    pub start: f64,
    /// The loop runs while the time is below this one, in seconds.
    pub end: f64,
    /// Share of the given step that is being taken: below 1 in pieces of a step that was cut.
    pub share: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { step: 0, time: 0.0, time_step: 0.0, load_time: 0.0, start: 0.0, end: 0.0, share: 1.0 }
    }
}

/// Choices of a run that do not stand in the project.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Folder of the project file: input files are sought there.
    pub folder: PathBuf,
    /// Folder for results.
    pub output: PathBuf,
    /// Reproduce Kratos 10.4.4 to round-off, its faults included.
    pub kratos_exact: bool,
}

/// What a hook may see and change.
pub struct Context<'a> {
    /// The model.
    pub model: &'a mut Model,
    /// Step and time.
    pub clock: &'a Clock,
    /// Choices of the run.
    pub options: &'a RunOptions,
}

/// Where a wanted variable lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// On material points (or the solver's own points).
    Points,
    /// On the conditions of the points' part.
    PointConditions,
    /// On nodes of a mesh.
    Nodes,
    /// On elements of a mesh.
    Elements,
}

impl Location {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::PointConditions => "conditions of points",
            Self::Nodes => "nodes",
            Self::Elements => "elements",
        }
    }
}

/// A variable that a process will read, with the place of the JSON that asks for it.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Where.
    pub location: Location,
    /// Its name.
    pub variable: String,
    /// Who asks.
    pub place: Parameters,
}

/// All that the processes of a scene will read. Solvers allocate this and nothing else.
#[derive(Debug, Clone, Default)]
pub struct Requirements {
    /// Variables.
    pub variables: Vec<Wanted>,
    /// Kinetic, strain and potential energy.
    pub energies: bool,
    /// Positions of points at the start of the run.
    pub initial_positions: bool,
    /// Everything that the account of a run (`--record`) holds.
    pub record: bool,
    /// Nodal variables that processes write.
    pub provided: Vec<&'static str>,
    /// Files that processes write.
    pub written: Vec<PathBuf>,
    /// Faults of what processes read and write between them.
    pub faults: InputErrors,
    /// What solvers of all kinds can show.
    pub providers: Vec<Provider>,
}

impl Requirements {
    /// Those of the variables that a solver knows at a location which are wanted there; the others
    /// that are wanted there become errors, unless a process provides them.
    pub fn choose(&self, location: Location, known: &[Variable], errors: &mut InputErrors) -> Vec<Variable> {
        let mut chosen: Vec<Variable> = Vec::new();
        let provided = |name: &str| location == Location::Nodes && self.provided.contains(&name);
        for wanted in self.variables.iter().filter(|wanted| wanted.location == location && !provided(&wanted.variable))
        {
            match known.iter().find(|variable| variable.name == wanted.variable) {
                Some(variable) if chosen.iter().any(|other| other.name == variable.name) => {}
                Some(variable) => chosen.push(*variable),
                None => errors.push(self.nobody(wanted, known.iter().map(|variable| variable.name))),
            }
        }
        chosen
    }

    /// The fault that a solver, which knows these names, does not provide what is wanted; tells who could.
    pub fn nobody(&self, wanted: &Wanted, known: impl Iterator<Item = &'static str>) -> Diagnostic {
        let name = wanted.variable.as_str();
        let fault = wanted.place.error(format!("nobody in this scene provides {name:?}"));
        let names: Vec<&str> = known.filter(|known| *known != name).collect();
        let others = self.providers.iter().filter(|provider| (provider.variables)().contains(&name));
        let others: Vec<String> =
            others.map(|provider| format!("{} on {}", provider.who, provider.location.name())).collect();
        match (others.is_empty(), names.is_empty()) {
            (true, _) => fault.allowed(name, names),
            (false, true) => fault.help(format!("provided by: {}", others.join("; "))),
            (false, false) => fault.help(format!("provided by: {}. Here: {}", others.join("; "), names.join(", "))),
        }
    }

    /// Says that the process at `place` writes a nodal variable, at the end of each step. Processes
    /// that read it must come after it, and no other may write it.
    pub fn provide(&mut self, variable: &'static str, place: &Parameters) {
        if self.provided.contains(&variable) {
            self.faults.push(place.error(format!("another process writes {variable:?} to the nodes, too")));
        } else if self.wants(Location::Nodes, variable) {
            let message = format!("a process before this one reads {variable:?} of the nodes, which this one writes");
            self.faults.push(place.error(message).help("put this process before it, in an earlier list"));
        }
        self.provided.push(variable);
    }

    /// Says that the process at `place` writes a file, which no other may write.
    pub fn write(&mut self, path: &Path, place: &Parameters) {
        if self.written.iter().any(|other| other == path) {
            let message = format!("another process writes {}, too", path.display());
            self.faults.push(place.error(message).help("give one of them another name or folder"));
        }
        self.written.push(path.to_path_buf());
    }

    /// True when a variable is wanted at a location.
    pub fn wants(&self, location: Location, variable: &str) -> bool {
        self.variables.iter().any(|w| w.location == location && w.variable == variable)
    }
}

/// What processes have found, for the summary of a run (`--summary`).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results {
    /// Errors by label.
    pub errors: Map<String, Value>,
    /// Measured values: by table, column, and `first`, `last`, `smallest` or `largest`.
    pub values: Map<String, Value>,
}

impl Results {
    /// Adds the values of a table, by the name of its file without the extension.
    pub fn add_table(&mut self, path: &Path, extremes: &measure::Extremes) {
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let values = extremes.values();
        if !values.is_empty() {
            self.values.insert(name, values.into());
        }
    }
}

/// A process. Every hook does nothing by default; the analysis calls them in Kratos's order.
#[allow(unused_variables)]
pub trait Process: Send {
    /// Name for messages and timings.
    fn name(&self) -> &str;

    /// Resolves the names of model parts once the meshes are read; may mark entities for the
    /// solver's set-up.
    ///
    /// # Errors
    /// Names that do not exist, entities that do not fit: all together.
    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        Ok(())
    }

    /// Names the variables that the process will read.
    fn require(&self, requirements: &mut Requirements) {}

    /// Once everything is set up, before the run: faults that show only now.
    ///
    /// # Errors
    /// Faults of the input, all together.
    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        Ok(())
    }

    /// Before the loop, ahead of all other processes' hooks that follow.
    ///
    /// # Errors
    /// Whatever stops the run; likewise for all hooks below.
    fn execute_initialize(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Once, after the solver is initialised.
    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Once, after the solver too is ready: output processes show the state at the start.
    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// At the start of each step, before the search.
    fn execute_initialize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Between the pieces of a step that is cut, each of which begins with the hook above: gives up what holds
    /// for a piece alone, such as fixed values. What is shown at the end of a step is not shown here.
    fn execute_between_pieces(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// At the end of each step.
    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Before any output of a step.
    fn execute_before_output_step(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// After all output of a step.
    fn execute_after_output_step(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// After the loop.
    fn execute_finalize(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Whether an output process prints now; other processes never do.
    fn is_output_step(&mut self, context: &Context) -> bool {
        false
    }

    /// Prints.
    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Saves what the process keeps from step to step to a checkpoint, or loads it from there: in a
    /// resumed run, instead of [`execute_initialize`](Self::execute_initialize) and
    /// [`execute_before_solution_loop`](Self::execute_before_solution_loop). Values in the model are not
    /// its concern. Files that it writes go on where they stood. A process that keeps nothing returns
    /// `Ok(())`; with one that does not say so, runs are refused that shall be resumed.
    ///
    /// # Errors
    /// The checkpoint does not fit, or a file cannot go on.
    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        Err(CheckpointError::Unsupported(format!("the process {:?}", self.name())))
    }

    /// Adds what the process has found to the summary of the run.
    fn results(&self, results: &mut Results) {}

    /// Files written so far, for the summary.
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }
}
