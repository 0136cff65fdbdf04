//! Faults of the mesh files, and bodies that do not fit their grid.

use super::base::{BODY, GRID, MATERIALS, PROJECT, Scene, mesh, part, refuse};

#[test]
fn files() {
    refuse(&[
        ("no body", |s| s.remove(BODY), &["Body.mdpa", "cannot be read", "Grid.mdpa"]),
        ("no grid", |s| s.remove(GRID), &["Grid.mdpa", "cannot be read", "Body.mdpa"]),
        ("both missing", |s| s.remove(GRID).remove(BODY), &["Grid.mdpa", "Body.mdpa", "2 errors in the input"]),
        (
            "empty grid",
            |s| s.write(GRID, "").replace(PROJECT, "Background_Grid.Floor", "Background_Grid"),
            &["Grid.mdpa", "the background grid has no elements"],
        ),
        ("empty body", |s| s.write(BODY, ""), &["there is no part \"Initial_MPM_Material.Cube\" of the bodies"]),
        ("not UTF-8", |s| s.write(GRID, *b"Begin Nodes\n1 0 \xff 0\nEnd Nodes\n"), &["Grid.mdpa"]),
        ("binary", |s| s.write(GRID, (0u8..=127).cycle().take(4000).collect::<Vec<u8>>()), &["Grid.mdpa:"]),
    ]);
}

#[test]
fn numbers() {
    refuse(&[
        ("nan", |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 nan 0.0"), &["Body.mdpa:8:9", "nan"]),
        ("0.2x5", |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 0.2x5 0.0"), &["Body.mdpa:8:9", "0.2x5"]),
        ("1e999", |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 1e999 0.0"), &["Body.mdpa:8:9", "1e999"]),
        ("two coordinates", |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 0.25"), &["Body.mdpa:8"]),
        ("id below zero", |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n-105 0.5 0.25 0.0"), &["Body.mdpa:8:1", "-105"]),
        (
            "huge id",
            |s| s.replace(BODY, "\n105 0.5 0.25 0.0", "\n99999999999 0.5 0.25 0.0"),
            &["Body.mdpa:8:1", "99999999999"],
        ),
        (
            "all together",
            |s| {
                s.replace(BODY, "\n105 0.5 0.25 0.0", "\n105 0.5 nan 0.0").replace(
                    BODY,
                    "\n106 0.75 0.25",
                    "\n106 0.7z 0.25",
                )
            },
            &["Body.mdpa:8:9", "Body.mdpa:9:5", "2 errors in the input"],
        ),
    ]);
}

#[test]
fn blocks() {
    refuse(&[
        (
            "cut off",
            |s| {
                let text = s.text(GRID);
                s.write(GRID, text[..300].to_string())
            },
            &["Grid.mdpa:", "Grid.mdpa:3:7", "the file ends inside the block Nodes that begins here"],
        ),
        (
            "unknown",
            |s| {
                s.replace(
                    GRID,
                    "Begin Properties 0\nEnd Properties\n",
                    "Begin Knots\nEnd Knots\nBegin Properties 0\nEnd Properties\n",
                )
            },
            &["Grid.mdpa:1:7", "Knots", "Nodes"],
        ),
        (
            "unclosed part",
            |s| {
                let text = s.text(GRID);
                let cut = text.rfind("End SubModelPart\n").unwrap();
                s.write(GRID, text[..cut].to_string())
            },
            &["Grid.mdpa:48:", "the file ends inside the block SubModelPart that begins here"],
        ),
        (
            "deep parts",
            |s| s.append(GRID, &"Begin SubModelPart a\n".repeat(50_000)),
            &["Grid.mdpa:", "nested more than 32 deep"],
        ),
        (
            "old element",
            |s| s.replace(BODY, "MPMUpdatedLagrangian2D4N", "MPMUpdatedLagrangean2D4N"),
            &[
                "Body.mdpa:14:16",
                "\"MPMUpdatedLagrangean2D4N\" is no element that is registered",
                "did you mean \"MPMUpdatedLagrangian2D4N\"?",
            ],
        ),
        (
            "nodes of a triangle",
            |s| s.replace(BODY, "MPMUpdatedLagrangian2D4N", "MPMUpdatedLagrangian2D3N"),
            &["Body.mdpa:15:1", "MPMUpdatedLagrangian2D3N has 3 nodes, but its line holds 4"],
        ),
        (
            "properties",
            |s| s.replace(BODY, "101 0 101 102", "101 7 101 102"),
            &["Body.mdpa:15", "the properties 7", "declared: 0"],
        ),
    ]);
}

#[test]
fn ids() {
    refuse(&[
        (
            "missing node",
            |s| s.replace(GRID, "\n6 0 7 8 13 12", "\n6 0 7 8 99999 12"),
            &["Grid.mdpa:36", "element 6 names the node 99999, which is missing", "ids from 1 to 25"],
        ),
        (
            "node twice",
            |s| s.replace(GRID, "\nEnd Nodes", "\n7 0.3 0.25 0.0\nEnd Nodes"),
            &["Grid.mdpa:29", "node 7 stands twice", "on line 10"],
        ),
        (
            "element twice",
            |s| s.replace(GRID, "\nEnd Elements", "\n6 0 7 8 13 12\nEnd Elements"),
            &["Grid.mdpa:47", "element 6 stands twice, first on line 36"],
        ),
        (
            "part names a node",
            |s| s.replace(GRID, "\n5\nEnd SubModelPartNodes", "\n77777\nEnd SubModelPartNodes"),
            &["Grid.mdpa:54", "the sub model part \"Floor\" names the node 77777, which is missing"],
        ),
        (
            "part names an element",
            |s| s.replace(BODY, "\n104\nEnd SubModelPartElements", "\n777\nEnd SubModelPartElements"),
            &["Body.mdpa:", "names the element 777, which is missing"],
        ),
        (
            "part twice",
            |s| s.append(GRID, "Begin SubModelPart Floor\nEnd SubModelPart\n"),
            &["the sub model part \"Floor\" stands twice, first on line 48"],
        ),
    ]);
}

#[test]
fn cells() {
    refuse(&[
        (
            "node twice",
            |s| s.replace(GRID, "\n6 0 7 8 13 12", "\n6 0 7 8 13 8"),
            &["Grid.mdpa:36", "Element2D4N 6 has node 8 twice"],
        ),
        (
            "inside out",
            |s| s.replace(GRID, "\n6 0 7 8 13 12", "\n6 0 7 12 13 8"),
            &["Grid.mdpa:36", "Element2D4N 6 is inside out", "1 4 3 2"],
        ),
        (
            "bow-tie",
            |s| s.replace(GRID, "\n6 0 7 8 13 12", "\n6 0 7 8 12 13"),
            &["Grid.mdpa:36", "Element2D4N 6 is folded", "counter-clockwise"],
        ),
        ("flat", |s| s.replace(GRID, "\n6 0 7 8 13 12", "\n6 0 6 7 8 9"), &["Grid.mdpa:36", "Element2D4N 6 is flat"]),
        (
            "body inside out",
            |s| s.replace(BODY, "\n103 0 104 105 108 107", "\n103 0 104 107 108 105"),
            &["Body.mdpa:17", "MPMUpdatedLagrangian2D4N 103 is inside out"],
        ),
        (
            "body bow-tie",
            |s| s.replace(BODY, "\n103 0 104 105 108 107", "\n103 0 104 105 107 108"),
            &["Body.mdpa:17", "MPMUpdatedLagrangian2D4N 103 is folded"],
        ),
        (
            "plane above zero",
            |s| {
                let text = s.text(GRID).replace(" 0.0\n", " 5.0\n").replace("\n6 0 7 8 13 12", "\n6 0 7 12 13 8");
                s.write(GRID, text)
            },
            &["Grid.mdpa:36", "Element2D4N 6 is inside out"],
        ),
        (
            "many",
            |s| {
                let text = s.text(GRID);
                let turned: String = text
                    .lines()
                    .map(|line| match line.split(' ').collect::<Vec<_>>().as_slice() {
                        [id, "0", a, b, c, d] => format!("{id} 0 {a} {d} {c} {b}\n"),
                        _ => format!("{line}\n"),
                    })
                    .collect();
                s.write(GRID, turned)
            },
            &["Grid.mdpa:31", "Grid.mdpa:46", "16 errors in the input"],
        ),
        (
            "hundreds",
            |s| {
                let text = mesh("Element2D4N", 0, 20, [0.0, 0.0], 0.05);
                let turned: String = text
                    .lines()
                    .map(|line| match line.split(' ').collect::<Vec<_>>().as_slice() {
                        [id, "0", a, b, c, d] => format!("{id} 0 {a} {d} {c} {b}\n"),
                        _ => format!("{line}\n"),
                    })
                    .collect();
                s.write(GRID, turned)
            },
            &["and 380 more cells"],
        ),
        (
            "solid in the plane",
            |s| {
                s.replace(
                    BODY,
                    "\nEnd Elements",
                    "\nEnd Elements\nBegin Elements MPMUpdatedLagrangian3D4N\n150 0 101 102 104 105\nEnd Elements",
                )
                .replace(BODY, "\n104\nEnd SubModelPartElements", "\n150\nEnd SubModelPartElements")
            },
            &["Body.mdpa:", "150"],
        ),
    ]);
}

#[test]
fn bodies_outside_their_grid() {
    refuse(&[
        (
            "partly",
            |s| {
                s.write(
                    BODY,
                    mesh("MPMUpdatedLagrangian2D4N", 100, 2, [-0.125, 0.0], 0.25) + &part("Cube", 101..=109, 101..=104),
                )
            },
            &[
                "Body.mdpa:15",
                "4 material points lie outside the background grid",
                "body element 101",
                "the grid spans",
                "[1.0, 1.0",
            ],
        ),
        (
            "wholly",
            |s| {
                s.write(
                    BODY,
                    mesh("MPMUpdatedLagrangian2D4N", 100, 2, [50.0, 0.0], 0.25) + &part("Cube", 101..=109, 101..=104),
                )
            },
            &["16 material points lie outside", "the grid spans"],
        ),
        (
            "far away",
            |s| {
                s.write(
                    BODY,
                    mesh("MPMUpdatedLagrangian2D4N", 100, 2, [1e300, 0.0], 1e299) + &part("Cube", 101..=109, 101..=104),
                )
            },
            &["Body.mdpa"],
        ),
        (
            "keeping lost points",
            |s| {
                s.write(
                    BODY,
                    mesh("MPMUpdatedLagrangian2D4N", 100, 2, [-0.125, 0.0], 0.25) + &part("Cube", 101..=109, 101..=104),
                )
                .replace(
                    PROJECT,
                    "\"max_iteration\": 20",
                    "\"element_search_settings\": {\"remove_entities_not_found\": false}",
                )
            },
            &["4 material points lie outside"],
        ),
        (
            "beyond the axis",
            |s| {
                s.write(GRID, mesh("Element2D4N", 0, 4, [-0.5, 0.0], 0.25) + &part("Floor", 1..=5, 1..=1))
                    .write(
                        BODY,
                        mesh("MPMUpdatedLagrangian2D4N", 100, 2, [-0.25, 0.0], 0.25)
                            + &part("Cube", 101..=109, 101..=104),
                    )
                    .replace(PROJECT, "\"axis_symmetric_flag\": false", "\"axis_symmetric_flag\": true")
                    .replace(MATERIALS, "PlaneStrain2DLaw", "Axisym2DLaw")
            },
            &["Body.mdpa:15", "body element 101", "negative radius", "x >= 0"],
        ),
        (
            "no elements in parts",
            |s| {
                let text = s.text(BODY);
                let cut = text.find("Begin SubModelPart Cube").unwrap();
                s.write(BODY, text[..cut].to_string()).replace(MATERIALS, ".Cube", "")
            },
            &["the bodies have no elements in parts", "sub model part of the first level"],
        ),
    ]);
}

#[test]
fn suspicious_bodies_are_told() {
    let words = |scene: Scene| {
        let outcome = scene.command("check", &[]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.words()
    };
    let left_out = words(Scene::base().replace(BODY, "\n104\nEnd SubModelPartElements", "\nEnd SubModelPartElements"));
    assert!(
        left_out.contains("1 element of the bodies belongs to no sub model part and makes no material points"),
        "{left_out}"
    );
    let twice = words(Scene::base().append(BODY, &part("Again", 101..=109, 104..=104)));
    assert!(twice.contains("1 element of the bodies belongs to several"), "{twice}");
    let axisymmetric =
        words(Scene::base().replace(BODY, "MPMUpdatedLagrangian2D4N", "MPMUpdatedLagrangianAxisymmetry2D4N"));
    assert!(axisymmetric.contains("axis_symmetric_flag"), "{axisymmetric}");
    let old = words(Scene::base().replace(BODY, "MPMUpdatedLagrangian2D4N", "UpdatedLagrangian2D4N"));
    assert!(!old.contains("warning"), "{old}");
}
