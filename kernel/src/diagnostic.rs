//! What is wrong with an input, where, and what to do about it.
//!
//! Readers collect [`Diagnostic`]s instead of stopping at the first one, so that a user sees all
//! the mistakes of a file together. The kernel never prints: the command line renders them.

use std::fmt;
use std::path::{Path, PathBuf};

/// Where a fault stands. Any part may be unknown.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// File that holds the fault.
    pub file: Option<PathBuf>,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// Column, counted from 1.
    pub column: Option<usize>,
    /// JSON pointer such as `/solver_settings/time_stepping/time_step`.
    pub pointer: Option<String>,
}

impl Place {
    /// A whole file.
    pub fn file(path: &Path) -> Self {
        Self { file: Some(path.to_path_buf()), ..Self::default() }
    }

    /// A line of a file, counted from 1.
    pub fn line(path: &Path, line: usize) -> Self {
        Self { file: Some(path.to_path_buf()), line: Some(line), ..Self::default() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}", file.display())?;
            if let Some(line) = self.line {
                write!(f, ":{line}")?;
                if let Some(column) = self.column {
                    write!(f, ":{column}")?;
                }
            }
        }
        // The pointer of the root is the empty text.
        match (&self.file, self.pointer.as_deref().filter(|pointer| !pointer.is_empty())) {
            (Some(_), Some(pointer)) => write!(f, " at {pointer}"),
            (None, Some(pointer)) => write!(f, "{pointer}"),
            _ => Ok(()),
        }
    }
}

/// An error stops the run before anything is written; a warning does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Legal but suspicious.
    Warning,
    /// The input cannot be used.
    Error,
}

/// One fault of the input: where, what was found, what is allowed, and the nearest allowed name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Where it stands.
    pub place: Place,
    /// What was found, in one sentence without a full stop.
    pub message: String,
    /// What is allowed, or what to do.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error at `place`.
    pub fn error(place: Place, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, place, message: message.into(), help: None }
    }

    /// A warning at `place`.
    pub fn warning(place: Place, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(place, message) }
    }

    /// Adds what is allowed or what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the nearest of `allowed` to `found`, and the list itself.
    #[must_use]
    pub fn allowed<'a>(self, found: &str, allowed: impl IntoIterator<Item = &'a str>) -> Self {
        let mut names: Vec<&str> = Vec::new();
        for name in allowed {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        if names.is_empty() {
            return self.help("nothing is allowed here");
        }
        let list = names.join(", ");
        match nearest(found, names.iter().copied()) {
            Some(near) => self.help(format!("did you mean {near:?}? Allowed: {list}")),
            None => self.help(format!("allowed: {list}")),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = self.place.to_string();
        if !place.is_empty() {
            write!(f, "{place}: ")?;
        }
        write!(f, "{}", self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n  {help}")?;
        }
        Ok(())
    }
}

impl From<Diagnostic> for InputErrors {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

/// All the faults that were found, in the order of their discovery.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct InputErrors(pub Vec<Diagnostic>);

impl InputErrors {
    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic);
    }

    /// True when one of them is an error and not only a warning.
    pub fn any_error(&self) -> bool {
        self.0.iter().any(|d| d.severity == Severity::Error)
    }

    /// `Err(self)` when there is an error, else `value`; warnings alone pass.
    ///
    /// # Errors
    /// The collected diagnostics.
    pub fn or<T>(self, value: T) -> Result<T, InputErrors> {
        if self.any_error() { Err(self) } else { Ok(value) }
    }

    /// Takes the value of a result, or keeps its errors and returns none.
    pub fn absorb<T>(&mut self, result: Result<T, InputErrors>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(errors) => {
                self.0.extend(errors.0);
                None
            }
        }
    }
}

impl fmt::Display for InputErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for InputErrors {}

/// The candidate nearest to `found` by optimal string alignment (insert, delete, replace, swap),
/// ignoring case, if it is near enough to be a slip of the hand.
pub fn nearest<'a>(found: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = 1 + found.chars().count() / 4;
    candidates
        .into_iter()
        .map(|name| (alignment_distance(&found.to_lowercase(), &name.to_lowercase()), name))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

fn alignment_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    best = best.min(rows[i - 2][j - 2] + 1);
                }
                best
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_finds_slips_and_refuses_strangers() {
        let keys = ["time_step", "max_iteration", "echo_level"];
        assert_eq!(nearest("max_iterations", keys), Some("max_iteration"));
        assert_eq!(nearest("tiem_step", keys), Some("time_step"));
        assert_eq!(nearest("ECHO_LEVEL", keys), Some("echo_level"));
        assert_eq!(nearest("gravity", keys), None);
    }

    #[test]
    fn place_shows_file_line_column_and_pointer() {
        let mut place = Place::line(Path::new("a.json"), 3);
        place.column = Some(7);
        place.pointer = Some("/x/0".into());
        assert_eq!(place.to_string(), "a.json:3:7 at /x/0");
    }
}
