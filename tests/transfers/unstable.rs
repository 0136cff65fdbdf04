//! A run that goes unstable says at once where, when and what step it should have had.

use super::{CUBIC, Frame, HATS, SPLINE, explicit, turning_block};
use serde_json::json;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn bia(folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder).args(["run", "ProjectParameters.json", "--quiet", "--threads", "1"]);
    command.output().expect("the built program starts")
}

#[test]
fn an_unstable_run_stops_at_once_and_tells_the_step() {
    let lumped = json!({"stress_update": "musl"});
    let verlet = json!({"scheme_type": "velocity_verlet", "consistent_mass_matrix": true});
    let apic = json!({"stress_update": "usl", "transfer": "apic"});
    for (frame, functions, members) in [
        (Frame::Total, HATS, &lumped),
        (Frame::Total, HATS, &verlet),
        (Frame::Total, SPLINE, &lumped),
        (Frame::Total, SPLINE, &verlet),
        (Frame::Total, CUBIC, &apic),
        (Frame::Updated, HATS, &lumped),
        (Frame::Updated, SPLINE, &apic),
    ] {
        let of = |time_step: f64, end: f64| {
            let folder = TempDir::new().unwrap();
            turning_block(frame, functions, explicit(frame, functions, time_step, members), end).write(folder.path());
            bia(folder.path())
        };
        // Some five times the stable step: the first step that breaks a point down ends the run.
        let output = of(0.025, 10.0);
        let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        let what = format!("{frame:?} {functions:?} {members}: {text}");
        assert_eq!(output.status.code(), Some(3), "{what}");
        for word in ["the run is unstable", "material point", " at (", "J = ", "velocity: [", "time step 2.5000e-2 s"] {
            assert!(text.contains(word), "no {word:?}: {what}");
        }
        let number = |after: &str| {
            let text = text.split(after).nth(1).unwrap_or_else(|| panic!("no {after:?}: {what}"));
            let text = text.trim_start().split([' ', ',']).next().unwrap();
            text.parse::<f64>().unwrap_or_else(|_| panic!("{text:?} after {after:?}: {what}"))
        };
        assert!(number("error: step") < 20.0, "{what}");
        // The step that it says it should have had serves, with room for the cells that compression
        // shortens and for points that become faster.
        let output = of(0.95 * number("a time step of at most"), 0.3);
        assert!(output.status.success(), "{what}\n{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// In the total frame no cell is crossed: a body may fly over many cells in a step.
#[test]
fn a_fast_body_is_no_unstable_one() {
    let mut scene = turning_block(Frame::Total, HATS, explicit(Frame::Total, HATS, 1e-3, &json!({})), 0.01);
    scene.processes = vec![super::initial_velocity("MPM_Material", ["1e4", "0", "0"])];
    let record = scene.run(&[]);
    let moved = record.last().total("com")[0] - record.first().total("com")[0];
    assert!((moved - 1e4 * record.last().time()).abs() < 1e-9 * moved, "{moved}");
    let strain = record.last().energy("strain") / record.first().energy("kinetic");
    assert!(strain.abs() < 1e-15, "flight strains the body: {strain:e}");
}
