//! The stability survey of `tests/survey`: every project and every change of it is what the program reads.

use std::path::Path;
use std::process::Command;

#[test]
fn all_runs_of_the_survey_can_be_made() {
    let survey = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/survey/SURVEY.json");
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.arg("survey").arg(survey).arg("--dry-run").output().expect("the built program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let commands = String::from_utf8_lossy(&output.stdout);
    assert!(commands.lines().filter(|line| line.starts_with("bia run")).count() > 500, "{commands}");
}
