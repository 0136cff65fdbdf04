//! What the user reads: faults of the input, the scene, the summary.

use bia_kernel::analysis::{Account, Analysis, peak_memory_mb};
use bia_kernel::diagnostic::{InputErrors, Place, Severity};
use bia_kernel::error::Error;
use bia_kernel::solving::solver::{ColumnUse, Inventory};
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, MietteError, MietteSpanContents,
    NamedSource, Report, SourceCode, SourceOffset, SourceSpan, SpanContents,
};
use serde_json::json;
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};
use std::path::Path;

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

/// Shows faults of the input with the lines they stand in; exit code 2.
pub fn input(errors: &InputErrors) -> u8 {
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
        let report = with_source(shown, &diagnostic.place);
        let mut text = String::new();
        match handler.render_report(&mut text, report.as_ref()) {
            Ok(()) => complain!("{}", text.trim_end_matches('\n')),
            Err(_) => complain!("{diagnostic}"),
        }
    }
    let count = errors.0.iter().filter(|d| d.severity == Severity::Error).count();
    complain!("{} in the input; nothing was run or written.", counted(count, "error"));
    2
}

/// Adds the line of the place and its neighbours; of a long line only the part around the column.
fn with_source(shown: MietteDiagnostic, place: &Place) -> Report {
    let source = place.file.as_deref().and_then(|file| Some((file, std::fs::read_to_string(file).ok()?)));
    let (Some((file, text)), Some(line)) = (source, place.line) else { return Report::new(shown) };
    let (name, column) = (file.display().to_string(), place.column.unwrap_or(1));
    let start = SourceOffset::from_location(&text, line, column).offset();
    let rest = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or_default().trim_end();
    let length = rest.chars().take(60).map(char::len_utf8).sum::<usize>();
    let before = text.get(..start).and_then(|before| before.rsplit('\n').next()).unwrap_or_default();
    if before.chars().count() + rest.chars().count() <= LONGEST_LINE {
        let span = LabeledSpan::at(start..start + length, "here");
        return Report::new(shown.with_label(span)).with_source_code(NamedSource::new(name, text));
    }
    let (text, start) = window(before, rest);
    let span = LabeledSpan::at(start..start + length, "here");
    Report::new(shown.with_label(span)).with_source_code(Window { name, text, line, column })
}

/// Characters of a line that is shown as a whole.
const LONGEST_LINE: usize = 200;

/// The part of a long line around the place between `before` and `rest`, and where the place is in it.
fn window(before: &str, rest: &str) -> (String, usize) {
    let cut = before.char_indices().rev().nth(59).map_or(0, |(index, _)| index);
    let end = rest.char_indices().nth(100).map_or(rest.len(), |(index, _)| index);
    let head = format!("{}{}", if cut > 0 { "…" } else { "" }, &before[cut..]);
    let tail = if end < rest.len() { "…" } else { "" };
    (format!("{head}{}{tail}", &rest[..end]), head.len())
}

/// A part of a line that is shown with the line's number and the column in the whole line.
struct Window {
    name: String,
    text: String,
    line: usize,
    column: usize,
}

impl SourceCode for Window {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, before, after)?;
        let (line, column) = (self.line.saturating_sub(1), self.column.saturating_sub(1));
        let name = self.name.clone();
        Ok(Box::new(MietteSpanContents::new_named(name, inner.data(), *inner.span(), line, column, inner.line_count())))
    }
}

/// `1 step`, `2 steps`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Shows why a run stopped; exit code 3, or 1 for a check process, or 2 for a file.
pub fn failure(error: &Error) -> u8 {
    complain!("error: {error}");
    match error {
        Error::Check(_) => 1,
        Error::Failure(_) => 3,
        Error::Input(_) | Error::Write { .. } | Error::Checkpoint(_) => 2,
    }
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

/// Shows how a project will be computed.
pub fn plan(file: &Path, analysis: &Analysis, as_json: bool) {
    let inventory = analysis.inventory();
    let processes = analysis.pipeline();
    let stages: Vec<&str> = analysis.solver().stages().into_iter().map(|(name, _)| name).collect();
    let (used, left): (Vec<&ColumnUse>, Vec<&ColumnUse>) =
        inventory.columns.iter().partition(|column| column.bytes > 0);
    let left: Vec<&str> = left.into_iter().map(|column| column.name).collect();
    if as_json {
        let columns: Vec<_> = used.iter().map(|c| json!({"name": c.name, "bytes": c.bytes})).collect();
        let plan = json!({"project": file, "processes": processes, "stages": stages,
            "scene": inventory.lines, "columns": columns, "left_out": left, "warnings": inventory.warnings});
        return say!("{plan:#}");
    }
    head(file, &inventory, 0);
    say!("each step");
    for (what, names) in [("processes", processes), ("solver", stages)] {
        let list = if names.is_empty() { "none".to_string() } else { names.join(" -> ") };
        say!("  {what:24} {list}");
    }
    say!("columns");
    let total: usize = used.iter().map(|column| column.bytes).sum();
    for column in used {
        let share = 100.0 * column.bytes as f64 / total as f64;
        say!("  {:36} {:>12.3} MB {share:5.1} %", column.name, column.bytes as f64 / 1e6);
    }
    say!("  {:36} {:>12.3} MB", "all", total as f64 / 1e6);
    say!("  {:36} {}", "left out", left.join(", "));
}

/// What the end of a run tells of its steps.
pub fn warnings(account: &Account) -> Vec<String> {
    let mut list = Vec::new();
    if let Some(first) = account.not_converged.first() {
        let count = counted(account.not_converged.len(), "step");
        list.push(format!("{count} did not converge within max_iteration, the first is step {first}"));
    }
    if let Some(first) = account.cut.first() {
        let (count, most) = (counted(account.cut.len(), "step"), 1u64 << account.halvings);
        list.push(format!(
            "{count} did not converge as given and were cut, the first is step {first}, at most into {most} pieces"
        ));
    }
    list
}

/// Shows what the run did.
pub fn summary(account: &Account) {
    let iterations: usize = account.iterations.iter().sum();
    let (steps, iterations) = (counted(account.steps, "step"), counted(iterations, "Newton iteration"));
    let state = if account.interrupted { "stopped" } else { "done" };
    say!("{state}: {steps} to t = {:.6e} s, {iterations}", account.end_time);
    if account.interrupted {
        match &account.checkpoint {
            Some(path) => say!("  {:24} {}, for bia run --resume", "checkpoint", path.display()),
            None => say!("  {:24} none: the project has no \"restart\"", "checkpoint"),
        }
    }
    for warning in warnings(account) {
        complain!("warning: {warning}");
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

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, line: usize, column: usize) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("p.json");
        std::fs::write(&file, text).unwrap();
        let place = Place { file: Some(file), line: Some(line), column: Some(column), ..Place::default() };
        let report = with_source(MietteDiagnostic::new("wrong"), &place);
        let mut out = String::new();
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none()).with_context_lines(1);
        handler.render_report(&mut out, report.as_ref()).unwrap();
        out
    }

    #[test]
    fn a_long_line_is_shown_around_the_column() {
        let long = format!("{{\n{}\"naïve\": 17{}\n}}", "ä".repeat(5000), "b".repeat(5000));
        let text = shown(&long, 2, 5001);
        assert!(text.chars().count() < 600, "{text}");
        assert!(text.contains("p.json:2:5001") && text.contains("ä\"naïve\": 17b"), "{text}");
        let lines: Vec<&str> = text.lines().collect();
        let source = lines.iter().position(|line| line.contains("naïve")).unwrap();
        let column = |line: &str, what: char| line.chars().position(|c| c == what);
        assert!(lines[source].trim_start().starts_with("2 |"), "{text}");
        assert_eq!(
            column(lines[source], '"'),
            column(lines[source + 1], '^').or(column(lines[source + 1], '|')),
            "{text}"
        );
    }

    #[test]
    fn a_short_line_is_shown_with_its_neighbours() {
        let text = shown("{\n  \"a\": 1,\n  \"b\": 2\n}", 2, 3);
        assert!(text.contains("p.json:2:3") && text.contains("\"b\": 2") && !text.contains('…'), "{text}");
    }

    #[test]
    fn one_is_singular() {
        assert_eq!([counted(0, "step"), counted(1, "step"), counted(2, "step")], ["0 steps", "1 step", "2 steps"]);
    }
}
