//! What is told at the end of a run does not depend on where it was stopped.

use super::common::{Cell, Mesh, Scene, fix, material, process};
use super::trial::{folder, run, run_until};
use serde_json::{Value, json};

/// A block that turns, by which it loses energy, and rises from its support.
fn scene(members: &Value) -> Scene {
    let body = Mesh::block(Cell::Quadrilateral, [4, 4, 0], [0.0, 0.19, 0.0], [1.0, 1.19, 0.0]);
    let room = Mesh::block(Cell::Quadrilateral, [12, 12, 0], [-1.0, 0.0, 0.0], [2.0, 3.0, 0.0]);
    let mut solver = json!({"solver_type": "dynamic", "time_stepping": {"time_step": 0.01}});
    solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    let value = json!(["7 - 10*y", "10*x - 2", 0.0]);
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1000.0, 1e6, 0.3);
    Scene::new(room, body, law, solver, 0.295)
        .part("Floor", |x| x[1] == 0.0)
        .part("Ceiling", |x| x[1] == 3.0)
        .with(fix("Floor", json!([null, 0.0, null])))
        .with(fix("Ceiling", json!([null, 0.0, null])))
        .with(process(
            "assign_initial_field_to_material_point_process",
            json!({"model_part_name": "MPM_Material", "value": value}),
        ))
}

#[test]
fn the_end_of_a_resumed_run_tells_the_same() {
    let explicit = json!({"time_integration_method": "explicit", "scheme_type": "forward_euler", "transfer": "pic",
                          "time_stepping": {"time_step": 0.005}});
    for members in [json!({"scheme_type": "newmark"}), explicit] {
        let warnings = |stops: &[usize]| -> Vec<String> {
            let folder = folder(&|folder| scene(&members).write(folder), &[], Some(json!({"every_steps": 5})));
            for (index, stop) in stops.iter().enumerate() {
                run_until(folder.path(), *stop, index > 0);
            }
            let resume: &[&str] = if stops.is_empty() { &[] } else { &["--resume"] };
            let (code, told) = run(folder.path(), resume);
            assert_eq!(code, Some(0), "{told}");
            told.lines().filter(|line| line.contains("WARN")).map(str::to_owned).collect()
        };
        let whole = warnings(&[]);
        for wanted in
            ["their energy has fallen by", "come away from the nodes of Background_Grid.Floor", "no body has reached"]
        {
            assert!(whole.iter().any(|line| line.contains(wanted)), "{wanted}: {whole:?}");
        }
        assert_eq!(warnings(&[7]), whole);
        assert_eq!(warnings(&[12, 25]), whole);
    }
}
