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
    /// Active numbers of the functions of each cell of the grid, in the order of the space; those of
    /// cells that are not active mean nothing.
    numbers: Vec<u32>,
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
    pub fn renew(&mut self, space: &Space, active: &ActiveCells, dofs: &ActiveDofs) {
        self.numbers.resize(space.entries().len(), 0);
        for list in [&mut self.nodes, &mut self.places] {
            list.clear();
        }
        self.patches.clear();
        // The place of a node, as long as it was met in the present patch.
        let mut place_of = vec![(u32::MAX, 0); dofs.nodes().len()];
        for first in (0..active.len()).step_by(CELLS) {
            let patch = self.patches.len() as u32;
            let cells = first..active.len().min(first + CELLS);
            let (nodes, places) = (self.nodes.len(), self.places.len());
            for &cell in &active.cells[cells.clone()] {
                let range = space.range_of(cell as usize);
                for (&node, of_cell) in space.entries()[range.clone()].iter().zip(&mut self.numbers[range]) {
                    // The nodes of active cells are active.
                    let Some(number) = dofs.number(node) else { continue };
                    *of_cell = number as u32;
                    let (last, place) = &mut place_of[number];
                    if *last != patch {
                        (*last, *place) = (patch, (self.nodes.len() - nodes) as u32);
                        self.nodes.push(number as u32);
                    }
                    self.places.push(*place);
                }
            }
            let (nodes, places) = (nodes..self.nodes.len(), places..self.places.len());
            self.patches.push(Patch { cells, nodes, places });
        }
    }

    /// Active numbers of the functions of an active cell.
    #[inline(always)]
    pub fn numbers(&self, space: &Space, cell: usize) -> &[u32] {
        &self.numbers[space.range_of(cell)]
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
