//! What the user reads: faults of the input, the scene, the summary.

use bia_kernel::analysis::{Account, peak_memory_mb};
use bia_kernel::diagnostic::{InputErrors, Severity};
use bia_kernel::error::Error;
use bia_kernel::solving::solver::Inventory;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, SourceOffset,
};
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

/// Sends the log to standard error.
pub fn start_log(quiet: bool) {
    let level = if quiet { tracing::Level::ERROR } else { tracing::Level::INFO };
    let _ = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_target(false)
        .without_time()
        .with_ansi(std::io::stderr().is_terminal())
        .try_init();
}

/// Shows faults of the input with the lines they stand in; exit code 2.
pub fn input(errors: &InputErrors) -> ExitCode {
    let theme = if std::io::stderr().is_terminal() { GraphicalTheme::unicode() } else { GraphicalTheme::none() };
    let handler = GraphicalReportHandler::new_themed(theme).with_context_lines(1).with_links(false);
    for diagnostic in &errors.0 {
        let severity = match diagnostic.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        };
        let place = diagnostic.place.to_string();
        let head =
            if place.is_empty() { diagnostic.message.clone() } else { format!("{place}: {}", diagnostic.message) };
        let mut shown = MietteDiagnostic::new(head).with_severity(severity);
        if let Some(help) = &diagnostic.help {
            shown = shown.with_help(help);
        }
        let source =
            diagnostic.place.file.as_deref().and_then(|file| Some((file, std::fs::read_to_string(file).ok()?)));
        let report = match (source, diagnostic.place.line) {
            (Some((file, text)), Some(line)) => {
                let offset = SourceOffset::from_location(&text, line, diagnostic.place.column.unwrap_or(1));
                let length = text[offset.offset()..].lines().next().map_or(0, |rest| rest.trim_end().len().min(60));
                let span = LabeledSpan::at(offset.offset()..offset.offset() + length, "here");
                Report::new(shown.with_label(span)).with_source_code(NamedSource::new(file.display().to_string(), text))
            }
            _ => Report::new(shown),
        };
        let mut text = String::new();
        match handler.render_report(&mut text, report.as_ref()) {
            Ok(()) => eprint!("{text}"),
            Err(_) => eprintln!("{diagnostic}"),
        }
    }
    let count = errors.0.iter().filter(|d| d.severity == Severity::Error).count();
    eprintln!("{count} error{} in the input; nothing was run or written.", if count == 1 { "" } else { "s" });
    ExitCode::from(2)
}

/// Shows why a run stopped; exit code 3, or 1 for a check process, or 2 for a file.
pub fn failure(error: &Error) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::from(match error {
        Error::Check(_) => 1,
        Error::Failure(_) => 3,
        Error::Input(_) | Error::Write { .. } => 2,
    })
}

/// Shows what the scene consists of.
pub fn head(file: &Path, inventory: &Inventory, threads: usize) {
    println!("bia {}  {}", env!("CARGO_PKG_VERSION"), file.display());
    for (what, text) in &inventory.lines {
        println!("  {what:24} {text}");
    }
    if threads > 0 {
        println!("  {:24} {threads}", "threads");
    }
    for warning in &inventory.warnings {
        eprintln!("warning: {warning}");
    }
}

/// Shows what the run did.
pub fn summary(account: &Account) {
    let iterations: usize = account.iterations.iter().sum();
    println!("done: {} steps to t = {:.6e} s, {iterations} Newton iterations", account.steps, account.end_time);
    if let Some(first) = account.not_converged.first() {
        let count = account.not_converged.len();
        eprintln!("warning: {count} steps did not converge within max_iteration, the first is step {first}");
    }
    println!(
        "  {:24} {:.3} s, CPU {:.3} s",
        "time of the loop",
        account.wall_loop.as_secs_f64(),
        account.cpu_loop.as_secs_f64()
    );
    for (stage, time) in &account.stages {
        println!("    {stage:22} {:.3} s", time.as_secs_f64());
    }
    if let Some(memory) = peak_memory_mb() {
        println!("  {:24} {memory:.1} MB", "peak memory");
    }
    for (name, energy) in &account.energies {
        println!("  {:24} {energy:.6e} J", format!("{name} energy"));
    }
    let shown = account.files.len().min(3);
    for file in &account.files[..shown] {
        println!("  {:24} {}", "written", file.display());
    }
    if account.files.len() > shown {
        println!("  {:24} … and {} more files", "", account.files.len() - shown);
    }
}
