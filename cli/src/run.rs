//! `bia run` and `bia check`.

use crate::progress::Progress;
use crate::signal::Signal;
use crate::{ProjectArguments, log, report, summary};
use bia_kernel::analysis::{Account, Analysis, RecordPlan};
use bia_kernel::diagnostic::{Diagnostic, InputErrors, Place};
use bia_kernel::error::Error;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use clap::Args;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `bia run`.
#[derive(Args)]
pub struct RunArguments {
    #[command(flatten)]
    project: ProjectArguments,
    /// Threads; results have the same bits for any number (default: all cores)
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Folder for results (default: the project's folder)
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Go on from the newest checkpoint, which the member "restart" of the project asks for
    #[arg(long)]
    resume: bool,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Write an account of the run: counts, times, iterations and states, as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Write a summary of the run, whatever its end: counts, times, memory, errors and measured values, as JSON
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    /// End at once when standard input ends: with the study that has started this run, however it died
    #[arg(long, hide = true)]
    end_with_input: bool,
    /// States in the account beside the first
    #[arg(long, value_name = "N", default_value = "5")]
    record_states: NonZeroUsize,
}

/// Beyond this a number of threads is a slip of the hand.
const MOST_THREADS: usize = 1024;

/// Runs a project.
pub fn run(arguments: &RunArguments, registry: &Registry) -> ExitCode {
    let log = log::start(arguments.quiet);
    if let Some(path) = &arguments.summary
        && let Err(message) = summary::check_place(path)
    {
        report::complain!("error: {message}");
        return ExitCode::from(2);
    }
    if arguments.end_with_input {
        std::thread::spawn(|| {
            // An error is an end, too.
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            std::process::exit(143);
        });
    }
    let signal = Signal::wait();
    let (end, analysis) = match start_threads(arguments.threads) {
        Ok(threads) => execute(arguments, threads, registry, &signal),
        Err(message) => (End::Refused(Diagnostic::error(Place::default(), message).into()), None),
    };
    let code = match &end {
        End::Done(account) => {
            if !arguments.quiet {
                report::summary(account);
            }
            if account.interrupted { signal.exit_code() } else { 0 }
        }
        End::Refused(errors) => report::input(errors),
        End::Failed(error) => report::failure(error),
    };
    let written = arguments.summary.as_deref().map_or(Ok(()), |path| {
        summary::write(path, &arguments.project.file, &end, code, &log.told(), analysis.as_ref())
    });
    match written {
        Ok(()) => ExitCode::from(code),
        Err(message) => {
            report::complain!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// How a run ended.
pub enum End {
    /// Done, or stopped by a signal after a whole step.
    Done(Box<Account>),
    /// The input is wrong, or its results have no place.
    Refused(InputErrors),
    /// It went wrong.
    Failed(Error),
}

/// Starts the threads and returns their number.
fn start_threads(wanted: Option<NonZeroUsize>) -> Result<usize, String> {
    if let Some(threads) = wanted.filter(|threads| threads.get() > MOST_THREADS) {
        return Err(format!("{threads} threads are more than the {MOST_THREADS} that make sense"));
    }
    let threads = wanted.or_else(|| std::thread::available_parallelism().ok()).map_or(1, usize::from);
    // This thread is one of them: what it starts, it works on too.
    match rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global() {
        Ok(()) => Ok(threads),
        Err(error) => Err(format!("{threads} threads cannot be started: {error}")),
    }
}

/// Prepares and runs; the analysis tells what was reached, unless the input is wrong.
fn execute(arguments: &RunArguments, threads: usize, registry: &Registry, signal: &Signal) -> (End, Option<Analysis>) {
    let record =
        arguments.record.clone().map(|path| RecordPlan { path, states: arguments.record_states.get(), threads });
    let prepared = prepare(&arguments.project, arguments.output.as_deref(), registry, record.is_some());
    let mut analysis = match prepared {
        Ok(analysis) => analysis,
        Err(errors) => return (End::Refused(errors), None),
    };
    if let Some(path) = arguments.summary.as_ref().filter(|path| analysis.is_input(path)) {
        let message = format!("the summary {} would overwrite an input file", path.display());
        return (End::Refused(Diagnostic::error(Place::default(), message).into()), None);
    }
    if !arguments.quiet {
        report::head(&arguments.project.file, &analysis.inventory(), threads);
    }
    let mut progress = Progress::new(arguments.quiet, signal.clone());
    let result = match arguments.resume {
        true => analysis.resume(&mut progress, record),
        false => analysis.run(&mut progress, record),
    };
    progress.finish();
    let end = match result {
        Ok(account) => End::Done(Box::new(account)),
        Err(Error::Input(errors)) => End::Refused(errors),
        Err(error) => End::Failed(error),
    };
    (end, Some(analysis))
}

/// Checks a project.
pub fn check(arguments: &ProjectArguments, registry: &Registry) -> ExitCode {
    log::start(false);
    match prepare(arguments, None, registry, false) {
        Ok(mut analysis) => {
            report::head(&arguments.file, &analysis.inventory(), 0);
            if let Some(steps) = analysis.planned_steps() {
                report::say!("  {:24} {steps}", "steps");
            }
            if let Some(warning) = analysis.unstable_step() {
                report::complain!("warning: {warning}");
            }
            report::say!("The input is right.");
            ExitCode::SUCCESS
        }
        Err(errors) => ExitCode::from(report::input(&errors)),
    }
}

/// Arguments of `bia explain`.
#[derive(Args)]
pub struct ExplainArguments {
    #[command(flatten)]
    project: ProjectArguments,
    /// As JSON
    #[arg(long)]
    json: bool,
}

/// Shows the plan of a project.
pub fn explain(arguments: &ExplainArguments, registry: &Registry) -> ExitCode {
    log::start(arguments.json);
    match prepare(&arguments.project, None, registry, false) {
        Ok(analysis) => {
            report::plan(&arguments.project.file, &analysis, arguments.json);
            ExitCode::SUCCESS
        }
        Err(errors) => ExitCode::from(report::input(&errors)),
    }
}

fn prepare(
    arguments: &ProjectArguments,
    output: Option<&Path>,
    registry: &Registry,
    record: bool,
) -> Result<Analysis, InputErrors> {
    let mut document = Document::read(&arguments.file)?;
    for assignment in &arguments.set {
        match assignment.split_once('=') {
            Some((pointer, value)) => document.set(pointer, value)?,
            None => {
                let message = format!("--set {assignment:?} has no =");
                return Err(Diagnostic::error(Place::default(), message).help("--set /json/pointer=value").into());
            }
        }
    }
    let folder = arguments.file.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let output = output.map_or_else(|| folder.clone(), Path::to_path_buf);
    let options = RunOptions { folder, output, kratos_exact: arguments.kratos_exact };
    Analysis::prepare(document, registry, options, record)
}
