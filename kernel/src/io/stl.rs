//! Reader of triangulated surfaces (`.stl`), as text or binary.
//!
//! Text: `solid NAME`, then for each triangle `facet normal x y z`, `outer loop`, three times `vertex x y z`,
//! `endloop`, `endfacet`, and at last `endsolid`. Binary: 80 bytes of header, the number of triangles (u32), and
//! for each its normal and corners (f32) with two bytes more, little-endian. Normals are not used: the order of
//! the corners says the same and is never out of date.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use std::path::Path;

/// Corners of a triangle.
pub type Triangle = [[f64; 3]; 3];

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Reads the triangles of a file.
///
/// # Errors
/// A file that cannot be read, is cut off, or holds what is no number.
pub fn read(path: &Path) -> Result<Vec<Triangle>, InputErrors> {
    let bytes = std::fs::read(path).map_err(|error| {
        InputErrors::from(Diagnostic::error(Place::file(path), format!("the surface cannot be read: {error}")))
    })?;
    parse(&bytes, path)
}

/// Reads the bytes of a file; `path` only serves messages.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Vec<Triangle>, InputErrors> {
    let count = bytes.get(80..HEADER).map(|count| count.iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte)));
    // Headers of binary files may begin with "solid" too; only their length tells.
    match count {
        Some(count) if count.checked_mul(RECORD).and_then(|n| n.checked_add(HEADER)) == Some(bytes.len()) => {
            binary(&bytes[HEADER..], path)
        }
        _ if bytes.trim_ascii_start().starts_with(b"solid") => text(bytes, path),
        Some(count) => {
            let found = bytes.len() - HEADER;
            let message = format!("the file announces {count} triangles of {RECORD} bytes, but {found} bytes follow");
            Err(Diagnostic::error(Place::file(path), message).help("it is cut off, or no STL file").into())
        }
        None => Err(Diagnostic::error(Place::file(path), "the file is too short for an STL file").into()),
    }
}

fn binary(records: &[u8], path: &Path) -> Result<Vec<Triangle>, InputErrors> {
    let mut triangles = Vec::with_capacity(records.len() / RECORD);
    for (index, record) in records.chunks_exact(RECORD).enumerate() {
        let number = |i: usize| {
            let at = 12 + 4 * i;
            f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
        };
        let triangle: Triangle = std::array::from_fn(|corner| std::array::from_fn(|axis| number(3 * corner + axis)));
        if triangle.as_flattened().iter().any(|x| !x.is_finite()) {
            let message = format!("the triangle {} has a corner that is no number", index + 1);
            return Err(Diagnostic::error(Place::file(path), message).into());
        }
        triangles.push(triangle);
    }
    Ok(triangles)
}

fn text(bytes: &[u8], path: &Path) -> Result<Vec<Triangle>, InputErrors> {
    let text = std::str::from_utf8(bytes).map_err(|_| {
        Diagnostic::error(Place::file(path), "the file is neither UTF-8 text nor a whole binary STL file")
    })?;
    let (mut triangles, mut corners, mut closed) = (Vec::new(), Vec::new(), false);
    for (line, content) in text.lines().enumerate() {
        let fault = |message: String| InputErrors::from(Diagnostic::error(Place::line(path, line + 1), message));
        let mut words = content.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let numbers: Vec<f64> =
                    words.map_while(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
                let [x, y, z] = numbers[..] else {
                    return Err(fault(format!("{:?} is not: vertex x y z", content.trim())));
                };
                corners.push([x, y, z]);
            }
            Some("endloop" | "endfacet") => {
                match corners[..] {
                    [a, b, c] => triangles.push([a, b, c]),
                    [] if content.contains("endfacet") => {}
                    _ => return Err(fault(format!("a facet has {} corners, must have 3", corners.len()))),
                }
                corners.clear();
            }
            Some("endsolid") => closed = true,
            // A file may hold several solids one after the other.
            Some("solid") => closed = false,
            Some("facet" | "outer") | None => {}
            Some(other) => return Err(fault(format!("{other:?} is no word of an STL file"))),
        }
    }
    if !closed {
        return Err(Diagnostic::error(Place::file(path), "the file is cut off: it ends without endsolid").into());
    }
    Ok(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1.5 -2e0\n  \
                        endloop\n endfacet\nendsolid a b\n";
    const TRIANGLE: Triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.5, -2.0]];

    fn read_text(text: &str) -> Result<Vec<Triangle>, InputErrors> {
        parse(text.as_bytes(), Path::new("a.stl"))
    }

    fn read_binary(header: &[u8], triangles: &[Triangle]) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes[..header.len()].copy_from_slice(header);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|&x| (x as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_say_the_same() {
        assert_eq!(read_text(TEXT).unwrap(), [TRIANGLE]);
        for header in [&b"solid but binary"[..], b"any"] {
            let bytes = read_binary(header, &[TRIANGLE, TRIANGLE]);
            assert_eq!(parse(&bytes, Path::new("a.stl")).unwrap(), [TRIANGLE, TRIANGLE]);
            for cut in 0..bytes.len() {
                assert!(parse(&bytes[..cut], Path::new("a.stl")).is_err(), "{cut}");
            }
        }
    }

    #[test]
    fn faults_are_told_with_their_line() {
        for (from, to, part) in [
            ("vertex 1 0 0", "vertex 1 0", "a.stl:5"),
            ("vertex 1 0 0", "vertex 1 nan 0", "a.stl:5"),
            ("   vertex 1 0 0\n", "", "2 corners"),
            ("endsolid", "", "no word"),
            ("endsolid a b\n", "", "without endsolid"),
        ] {
            let errors = read_text(&TEXT.replace(from, to)).unwrap_err();
            assert!(errors.to_string().contains(part), "{errors}");
        }
        let nan = read_binary(b"", &[[[0.0; 3], [f64::NAN; 3], [1.0; 3]]]);
        assert!(parse(&nan, Path::new("a.stl")).unwrap_err().to_string().contains("triangle 1"));
    }
}
