use super::*;
use crate::geometry::check_cells;
use std::path::PathBuf;

/// Files that Gmsh 4.15 wrote (`python_scripts/make_gmsh_fixtures.py`).
fn files(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/gmsh");
    let forms = ["2.2_text", "2.2_binary", "4.1_text", "4.1_binary"];
    forms.iter().map(|form| folder.join(format!("{name}_{form}.msh"))).collect()
}

fn meshes(name: &str) -> Vec<ModelPart> {
    files(name).iter().map(|file| read(file, "Mesh", "Element").unwrap()).collect()
}

/// Length, area or volume of the elements of a sub model part, or of all.
fn measure(part: &ModelPart, name: Option<&str>) -> f64 {
    let all: Vec<u32> = (0..part.elements.len() as u32).collect();
    let chosen = name.map_or(&all, |name| &part.find(name).unwrap().elements);
    let of = |&cell: &u32| {
        let (shape, corners) = (part.elements.shapes[cell as usize], part.corners(&part.elements, cell as usize));
        if shape.dimension() == 2 { shape.plane_area(&corners) } else { shape.measure(&corners) }
    };
    chosen.iter().map(of).sum()
}

#[test]
fn a_plate_is_the_same_in_each_format() {
    for part in meshes("plate") {
        assert_eq!(check_cells(&part, &part.elements, 2), []);
        let count = |name: &str| {
            let part = part.find(name).unwrap();
            (part.nodes.len(), part.elements.len(), part.geometries.len())
        };
        // As Gmsh itself counts them.
        assert_eq!(count("Holed"), (51, 74, 0));
        assert_eq!(count("Whole"), (49, 36, 0));
        assert_eq!(count("Both"), (93, 110, 0));
        assert_eq!(count("Floor of plate"), (12, 0, 11));
        assert_eq!(count("Corner"), (1, 0, 1));
        assert_eq!((part.elements.len(), part.nodes.len()), (110, 93));
        assert!((measure(&part, Some("Whole")) - 1.0).abs() < 1e-12);
        assert!((measure(&part, Some("Both")) - measure(&part, None)).abs() < 1e-12);
        let holed = measure(&part, Some("Holed"));
        assert!(holed > 1.0 - 0.2 * 0.2 * std::f64::consts::PI && holed < 0.9, "{holed}");
        assert!(part.elements.names.iter().all(|name| ["Element2D3N", "Element2D4N"].contains(&name.as_str())));
        let floor = &part.find("Floor of plate").unwrap().nodes;
        assert!(floor.iter().all(|&node| part.nodes.coordinates[node as usize][1] == 0.0));
        let line = part.find("Floor of plate").unwrap().geometries[0] as usize;
        assert_eq!(part.geometries.name_of(line), "Line2D2");
    }
}

#[test]
fn solids_have_their_volume() {
    for part in meshes("block") {
        assert_eq!(check_cells(&part, &part.elements, 3), []);
        assert!((measure(&part, Some("Block")) - 2.0).abs() < 1e-12);
        let base = part.find("Base").unwrap();
        assert!(base.nodes.iter().all(|&node| part.nodes.coordinates[node as usize][2].abs() < 1e-12));
        let cells = base.geometries.iter().map(|&cell| part.corners(&part.geometries, cell as usize));
        let area: f64 = cells.map(|corners| crate::geometry::Shape::Triangle3.measure(&corners)).sum();
        assert!((area - 1.0).abs() < 1e-12);
    }
    for part in meshes("bricks") {
        assert_eq!((part.nodes.len(), part.elements.len()), (27, 8));
        assert!((measure(&part, Some("Volume_7")) - 2.0).abs() < 1e-12);
    }
}

#[test]
fn formats_agree_cell_by_cell() {
    for name in ["plate", "block", "bricks"] {
        let all = meshes(name);
        let places = |part: &ModelPart| {
            let mut cells: Vec<Vec<[i64; 3]>> = (0..part.elements.len())
                .map(|cell| {
                    part.corners(&part.elements, cell).iter().map(|x| x.map(|x| (x * 1e9).round() as i64)).collect()
                })
                .collect();
            cells.sort();
            cells
        };
        for other in &all[1..] {
            assert_eq!(places(&all[0]), places(other), "{name}");
        }
    }
}

fn message(text: &str) -> String {
    match parse(text.as_bytes(), Path::new("m.msh"), "Mesh", "Element") {
        Ok(_) => "no fault".into(),
        Err(errors) => errors.to_string(),
    }
}

const HEAD: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const NODES: &str = "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";

#[test]
fn faults_have_their_line() {
    let cases = [
        ("Begin Nodes\n".to_string(), "does not begin with $MeshFormat"),
        ("$MeshFormat\n4 0 8\n$EndMeshFormat\n".into(), "m.msh:2: the format 4 of Gmsh is not read"),
        (HEAD.into(), "ends without the section $Nodes"),
        (format!("{HEAD}{NODES}"), "ends without the section $Elements"),
        (format!("{HEAD}$Nodes\n3\n1 0 x 0\n"), "m.msh:6: \"x\" is no number"),
        (format!("{HEAD}$Nodes\n3\n1 0 nan 0\n"), "NaN is not finite"),
        (format!("{HEAD}$Nodes\n300000000\n1 0 0 0\n"), "300000000 items are announced"),
        (format!("{HEAD}$Nodes\n2\n1 0 0 0\n"), "ends too soon"),
        (format!("{HEAD}$Nodes\n1\n0 0 0 0\n"), "the id 0 is not between"),
        (
            format!("{HEAD}{NODES}$Elements\n1\n1 6 2 0 1 1 2 3 1 2 3\n$EndElements\n"),
            "m.msh:12: the mesh holds prisms",
        ),
        (
            format!("{HEAD}{NODES}$Elements\n1\n1 2 2 0 1 1 2 4\n$EndElements\n"),
            "the cell 1 holds the node 4, which does",
        ),
        (format!("{HEAD}{NODES}$Elements\n1\n1 15 2 0 1 1\n$EndElements\n"), "no lines, faces or solids"),
        (
            format!("{HEAD}{NODES}$Elements\n1\n1 2 2 0 1 1 2 3\n$EndNodes\n"),
            "$EndNodes stands where $EndElements must",
        ),
        (format!("{HEAD}$PhysicalNames\n1\n2 1 \"a.b\"\n$EndPhysicalNames\n"), "called \"a.b\""),
        (format!("{HEAD}$Periodic\n1\n"), "has no end"),
    ];
    for (text, expected) in cases {
        let found = message(&text);
        assert!(found.contains(expected), "{expected:?} is not in {found}");
    }
}

#[test]
fn clockwise_faces_are_turned_over() {
    let text = format!("{HEAD}{NODES}$Elements\n1\n1 2 2 0 1 1 3 2\n$EndElements\n");
    let part = parse(text.as_bytes(), Path::new("m.msh"), "Mesh", "Element").unwrap();
    assert_eq!(measure(&part, None), 0.5);
}

/// A seeded walk of broken bytes: an error or a mesh, never a panic or a huge allocation.
#[test]
fn broken_files_do_no_harm() {
    let mut state = 12345u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    for file in ["plate", "block", "bricks"].iter().flat_map(|name| files(name)) {
        let whole = std::fs::read(&file).unwrap();
        for _ in 0..100 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random(4) {
                let at = random(bytes.len());
                match random(4) {
                    0 => bytes[at] = random(256) as u8,
                    1 => bytes.truncate(at.max(1)),
                    2 => bytes.insert(at, b"0123456789-$e \n"[random(15)]),
                    _ => drop(bytes.remove(at)),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            let _ = parse(&bytes, &file, "Mesh", "Element");
        }
    }
}
