//! Runs in temporary folders: undisturbed, and in pieces.

use super::common::process;
use bia_kernel::analysis::{Analysis, Observer, RecordPlan};
use bia_kernel::parameters::Document;
use bia_kernel::processes::{Clock, RunOptions};
use bia_kernel::registry::Registry;
use bia_kernel::solving::StepReport;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// States that records hold beside the first one.
pub const STATES: usize = 3;

/// Writes the inputs of a scene to a folder.
pub type Write<'a> = &'a dyn Fn(&Path);

/// A folder with the scene and other output processes.
pub fn folder(write: Write, outputs: &[Value], restart: Option<Value>) -> TempDir {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let path = folder.path().join("ProjectParameters.json");
    let mut project: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    project["output_processes"]["list"] = outputs.into();
    if let Some(restart) = restart {
        project["restart"] = restart;
    }
    std::fs::write(path, project.to_string()).unwrap();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    folder
}

/// `bia run` in a folder, results and record below `out`.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder).args(["run", "ProjectParameters.json", "--output", "out"]);
    command.args(["--record", "out/record.json", "--record-states", &STATES.to_string()]).args(arguments);
    command
}

/// The exit code and what the program said.
pub fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let Output { status, stdout, stderr } = command(folder, arguments).output().unwrap();
    (status.code(), String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr))
}

pub fn succeed(folder: &Path, arguments: &[&str]) {
    let (code, told) = run(folder, arguments);
    assert_eq!(code, Some(0), "{told}");
}

/// Stops after a step.
struct StopAt(usize, usize);

impl Observer for StopAt {
    fn step(&mut self, clock: &Clock, _: Option<usize>, _: &StepReport) {
        self.1 = clock.step;
    }

    fn wants_to_stop(&self) -> bool {
        self.1 >= self.0
    }
}

/// Runs or resumes in this process until a step is done.
pub fn run_until(folder: &Path, step: usize, resumes: bool) {
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    bia_structural::register(&mut registry);
    bia_dgmpm::register(&mut registry);
    let out = folder.join("out");
    let options = RunOptions { folder: folder.into(), output: out.clone(), ..RunOptions::default() };
    let document = Document::read(&folder.join("ProjectParameters.json")).unwrap();
    let mut analysis = Analysis::prepare(document, &registry, options, true).map_err(|e| e.to_string()).unwrap();
    let record = Some(RecordPlan { path: out.join("record.json"), states: STATES, threads: 1 });
    let mut stop = StopAt(step, 0);
    let account = if resumes { analysis.resume(&mut stop, record) } else { analysis.run(&mut stop, record) };
    let account = account.unwrap();
    assert!(account.interrupted, "the run ended at step {} before it could be stopped", account.steps);
    assert_eq!(account.steps, step);
}

/// All result files by name; of the record what is no time, memory or number of threads.
pub fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    collect(&folder.join("out"), "", &mut found);
    let record = found.get_mut("record.json").expect("the run is whole, so it has a record");
    let mut json: Value = serde_json::from_slice(record).unwrap();
    let members = json.as_object_mut().unwrap();
    members.retain(|key, _| !key.ends_with("_s") && !key.ends_with("_mb") && key != "threads");
    *record = json.to_string().into_bytes();
    found
}

fn collect(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        match entry.file_type().unwrap().is_dir() {
            true => collect(&entry.path(), &format!("{name}/"), found),
            false => drop(found.insert(name, std::fs::read(entry.path()).unwrap())),
        }
    }
}

/// Compares result files byte for byte.
pub fn assert_same(told: &str, expected: &BTreeMap<String, Vec<u8>>, found: &BTreeMap<String, Vec<u8>>) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(expected), names(found), "{told}: other files");
    for (name, bytes) in expected {
        let other = &found[name];
        if bytes != other {
            let place = bytes.iter().zip(other).position(|(a, b)| a != b).unwrap_or(bytes.len().min(other.len()));
            let show = |bytes: &[u8]| {
                let range = place.saturating_sub(60)..bytes.len().min(place + 60);
                String::from_utf8_lossy(&bytes[range]).into_owned()
            };
            panic!("{told}: {name} differs at byte {place}:\n{}\n{}", show(bytes), show(other));
        }
    }
}

/// A run that stops twice, and goes on with two threads, leaves the same files as one that does not stop.
pub fn assert_resumes(told: &str, write: Write, outputs: &[Value], stops: [usize; 2]) {
    let whole = folder(write, outputs, None);
    succeed(whole.path(), &["--threads", "1", "--quiet"]);
    let expected = results(whole.path());
    assert!(expected.len() > 1, "{told}: a record alone would test no series");
    let pieces = folder(write, outputs, Some(json!({"every_steps": 2})));
    run_until(pieces.path(), stops[0], false);
    run_until(pieces.path(), stops[1], true);
    succeed(pieces.path(), &["--threads", "2", "--quiet", "--resume"]);
    assert_same(told, &expected, &results(pieces.path()));
}

/// All kinds of output of material points and their grid.
pub fn outputs_of_points(every: usize) -> Vec<Value> {
    let control = |mut members: Value| {
        let own = json!({"output_control_type": "step", "output_interval": every});
        members.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
        members
    };
    vec![
        process(
            "mpm_vtk_output_process",
            control(json!({"model_part_name": "MPM_Material", "file_format": "vtu", "output_path": "points",
                "gauss_point_variables_in_elements": ["MP_DISPLACEMENT", "MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"]})),
        ),
        process(
            "vtk_output_process",
            control(json!({"model_part_name": "Background_Grid", "file_format": "ascii", "output_path": "grid",
                "nodal_solution_step_data_variables": ["DISPLACEMENT", "REACTION"]})),
        ),
        process(
            "mpm_write_energy_output_process",
            control(json!({"model_part_name": "MPM_Material", "print_format": ".16e"})),
        ),
        process("mpm_totals_output_process", json!({})),
        // Its numbers stand in the record, too.
        process(
            "error_process",
            json!({"label": "u", "model_part_name": "MPM_Material", "variable": "MP_DISPLACEMENT",
                   "reference": {"type": "formula", "value": ["0.1*X*t", "Y*t", 0]}, "interval": [0.002, "End"]}),
        ),
        process(
            "range_output_process",
            control(json!({"model_part_name": "MPM_Material", "output_variables": ["MP_DETERMINANT_F", "MP_VELOCITY"],
                           "on": {"positions": [[0.5, 0.5, 0.0], [0.1, 0.9, 0.0]], "of": "points"}})),
        ),
        process(
            "mpm_point_output_process",
            json!({"positions": [[0.5, 0.5, 0.0]], "output_variables": ["MP_DISPLACEMENT", "MP_VOLUME"],
                   "output_control_type": "time", "output_interval": 0.004}),
        ),
        process(
            "mpm_json_output_process",
            json!({"model_part_name": "MPM_Material", "time_frequency": 0.003, "output_file_name": "points.json",
                   "gauss_points_output_variables": ["MP_DISPLACEMENT", "MP_CAUCHY_STRESS_VECTOR"]}),
        ),
    ]
}
