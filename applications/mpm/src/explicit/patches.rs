//! Neighbouring active cells in patches, which number their nodes among themselves: sums over the
//! points of a patch stay in the cache, and each node is added to the grid once a patch.

use crate::active::ActiveCells;
use crate::space::Space;
use bia_kernel::solving::ActiveDofs;
use std::ops::Range;

/// Active cells of one patch.
const CELLS: usize = 256;

/// All active cells, in their order.
#[derive(Default)]
pub struct Patches {
    /// Active numbers of the nodes, patch by patch.
    nodes: Vec<u32>,
    /// Places of the cells' nodes in their patch, cell by cell.
    places: Vec<u32>,
    patches: Vec<Patch>,
}

/// One patch as ranges.
struct Patch {
    cells: Range<usize>,
    nodes: Range<usize>,
    places: Range<usize>,
}

impl Patches {
    /// Divides the active cells.
    pub fn new(space: &Space, active: &ActiveCells, dofs: &ActiveDofs) -> Self {
        let mut out = Self::default();
        // The place of a node, as long as it was met in the present patch.
        let mut place_of = vec![(u32::MAX, 0); dofs.nodes().len()];
        for first in (0..active.len()).step_by(CELLS) {
            let patch = out.patches.len() as u32;
            let cells = first..active.len().min(first + CELLS);
            let (nodes, places) = (out.nodes.len(), out.places.len());
            for &cell in &active.cells[cells.clone()] {
                for &node in space.nodes_of(cell as usize) {
                    // The nodes of active cells are active.
                    let Some(number) = dofs.number(node) else { continue };
                    let (last, place) = &mut place_of[number];
                    if *last != patch {
                        (*last, *place) = (patch, (out.nodes.len() - nodes) as u32);
                        out.nodes.push(number as u32);
                    }
                    out.places.push(*place);
                }
            }
            let (nodes, places) = (nodes..out.nodes.len(), places..out.places.len());
            out.patches.push(Patch { cells, nodes, places });
        }
        out
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Indices of a patch's cells among the active ones.
    pub fn cells(&self, patch: usize) -> Range<usize> {
        self.patches[patch].cells.clone()
    }

    /// Active numbers of a patch's nodes.
    pub fn nodes(&self, patch: usize) -> &[u32] {
        &self.nodes[self.patches[patch].nodes.clone()]
    }

    /// Places among [`nodes`](Self::nodes) of the nodes of a patch's cells, cell by cell.
    pub fn places(&self, patch: usize) -> &[u32] {
        &self.places[self.patches[patch].places.clone()]
    }
}
