//! `bia survey`: scenes and methods, and which of them stay stable.

mod beside;
mod criterion;
mod keys;
mod plan;
mod report;

use super::machine::machine;
use super::outcome::Outcome;
use super::{Job, StudyArguments};
use bia_kernel::diagnostic::InputErrors;
use plan::Survey;
use report::Report;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs a survey.
pub fn survey(arguments: &StudyArguments) -> ExitCode {
    super::start::<Survey>(arguments)
}

impl Job for Survey {
    fn read(path: &Path) -> Result<Self, InputErrors> {
        Survey::read(path)
    }

    fn cases(&self) -> Vec<&super::case::Case> {
        self.wanted().map(|wanted| &wanted.case).collect()
    }

    fn repetitions(&self) -> usize {
        self.repetitions
    }

    fn report(&self, outcomes: Vec<Outcome>, folder: &Path) -> Vec<(PathBuf, String)> {
        let by_name = self.wanted().map(|wanted| wanted.case.name.as_str()).zip(outcomes).collect();
        let report = Report::new(self, machine(), by_name);
        vec![
            (folder.join("report.html"), report.html()),
            (folder.join("results.csv"), report.csv()),
            (folder.join("results.json"), format!("{:#}\n", report.json())),
        ]
    }
}
