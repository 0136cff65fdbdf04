//! A scene without nodal pressures has no column, dof or matrix block of them.

use super::common::{Cell, Mesh, Scene, fix, gravity, material};
use serde_json::json;
use std::process::Command;

fn check(pressure_dofs: bool) -> String {
    let mesh = Mesh::block(Cell::Quadrilateral, [3, 3, 1], [0.0; 3], [1.0; 3]);
    let law = if pressure_dofs {
        "HyperElasticNeoHookeanPlaneStrainUP2DLaw"
    } else {
        "HyperElasticNeoHookeanPlaneStrain2DLaw"
    };
    let solver = json!({"pressure_dofs": pressure_dofs, "solver_type": "dynamic"});
    let scene = Scene::new(mesh.clone(), mesh, material(law, 4, 1.0, 1e4, 0.4), solver, 1.0)
        .part("Floor", |x| x[1] == 0.0)
        .with(fix("Floor", json!([0.0, 0.0, 0.0])))
        .with(gravity([0.0, -1.0, 0.0]));
    let folder = tempfile::TempDir::new().unwrap();
    scene.write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(["check", "ProjectParameters.json"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn line<'a>(text: &'a str, start: &str) -> &'a str {
    text.lines().find(|line| line.trim_start().starts_with(start)).unwrap_or_else(|| panic!("no {start} in {text}"))
}

#[test]
fn pressure_takes_room_only_where_it_is_an_unknown() {
    let (plain, mixed) = (check(false), check(true));
    assert!(!line(&plain, "columns in use").contains("pressure") && line(&plain, "left out").contains("pressure"));
    assert!(line(&plain, "dofs at the start").contains("32 on 9"), "{plain}");
    assert!(line(&mixed, "columns in use").contains("pressure"));
    assert!(line(&mixed, "dofs at the start").contains("48 on 9"), "{mixed}");
    let bytes = |text: &str| -> f64 {
        let told = line(text, "memory of the points");
        told.split(", ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    assert_eq!(bytes(&mixed) - bytes(&plain), 8.0);
}
