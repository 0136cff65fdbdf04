use super::super::dataset::tests::{integer, mixed_mesh, real};
use super::*;
use std::path::PathBuf;
use vtkio::model::{Attribute, DataSet, UnstructuredGridPiece, VertexNumbers};

fn write(folder: &Path, data: &Dataset, encoding: Encoding) -> PathBuf {
    let path = folder.join("data.vtk");
    let bytes = write_legacy(&path, data, encoding).unwrap();
    assert_eq!(bytes, std::fs::metadata(&path).unwrap().len());
    path
}

fn text(data: &Dataset, precision: usize) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::read_to_string(write(folder.path(), data, Encoding::Ascii { precision })).unwrap()
}

/// Reads a file with `vtkio`, an independent reader.
fn read_back(path: &Path) -> UnstructuredGridPiece {
    let vtk = vtkio::Vtk::import(path).unwrap();
    let DataSet::UnstructuredGrid { pieces, .. } = vtk.data else { panic!("no unstructured grid") };
    pieces.into_iter().next().unwrap().into_loaded_piece_data(None).unwrap()
}

/// Name, components and values of all fields of one section.
fn fields(attributes: Vec<Attribute>) -> Vec<(String, usize, Vec<f64>)> {
    let arrays = attributes.into_iter().flat_map(|attribute| match attribute {
        Attribute::Field { data_array, .. } => data_array,
        Attribute::DataArray(array) => panic!("unexpected attribute {}", array.name),
    });
    arrays.map(|array| (array.name, array.elem as usize, array.data.cast_into().unwrap())).collect()
}

fn expected(fields: &[Field]) -> Vec<(String, usize, Vec<f64>)> {
    let numbers = |values: &FieldData| match values {
        FieldData::F64(values) => values.clone(),
        FieldData::I32(values) => values.iter().map(|&value| value.into()).collect(),
    };
    fields.iter().map(|f| (f.name.clone(), f.components, numbers(&f.values))).collect()
}

/// Layout as Kratos 10 writes material points: `float` after two blanks, blanks at the end of vector rows only,
/// an empty line before `CELLS` and `CELL_TYPES`, no `POINT_DATA`.
#[test]
fn material_points_have_kratos_layout() {
    let mut data = Dataset::vertices(vec![[0.25, -1.5, 0.0], [1e-5, 2.0, 0.0]]);
    data.cell_fields = vec![
        real("MP_VELOCITY", 3, vec![0.0, -9.81, 0.0, 1234.5678, 0.1, 1e-40]),
        real("MP_MASS", 1, vec![15.625, f64::NAN]),
        integer("PROPERTIES_ID", vec![1, 20]),
    ];
    // A middle dot stands for a blank at the end of a line.
    let layout = "\
# vtk DataFile Version 4.0
vtk output
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 2 float
2.5000000e-01 -1.5000000e+00 0.0000000e+00·
1.0000000e-05 2.0000000e+00 0.0000000e+00·

CELLS 2 4
1 0
1 1

CELL_TYPES 2
1
1
CELL_DATA 2
FIELD FieldData 3
MP_VELOCITY 3 2  float
0.0000000e+00 -9.8100000e+00 0.0000000e+00·
1.2345678e+03 1.0000000e-01 0.0000000e+00·
MP_MASS 1 2  float
1.5625000e+01
nan
PROPERTIES_ID 1 2  int
1
20
";
    assert_eq!(text(&data, 7), layout.replace('·', " "));
}

#[test]
fn meshes_have_kratos_layout() {
    let data = Dataset {
        points: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]],
        cells: CellsOf::Mesh { starts: vec![0, 3, 5], nodes: vec![0, 1, 2, 1, 3], types: vec![5, 3] },
        point_fields: vec![real("DISPLACEMENT", 2, vec![0.0; 8])],
        cell_fields: Vec::new(),
    };
    let after_points = "
CELLS 2 7
3 0 1 2
2 1 3

CELL_TYPES 2
5
3
POINT_DATA 4
FIELD FieldData 1
DISPLACEMENT 2 4  float
0.0e+00 0.0e+00·
0.0e+00 0.0e+00·
0.0e+00 0.0e+00·
0.0e+00 0.0e+00·
CELL_DATA 2
FIELD FieldData 0
";
    let text = text(&data, 1);
    let (head, tail) = text.split_once("2.0e+00 0.0e+00 0.0e+00 \n").unwrap();
    assert!(
        head.ends_with(
            "POINTS 4 float\n0.0e+00 0.0e+00 0.0e+00 \n1.0e+00 0.0e+00 0.0e+00 \n0.0e+00 1.0e+00 0.0e+00 \n"
        )
    );
    assert_eq!(tail, after_points.replace('·', " "));
}

/// Kratos writes a part without cells (the nodes of a boundary) with neither `CELLS` nor `CELL_DATA`.
#[test]
fn nodes_without_cells_have_kratos_layout() {
    let mut data = Dataset::vertices(vec![[0.0; 3]]);
    data.cells = CellsOf::Mesh { starts: Vec::new(), nodes: Vec::new(), types: Vec::new() };
    let written = text(&data, 0);
    assert!(written.ends_with("POINTS 1 float\n0e+00 0e+00 0e+00 \nPOINT_DATA 1\nFIELD FieldData 0\n"), "{written}");
    assert!(text(&Dataset::vertices(Vec::new()), 7).ends_with("UNSTRUCTURED_GRID\nPOINTS 0 float\n"));
}

/// Sections of a binary file stand where Kratos puts them: a new line before `CELLS` and `CELL_TYPES`, none elsewhere.
#[test]
fn binary_files_are_big_endian_and_have_kratos_layout() {
    let mut data = Dataset::vertices(vec![[1.0, -2.0, 0.5]]);
    data.cell_fields = vec![integer("ID", vec![258]), real("MASS", 1, vec![0.25])];
    let folder = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(write(folder.path(), &data, Encoding::Binary)).unwrap();
    let expected: [&[u8]; 12] = [
        b"# vtk DataFile Version 4.0\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n",
        &[0x3f, 0x80, 0, 0, 0xc0, 0, 0, 0, 0x3f, 0, 0, 0],
        b"\nCELLS 1 2\n",
        &[0, 0, 0, 1, 0, 0, 0, 0],
        b"\nCELL_TYPES 1\n",
        &[0, 0, 0, 1],
        b"CELL_DATA 1\nFIELD FieldData 2\n",
        b"ID 1 1  int\n",
        &[0, 0, 1, 2],
        b"MASS 1 1  float\n",
        &[0x3e, 0x80, 0, 0],
        b"",
    ];
    assert_eq!(bytes, expected.concat());
}

#[test]
fn vtkio_reads_every_value_back() {
    let folder = tempfile::tempdir().unwrap();
    let data = mixed_mesh();
    for encoding in [Encoding::Ascii { precision: 7 }, Encoding::Binary] {
        let piece = read_back(&write(folder.path(), &data, encoding));
        let points: Vec<f64> = piece.points.cast_into().unwrap();
        assert_eq!(points, data.points.as_flattened());
        let types: Vec<u8> = piece.cells.types.iter().map(|&kind| kind as u8).collect();
        assert_eq!(types, [9, 5, 3]);
        let VertexNumbers::Legacy { vertices, .. } = piece.cells.cell_verts else { panic!("legacy cells") };
        assert_eq!(vertices, [4, 0, 1, 4, 3, 3, 1, 2, 4, 2, 4, 5]);
        assert_eq!(fields(piece.data.point), expected(&data.point_fields));
        assert_eq!(fields(piece.data.cell), expected(&data.cell_fields));
    }
}

/// More than one portion of the buffer, and values that are not exact in `f32`.
#[test]
fn long_files_lose_no_more_than_single_precision() {
    let folder = tempfile::tempdir().unwrap();
    let value = |i: usize| (i as f64 * 0.7).sin() * 10f64.powi((i % 61) as i32 - 30);
    let mut data = Dataset::vertices((0..20_001).map(|i| [value(i), value(i + 1), value(i + 2)]).collect());
    data.cell_fields = vec![real("VALUE", 1, (0..20_001).map(value).collect())];
    for encoding in [Encoding::Ascii { precision: 8 }, Encoding::Binary] {
        let piece = read_back(&write(folder.path(), &data, encoding));
        let points: Vec<f32> = piece.points.cast_into().unwrap();
        // Nine digits are enough to name any f32.
        assert!(points.iter().zip(data.points.as_flattened()).all(|(&read, &written)| {
            (f64::from(read) - written).abs() <= written.abs() * f64::from(f32::EPSILON) / 2.0 * 1.1
        }));
        let (_, _, values) = fields(piece.data.cell).remove(0);
        assert!((0..20_001).all(|i| (values[i] - value(i)).abs() <= value(i).abs() * 1e-7));
    }
}

#[test]
fn names_become_one_word_and_faults_leave_no_file() {
    assert_eq!(one_word("MP_PRESSURE"), "MP_PRESSURE");
    assert_eq!(one_word("a b%\"é"), "a%20b%25%22%C3%A9");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.vtk");
    let mut data = mixed_mesh();
    data.point_fields[0].components = 2;
    let error = write_legacy(&path, &data, Encoding::Binary).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    assert!(error.to_string().contains("TEMPERATURE"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
