//! What can stop a run.

use crate::diagnostic::{Diagnostic, InputErrors};
use crate::io::checkpoint::CheckpointError;
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
    Failure(#[from] Failure),
    /// A result file could not be written: exit code 2 (the place is the user's choice).
    #[error("{} cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A checkpoint could not be written or taken up: exit code 2.
    #[error("{0}")]
    Checkpoint(#[from] CheckpointError),
    /// A check process found values that differ from its file: exit code 1.
    #[error("{0}")]
    Check(String),
}

impl From<Diagnostic> for Error {
    fn from(diagnostic: Diagnostic) -> Self {
        Error::Input(diagnostic.into())
    }
}

/// A numerical failure: what, when, where, and what to try. A pointer wide, so that results that
/// carry it stay small.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure(Box<FailureReport>);

/// The content of a [`Failure`].
#[derive(Debug, Clone, PartialEq)]
pub struct FailureReport {
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
        Self(Box::new(FailureReport {
            what: what.into(),
            step: 0,
            time: 0.0,
            entity: None,
            position: None,
            details: Vec::new(),
            advice: advice.into(),
        }))
    }

    /// Adds whom it concerns.
    #[must_use]
    pub fn at(mut self, entity: impl Into<String>, position: [f64; 3]) -> Self {
        self.0.entity = Some(entity.into());
        self.0.position = Some(position);
        self
    }

    /// Says when it happened.
    pub fn stamp(&mut self, step: usize, time: f64) {
        self.0.step = step;
        self.0.time = time;
    }

    /// What is known of it.
    pub fn report(&self) -> &FailureReport {
        &self.0
    }

    /// Adds a line of numbers.
    #[must_use]
    pub fn detail(mut self, line: impl Into<String>) -> Self {
        self.0.details.push(line.into());
        self
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let report = &*self.0;
        write!(f, "step {}, time {}: {}", report.step, report.time, report.what)?;
        if let Some(entity) = &report.entity {
            write!(f, "\n  {entity}")?;
            if let Some([x, y, z]) = report.position {
                write!(f, " at ({x}, {y}, {z})")?;
            }
        }
        for line in &report.details {
            write!(f, "\n  {line}")?;
        }
        write!(f, "\n  try: {}", report.advice)
    }
}

impl std::error::Error for Failure {}
