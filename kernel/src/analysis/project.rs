//! The layout of `ProjectParameters.json`: which blocks there are and in which order they act.

use super::restart::{NAME, RESTART};
use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind, Parameters, Range, Settings, describe};

pub(super) const PROBLEM_DATA: &[Key] = &[
    Key::new("problem_name", Kind::Text, "\"problem\"", "name of the problem"),
    Key::new("parallel_type", Kind::Choice(&["OpenMP"]), "\"OpenMP\"", "threads of one machine"),
    Key::new("echo_level", Kind::Integer { min: 0 }, "0", "how much is reported"),
    Key::new("start_time", Kind::Number(Range::ANY), "0.0", "first time [s]"),
    Key::required("end_time", Kind::Number(Range::ANY), "the loop runs while the time is below this one [s]"),
];

/// Lists of processes at the root, as projects before 2019 have them, in the order in which they act.
pub(super) const LEGACY_LISTS: &[&str] =
    &["constraints_process_list", "loads_process_list", "list_other_processes", "gravity"];
/// Other members of the root that are read.
const MEMBERS: &[&str] = &[
    "$schema",
    "problem_data",
    "solver_settings",
    "modelers",
    "analysis_stage",
    "processes",
    "output_processes",
    "kratos_exact",
    NAME,
];
/// Members that Kratos projects carry and that change nothing here.
pub(super) const WITHOUT_EFFECT: &[&str] = &[
    "grid_output_configuration",
    "body_output_configuration",
    "print_output_process",
    "json_output_process",
    "json_check_process",
    "restart_options",
    "output_configuration",
];

/// A project, taken apart but not yet built.
pub struct Project {
    /// The whole file.
    pub root: Parameters,
    /// `problem_data`; none if it is faulty.
    pub problem: Option<Settings>,
    /// `solver_settings`; none if they are missing.
    pub solver: Option<Parameters>,
    /// Blocks of modelers.
    pub modelers: Vec<Parameters>,
    /// Blocks of processes in the order in which they act.
    pub processes: Vec<Parameters>,
    /// Blocks of output processes in the order in which they act, after the others.
    pub outputs: Vec<Parameters>,
    /// The project itself asks to reproduce Kratos.
    pub kratos_exact: bool,
    /// `restart`, if given.
    pub restart: Option<Settings>,
    /// What is legal but has no effect.
    pub warnings: Vec<String>,
}

impl Project {
    /// Takes a project apart, as far as it can be: missing and wrong members are added to `errors`.
    pub fn read(root: Parameters, errors: &mut InputErrors) -> Self {
        if !root.value().is_object() {
            errors.push(root.error("a project must be a JSON object"));
        }
        let is_object = root.value().is_object();
        let mut warnings = check_members(&root, errors);
        let mut member = |name: &str| {
            let child = root.child(name);
            if child.is_none() && is_object {
                errors.push(root.error(format!("{name:?} is missing")));
            }
            child
        };
        let (problem, solver) = (member("problem_data"), member("solver_settings"));
        let problem = problem.and_then(|p| errors.absorb(p.read(PROBLEM_DATA)));
        if let Some(problem) = &problem {
            let (start, end) = (problem.number("start_time"), problem.number("end_time"));
            if end <= start {
                let message = format!("end_time is {end}, must be above the start_time {start}");
                errors.push(problem.error("end_time", message));
            }
        }
        let modelers = root.child("modelers").and_then(|list| errors.absorb(list.list())).unwrap_or_default();
        let (processes, outputs) = process_blocks(&root, errors);
        if processes.is_empty() {
            warnings.push(root.warning("there are no processes: nothing is held, loaded or moved").to_string());
        }
        let flag = root.child("kratos_exact").and_then(|flag| errors.absorb(read_flag(&flag)));
        let kratos_exact = flag.unwrap_or(false);
        let restart = root.child(NAME).and_then(|restart| errors.absorb(restart.read(RESTART)));
        Self { root, problem, solver, modelers, processes, outputs, kratos_exact, restart, warnings }
    }
}

fn read_flag(value: &Parameters) -> Result<bool, InputErrors> {
    let wrong = || value.error(format!("is {}, must be true or false", describe(value.value()))).into();
    value.value().as_bool().ok_or_else(wrong)
}

/// Refuses unknown members; those whose names begin with an underscore are comments, or switched off.
fn check_members(root: &Parameters, errors: &mut InputErrors) -> Vec<String> {
    let known: Vec<&str> = MEMBERS.iter().chain(LEGACY_LISTS).chain(WITHOUT_EFFECT).copied().collect();
    let mut warnings = Vec::new();
    for (name, value) in root.members() {
        if known.contains(&name.as_str()) {
            if WITHOUT_EFFECT.contains(&name.as_str()) {
                warnings.push(value.warning(format!("{name:?} has no effect in Bia")).to_string());
            }
        } else if !name.starts_with('_') {
            errors.push(value.error(format!("the key {name:?} is unknown")).allowed(&name, known.iter().copied()));
        }
    }
    warnings
}

/// Process blocks in Kratos's order: JSON objects are visited in the alphabetical order of their
/// keys, each list in its own order; the old lists at the root come in a fixed order.
fn process_blocks(root: &Parameters, errors: &mut InputErrors) -> (Vec<Parameters>, Vec<Parameters>) {
    let mut blocks = |name: &str| {
        let mut list = Vec::new();
        if let Some(group) = root.child(name) {
            if !group.value().is_object() {
                errors.push(group.error("must be an object of lists of processes"));
            }
            for (key, entry) in group.members() {
                if entry.value().is_array() {
                    list.extend(entry.entries());
                } else {
                    errors.push(entry.error(format!("{key:?} must be a list of processes")));
                }
            }
        }
        list
    };
    let (mut processes, outputs) = (blocks("processes"), blocks("output_processes"));
    let legacy: Vec<Parameters> = LEGACY_LISTS.iter().filter_map(|name| root.child(name)).collect();
    let blocks: Vec<Parameters> = legacy.iter().filter_map(|list| errors.absorb(list.list())).flatten().collect();
    if let Some(first) = legacy.first() {
        if processes.is_empty() {
            processes = blocks;
        } else if !blocks.is_empty() {
            errors.push(first.error("lists of processes at the root cannot stand beside \"processes\""));
        }
    }
    (processes, outputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Document;
    use std::path::Path;

    fn read(text: &str) -> Result<Project, InputErrors> {
        let mut errors = InputErrors::default();
        let project = Project::read(Parameters::root(Document::parse(Path::new("p.json"), text.into())?), &mut errors);
        errors.or(project)
    }

    #[test]
    fn lists_act_in_alphabetical_order() {
        let text = r#"{"problem_data": {"end_time": 1}, "solver_settings": {},
            "processes": {"loads": [3], "gravity": [1, 2]}, "output_processes": {"b": [5], "a": [4]}}"#;
        let project = read(text).unwrap();
        let values = |list: &[Parameters]| list.iter().map(|p| p.value().as_i64().unwrap()).collect::<Vec<_>>();
        assert_eq!((values(&project.processes), values(&project.outputs)), (vec![1, 2, 3], vec![4, 5]));
    }

    #[test]
    fn old_lists_act_in_their_own_order_and_cannot_be_mixed() {
        let text =
            r#"{"problem_data": {"end_time": 1}, "solver_settings": {}, "gravity": [2], "loads_process_list": [1]}"#;
        assert_eq!(read(text).unwrap().processes[0].value(), 1);
        let mixed = text.replace("\"gravity\"", "\"processes\": {\"a\": [3]}, \"gravity\"");
        assert!(read(&mixed).err().unwrap().to_string().contains("beside"));
    }

    #[test]
    fn unknown_members_are_errors_unless_they_are_commented_out() {
        let text = r#"{"problem_data": {"end_time": 1}, "solver_setings": {}, "something_else": 1}"#;
        let message = read(text).err().unwrap().to_string();
        assert!(message.contains("did you mean \"solver_settings\""), "{message}");
        assert!(message.contains("\"something_else\" is unknown"), "{message}");
        let text = r#"{"problem_data": {"end_time": 1}, "solver_settings": {}, "_something_else": 1}"#;
        assert_eq!(read(text).unwrap().warnings.len(), 1, "that there are no processes");
    }
}
