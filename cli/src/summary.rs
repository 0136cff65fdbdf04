//! `bia run --summary FILE`: what a run took and found, and how it ended, for programs that compare runs.

use crate::report;
use crate::run::End;
use bia_kernel::analysis::{Analysis, number};
use bia_kernel::diagnostic::{InputErrors, Severity};
use bia_kernel::error::Error;
use bia_kernel::io::files::write_atomically;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Says why a summary cannot stand there, so that no run is made in vain.
///
/// # Errors
/// The path is a folder, or stands in none.
pub fn check_place(path: &Path) -> Result<(), String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (path.is_dir(), folder.is_dir()) {
        (true, _) => Err(format!("the summary {} is a folder", path.display())),
        (false, false) => Err(format!("the summary's folder {} does not exist", folder.display())),
        (false, true) => Ok(()),
    }
}

/// Writes the summary, with the warnings that the log has `told`. An input that would be overwritten stays as it is.
///
/// # Errors
/// The file cannot be written.
pub fn write(
    path: &Path,
    project: &Path,
    end: &End,
    code: u8,
    told: &[String],
    analysis: Option<&Analysis>,
) -> Result<(), String> {
    if analysis.is_none() && is_foreign(path) {
        return Ok(());
    }
    let (status, reason, failure) = describe(end);
    let mut summary = Map::new();
    let mut insert = |name: &str, value: Value| summary.insert(name.into(), value);
    insert("bia", env!("CARGO_PKG_VERSION").into());
    insert("project", project.display().to_string().into());
    insert("status", status.into());
    insert("exit_code", code.into());
    if let Some(reason) = reason {
        insert("reason", reason.into());
    }
    if let Some(failure) = failure {
        insert("failure", failure);
    }
    if let Some(analysis) = analysis {
        let of_steps = if let End::Done(account) = end { report::warnings(account) } else { Vec::new() };
        let warnings = [analysis.inventory().warnings, told.to_vec(), of_steps].concat();
        summary.insert("warnings".into(), warnings.into());
        summary.extend(analysis.summary());
    }
    let text = format!("{:#}\n", Value::Object(summary));
    let written = write_atomically(path, |out| out.write_all(text.as_bytes()));
    written.map(|_| ()).map_err(|error| format!("the summary cannot be written: {error}"))
}

/// Whether a file there is none of ours: when the input is wrong, it may be part of it.
fn is_foreign(path: &Path) -> bool {
    let Ok(text) = std::fs::read_to_string(path) else { return path.exists() };
    let read: Value = serde_json::from_str(&text).unwrap_or_default();
    read.get("bia").is_none() || read.get("status").is_none()
}

/// Status, reason in one line, and details of a failure.
fn describe(end: &End) -> (&'static str, Option<String>, Option<Value>) {
    match end {
        End::Done(account) if account.interrupted => {
            ("stopped", Some(format!("stopped by a signal after step {}", account.steps)), None)
        }
        End::Done(_) => ("done", None, None),
        End::Refused(errors) => ("input", Some(first_line(errors)), None),
        End::Failed(Error::Failure(failure)) => {
            let report = failure.report();
            let details = json!({
                "step": report.step, "time": number(report.time), "what": report.what, "entity": report.entity,
                "position": report.position, "details": report.details, "advice": report.advice,
            });
            ("failed", Some(report.what.clone()), Some(details))
        }
        End::Failed(error) => ("failed", Some(error.to_string()), None),
    }
}

/// The first error without its place, and how many more there are.
fn first_line(errors: &InputErrors) -> String {
    let mut all = errors.0.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
    let first = all.next().map_or("the input is wrong", |first| first.message.as_str());
    let pointer = errors.0.first().and_then(|first| first.place.pointer.clone());
    let place = pointer.map_or_else(String::new, |pointer| format!("{pointer}: "));
    match all.count() {
        0 => format!("{place}{first}"),
        more => format!("{place}{first} (and {more} more)"),
    }
}
