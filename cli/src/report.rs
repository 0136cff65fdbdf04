//! What the user reads: faults of the input, the scene, the summary.

use bia_kernel::analysis::{Account, peak_memory_mb};
use bia_kernel::diagnostic::{InputErrors, Severity};
use bia_kernel::error::Error;
use bia_kernel::solving::solver::Inventory;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, SourceOffset,
};
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// A line to standard output. A reader that has gone away (`bia check P.json | head -1`) is no
/// reason to stop.
pub fn to_output(line: Arguments) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// A line to standard error.
pub fn to_error(line: Arguments) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

macro_rules! say {
    ($($part:tt)*) => { $crate::report::to_output(format_args!($($part)*)) };
}

macro_rules! complain {
    ($($part:tt)*) => { $crate::report::to_error(format_args!($($part)*)) };
}

pub(crate) use {complain, say};

/// Sends the log to standard error.
pub fn start_log(quiet: bool) {
    let level = if quiet { tracing::Level::ERROR } else { tracing::Level::INFO };
    let _ = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_target(false)
        .without_time()
        .log_internal_errors(false)
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
                let start = SourceOffset::from_location(&text, line, diagnostic.place.column.unwrap_or(1)).offset();
                let rest = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default().trim_end();
                let length = rest.chars().take(60).map(char::len_utf8).sum::<usize>();
                let span = LabeledSpan::at(start..start + length, "here");
                Report::new(shown.with_label(span)).with_source_code(NamedSource::new(file.display().to_string(), text))
            }
            _ => Report::new(shown),
        };
        let mut text = String::new();
        match handler.render_report(&mut text, report.as_ref()) {
            Ok(()) => complain!("{}", text.trim_end_matches('\n')),
            Err(_) => complain!("{diagnostic}"),
        }
    }
    let count = errors.0.iter().filter(|d| d.severity == Severity::Error).count();
    complain!("{count} error{} in the input; nothing was run or written.", if count == 1 { "" } else { "s" });
    ExitCode::from(2)
}

/// Shows why a run stopped; exit code 3, or 1 for a check process, or 2 for a file.
pub fn failure(error: &Error) -> ExitCode {
    complain!("error: {error}");
    ExitCode::from(match error {
        Error::Check(_) => 1,
        Error::Failure(_) => 3,
        Error::Input(_) | Error::Write { .. } => 2,
    })
}

/// Shows what the scene consists of.
pub fn head(file: &Path, inventory: &Inventory, threads: usize) {
    say!("bia {}  {}", env!("CARGO_PKG_VERSION"), file.display());
    for (what, text) in &inventory.lines {
        say!("  {what:24} {text}");
    }
    if threads > 0 {
        say!("  {:24} {threads}", "threads");
    }
    for warning in &inventory.warnings {
        complain!("warning: {warning}");
    }
}

/// Shows what the run did.
pub fn summary(account: &Account) {
    let iterations: usize = account.iterations.iter().sum();
    say!("done: {} steps to t = {:.6e} s, {iterations} Newton iterations", account.steps, account.end_time);
    if let Some(first) = account.not_converged.first() {
        let count = account.not_converged.len();
        complain!("warning: {count} steps did not converge within max_iteration, the first is step {first}");
    }
    say!(
        "  {:24} {:.3} s, CPU {:.3} s",
        "time of the loop",
        account.wall_loop.as_secs_f64(),
        account.cpu_loop.as_secs_f64()
    );
    for (stage, time) in &account.stages {
        say!("    {stage:22} {:.3} s", time.as_secs_f64());
    }
    if let Some(memory) = peak_memory_mb() {
        say!("  {:24} {memory:.1} MB", "peak memory");
    }
    for (name, energy) in &account.energies {
        say!("  {:24} {energy:.6e} J", format!("{name} energy"));
    }
    let shown = account.files.len().min(3);
    for file in &account.files[..shown] {
        say!("  {:24} {}", "written", file.display());
    }
    if account.files.len() > shown {
        say!("  {:24} … and {} more files", "", account.files.len() - shown);
    }
}
