//! `bia study`: a family of runs, their errors against their run times.

mod case;
mod chart;
mod keys;
mod machine;
mod outcome;
mod page;
mod plan;
mod report;
mod runner;
mod store;

use crate::report as shown;
use crate::signal::Signal;
use bia_kernel::io::files::write_atomically;
use clap::Args;
use outcome::Outcome;
use plan::Study;
use report::Report;
use runner::{Runner, Stop};
use shown::{complain, say};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use store::Store;

/// Arguments of `bia study`.
#[derive(Args)]
pub struct StudyArguments {
    /// The study: which variants of which projects are compared
    file: PathBuf,
    /// Folder for the report and for what finished runs left (default: beside the study, NAME_results)
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write the page here, too
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Check the study and all its projects' changes, and show the commands; run nothing
    #[arg(long)]
    dry_run: bool,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Runs a study.
pub fn study(arguments: &StudyArguments) -> ExitCode {
    shown::start_log(arguments.quiet);
    let study = match Study::read(&arguments.file) {
        Ok(study) => study,
        Err(errors) => return ExitCode::from(shown::input(&errors)),
    };
    if arguments.dry_run {
        study.cases().iter().for_each(|case| say!("{}", case.command()));
        return ExitCode::SUCCESS;
    }
    let folder = arguments.output.clone().unwrap_or_else(|| results_folder(&arguments.file));
    let signal = Signal::wait();
    match run_study(arguments, &study, &folder, &signal) {
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

fn run_study(arguments: &StudyArguments, study: &Study, folder: &Path, signal: &Signal) -> Result<(), Stop> {
    let program = std::env::current_exe()?;
    let store = Store::open(folder, &program)?;
    let runner = Runner { store: &store, program, signal: signal.clone(), quiet: arguments.quiet };
    let cases = study.cases();
    let left = runner.run(&cases, study.repetitions)?;
    let mut by_name: HashMap<&str, Outcome> =
        cases.iter().zip(left).map(|(case, left)| (case.name.as_str(), Outcome::new(left))).collect();
    let mut outcomes = Vec::new();
    for variant in &study.variants {
        let own = variant.entries.iter().map(|entry| by_name.remove(entry.case.name.as_str()));
        outcomes.push(own.map(|outcome| outcome.unwrap_or_else(|| Outcome::new(Vec::new()))).collect::<Vec<_>>());
    }
    let missing = outcomes.iter().flatten().filter(|outcome| !outcome.is_done()).count();
    let report = Report::new(study, machine::machine(), outcomes);
    let page = report.html();
    let mut files = vec![
        (folder.join("report.html"), page.clone()),
        (folder.join("results.csv"), report.csv()),
        (folder.join("results.json"), format!("{:#}\n", report.json())),
        (folder.join("work_precision.svg"), report.work_precision().svg(true)),
        (folder.join("convergence.svg"), report.convergence().svg(true)),
    ];
    files.extend(arguments.html.clone().map(|path| (path, page)));
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
