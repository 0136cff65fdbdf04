//! `bia survey`: scenes and methods, and which of them stay stable.

mod beside;
mod criterion;
mod draft;
mod keys;
mod plan;
mod report;
mod used;

use super::machine::machine;
use super::outcome::Outcome;
use super::{Job, StudyArguments};
use bia_kernel::diagnostic::InputErrors;
use criterion::Criterion;
use plan::{Run, Survey};
use report::Report;
use serde_json::{Value, json};
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

    fn plan(&self) -> Value {
        let mut plan = Vec::new();
        for scene in &self.scenes {
            for (method, run) in self.methods.iter().zip(&scene.runs) {
                let Some(Run::Wanted(wanted)) = run else { continue };
                let mut entry = wanted.case.json();
                entry["scene"] = json!(scene.id);
                entry["method"] = json!(method.label);
                entry["must"] = json!(wanted.must);
                entry["text"] = json!(wanted.text);
                entry["criteria"] = wanted.criteria.iter().map(Criterion::json).collect();
                plan.push(entry);
            }
        }
        plan.into()
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
