//! What a result file holds, whatever its format: points, cells and named fields, without physics.

use std::io;

/// Values of a field, point by point (or cell by cell): entry `i * components + c`.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldData {
    /// Real numbers.
    F64(Vec<f64>),
    /// Integers: ids, flags, materials.
    I32(Vec<i32>),
}

impl FieldData {
    /// Number of values, over all points and components.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::I32(values) => values.len(),
        }
    }

    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A named field on the points or on the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Name shown by the viewer, such as `MP_VELOCITY`.
    pub name: String,
    /// Values per point or cell, at least 1.
    pub components: usize,
    /// The values, in the units of the quantity.
    pub values: FieldData,
}

/// Cells of a [`Dataset`].
#[derive(Debug, Clone, PartialEq)]
pub enum CellsOf {
    /// One vertex cell for each point: the form of material points.
    Vertices,
    /// Cells of a mesh.
    Mesh {
        /// Start of each cell's node list in `nodes`; one more entry than cells (empty: no cells).
        starts: Vec<u32>,
        /// Indices of points, cell by cell, in VTK's order of a cell's nodes.
        nodes: Vec<u32>,
        /// VTK's number of each cell's type, such as 5 (triangle), 9 (quadrilateral), 10 (tetrahedron).
        types: Vec<u8>,
    },
}

/// VTK's number of the cell type "vertex".
pub(super) const VTK_VERTEX: u8 = 1;

/// Points, cells and fields of one output file.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Coordinates in metres; the third is 0 in the plane.
    pub points: Vec<[f64; 3]>,
    /// The cells.
    pub cells: CellsOf,
    /// Fields with one entry for each point.
    pub point_fields: Vec<Field>,
    /// Fields with one entry for each cell.
    pub cell_fields: Vec<Field>,
}

/// Why a [`Dataset`] cannot be written. Writers return it inside an [`io::Error`] of kind `InvalidInput`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DatasetError {
    /// The number of values is not components × entities.
    #[error("field {name:?} holds {found} values where {components} x {entities} {on} are needed")]
    FieldLength {
        /// Name of the field.
        name: String,
        /// Number of its values.
        found: usize,
        /// Its components.
        components: usize,
        /// Number of points or cells.
        entities: usize,
        /// `points` or `cells`.
        on: &'static str,
    },
    /// A field without name or without components.
    #[error("field {0:?} needs a name and at least one component")]
    FieldShape(String),
    /// Two fields of one name on the same entities: a reader would show only one of them.
    #[error("field {0:?} is given twice")]
    FieldTwice(String),
    /// `starts`, `nodes` and `types` do not belong together.
    #[error("the cells' starts do not ascend from 0 to the number of node indices, one step for each type")]
    CellLists,
    /// A cell names a point that is not there.
    #[error("a cell names point {node}, but there are {points} points")]
    NodeIndex {
        /// Index found.
        node: u32,
        /// Number of points.
        points: usize,
    },
    /// More than the formats' 32-bit indices can count.
    #[error("{0} indices are more than one file can hold ({max})", max = i32::MAX)]
    TooMany(usize),
}

impl From<DatasetError> for io::Error {
    fn from(error: DatasetError) -> Self {
        io::Error::new(io::ErrorKind::InvalidInput, error)
    }
}

impl Dataset {
    /// Points as vertex cells, without fields.
    pub fn vertices(points: Vec<[f64; 3]>) -> Self {
        Self { points, cells: CellsOf::Vertices, point_fields: Vec::new(), cell_fields: Vec::new() }
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        match &self.cells {
            CellsOf::Vertices => self.points.len(),
            CellsOf::Mesh { types, .. } => types.len(),
        }
    }

    /// The same with all real numbers rounded to single precision.
    #[must_use]
    pub fn in_single_precision(mut self) -> Self {
        let round = |value: &mut f64| *value = f64::from(*value as f32);
        self.points.as_flattened_mut().iter_mut().for_each(round);
        for field in self.point_fields.iter_mut().chain(&mut self.cell_fields) {
            if let FieldData::F64(values) = &mut field.values {
                values.iter_mut().for_each(round);
            }
        }
        self
    }

    /// Checks that all lists belong together, so that what is written can be read.
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(&self) -> Result<(), DatasetError> {
        let mut indices = self.points.len();
        if let CellsOf::Mesh { starts, nodes, types } = &self.cells {
            check_mesh(starts, nodes, types, self.points.len())?;
            indices = indices.max(nodes.len() + types.len());
        } else {
            indices *= 2; // the legacy format counts a vertex cell as two numbers
        }
        if i32::try_from(indices).is_err() {
            return Err(DatasetError::TooMany(indices));
        }
        check_fields(&self.point_fields, self.points.len(), "points")?;
        check_fields(&self.cell_fields, self.cell_count(), "cells")
    }
}

fn check_mesh(starts: &[u32], nodes: &[u32], types: &[u8], points: usize) -> Result<(), DatasetError> {
    let fits = match (starts.first(), starts.last()) {
        (Some(&first), Some(&last)) => {
            first == 0 && last as usize == nodes.len() && starts.len() == types.len() + 1 && starts.is_sorted()
        }
        _ => nodes.is_empty() && types.is_empty(),
    };
    if !fits {
        return Err(DatasetError::CellLists);
    }
    match nodes.iter().find(|&&node| node as usize >= points) {
        Some(&node) => Err(DatasetError::NodeIndex { node, points }),
        None => Ok(()),
    }
}

fn check_fields(fields: &[Field], entities: usize, on: &'static str) -> Result<(), DatasetError> {
    for (i, field) in fields.iter().enumerate() {
        let name = || field.name.clone();
        if field.components == 0 || field.name.is_empty() {
            return Err(DatasetError::FieldShape(name()));
        }
        if fields[..i].iter().any(|other| other.name == field.name) {
            return Err(DatasetError::FieldTwice(name()));
        }
        if field.values.len() != field.components * entities {
            let (found, components) = (field.values.len(), field.components);
            return Err(DatasetError::FieldLength { name: name(), found, components, entities, on });
        }
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::io) fn real(name: &str, components: usize, values: Vec<f64>) -> Field {
        Field { name: name.into(), components, values: FieldData::F64(values) }
    }

    pub(in crate::io) fn integer(name: &str, values: Vec<i32>) -> Field {
        Field { name: name.into(), components: 1, values: FieldData::I32(values) }
    }

    /// A quadrilateral, a triangle and a line on six points; all numbers are exact in `f32`.
    pub(in crate::io) fn mixed_mesh() -> Dataset {
        let corners = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.5], [0.0, 1.0], [1.0, 1.0], [-2.5, 1e3]];
        let points: Vec<[f64; 3]> = corners.iter().map(|c| [c[0], c[1], 0.125 * c[0]]).collect();
        let temperature = points.iter().map(|p| p[0] - 4.0 * p[1]).collect();
        let displacement = points.iter().flat_map(|p| [p[1], -p[0], 0.5]).collect();
        Dataset {
            points,
            cells: CellsOf::Mesh {
                starts: vec![0, 4, 7, 9],
                nodes: vec![0, 1, 4, 3, 1, 2, 4, 4, 5],
                types: vec![9, 5, 3],
            },
            point_fields: vec![real("TEMPERATURE", 1, temperature), real("DISPLACEMENT", 3, displacement)],
            cell_fields: vec![
                integer("MATERIAL", vec![7, -1, i32::MAX]),
                real("STRESS", 4, (0..12).map(|i| 0.25 * f64::from(i) - 1.0).collect()),
            ],
        }
    }

    #[test]
    fn a_sound_data_set_passes_and_each_fault_is_named() {
        assert_eq!(mixed_mesh().check(), Ok(()));
        let fault = |change: &dyn Fn(&mut Dataset)| {
            let mut data = mixed_mesh();
            change(&mut data);
            data.check().expect_err("a fault")
        };
        assert!(matches!(fault(&|d| d.points.truncate(5)), DatasetError::NodeIndex { node: 5, points: 5 }));
        assert!(matches!(fault(&|d| d.point_fields[1].components = 2), DatasetError::FieldLength { found: 18, .. }));
        assert!(matches!(fault(&|d| d.cell_fields[0].components = 0), DatasetError::FieldShape(_)));
        assert!(matches!(fault(&|d| d.cell_fields[1].name = "MATERIAL".into()), DatasetError::FieldTwice(_)));
        for (starts, types) in [(vec![0, 4, 9], 3), (vec![0, 7, 4, 9], 3), (vec![0, 4, 7, 8], 3), (vec![], 0)] {
            let error = fault(&|d| {
                let nodes = vec![0; 9];
                d.cells = CellsOf::Mesh { starts: starts.clone(), nodes, types: vec![9; types] };
            });
            assert_eq!(error, DatasetError::CellLists);
        }
    }
}
