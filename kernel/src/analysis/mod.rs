//! The analysis: builds what a project names and drives it through time in Kratos's order.

mod account;
mod balance;
mod checkpoints;
mod old_names;
mod prepare;
mod project;
mod reach;
mod restart;
mod schema;
mod step;
mod summary;

pub use account::{Account, RecordPlan, number, peak_memory_mb};
pub use project::Project;
pub use schema::{project_keys, project_schema};

use crate::diagnostic::{Diagnostic, Place};
use crate::error::{Error, Failure};
use crate::io::checkpoint::{Archive, Contents, file};
use crate::model::Model;
use crate::parameters::Parameters;
use crate::processes::{Clock, Context, Process, Results, RunOptions};
use crate::solving::StepReport;
use crate::solving::solver::{Inventory, MechanicalEnergy, Solver};
use crate::variables::Variable;
use account::Recorder;
use restart::Restart;
use std::path::Path;
use std::time::{Duration, Instant};

/// Name of the file to which a failed run saves its state.
pub const FAILED_STATE: &str = "failed_state.vtu";

/// Watches a run: the command line shows progress with it.
pub trait Observer {
    /// A step is done. `planned` is the number of steps expected, if it can be known.
    fn step(&mut self, clock: &Clock, planned: Option<usize>, report: &StepReport);

    /// Asked after each step: whether the run shall stop here, with a checkpoint if the project has
    /// `restart`.
    fn wants_to_stop(&self) -> bool {
        false
    }
}

/// An observer that looks away.
impl Observer for () {
    fn step(&mut self, _: &Clock, _: Option<usize>, _: &StepReport) {}
}

/// A project, read, checked and ready to run.
pub struct Analysis {
    /// The model.
    pub model: Model,
    solver: Box<dyn Solver>,
    processes: Vec<Box<dyn Process>>,
    clock: Clock,
    options: RunOptions,
    project: Parameters,
    restart: Option<Restart>,
    /// By which a checkpoint is told from those of other projects; none before the run.
    identity: serde_json::Value,
    /// All that there are, so that columns of a checkpoint find their names.
    variables: Vec<Variable>,
    /// Settings of the solver that may change where a run has failed.
    adjustable: Vec<&'static str>,
    warnings: Vec<String>,
    /// Nodes at which bodies were in the first step.
    reached_first: Vec<bool>,
    /// Where nothing but their weight works on the bodies.
    energy_at_start: Option<MechanicalEnergy>,
    stages: Vec<(&'static str, Duration)>,
    /// That of the last run, however it ended.
    account: Option<Account>,
    /// The stable time step in the first step, in seconds, where it is known.
    first_stable: Option<f64>,
}

impl Analysis {
    /// What the scene consists of.
    pub fn inventory(&self) -> Inventory {
        let mut inventory = self.solver.inventory(&self.model);
        inventory.warnings.splice(0..0, self.warnings.iter().cloned());
        inventory
    }

    /// Names of the processes, in the order in which they act.
    pub fn pipeline(&self) -> Vec<&str> {
        self.processes.iter().map(|process| process.name()).collect()
    }

    /// The solver.
    pub fn solver(&self) -> &dyn Solver {
        self.solver.as_ref()
    }

    /// What the processes have found.
    pub fn results(&self) -> Results {
        let mut results = Results::default();
        self.processes.iter().for_each(|process| process.results(&mut results));
        results
    }

    /// Whether a path is a file that the project reads.
    pub fn is_input(&self, path: &Path) -> bool {
        self.project.is_input(path)
    }

    /// Steps that the run will take, if the step depends on nothing but the time.
    pub fn planned_steps(&mut self) -> Option<usize> {
        const MOST: usize = 50_000_000;
        if !self.solver.plans_steps() {
            return None;
        }
        let mut clock = self.clock;
        while clock.time < clock.end {
            let step = self.solver.time_step(&self.model, &clock).ok()?;
            clock = Clock { step: clock.step + 1, time: clock.time + step, time_step: step, ..clock };
            if step <= 0.0 || clock.step > MOST {
                return None;
            }
        }
        Some(clock.step)
    }

    /// That the first step is above the stable one, where that is known before the run: motion that
    /// begins with the run lowers it further.
    pub fn unstable_step(&mut self) -> Option<Diagnostic> {
        // A step that is a share of the stable one is never above it.
        let stable = self.solver.stable_time_step(&self.model).filter(|_| self.solver.plans_steps())?;
        let step = self.solver.time_step(&self.model, &self.clock).ok().filter(|step| *step > stable)?;
        let place = self.project.child("solver_settings")?.child("time_stepping")?;
        let message = format!("the time step {step:.4e} s is above the stable one, {stable:.4e} s");
        Some(place.warning(message).help("a smaller step, or \"time_step\": \"auto\""))
    }

    /// Runs to the end, or until the observer wants to stop.
    ///
    /// # Errors
    /// A numerical failure (after saving the state), or a file that cannot be written.
    pub fn run(&mut self, observer: &mut dyn Observer, record: Option<RecordPlan>) -> Result<Account, Error> {
        self.start(observer, record, false)
    }

    /// Goes on from the newest whole checkpoint, to the same bits as if the run had never stopped.
    ///
    /// # Errors
    /// There is no checkpoint, or it is of another project; else as [`Self::run`].
    pub fn resume(&mut self, observer: &mut dyn Observer, record: Option<RecordPlan>) -> Result<Account, Error> {
        self.start(observer, record, true)
    }

    fn start(
        &mut self,
        observer: &mut dyn Observer,
        record: Option<RecordPlan>,
        resumes: bool,
    ) -> Result<Account, Error> {
        if let Some(plan) = record.as_ref().filter(|plan| self.project.is_input(&plan.path)) {
            let message = format!("the record {} would overwrite an input file", plan.path.display());
            return Err(Diagnostic::error(Place::default(), message).into());
        }
        let checkpoint = self.choose_checkpoint(record.as_ref(), resumes)?;
        let planned = self.planned_steps();
        // What an earlier run left must not be taken for this one's.
        let _ = std::fs::remove_file(self.options.output.join(FAILED_STATE));
        let keeps = self.restart.is_some();
        let record = record.map(|plan| Recorder::new(plan, planned, &self.clock, resumes, keeps));
        let recorder = record.transpose()?;
        let mut account = Account::start();
        let ended = self.go(observer, planned, recorder, &mut account, checkpoint);
        self.account = Some(account.clone());
        ended.map(|()| account)
    }

    /// The loop and what follows it, whatever its end.
    fn go(
        &mut self,
        observer: &mut dyn Observer,
        planned: Option<usize>,
        mut recorder: Option<Recorder>,
        account: &mut Account,
        checkpoint: Option<Contents>,
    ) -> Result<(), Error> {
        let ended = self.run_loop(observer, planned, &mut recorder, account, checkpoint);
        account.steps = self.clock.step;
        account.end_time = self.clock.time;
        account.end_loop();
        match ended {
            Ok(()) => self.finish(account, recorder),
            Err(Error::Failure(failure)) => Err(Error::Failure(self.complete(failure))),
            Err(other) => Err(other),
        }
    }

    /// Adds to a failure when it happened, and where the state was saved.
    fn complete(&mut self, mut failure: Failure) -> Failure {
        failure.stamp(self.clock.step, self.clock.time);
        failure = failure.detail(match self.solver.save_state(&self.model, &self.options.output) {
            Ok(files) => {
                let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
                format!("the state was saved to {}", names.join(", "))
            }
            Err(error) => format!("the state could not be saved: {error}"),
        });
        self.save_before(failure)
    }

    /// What is told of a run that has ended without an error.
    fn finish(&mut self, account: &mut Account, mut recorder: Option<Recorder>) -> Result<(), Error> {
        let remarks = self.solver.remarks(&self.model).into_iter().chain(self.unreached());
        for remark in remarks.chain(self.unbalanced()) {
            tracing::warn!("{remark}");
        }
        account.stages = std::mem::take(&mut self.stages);
        account.stages.splice(1..2, self.solver.stages());
        account.energies = self.solver.energies(&self.model);
        account.files = self.processes.iter().flat_map(|p| p.files()).collect();
        if let Some(restart) = self.restart.as_ref().filter(|restart| !restart.cost.is_zero()) {
            account.stages.push(("checkpoints", restart.cost));
        }
        if account.interrupted {
            account.checkpoint = self.restart.as_ref().and_then(|restart| restart.files.last().cloned());
            return Ok(());
        }
        if let Some(recorder) = &mut recorder {
            let mut head = self.solver.account(&self.model);
            let errors = self.results().errors;
            if !errors.is_empty() {
                head.insert("errors".into(), errors.into());
            }
            recorder.complete(account, head)?;
        }
        // A run that is done cannot be resumed. One that is killed from here on begins anew: a checkpoint without the
        // file that it goes on with would be of no use.
        self.restart.as_mut().map_or(Ok(()), Restart::clear)?;
        recorder.map_or(Ok(()), Recorder::publish)
    }

    /// Brings the scene to its start, or to the state of a checkpoint.
    fn begin(
        &mut self,
        account: &mut Account,
        recorder: &mut Option<Recorder>,
        checkpoint: Option<Contents>,
    ) -> Result<(), Error> {
        if let Some(contents) = checkpoint {
            return Ok(self.exchange(&mut Archive::loading(&contents), account, recorder)?);
        }
        if self.restart.is_some() {
            // Better told now than after hours.
            file::check(&mut |archive| self.exchange(archive, account, recorder))?;
        }
        self.all(0, |process, context| process.execute_initialize(context))?;
        self.all(0, |process, context| process.execute_before_solution_loop(context))?;
        let mut context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
        self.solver.before_solution_loop(&mut context)?;
        self.all(2, |process, context| process.print_start(context))?;
        match recorder {
            Some(recorder) => recorder.observe(&self.clock, self.solver.as_ref(), &self.model),
            None => Ok(()),
        }
    }

    fn run_loop(
        &mut self,
        observer: &mut dyn Observer,
        planned: Option<usize>,
        recorder: &mut Option<Recorder>,
        account: &mut Account,
        checkpoint: Option<Contents>,
    ) -> Result<(), Error> {
        self.stages = vec![("processes", Duration::ZERO), ("solver", Duration::ZERO), ("output", Duration::ZERO)];
        let is_resumed = checkpoint.is_some();
        self.begin(account, recorder, checkpoint)?;
        if !is_resumed {
            self.energy_at_start = self.solver.mechanical_energy(&self.model);
        }
        self.keep_state(account, recorder)?;
        account.start_loop();
        while self.clock.time < self.clock.end {
            let step = self.solver.time_step(&self.model, &self.clock)?;
            let report = self.take_step(step)?;
            if self.clock.step == 1 {
                self.reached_first = self.solver.reached(&self.model).map_or(Vec::new(), |reached| reached.now);
            }
            if self.first_stable.is_none() {
                self.first_stable = self.solver.stable_time_step(&self.model);
            }
            self.all(0, |process, context| process.execute_finalize_solution_step(context))?;
            self.print()?;
            account.step(&self.clock, &report);
            if let Some(recorder) = recorder {
                recorder.observe(&self.clock, self.solver.as_ref(), &self.model)?;
            }
            observer.step(&self.clock, planned, &report);
            // The last step may as well be finished.
            account.interrupted = observer.wants_to_stop() && self.clock.time < self.clock.end;
            self.save_checkpoint(account, recorder, account.interrupted)?;
            if account.interrupted {
                break;
            }
        }
        account.end_loop();
        if account.interrupted {
            return Ok(());
        }
        self.all(0, |process, context| process.execute_finalize(context))
    }

    /// Calls a hook of all processes from `first` on.
    fn all(
        &mut self,
        stage: usize,
        hook: impl Fn(&mut dyn Process, &mut Context) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let begin = Instant::now();
        let mut context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
        for process in &mut self.processes {
            hook(process.as_mut(), &mut context)?;
        }
        self.stages[stage].1 += begin.elapsed();
        Ok(())
    }

    /// Lets the output processes print whose time has come, in whatever list they stand.
    fn print(&mut self) -> Result<(), Error> {
        for i in 0..self.processes.len() {
            let begin = Instant::now();
            let context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
            if !self.processes[i].is_output_step(&context) {
                continue;
            }
            self.all(2, |process, context| process.execute_before_output_step(context))?;
            let mut context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
            self.processes[i].print_output(&mut context)?;
            self.stages[2].1 += begin.elapsed();
            self.all(2, |process, context| process.execute_after_output_step(context))?;
        }
        Ok(())
    }
}
