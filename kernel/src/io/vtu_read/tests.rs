use super::*;
use crate::io::dataset::tests::mixed_mesh;
use crate::io::vtu::{VtuEncoding, VtuOptions, write_vtu};

fn bytes(options: &VtuOptions) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.vtu");
    write_vtu(&path, &mixed_mesh(), Some(1.5), options).unwrap();
    std::fs::read(path).unwrap()
}

fn forms() -> impl Iterator<Item = VtuOptions> {
    let encodings = [VtuEncoding::RawAppended, VtuEncoding::Base64Appended, VtuEncoding::Ascii];
    encodings.into_iter().flat_map(|encoding| {
        [(true, false), (false, false), (true, true)].map(|(compress, single_precision)| VtuOptions {
            encoding,
            compress,
            single_precision,
        })
    })
}

fn parse(bytes: &[u8]) -> Result<Dataset, InputErrors> {
    parse_vtu(bytes, Path::new("mesh.vtu"))
}

#[test]
fn every_form_that_is_written_is_read() {
    for form in forms() {
        assert_eq!(parse(&bytes(&form)).unwrap(), mixed_mesh(), "{form:?}");
    }
}

/// Inline base64, 32-bit headers and other byte orders are VTK's and meshio's, not ours: by hand.
#[test]
fn forms_of_others_are_read() {
    let file = |order: &str, points: &str| {
        format!(
            "<?xml version='1.0'?><!-- a > b --><VTKFile type='UnstructuredGrid' byte_order='{order}'>\
             <UnstructuredGrid><FieldData><DataArray type='Float64' Name='TimeValue' format='ascii'>1</DataArray>\
             </FieldData><Piece NumberOfPoints='1' NumberOfCells='1'><Points>\
             <DataArray type='Float32' NumberOfComponents='3' format='binary'>{points}</DataArray></Points><Cells>\
             <DataArray type='Int64' Name='connectivity' format='ascii'> 0 </DataArray>\
             <DataArray type='Int64' Name='offsets' format='ascii'> 1 </DataArray>\
             <DataArray type='UInt8' Name='types' format='ascii'>1</DataArray></Cells>\
             </Piece></UnstructuredGrid></VTKFile>"
        )
    };
    // 12 as u32, then 1, 2 and −0.5 as f32.
    for (order, points) in [("LittleEndian", "DAAAAAAAgD8AAABAAAAAvw=="), ("BigEndian", "AAAADD+AAABAAAAAvwAAAA==")] {
        let data = parse(file(order, points).as_bytes()).unwrap();
        assert_eq!(data.points, [[1.0, 2.0, -0.5]]);
    }
    for (points, part) in [("DAAAAAAAgD8AAABAAAAAv", "base64"), ("DAAAAAAAgD8AAABA", "announces 12 bytes, and 8")] {
        let errors = parse(file("LittleEndian", points).as_bytes()).unwrap_err();
        assert!(errors.to_string().contains(part), "{errors}");
    }
}

/// Whatever is cut off or changed ends in a data set that is sound, or an error.
#[test]
fn damage_is_an_error_and_never_a_panic() {
    let mut seed = 1u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % below
    };
    for form in forms() {
        let whole = bytes(&form);
        for length in 0..whole.len() {
            if let Ok(data) = parse(&whole[..length]) {
                assert_eq!(data, mixed_mesh(), "{length} of {}", whole.len());
            }
        }
        for _ in 0..500 {
            let mut changed = whole.clone();
            for _ in 0..1 + random(3) {
                let at = random(changed.len());
                changed[at] = random(256) as u8;
            }
            if let Ok(data) = parse(&changed) {
                assert_eq!(data.check(), Ok(()));
            }
        }
    }
}

#[test]
fn what_is_not_read_is_told() {
    let text = String::from_utf8(bytes(&VtuOptions { encoding: VtuEncoding::Ascii, ..VtuOptions::default() })).unwrap();
    for (from, to, part) in [
        ("\"UnstructuredGrid\"", "\"PolyData\"", "not an unstructured grid"),
        ("header_type=\"UInt64\"", "header_type=\"UInt64\" compressor=\"vtkLZ4DataCompressor\"", "zlib"),
        ("Name=\"offsets\"", "Name=\"ends\"", "no array \"offsets\""),
        ("Float64\" Name=\"Points", "Bit\" Name=\"Points", "type \"Bit\""),
        ("NumberOfPoints=\"6\"", "NumberOfPoints=\"7\"", "are needed"),
        ("NumberOfPoints=\"6\"", "NumberOfPoints=\"x\"", "no count"),
    ] {
        assert!(text.contains(from), "{from}");
        let errors = parse(text.replacen(from, to, 1).as_bytes()).unwrap_err();
        assert!(errors.to_string().contains(part), "{errors}");
    }
}
