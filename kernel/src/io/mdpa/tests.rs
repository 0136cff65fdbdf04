use super::*;
use crate::model::Value;
use std::io::Read;

/// A handful of Kratos's names, as an application would register them.
struct Names;

const ELEMENTS: [(&str, Shape); 6] = [
    ("Element2D3N", Shape::Triangle3),
    ("Element2D4N", Shape::Quadrilateral4),
    ("Element3D4N", Shape::Tetrahedron4),
    ("Element3D8N", Shape::Hexahedron8),
    ("MPMUpdatedLagrangian2D3N", Shape::Triangle3),
    ("MPMUpdatedLagrangian2D4N", Shape::Quadrilateral4),
];
const CONDITIONS: [(&str, Shape); 3] = [
    ("PointCondition2D1N", Shape::Point1),
    ("LineCondition2D2N", Shape::Line2),
    ("SurfaceCondition3D3N", Shape::Triangle3),
];

impl CellNames for Names {
    fn shape(&self, category: Category, name: &str) -> Option<Shape> {
        let names: &[(&str, Shape)] = match category {
            Category::Element => &ELEMENTS,
            Category::Condition => &CONDITIONS,
            Category::Geometry => &[],
        };
        names.iter().find(|(known, _)| *known == name).map(|(_, shape)| *shape)
    }

    fn names(&self, category: Category) -> Vec<String> {
        let names = ELEMENTS.iter().chain(&CONDITIONS);
        names.filter(|(name, _)| self.shape(category, name).is_some()).map(|(name, _)| name.to_string()).collect()
    }
}

fn read_text(text: &str) -> Result<ModelPart, InputErrors> {
    parse(text, Path::new("t.mdpa"), "Grid", &Names)
}

const VALID: &str = "\
Begin ModelPartData // comment
  AMBIENT_TEMPERATURE 250.0
End ModelPartData
Begin Table 3 TIME DISPLACEMENT_X
  0.0 0.0 /* in between */
  1.0 2.0
End Table
Begin Properties 0
End Properties
Begin Properties 1
  DENSITY 7.85e3
  CONSTITUTIVE_LAW LinearElastic3DLaw
  BODY_FORCE [3] (0.0, -9.81, 0)
  LOCAL_INERTIA [2,2]((1,0),(0,1))
  IS_ON true
  Begin Table TEMPERATURE YOUNG_MODULUS
    0 10
    5 20
  End Table
End Properties
Begin Nodes
  4 0 1 0
  2 1.0 0.0 .0
End Nodes
Begin Nodes // a second block, unsorted
  1 0 0 0 /* two
  lines */
  3 1 1. 0
  2 1 0 0
  7 5 5 0
End Nodes
Begin Elements Element2D3N// GUI group identifier: a
  12 1 1 3 4
  11 1 1 2 3
End Elements
Begin Elements Element2D4N
  5 0 1 2 3 4
End Elements
Begin Conditions LineCondition2D2N
  1 0 1 2
End Conditions
Begin Geometries Triangle2D3
  9 4 3 7
End Geometries
Begin NodalData DISPLACEMENT_X
  3 1 0.5
  1 0 -0.5
End NodalData
Begin NodalData VELOCITY
  7 0 [3](1,2,3)
End NodalData
Begin NodalData SLIP
  2
End NodalData
Begin ElementalData TEMPERATURE
  12 4.0
End ElementalData
Begin ConditionalData PRESSURE
  1 4.5
End ConditionalData
Begin Mesh 1
  Begin MeshNodes
    1 2
  End MeshNodes
End Mesh
Begin SubModelPart Outer // Group
  Begin SubModelPartTables
    3
  End SubModelPartTables
  Begin SubModelPartNodes
    7 1
  End SubModelPartNodes
  Begin SubModelPart Inner
    Begin SubModelPartProperties
      1
    End SubModelPartProperties
    Begin SubModelPartNodes
      4
      1
    End SubModelPartNodes
    Begin SubModelPartElements
      12 5
    End SubModelPartElements
    Begin SubModelPartGeometries
      9
    End SubModelPartGeometries
  End SubModelPart
  Begin SubModelPartConditions
    1
  End SubModelPartConditions
End SubModelPart
";

#[test]
fn a_file_with_everything() {
    let part = read_text(VALID).unwrap();
    assert_eq!(part.name, "Grid");
    assert_eq!(part.nodes.ids, [1, 2, 3, 4, 7]);
    assert_eq!(part.nodes.coordinates[3], [0.0, 1.0, 0.0]);
    assert_eq!(part.elements.ids, [5, 11, 12]);
    assert_eq!(part.elements.shapes, [Shape::Quadrilateral4, Shape::Triangle3, Shape::Triangle3]);
    assert_eq!(part.elements.name_of(2), "Element2D3N");
    assert_eq!(part.elements.nodes_of(0), [0, 1, 2, 3]);
    assert_eq!(part.elements.nodes_of(2), [0, 2, 3]);
    assert_eq!(part.elements.properties, [0, 1, 1]);
    assert_eq!(part.conditions.nodes_of(0), [0, 1]);
    assert_eq!(part.geometries.nodes_of(0), [3, 2, 4]);
    assert_eq!(part.tables[&3].value(0.5), 1.0);
    let properties = &part.properties[&1];
    assert_eq!((properties.id, properties.law.as_deref()), (1, Some("LinearElastic3DLaw")));
    assert_eq!(properties.number("DENSITY"), Some(7850.0));
    assert_eq!(properties.values["BODY_FORCE"], Value::Vector(vec![0.0, -9.81, 0.0]));
    assert_eq!(properties.values["IS_ON"], Value::Bool(true));
    assert_eq!(properties.tables[&("TEMPERATURE".to_string(), "YOUNG_MODULUS".to_string())].value(2.5), 15.0);
    assert_eq!(part.nodal_data["DISPLACEMENT_X"], [(0, false, Value::Number(-0.5)), (2, true, Value::Number(0.5))]);
    assert_eq!(part.nodal_data["SLIP"], [(1, false, Value::Bool(true))]);
    assert_eq!(part.elemental_data["TEMPERATURE"], [(2, Value::Number(4.0))]);
    assert_eq!(part.conditional_data["PRESSURE"], [(0, Value::Number(4.5))]);
}

#[test]
fn parents_hold_what_their_children_hold_ascending() {
    let part = read_text(VALID).unwrap();
    assert_eq!(part.paths(), ["Outer", "Outer.Inner"]);
    let inner = part.find("Outer.Inner").unwrap();
    assert_eq!((inner.nodes.as_slice(), inner.elements.as_slice()), (&[0, 3][..], &[0, 2][..]));
    let outer = part.find("Outer").unwrap();
    assert_eq!(outer.nodes, [0, 3, 4]);
    assert_eq!((outer.elements.as_slice(), outer.conditions.as_slice()), (&[0, 2][..], &[0][..]));
    assert_eq!((outer.geometries.as_slice(), outer.tables.as_slice()), (&[0][..], &[3][..]));
    assert_eq!(outer.properties, [1]);
}

/// A text with one fault, the fault's line, and parts of the message that must be there.
type Faulty = (&'static str, usize, &'static [&'static str]);

const HEAD: &str = "Begin Properties 0\nEnd Properties\nBegin Nodes\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\nEnd Nodes\n";

fn assert_faults(prefix: &str, cases: &[Faulty]) {
    for (text, line, parts) in cases {
        let errors = read_text(&format!("{prefix}{text}")).expect_err(text);
        assert_eq!(errors.0.len(), 1, "{text}: {errors}");
        let shown = errors.to_string();
        assert_eq!(errors.0[0].place.line, Some(prefix.lines().count() + line), "{text}: {shown}");
        assert!(parts.iter().all(|part| shown.contains(part)), "{text}: {shown}");
    }
}

#[test]
fn faults_of_rows_name_line_and_reason() {
    assert_faults(
        "",
        &[
            ("Begin Nodes\n1 0.2x5 0 0\nEnd Nodes", 2, &["t.mdpa:2:3", "\"0.2x5\" is not a number"]),
            ("Begin Nodes\n1 0 nan 0\nEnd Nodes", 2, &["\"nan\" is not a finite number"]),
            ("Begin Nodes\n1 0 0 -inf\nEnd Nodes", 2, &["not a finite number"]),
            ("Begin Nodes\n1 0 0 1e999\nEnd Nodes", 2, &["beyond the range"]),
            ("Begin Nodes\n1 0 0\n2 0 0 0\nEnd Nodes", 2, &["node 1 has 2 coordinates"]),
            ("Begin Nodes\n1 0 0 0 0\nEnd Nodes", 2, &["one word too many"]),
            ("Begin Nodes\n0 0 0 0\nEnd Nodes", 2, &["ids begin with 1"]),
            ("Begin Nodes\n-1 0 0 0\nEnd Nodes", 2, &["-1 is negative"]),
            ("Begin Nodes\n4294967296 0 0 0\nEnd Nodes", 2, &["larger than 4294967295"]),
            ("Begin Nodes\n1.5 0 0 0\nEnd Nodes", 2, &["whole number"]),
            ("Begin Nodes\n1 0 0 0\n2 1 0 0\n1 0 0 1\nEnd Nodes", 4, &["node 1 stands twice", "on line 2"]),
            ("Begin Properties 1\nDENSITY\nEnd Properties", 2, &["a value is missing"]),
            ("Begin Properties 1\nDENSITY 1e3kg\nEnd Properties", 2, &["\"1e3kg\" is not a number"]),
            ("Begin Properties 1\nDENSITY nan\nEnd Properties", 2, &["not a finite number"]),
            ("Begin Properties 1\nF [3](1,2)\nEnd Properties", 2, &["announces 3 numbers, but there are 2"]),
            ("Begin Properties 1\nF 1 2\nEnd Properties", 2, &["one word too many"]),
            ("Begin Properties 1\nF 1\nF 2\nEnd Properties", 3, &["F stands twice"]),
            ("Begin Properties 1\n1 F\nEnd Properties", 2, &["not the name of a variable"]),
            ("Begin Properties 1\nF [2](1,x)\nEnd Properties", 2, &["\"x\" is not a number"]),
            ("Begin Table 1 X Y\n1 2\n1 3\nEnd Table", 1, &["1 stands twice"]),
            ("Begin Table 1 X Y\n1 2 3\nEnd Table", 2, &["one word too many"]),
            ("Begin Table 1 X Y\n1\nEnd Table", 2, &["second number is missing"]),
            ("Begin Table 1 X Y\nEnd Table", 1, &["at least one pair"]),
            ("Begin Table 1 X\n1 2\nEnd Table", 1, &["needs an id and two variables"]),
            ("Begin Table 1 X Y\n1 2\nEnd Table\nBegin Table 1 X Y\n1 2\nEnd Table", 4, &["table 1 stands twice"]),
        ],
    );
}

#[test]
fn faults_of_cells_name_line_and_reason() {
    let twice = "Begin Elements Element2D3N\n1 0 1 2 3\n1 0 1 2 4\nEnd Elements";
    assert_faults(
        HEAD,
        &[
            (
                "Begin Elements Element2D4M\n1 0 1 2 3 4\nEnd Elements",
                1,
                &["Element2D4M", "did you mean \"Element2D4N\"?"],
            ),
            ("Begin Conditions LineCondition\n1 0 1 2\nEnd Conditions", 1, &["is no condition", "LineCondition2D2N"]),
            ("Begin Geometries Triangle2D4\n1 1 2 3\nEnd Geometries", 1, &["did you mean \"Triangle2D3\"?"]),
            ("Begin Elements\nEnd Elements", 1, &["needs the name of its cells"]),
            ("Begin Elements Element2D4N\n1 0 1 2 3\nEnd Elements", 2, &["has 4 nodes, but its line holds 3"]),
            ("Begin Elements Element2D3N\n1 0 1 2 3 4\nEnd Elements", 2, &["has 3 nodes, but its line holds 4"]),
            (
                "Begin Elements Element2D4N\n1 0 1 2\n3 4\nEnd Elements",
                2,
                &["holds 2; it seems to go on on the next line"],
            ),
            ("Begin Elements Element2D3N\n1\nEnd Elements", 2, &["its line holds 0"]),
            ("Begin Elements Element2D3N\n1 0 1 2 77\nEnd Elements", 2, &["names the node 77", "ids from 1 to 4"]),
            (
                "Begin Elements Element2D3N\n1 5 1 2 3\n2 5 1 2 3\nEnd Elements",
                2,
                &["properties 5 of 2", "declared: 0"],
            ),
            (twice, 3, &["element 1 stands twice, first on line 10"]),
            ("Begin Elements Element2D3N\n0 0 1 2 3\nEnd Elements", 2, &["ids begin with 1"]),
            ("Begin NodalData T\n9 0 1.0\nEnd NodalData", 2, &["the id 9, which is missing"]),
            ("Begin NodalData T\n1 1.0\nEnd NodalData", 2, &["0 (free) or 1 (fixed)"]),
            ("Begin NodalData T\n1 0 1.0\n1 0 2.0\nEnd NodalData", 3, &["given twice for the id 1"]),
            ("Begin NodalData V\n1 1 [2](1,2)\nEnd NodalData", 2, &["only a number can be fixed"]),
            ("Begin NodalData SLIP\n1 0 1.0\nEnd NodalData", 2, &["one word too many"]),
        ],
    );
}

#[test]
fn faults_of_blocks_name_line_and_reason() {
    assert_faults(
        HEAD,
        &[
            ("Begin Node\n9 0 0 0\nEnd Node", 1, &["\"Node\" is unknown", "did you mean \"Nodes\"?"]),
            ("Begin Constraints X\n1 2\nEnd Constraints", 2, &["not supported unless empty"]),
            ("Begin Nodes\n9 0 0 0\n", 1, &["the file ends inside the block Nodes"]),
            ("Begin Nodes\n9 0 0 0\nBegin Properties 7\nEnd Properties", 3, &["`End Nodes` is missing"]),
            (
                "Begin Nodes\n9 0 0 0\nEnd Elements\nBegin Properties 7\nEnd Properties",
                3,
                &["does not close the block Nodes"],
            ),
            ("End Nodes", 1, &["closes no block"]),
            ("9 0 0 0", 1, &["outside of all blocks"]),
            ("Begin", 1, &["without the name"]),
            ("/* open", 1, &["never closed"]),
            (
                "Begin SubModelPart a\nBegin SubModelPartNodes\n99\nEnd SubModelPartNodes\nEnd SubModelPart",
                3,
                &["node 99"],
            ),
            (
                "Begin SubModelPart a\nBegin SubModelPartNods\nEnd SubModelPartNods\nEnd SubModelPart",
                2,
                &["SubModelPartNodes\"?"],
            ),
            ("Begin SubModelPart a\nEnd SubModelPart\nBegin SubModelPart a\nEnd SubModelPart", 3, &["stands twice"]),
            ("Begin SubModelPart a.b\nEnd SubModelPart", 1, &["holds a dot"]),
            ("Begin SubModelPart a\n3\nEnd SubModelPart", 2, &["outside of its blocks"]),
            (
                "Begin SubModelPart a\nBegin SubModelPartNodes\n3\nEnd SubModelPart",
                4,
                &["does not close the block SubModelPartNodes"],
            ),
            ("Begin SubModelPart a\nBegin Properties 4\nEnd Properties\n", 2, &["`End SubModelPart` is missing"]),
            (
                "Begin SubModelPart a\nBegin SubModelPartTables\n3\nEnd SubModelPartTables\nEnd SubModelPart",
                3,
                &["table 3"],
            ),
        ],
    );
}

#[test]
fn many_faults_are_shown_by_line_and_then_counted() {
    let rows: String = (0..30).map(|i| format!("{i}x 0 0 0\n")).collect();
    let errors = read_text(&format!("Begin Nodes\n{rows}End Nodes\n")).unwrap_err();
    assert_eq!(errors.0.len(), 21);
    assert!(errors.0[..20].iter().zip(2..).all(|(fault, line)| fault.place.line == Some(line)));
    assert_eq!(errors.0[20].to_string(), "t.mdpa: and 10 more errors");
}

#[test]
fn a_lost_row_does_not_raise_faults_elsewhere() {
    let text = "Begin Nodes\nx 0 0 0\nEnd Nodes\nBegin SubModelPart a\nBegin SubModelPartNodes\n1\nEnd SubModelPartNodes\nEnd SubModelPart\n";
    assert_eq!(read_text(text).unwrap_err().0.len(), 1);
}

#[test]
fn deep_nesting_is_refused() {
    for block in ["SubModelPart a\n", "Foo\n"] {
        let text = format!("Begin {block}").repeat(100_000);
        assert!(read_text(&text).is_err());
    }
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("beam_Grid.mdpa"), VALID).unwrap();
    std::fs::write(folder.path().join("bad.mdpa"), b"Begin Nodes\n1 0 0 0 // \xe9\n").unwrap();
    assert!(read(&folder.path().join("beam_Grid.mdpa"), "Grid", &Names).is_ok());
    let missing = read(&folder.path().join("bean_Grid.mdpa"), "Grid", &Names).unwrap_err().to_string();
    assert!(missing.contains("did you mean \"beam_Grid.mdpa\"?"), "{missing}");
    let bytes = read(&folder.path().join("bad.mdpa"), "Grid", &Names).unwrap_err();
    assert_eq!(bytes.0[0].place.line, Some(2));
    assert!(bytes.to_string().contains("0xe9 is not UTF-8"), "{bytes}");
    let nowhere = read(&folder.path().join("no/such.mdpa"), "Grid", &Names).unwrap_err().to_string();
    assert!(nowhere.contains("cannot be read either"), "{nowhere}");
}

/// A small generator of random numbers (xorshift64*), seeded.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % limit
    }
}

#[test]
fn mutations_never_panic_and_bad_texts_say_where() {
    let pieces =
        ["Begin ", "End ", "\n", "/*", "//", "[3](", ")", "SubModelPart ", "Nodes", "-", "0", "9e999", "é", "\u{0}"];
    let mut random = Random(20_261_122);
    let (mut good, mut bad) = (0, 0);
    for _ in 0..2_000 {
        let mut bytes = VALID.as_bytes().to_vec();
        for _ in 0..=random.below(3) {
            let (at, length) = (random.below(bytes.len()), random.below(40));
            match random.below(5) {
                0 => bytes[at] = random.below(256) as u8,
                1 => drop(bytes.drain(at..(at + length).min(VALID.len()).min(bytes.len()).max(at))),
                2 => bytes.truncate(at.max(1)),
                3 => drop(bytes.splice(at..at, pieces[random.below(pieces.len())].bytes())),
                _ => {
                    let copy = bytes[at..(at + length).min(bytes.len())].to_vec();
                    let target = random.below(bytes.len());
                    drop(bytes.splice(target..target, copy));
                }
            }
        }
        match read_text(&String::from_utf8_lossy(&bytes)) {
            Ok(_) => good += 1,
            Err(errors) => {
                bad += 1;
                assert!(!errors.0.is_empty() && errors.0.len() <= 21);
                assert!(errors.0.iter().take(20).all(|fault| fault.place.line.is_some() && !fault.message.is_empty()));
            }
        }
    }
    assert!(good > 50 && bad > 1_000, "{good} good, {bad} bad: the mutations are too weak or too strong");
}

/// Names by their ending, for files of any application.
struct ByEnding;

impl CellNames for ByEnding {
    fn shape(&self, category: Category, name: &str) -> Option<Shape> {
        let shapes = match category {
            Category::Element => &ELEMENTS[..4],
            _ => &[
                ("3D4N", Shape::Quadrilateral4),
                ("1N", Shape::Point1),
                ("2N", Shape::Line2),
                ("3N", Shape::Triangle3),
            ],
        };
        let ending = |known: &str| name.ends_with(known.trim_start_matches("Element"));
        shapes.iter().find(|(known, _)| ending(known)).map(|(_, shape)| *shape)
    }

    fn names(&self, _: Category) -> Vec<String> {
        Vec::new()
    }
}

/// Runs only where the folder of Kratos's cases is at hand (`BIA_KRATOS_CASES`).
#[test]
fn kratos_files_parse() {
    let folder = std::env::var("BIA_KRATOS_CASES")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/kratos_cases/cases").into());
    let Ok(cases) = std::fs::read_dir(&folder) else { return };
    let (mut files, mut bytes, mut seconds) = (0, 0, 0.0);
    for entry in cases.flatten().flat_map(|case| std::fs::read_dir(case.path()).into_iter().flatten().flatten()) {
        let path = entry.path();
        let name = path.to_string_lossy().into_owned();
        let mut text = String::new();
        if name.ends_with(".mdpa.gz") {
            let file = std::fs::File::open(&path).unwrap();
            flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap();
        } else if name.ends_with(".mdpa") {
            text = std::fs::read_to_string(&path).unwrap();
        } else {
            continue;
        }
        let start = std::time::Instant::now();
        let part = parse(&text, &path, "Grid", &ByEnding).unwrap_or_else(|errors| panic!("{errors}"));
        seconds += start.elapsed().as_secs_f64();
        assert!(!part.nodes.is_empty() && !part.elements.is_empty(), "{name}");
        (files, bytes) = (files + 1, bytes + text.len());
    }
    let rate = bytes as f64 / 1e6 / seconds;
    println!("{files} files, {:.1} MB, {rate:.0} MB/s", bytes as f64 / 1e6);
    assert!(files > 0, "{folder} holds no .mdpa file");
}
