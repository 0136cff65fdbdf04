//! A scene holds what its method needs and nothing else.

use super::{Frame, HATS, explicit, turning_block};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

/// Columns in use, and bytes a point, as `bia check` tells them.
fn check(frame: Frame, members: &Value) -> (Vec<String>, usize) {
    let folder = TempDir::new().unwrap();
    turning_block(frame, HATS, explicit(frame, HATS, 1e-3, members), 0.1).write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(["check", "ProjectParameters.json"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    let line = |name: &str| {
        let line = text.lines().map(str::trim).find_map(|line| line.strip_prefix(name));
        line.unwrap_or_else(|| panic!("no line {name:?} in {text}")).trim().to_string()
    };
    let list = |name: &str| line(name).split(", ").map(String::from).collect::<Vec<_>>();
    let (used, left) = (list("columns in use"), list("left out"));
    assert!(used.iter().all(|name| !left.contains(name)), "{text}");
    let memory = line("memory of the points");
    let bytes = memory.split(" bytes a point").next().and_then(|head| head.rsplit(' ').next()).unwrap();
    (used, bytes.parse().unwrap())
}

#[test]
fn no_scene_holds_the_columns_of_another_method() {
    const EXPLICIT: &[&str] = &["position", "velocity", "mass", "deformation gradient", "Cauchy stress", "volume"];
    const IMPLICIT: &[&str] =
        &["local coordinates", "position", "velocity", "acceleration", "mass", "deformation gradient"];
    let implicit = json!({"time_integration_method": "implicit", "scheme_type": "newmark"});
    let with = |columns: &[&'static str], more: &[&'static str]| [columns, more].concat();
    for (frame, members, expected, most) in [
        (Frame::Updated, json!({"stress_update": "musl"}), with(EXPLICIT, &[]), 112),
        (Frame::Updated, json!({"scheme_type": "central_difference"}), with(EXPLICIT, &["acceleration"]), 128),
        (Frame::Total, json!({"scheme_type": "velocity_verlet"}), with(EXPLICIT, &["local coordinates"]), 128),
        (Frame::Updated, json!({"transfer": "pic"}), with(EXPLICIT, &[]), 112),
        (Frame::Updated, json!({"transfer": "apic"}), with(EXPLICIT, &["transfer"]), 144),
        (Frame::Updated, json!({"transfer": "tpic"}), with(EXPLICIT, &["transfer"]), 144),
        (Frame::Updated, json!({"transfer": "xpic"}), with(EXPLICIT, &["transfer"]), 128),
        (Frame::Updated, implicit.clone(), with(IMPLICIT, &[]), 112),
        (Frame::Total, implicit, with(IMPLICIT, &[]), 112),
    ] {
        let (mut used, bytes) = check(frame, &members);
        let mut expected: Vec<String> = expected.into_iter().map(String::from).collect();
        used.sort();
        expected.sort();
        assert_eq!(used, expected, "{frame:?} {members}");
        assert!(bytes <= most, "{frame:?} {members}: {bytes} bytes a point");
    }
}
