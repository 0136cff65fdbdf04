//! The solver of an application, as the analysis drives it.

use super::StepReport;
use super::newton::OnNoConvergence;
use crate::analysis::FAILED_STATE;
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::dataset::Dataset;
use crate::io::json::JsonObject;
use crate::io::vtu::{VtuOptions, write_vtu};
use crate::model::Model;
use crate::processes::{Clock, Context, Process, Requirements};
use crate::registry::Registry;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What a scene consists of, for `bia check` and the summary of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inventory {
    /// Lines of (what, how much), in the order to be shown.
    pub lines: Vec<(String, String)>,
    /// Columns that the solver can have.
    pub columns: Vec<ColumnUse>,
    /// How many cells, nodes, points and unknowns.
    pub counts: Counts,
    /// Suspicious but legal facts.
    pub warnings: Vec<String>,
}

/// Nodes of a grid in which bodies move.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Reached {
    /// The root part of the grid.
    pub root: &'static str,
    /// Whether a body is at each node.
    pub now: Vec<bool>,
    /// Whether one has been there at any time.
    pub ever: Vec<bool>,
}

/// Sizes of a scene as numbers; 0 where there is no such thing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Cells of the mesh.
    pub cells: usize,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Material points, or points where a law is evaluated.
    pub points: usize,
    /// Unknowns of a step.
    pub unknowns: usize,
}

/// A column of numbers that a scene has, or does without.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnUse {
    /// What it holds.
    pub name: &'static str,
    /// Its size; 0 where the scene does without it.
    pub bytes: usize,
}

/// Energy of bodies in J, and the work on them where anything but their weight works.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MechanicalEnergy {
    /// Kinetic energy, and strain energy where the law has one.
    pub own: f64,
    /// −Σ m g·x.
    pub potential: f64,
    /// What the weight could do if all sank to the lowest place.
    pub height: f64,
    /// Work of loads and of supports that move since the start; 0 where there are none.
    pub work: f64,
    /// Neither laws nor a weight take any of it, and it is all that there is.
    pub is_kept: bool,
}

impl MechanicalEnergy {
    /// Saves or loads an energy that may be there.
    ///
    /// # Errors
    /// The checkpoint does not hold it.
    pub fn exchange(energy: &mut Option<Self>, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut values = energy.map_or(Vec::new(), |e| vec![[e.own, e.potential, e.height, e.work]]);
        let mut is_kept = energy.is_some_and(|e| e.is_kept);
        archive.column("energy at the start", &mut values)?;
        archive.flag("energy at the start is kept", &mut is_kept)?;
        if archive.is_loading() {
            let of = |&[own, potential, height, work]: &[f64; 4]| Self { own, potential, height, work, is_kept };
            *energy = values.first().map(of);
        }
        Ok(())
    }
}

/// An application's solver. The analysis calls these in Kratos's order (spec 01 §1.2).
pub trait Solver: Send {
    /// Reads meshes and materials into the model.
    ///
    /// # Errors
    /// Faults of the input, all together.
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors>;

    /// Makes what the solver solves for (material points, say) and allocates what the processes
    /// will read, and nothing else.
    ///
    /// # Errors
    /// Faults of the input that show only now, such as a wanted variable that nobody provides.
    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors>;

    /// Processes that the solver itself puts at the head of the pipeline, such as the reset of a
    /// grid.
    fn processes(&self) -> Vec<Box<dyn Process>> {
        Vec::new()
    }

    /// Once, after the processes' hook of this name.
    ///
    /// # Errors
    /// A numerical failure.
    #[allow(unused_variables)]
    fn before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    /// Saves what the solver keeps from step to step to a checkpoint, its own data beside the model parts
    /// included, or loads it from there: in a resumed run, instead of
    /// [`before_solution_loop`](Self::before_solution_loop). What the input gives, and what is found anew
    /// in each step, does not belong there.
    ///
    /// # Errors
    /// The checkpoint does not fit. A solver without this hook refuses runs that shall be resumed.
    #[allow(unused_variables)]
    fn exchange_state(&mut self, model: &mut Model, archive: &mut Archive) -> Result<(), CheckpointError> {
        Err(CheckpointError::Unsupported("the solver".into()))
    }

    /// Size of the step that begins at `clock.time`, in seconds.
    ///
    /// # Errors
    /// A step that is not positive.
    fn time_step(&mut self, model: &Model, clock: &Clock) -> Result<f64, Error>;

    /// The largest step that is stable now, in seconds, where the scheme has a limit that is known.
    #[allow(unused_variables)]
    fn stable_time_step(&self, model: &Model) -> Option<f64> {
        None
    }

    /// Whether [`time_step`](Self::time_step) depends on the time alone, so that the number of steps
    /// can be told before the run.
    fn plans_steps(&self) -> bool {
        true
    }

    /// What becomes of a step that does not converge. A step that is cut starts again from what
    /// [`exchange_state`](Self::exchange_state) kept.
    fn on_no_convergence(&self) -> OnNoConvergence {
        OnNoConvergence::Continue
    }

    /// When in a step loads act, as a share of it: at its end, unless the scheme takes forces earlier.
    fn load_time(&self) -> f64 {
        1.0
    }

    /// Search, reset of the grid, transfer to it, prediction.
    ///
    /// # Errors
    /// A numerical failure; likewise below.
    fn predict(&mut self, context: &mut Context) -> Result<(), Error>;

    /// Solves the step.
    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error>;

    /// Transfer from the grid, history.
    fn finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error>;

    /// What the scene consists of.
    fn inventory(&self, model: &Model) -> Inventory;

    /// Kinetic, strain and potential energy in joules, as far as they are known.
    fn energies(&self, model: &Model) -> Vec<(&'static str, f64)>;

    /// Energy of bodies, and the work that was done on them. None where something works on them whose work is not
    /// known, or where the scene has no inertia.
    #[allow(unused_variables)]
    fn mechanical_energy(&self, model: &Model) -> Option<MechanicalEnergy> {
        None
    }

    /// What a user should know after the run, such as points that were lost.
    #[allow(unused_variables)]
    fn remarks(&self, model: &Model) -> Vec<String> {
        Vec::new()
    }

    /// The nodes on which bodies are and were; none where bodies are meshes.
    #[allow(unused_variables)]
    fn reached(&self, model: &Model) -> Option<Reached> {
        None
    }

    /// Fixed facts for the account of a run (`n_mp`, `laws`, …).
    fn account(&self, model: &Model) -> serde_json::Map<String, serde_json::Value>;

    /// Writes the present state for the account of a run.
    ///
    /// # Errors
    /// The file cannot be written.
    fn snapshot(&self, model: &Model, out: &mut JsonObject) -> std::io::Result<()>;

    /// Time spent in the solver's own stages.
    fn stages(&self) -> Vec<(&'static str, Duration)>;

    /// Saves the state for ParaView after a failure and returns the files.
    ///
    /// # Errors
    /// The folder cannot be written.
    fn save_state(&self, model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error>;
}

/// Writes the data set of a failed run for [`Solver::save_state`].
///
/// # Errors
/// The folder cannot be written.
pub fn write_failed_state(data: &Dataset, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let path = folder.join(FAILED_STATE);
    let written = std::fs::create_dir_all(folder).and_then(|()| write_vtu(&path, data, None, &VtuOptions::default()));
    match written {
        Ok(_) => Ok(vec![path]),
        Err(source) => Err(Error::Write { path, source }),
    }
}
