//! `bia study`: a family of runs, their errors against their run times; `bia survey`: scenes and methods,
//! and which of them stay stable.

mod case;
mod chart;
mod keys;
mod machine;
mod outcome;
mod page;
mod plan;
mod quantity;
mod report;
mod runner;
mod store;
mod survey;

use crate::report as shown;
use crate::signal::Signal;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::files::write_atomically;
use case::Case;
use clap::Args;
use outcome::Outcome;
use plan::Study;
use report::Report;
use runner::{Runner, Stop};
use serde_json::Value;
use shown::{complain, say};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use store::Store;
pub use survey::survey;

/// Arguments of `bia study` and `bia survey`.
#[derive(Args)]
pub struct StudyArguments {
    /// The study (or survey): which projects are run, with what changed in them
    file: PathBuf,
    /// Folder for the report and for what finished runs left (default: beside the study, NAME_results)
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write the page here, too, and its first figure beside it as SVG
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Check the study and all its projects' changes, and show the commands; run nothing
    #[arg(long)]
    dry_run: bool,
    /// With --dry-run: all that is known of the runs, as JSON
    #[arg(long, requires = "dry_run")]
    json: bool,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// What is run and reported: a study or a survey.
trait Job: Sized {
    /// Reads it, with all projects that it names.
    ///
    /// # Errors
    /// Everything that is wrong in it, together.
    fn read(path: &Path) -> Result<Self, InputErrors>;

    /// What is run, in this order.
    fn cases(&self) -> Vec<&Case>;

    /// What is known of these runs.
    fn plan(&self) -> Value {
        self.cases().into_iter().map(Case::json).collect()
    }

    /// How often.
    fn repetitions(&self) -> usize;

    /// The files of the report, the page first. The outcomes are in the order of the cases.
    fn report(&self, outcomes: Vec<Outcome>, folder: &Path) -> Vec<(PathBuf, String)>;
}

impl Job for Study {
    fn read(path: &Path) -> Result<Self, InputErrors> {
        Study::read(path)
    }

    fn cases(&self) -> Vec<&Case> {
        Study::cases(self)
    }

    fn repetitions(&self) -> usize {
        self.repetitions
    }

    fn report(&self, outcomes: Vec<Outcome>, folder: &Path) -> Vec<(PathBuf, String)> {
        let names = Study::cases(self).into_iter().map(|case| case.name.as_str());
        let mut by_name: HashMap<&str, Outcome> = names.zip(outcomes).collect();
        let mut of_variant = |variant: &plan::Variant| -> Vec<Outcome> {
            let own = variant.entries.iter().map(|entry| by_name.remove(entry.case.name.as_str()));
            own.map(|outcome| outcome.unwrap_or_else(|| Outcome::new(Vec::new()))).collect()
        };
        let outcomes = self.variants.iter().map(&mut of_variant).collect();
        let report = Report::new(self, machine::machine(), outcomes);
        vec![
            (folder.join("report.html"), report.html()),
            (folder.join("results.csv"), report.csv()),
            (folder.join("results.json"), format!("{:#}\n", report.json())),
            (folder.join("work_precision.svg"), report.work_precision().svg(true)),
            (folder.join("convergence.svg"), report.convergence().svg(true)),
        ]
    }
}

/// Runs a study.
pub fn study(arguments: &StudyArguments) -> ExitCode {
    start::<Study>(arguments)
}

fn start<J: Job>(arguments: &StudyArguments) -> ExitCode {
    crate::log::start(arguments.quiet);
    let job = match J::read(&arguments.file) {
        Ok(job) => job,
        Err(errors) => return ExitCode::from(shown::input(&errors)),
    };
    if arguments.dry_run && arguments.json {
        say!("{:#}", job.plan());
        return ExitCode::SUCCESS;
    }
    if arguments.dry_run {
        job.cases().iter().for_each(|case| say!("{}", case.command()));
        return ExitCode::SUCCESS;
    }
    let folder = arguments.output.clone().unwrap_or_else(|| results_folder(&arguments.file));
    let signal = Signal::wait();
    match run_job(arguments, &job, &folder, &signal) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Signal) => {
            complain!("stopped; the same command goes on, finished runs are kept in {}", folder.display());
            ExitCode::from(signal.exit_code())
        }
        Err(Stop::System(error)) => {
            complain!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// `step_bar.json` leaves its results in `step_bar_results`.
fn results_folder(file: &Path) -> PathBuf {
    let stem = file.file_stem().map_or_else(|| "study".into(), |stem| stem.to_string_lossy().into_owned());
    file.with_file_name(format!("{stem}_results"))
}

fn run_job<J: Job>(arguments: &StudyArguments, job: &J, folder: &Path, signal: &Signal) -> Result<(), Stop> {
    let program = std::env::current_exe()?;
    let store = Store::open(folder, &program)?;
    let runner = Runner { store: &store, program, signal: signal.clone(), quiet: arguments.quiet };
    let cases = job.cases();
    let left = runner.run(&cases, job.repetitions())?;
    let outcomes: Vec<Outcome> = left.into_iter().map(Outcome::new).collect();
    let missing = outcomes.iter().filter(|outcome| !outcome.is_done()).count();
    let mut files = job.report(outcomes, folder);
    let shipped = arguments.html.iter().flat_map(|html| {
        let first = |extension: &str| files.iter().find(|(path, _)| path.extension().is_some_and(|e| e == extension));
        ["html", "svg"].into_iter().filter_map(move |extension| {
            first(extension).map(|(_, text)| (html.with_extension(extension), text.clone()))
        })
    });
    let shipped: Vec<_> = shipped.collect();
    files.extend(shipped);
    write_all(&files)?;
    if !arguments.quiet {
        let runs = outcome_line(cases.len(), missing);
        say!("{runs}; report: {}", folder.join("report.html").display());
    }
    Ok(())
}

fn outcome_line(cases: usize, missing: usize) -> String {
    match missing {
        0 => format!("{cases} cases, all done"),
        _ => format!("{cases} cases, {missing} did not end well: the report tells why"),
    }
}

fn write_all(files: &[(PathBuf, String)]) -> io::Result<()> {
    for (path, text) in files {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)?;
        }
        write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}
