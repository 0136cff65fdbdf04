//! Faces between cells and at the boundary.
//!
//! Cells are kept in chunks of [`CHUNK`], of which the last of each block may be short; the index of a
//! cell counts the full ones. A *slot* is a face as one cell sees it: cell · 2 D + local face.

use crate::kind::face_nodes;
use std::collections::HashMap;

/// Cells of a chunk: a few of them fill a cache of the second level.
pub const CHUNK: usize = 256;

/// In [`Faces::of_slots`]: the slot is the face's right side.
pub const RIGHT: u32 = 1 << 31;

/// Faces: those between two cells first, then those of the boundary.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faces {
    /// Slot of the left side, on whose normal values at the face stand.
    pub left: Vec<u32>,
    /// Slot of the right side of the faces between two cells.
    pub right: Vec<u32>,
    /// Face of each slot, with [`RIGHT`] added where the slot is the right side; 0 in the gaps of
    /// short chunks.
    pub of_slots: Vec<u32>,
}

/// A face that three cells share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThreeCells {
    /// The index of the third cell.
    pub cell: usize,
}

impl Faces {
    /// Finds the faces of cells given by their index and nodes, ascending; `corners` are those of the
    /// reference cell, `slots` is the number of all slots.
    ///
    /// # Errors
    /// A face of three cells.
    pub fn new<'a>(
        cells: impl Iterator<Item = (usize, &'a [u32])>,
        corners: &[[f64; 3]],
        dimension: usize,
        slots: usize,
    ) -> Result<Self, ThreeCells> {
        let (mut open, mut first): (HashMap<[u32; 4], usize>, Vec<u32>) = (HashMap::new(), Vec::new());
        let (mut pairs, mut whole) = (Vec::new(), Vec::new());
        for (cell, nodes) in cells {
            for face in 0..2 * dimension {
                let mut key = [u32::MAX; 4];
                for (entry, node) in key.iter_mut().zip(face_nodes(corners, face)) {
                    *entry = nodes[node];
                }
                key.sort_unstable();
                let slot = (cell * 2 * dimension + face) as u32;
                match open.get(&key) {
                    None => {
                        open.insert(key, first.len());
                        first.push(slot);
                        whole.push(false);
                    }
                    Some(&other) if whole[other] => return Err(ThreeCells { cell }),
                    Some(&other) => {
                        whole[other] = true;
                        pairs.push((first[other], slot));
                    }
                }
            }
        }
        let boundary = first.iter().zip(&whole).filter(|(_, whole)| !**whole).map(|(slot, _)| *slot);
        Ok(Self::of_pairs(pairs, boundary, slots))
    }

    /// The faces of a periodic lattice of `counts` cells along the axes, first axis fastest.
    pub fn lattice(counts: &[usize]) -> Self {
        let (dimension, cells) = (counts.len(), counts.iter().product::<usize>());
        let slot = |cell: usize, face: usize| (cell * 2 * dimension + face) as u32;
        let mut pairs = Vec::new();
        for cell in 0..cells {
            let mut stride = 1;
            for (axis, &count) in counts.iter().enumerate() {
                let place = cell / stride % count;
                let next = cell - place * stride + (place + 1) % count * stride;
                pairs.push((slot(cell, 2 * axis + 1), slot(next, 2 * axis)));
                stride *= count;
            }
        }
        Self::of_pairs(pairs, std::iter::empty(), cells.next_multiple_of(CHUNK) * 2 * dimension)
    }

    fn of_pairs(pairs: Vec<(u32, u32)>, boundary: impl Iterator<Item = u32>, slots: usize) -> Self {
        let mut faces = Self { left: Vec::new(), right: Vec::new(), of_slots: vec![0; slots] };
        for (face, &(left, right)) in pairs.iter().enumerate() {
            faces.left.push(left);
            faces.right.push(right);
            faces.of_slots[left as usize] = face as u32;
            faces.of_slots[right as usize] = face as u32 | RIGHT;
        }
        for slot in boundary {
            faces.of_slots[slot as usize] = faces.left.len() as u32;
            faces.left.push(slot);
        }
        faces
    }

    /// Number of faces between two cells.
    pub fn inner(&self) -> usize {
        self.right.len()
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.left.len()
    }
}
