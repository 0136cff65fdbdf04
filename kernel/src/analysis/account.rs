//! The account of a run: what it did, how long it took, and the states that `--record` asks for.

use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError, reopen};
use crate::io::json::JsonObject;
use crate::model::Model;
use crate::processes::Clock;
use crate::solving::StepReport;
use crate::solving::solver::Solver;
use cpu_time::ProcessTime;
use serde_json::{Map, Value, json};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Seek, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What a run did.
#[derive(Debug, Clone)]
pub struct Account {
    /// Steps taken.
    pub steps: usize,
    /// Time reached, in seconds.
    pub end_time: f64,
    /// Newton iterations of each step.
    pub iterations: Vec<usize>,
    /// Steps whose criterion was not met.
    pub not_converged: Vec<usize>,
    /// Smallest and largest time step, in seconds; infinite and 0 before the first.
    pub time_steps: [f64; 2],
    /// Steps that were cut.
    pub cut: Vec<usize>,
    /// How often a step was halved, at most.
    pub halvings: u32,
    /// Wall time by stage.
    pub stages: Vec<(&'static str, Duration)>,
    /// Energies at the end, in joules.
    pub energies: Vec<(&'static str, f64)>,
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Wall time of the loop.
    pub wall_loop: Duration,
    /// CPU time of the loop, all threads.
    pub cpu_loop: Duration,
    /// The run was asked to stop before its end.
    pub interrupted: bool,
    /// The checkpoint from which an interrupted run can be resumed.
    pub checkpoint: Option<PathBuf>,
    /// Wall and CPU time of the loop before the run was resumed.
    earlier: [Duration; 2],
    begin: Instant,
    /// Wall clock and CPU time when the loop began, if it has.
    loop_begin: Option<(Instant, Duration)>,
}

impl Account {
    pub(super) fn start() -> Self {
        Self {
            steps: 0,
            end_time: 0.0,
            iterations: Vec::new(),
            not_converged: Vec::new(),
            time_steps: [f64::INFINITY, 0.0],
            cut: Vec::new(),
            halvings: 0,
            stages: Vec::new(),
            energies: Vec::new(),
            files: Vec::new(),
            wall_loop: Duration::ZERO,
            cpu_loop: Duration::ZERO,
            interrupted: false,
            checkpoint: None,
            earlier: [Duration::ZERO; 2],
            begin: Instant::now(),
            loop_begin: None,
        }
    }

    pub(super) fn start_loop(&mut self) {
        self.loop_begin = Some((Instant::now(), cpu_total()));
    }

    pub(super) fn end_loop(&mut self) {
        [self.wall_loop, self.cpu_loop] = self.times();
    }

    /// Wall and CPU time of the loop so far.
    fn times(&self) -> [Duration; 2] {
        let [wall, cpu] = self.earlier;
        match self.loop_begin {
            Some((begin, spent)) => [wall + begin.elapsed(), cpu + cpu_total().saturating_sub(spent)],
            None => [wall, cpu],
        }
    }

    /// Saves or loads the account of the steps so far.
    pub(super) fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut times = self.times().map(|time| time.as_secs_f64());
        archive.slice("wall and CPU time", &mut times)?;
        archive.slice("time steps", &mut self.time_steps)?;
        if archive.is_loading() {
            self.earlier = times.map(|time| Duration::try_from_secs_f64(time).unwrap_or_default());
        }
        let mut halvings = self.halvings as usize;
        archive.count("halvings", &mut halvings)?;
        self.halvings = halvings as u32;
        let (iterations, not_converged) = (&mut self.iterations, &mut self.not_converged);
        for (name, list) in [("iterations", iterations), ("not converged", not_converged), ("cut", &mut self.cut)] {
            let mut numbers: Vec<u64> = list.iter().map(|number| *number as u64).collect();
            archive.column(name, &mut numbers)?;
            if archive.is_loading() {
                *list = numbers.into_iter().map(|number| number as usize).collect();
            }
        }
        Ok(())
    }

    pub(super) fn step(&mut self, clock: &Clock, report: &StepReport) {
        self.iterations.push(report.iterations);
        let [smallest, largest] = self.time_steps;
        self.time_steps = [smallest.min(clock.time_step), largest.max(clock.time_step)];
        if !report.converged {
            self.not_converged.push(clock.step);
        }
        if report.halvings > 0 {
            self.cut.push(clock.step);
            self.halvings = self.halvings.max(report.halvings);
        }
    }
}

impl Account {
    /// Wall time since the run began.
    pub(super) fn wall_total(&self) -> Duration {
        self.begin.elapsed()
    }
}

/// CPU time of this process so far.
pub(super) fn cpu_total() -> Duration {
    ProcessTime::try_now().map_or(Duration::ZERO, |time| time.as_duration())
}

/// Largest resident memory so far in megabytes, where the system tells it.
pub fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}

/// Where the account is written and how many states it holds.
#[derive(Debug, Clone)]
pub struct RecordPlan {
    /// The file.
    pub path: PathBuf,
    /// States beside the first one.
    pub states: usize,
    /// Threads used, for the account.
    pub threads: usize,
}

/// When states are written.
enum Due {
    /// After these steps.
    Steps(Vec<usize>),
    /// When the run has passed the next of equal shares of its time, if its steps are not known.
    Times { next: f64, share: f64 },
}

/// Writes states while the run goes on: to a partial file that takes its name when it is whole.
pub(super) struct Recorder {
    plan: RecordPlan,
    due: Due,
    partial: PathBuf,
    file: BufWriter<File>,
    states: usize,
    whole: bool,
    /// A resumed run may go on with it.
    keeps: bool,
}

/// What was not finished is taken away.
impl Drop for Recorder {
    fn drop(&mut self) {
        if !self.whole && !self.keeps {
            // The first error is on its way to the caller; a second one could not help.
            let _ = std::fs::remove_file(&self.partial);
        }
    }
}

impl Recorder {
    /// A new record, or that of the run that is `resumed`, which [`Self::exchange`] brings to its place;
    /// `keeps` the states on the disk if the run stops.
    pub(super) fn new(
        plan: RecordPlan,
        planned: Option<usize>,
        clock: &Clock,
        resumed: bool,
        keeps: bool,
    ) -> Result<Self, Error> {
        let n = plan.states.max(1);
        let due = match planned {
            Some(total) => {
                let step = |k: usize| round_half_to_even(k as f64 * total as f64 / n as f64).max(1);
                Due::Steps((1..=n).map(step).chain([total]).collect())
            }
            None => {
                let share = (clock.end - clock.start) / n as f64;
                Due::Times { next: clock.start + share, share }
            }
        };
        let mut partial = plan.path.clone();
        partial.as_mut_os_string().push(".partial");
        let place = match plan.path.is_dir() {
            true => Err(std::io::Error::other("it is a folder")),
            false => Ok(()),
        };
        let make = || {
            if resumed {
                return OpenOptions::new().write(true).open(&partial).map(BufWriter::new);
            }
            let mut file = BufWriter::new(File::create(&partial)?);
            file.write_all(b"{\"snapshots\":[").map(|()| file)
        };
        match place.and_then(|()| make()) {
            Ok(file) => Ok(Self { plan, due, partial, file, states: 0, whole: false, keeps }),
            Err(source) if resumed => Err(CheckpointError::File { path: partial, source }.into()),
            Err(source) => Err(Error::Write { path: plan.path, source }),
        }
    }

    /// Saves or loads what stands in the partial file.
    pub(super) fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let failed = |source| CheckpointError::File { path: self.partial.clone(), source };
        self.file.flush().map_err(failed)?;
        let mut length = self.file.stream_position().map_err(failed)? as usize;
        archive.count("states", &mut self.states)?;
        archive.count("length", &mut length)?;
        if let Due::Times { next, .. } = &mut self.due {
            archive.number("next", next)?;
        }
        if archive.is_loading() {
            self.file = BufWriter::new(reopen(&self.partial, length as u64).map_err(failed)?);
        }
        Ok(())
    }

    pub(super) fn observe(&mut self, clock: &Clock, solver: &dyn Solver, model: &Model) -> Result<(), Error> {
        let due = match &mut self.due {
            Due::Steps(steps) => steps.contains(&clock.step),
            Due::Times { next, share } => {
                let due = clock.time >= next.min(clock.end);
                while clock.time >= *next && *share > 0.0 {
                    *next += *share;
                }
                due
            }
        };
        if clock.step > 0 && !due {
            return Ok(());
        }
        let separator: &[u8] = if self.states > 0 { b"," } else { b"" };
        self.states += 1;
        let mut write = || {
            self.file.write_all(separator)?;
            let mut state = JsonObject::open(&mut self.file)?;
            state.value("step", &clock.step.into())?;
            state.value("time", &number(clock.time))?;
            solver.snapshot(model, &mut state)?;
            state.close()
        };
        write().map_err(|source| Error::Write { path: self.plan.path.clone(), source })
    }

    /// Writes the facts of the run behind its states.
    pub(super) fn complete(&mut self, account: &Account, head: Map<String, Value>) -> Result<(), Error> {
        let mut facts = json!({
            "bia_version": env!("CARGO_PKG_VERSION"),
            "threads": self.plan.threads,
            "steps": account.steps,
            "end_time": account.end_time,
            "wall_loop_s": account.wall_loop.as_secs_f64(),
            "cpu_loop_s": account.cpu_loop.as_secs_f64(),
            "wall_total_s": account.begin.elapsed().as_secs_f64(),
            "cpu_total_s": cpu_total().as_secs_f64(),
            "peak_rss_mb": peak_memory_mb(),
            "iterations": account.iterations,
            "not_converged_steps": account.not_converged,
            "cut_steps": account.cut,
        });
        if let Some(map) = facts.as_object_mut() {
            map.extend(head);
        }
        // The facts' own opening brace gives way to the comma after the states.
        let text = facts.to_string();
        let mut write = || {
            self.file.write_all(b"],")?;
            self.file.write_all(&text.as_bytes()[1..])?;
            self.file.flush()
        };
        write().map_err(|source| Error::Write { path: self.plan.path.clone(), source })
    }

    /// Gives the complete file its name.
    pub(super) fn publish(mut self) -> Result<(), Error> {
        let named = std::fs::rename(&self.partial, &self.plan.path);
        self.whole = named.map(|()| true).map_err(|source| Error::Write { path: self.plan.path.clone(), source })?;
        Ok(())
    }
}

/// A number for JSON, which has no infinities: they become null.
pub fn number(x: f64) -> Value {
    serde_json::Number::from_f64(x).map_or(Value::Null, Value::Number)
}

fn round_half_to_even(x: f64) -> usize {
    x.round_ties_even() as usize
}
