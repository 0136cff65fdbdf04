use super::*;
use crate::geometry::Shape;
use crate::io::mdpa::{Category, CellNames};
use std::path::PathBuf;

/// Names of two elements and a condition.
struct Kinds;

impl CellNames for Kinds {
    fn shape(&self, category: Category, name: &str) -> Option<Shape> {
        match (category, name) {
            (Category::Element, "Element2D3N") => Some(Shape::Triangle3),
            (Category::Element, "Element2D4N") => Some(Shape::Quadrilateral4),
            (Category::Condition, "LineCondition2D2N") => Some(Shape::Line2),
            _ => None,
        }
    }

    fn names(&self, _: Category) -> Vec<String> {
        Vec::new()
    }
}

/// Ids with gaps, two kinds of elements, conditions, geometries, nested parts, properties, tables, data.
const MESH: &str = "
Begin Properties 0
End Properties
Begin Properties 1
  DENSITY 1.0e3
  CONSTITUTIVE_LAW SomeLaw
  VECTOR [3](1,2,3.5)
  MATRIX [2,2]((1,2),(3,4))
  FLAG true
  Begin Table TEMPERATURE YOUNG_MODULUS
    0 1e9
    100 0.1
  End Table
End Properties
Begin Table 7 TIME VALUE
  0 0
  0.1 3
End Table
Begin Nodes
  1 0 0 0
  2 1 0 0
  4 1 1 0
  8 0 1e-7 0
  9 0.3333333333333333 2 0
  12 5 5 0
End Nodes
Begin Elements Element2D3N
  3 1 1 2 4
End Elements
Begin Elements Element2D4N
  5 1 1 4 9 8
End Elements
Begin Conditions LineCondition2D2N
  2 0 1 2
End Conditions
Begin Geometries Line2D2
  6 2 4
End Geometries
Begin NodalData PRESSURE
  1 0 0.5
  2 0 1
  4 0 2
  8 0 3
  9 0 -4
  12 0 0
End NodalData
Begin NodalData DISPLACEMENT_X
  1 1 0.25
End NodalData
Begin ElementalData HEAT
  3 7.5
End ElementalData
Begin SubModelPart Body
  Begin SubModelPartNodes
    1 2 4 8 9
  End SubModelPartNodes
  Begin SubModelPartElements
    3 5
  End SubModelPartElements
  Begin SubModelPart Floor
    Begin SubModelPartNodes
      1
      2
    End SubModelPartNodes
    Begin SubModelPartConditions
      2
    End SubModelPartConditions
  End SubModelPart
End SubModelPart
Begin SubModelPart Lone
  Begin SubModelPartTables
    7
  End SubModelPartTables
  Begin SubModelPartNodes
    12
  End SubModelPartNodes
End SubModelPart
";

fn example() -> ModelPart {
    mdpa::parse(MESH, Path::new("mesh.mdpa"), "Mesh", &Kinds).unwrap()
}

/// Writes to a file of this name and reads it back.
fn back(part: &ModelPart, name: &str, options: &Options) -> (ModelPart, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let written = write(part, &path, options).unwrap();
    assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len());
    (read(&path, &Kinds, options).unwrap(), written.losses)
}

#[test]
fn mdpa_loses_nothing() {
    let (read, losses) = back(&example(), "mesh.mdpa", &Options::default());
    assert_eq!(read, example());
    assert!(losses.is_empty());
}

#[test]
fn vtu_keeps_all_but_constants_tables_and_partial_data() {
    let (read, losses) = back(&example(), "mesh.vtu", &Options::default());
    let mut kept = example();
    kept.tables.clear();
    kept.children[1].tables.clear();
    kept.elemental_data.clear();
    kept.nodal_data.remove("DISPLACEMENT_X");
    kept.properties = read.properties.clone();
    assert_eq!(read.properties.keys().collect::<Vec<_>>(), [&0, &1]);
    assert_eq!(read, kept);
    for word in ["constants", "1 tables", "DISPLACEMENT_X", "HEAT"] {
        assert!(losses.iter().any(|loss| loss.contains(word)), "{word}: {losses:?}");
    }
    assert_eq!(losses.len(), 4);
}

/// Single precision changes the coordinates only.
#[test]
fn vtu_in_single_precision() {
    let (read, _) = back(&example(), "mesh.vtu", &Options { single_precision: true, ..Options::default() });
    assert_eq!(read.nodes.coordinates[4][0], f64::from(0.333_333_34_f32));
    assert_eq!(read.elements, example().elements);
}

#[test]
fn msh_keeps_cells_and_groups() {
    let whole = example();
    let (older, newer) = (gmsh::Version::V2, gmsh::Version::V4);
    for (version, binary) in [(older, false), (older, true), (newer, false), (newer, true)] {
        let options = Options { msh: version, msh_binary: binary, ..Options::default() };
        let (read, losses) = back(&whole, "mesh.msh", &options);
        assert_eq!(read.nodes, whole.nodes, "{version:?}");
        assert_eq!(read.elements.ids, whole.elements.ids);
        assert_eq!(read.elements.nodes, whole.elements.nodes);
        assert_eq!(read.elements.names, whole.elements.names);
        assert_eq!(read.find("Body").unwrap().elements, [0, 1]);
        assert_eq!(read.find("Body").unwrap().nodes, [0, 1, 2, 3, 4]);
        let floor = read.find("Body_Floor").unwrap();
        assert_eq!((&floor.nodes[..], floor.geometries.len()), (&[0, 1][..], 1));
        assert_eq!(read.geometries.nodes_of(floor.geometries[0] as usize), [0, 1]);
        assert_eq!(read.find("Lone").unwrap().nodes, [5]);
        for word in
            ["1 conditions", "properties", "tables", "PRESSURE", "HEAT", "\"Floor\" is the group \"Body_Floor\""]
        {
            assert!(losses.iter().any(|loss| loss.contains(word)), "{word}: {losses:?}");
        }
    }
}

/// Files of Gmsh, through each format and back: groups, counts and places are the same.
#[test]
fn meshes_of_gmsh_go_around() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/gmsh");
    for name in ["plate", "block", "bricks"] {
        let first = gmsh::read(&folder.join(format!("{name}_4.1_binary.msh")), "Mesh", "Element").unwrap();
        let (older, newer) = (gmsh::Version::V2, gmsh::Version::V4);
        for (through, version, binary) in [
            ("a.msh", older, false),
            ("a.msh", older, true),
            ("a.msh", newer, false),
            ("a.msh", newer, true),
            ("a.vtu", newer, false),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path: PathBuf = folder.path().join(through);
            let options = Options { msh: version, msh_binary: binary, ..Options::default() };
            write(&first, &path, &options).unwrap();
            // Elements of solids are named, which the names of the tests above do not know.
            let read = match Format::of(&path).unwrap() {
                Format::Vtu => {
                    let mut data = vtu_read::read_vtu(&path).unwrap();
                    data.cell_fields.retain(|field| !field.name.starts_with("Element "));
                    vtu_mesh::model_part(data, "Element", &Kinds, &path).unwrap()
                }
                _ => gmsh::read(&path, "Mesh", "Element").unwrap(),
            };
            assert_eq!((&read.nodes, &read.elements.nodes), (&first.nodes, &first.elements.nodes), "{name} {through}");
            assert_eq!(read.paths(), first.paths());
            for path in first.paths() {
                let (a, b) = (read.find(&path).unwrap(), first.find(&path).unwrap());
                assert_eq!((&a.nodes, &a.elements), (&b.nodes, &b.elements), "{path}");
                assert_eq!(a.geometries.len(), b.geometries.len());
            }
        }
    }
}

#[test]
fn formats_are_told_by_the_end_of_the_name() {
    for (name, format) in [("a.b.msh", Format::Gmsh), ("x/y.mdpa", Format::Mdpa), ("z.vtu", Format::Vtu)] {
        assert_eq!(Format::of(Path::new(name)), Ok(format));
    }
    let errors = Format::of(Path::new("a.mdap")).unwrap_err();
    assert!(errors.to_string().contains("did you mean \"mdpa\""), "{errors}");
    assert!(Format::of(Path::new("mesh")).is_err());
}
