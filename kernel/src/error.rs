//! What can stop a run.

use crate::diagnostic::{Diagnostic, InputErrors};
use std::path::PathBuf;
use thiserror::Error;

/// Anything that stops a run. The command line turns it into a message and an exit code.
#[derive(Debug, Error)]
pub enum Error {
    /// The input is wrong: exit code 2, nothing was written.
    #[error("{0}")]
    Input(#[from] InputErrors),
    /// The run went wrong physically: exit code 3.
    #[error("{0}")]
    Failure(#[from] Box<Failure>),
    /// A result file could not be written: exit code 2 (the place is the user's choice).
    #[error("{} cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A check process found values that differ from its file: exit code 1.
    #[error("{0}")]
    Check(String),
}

impl From<Diagnostic> for Error {
    fn from(diagnostic: Diagnostic) -> Self {
        Error::Input(diagnostic.into())
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        Error::Failure(Box::new(failure))
    }
}

/// A numerical failure: what, when, where, and what to try.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// What went wrong, in one sentence.
    pub what: String,
    /// Step, counted from 1 (0 before the loop); filled in by the analysis.
    pub step: usize,
    /// Time in seconds; filled in by the analysis.
    pub time: f64,
    /// Id of the point, node or element, with its kind: `material point 17`.
    pub entity: Option<String>,
    /// Position in metres.
    pub position: Option<[f64; 3]>,
    /// Further numbers: law, deformation gradient, J.
    pub details: Vec<String>,
    /// What to try.
    pub advice: String,
}

impl Failure {
    /// A failure with advice; the analysis adds step and time.
    pub fn new(what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            step: 0,
            time: 0.0,
            entity: None,
            position: None,
            details: Vec::new(),
            advice: advice.into(),
        }
    }

    /// Adds whom it concerns.
    #[must_use]
    pub fn at(mut self, entity: impl Into<String>, position: [f64; 3]) -> Self {
        self.entity = Some(entity.into());
        self.position = Some(position);
        self
    }

    /// Adds a line of numbers.
    #[must_use]
    pub fn detail(mut self, line: impl Into<String>) -> Self {
        self.details.push(line.into());
        self
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "step {}, time {}: {}", self.step, self.time, self.what)?;
        if let Some(entity) = &self.entity {
            write!(f, "\n  {entity}")?;
            if let Some([x, y, z]) = self.position {
                write!(f, " at ({x}, {y}, {z})")?;
            }
        }
        for line in &self.details {
            write!(f, "\n  {line}")?;
        }
        write!(f, "\n  try: {}", self.advice)
    }
}

impl std::error::Error for Failure {}
