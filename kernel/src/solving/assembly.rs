//! Assembly of cell matrices and vectors into a block-sparse system whose pattern is kept.
//!
//! Cells are computed in parallel, a batch at a time, and added one after the other in their
//! order: the sums have the same bits for every number of threads.

use super::ActiveDofs;
use super::ordered::in_order;
use crate::model::Cells;
use bia_linalg::{BlockMatrix, BlockPattern};
use std::sync::Arc;

/// Matrix and right-hand side with the places of each cell's blocks.
pub struct System {
    /// The tangent.
    pub matrix: BlockMatrix,
    /// The residual (external minus internal forces).
    pub rhs: Vec<f64>,
    cells: Vec<u32>,
    starts: Vec<u32>,
    places: Vec<u32>,
    place_starts: Vec<usize>,
    buffers: Vec<CellBuffer>,
}

/// A cell's own matrix and vector.
#[derive(Debug, Clone, Default)]
pub struct CellBuffer {
    /// Row-major, (nodes × block)²: row `node * block + component`, but column
    /// `component * nodes + node`, so that loops over the nodes of a row run over neighbours.
    pub matrix: Vec<f64>,
    /// nodes × block.
    pub vector: Vec<f64>,
    /// Room for whatever the application needs while it computes a cell; never cleared.
    pub scratch: Vec<f64>,
}

impl CellBuffer {
    /// Zeros for a cell of this size, nodes × block.
    pub fn clear(&mut self, size: usize, with_matrix: bool) {
        self.vector.clear();
        self.vector.resize(size, 0.0);
        if with_matrix {
            self.matrix.clear();
            self.matrix.resize(size * size, 0.0);
        }
    }
}

impl System {
    /// The system that couples the dof numbers of each cell's nodes. `cells` holds them cell after
    /// cell, `starts` the start of each cell (one more entry than cells).
    pub fn new(block: usize, rows: usize, cells: Vec<u32>, starts: Vec<u32>) -> Self {
        let cliques = starts.windows(2).map(|range| &cells[range[0] as usize..range[1] as usize]);
        let pattern = BlockPattern::from_cliques(block, rows, cliques);
        Self::with_pattern(pattern, cells, starts)
    }

    /// A system of the same cells, whose matrix couples the nodes of each further clique, too; whoever
    /// asks for them fills them in.
    #[must_use]
    pub fn widened<'a>(&'a self, further: impl Iterator<Item = &'a [u32]>) -> Self {
        let (block, rows) = (self.matrix.pattern.block(), self.matrix.pattern.rows());
        let cliques = self.starts.windows(2).map(|range| &self.cells[range[0] as usize..range[1] as usize]);
        let cliques: Vec<&[u32]> = cliques.chain(further).collect();
        let pattern = BlockPattern::from_cliques(block, rows, cliques.iter().copied());
        Self::with_pattern(pattern, self.cells.clone(), self.starts.clone())
    }

    fn with_pattern(pattern: BlockPattern, cells: Vec<u32>, starts: Vec<u32>) -> Self {
        let (mut places, mut place_starts) = (Vec::new(), vec![0]);
        for range in starts.windows(2) {
            let clique = &cells[range[0] as usize..range[1] as usize];
            for &row in clique {
                for &column in clique {
                    // Every pair of a clique is in the pattern that was made of the cliques.
                    places.push(pattern.position(row as usize, column as usize).unwrap_or(u32::MAX));
                }
            }
            place_starts.push(places.len());
        }
        let rhs = vec![0.0; pattern.order()];
        let pattern = Arc::new(pattern);
        Self { matrix: BlockMatrix::new(pattern), rhs, cells, starts, places, place_starts, buffers: Vec::new() }
    }

    /// The system that couples the nodes of each of these cells.
    pub fn of_cells(cells: &Cells, chosen: &[u32], dofs: &ActiveDofs) -> Self {
        let (mut numbers, mut starts) = (Vec::new(), vec![0]);
        for &cell in chosen {
            let of_cell = cells.nodes_of(cell as usize).iter().filter_map(|&node| dofs.number(node));
            numbers.extend(of_cell.map(|number| number as u32));
            starts.push(numbers.len() as u32);
        }
        Self::new(dofs.block(), dofs.nodes().len(), numbers, starts)
    }

    /// Sets the right-hand side, and the matrix if wanted, to zero.
    pub fn clear(&mut self, with_matrix: bool) {
        self.rhs.fill(0.0);
        if with_matrix {
            self.matrix.clear();
        }
    }

    /// Adds all cells. `compute(cell, buffer)` fills the buffer's vector, and its matrix if
    /// `with_matrix`; both come zeroed.
    ///
    /// # Errors
    /// The error of the first cell, in their order, that fails.
    pub fn add_cells<E: Send>(
        &mut self,
        with_matrix: bool,
        compute: impl Fn(usize, &mut CellBuffer) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let block = self.matrix.pattern.block();
        let mut buffers = std::mem::take(&mut self.buffers);
        let sizes: Vec<usize> = self.starts.windows(2).map(|range| block * (range[1] - range[0]) as usize).collect();
        let prepare = |cell: usize, buffer: &mut CellBuffer| {
            buffer.clear(sizes[cell], with_matrix);
            compute(cell, buffer)
        };
        let add = |cell: usize, buffer: &CellBuffer| self.add_cell(cell, buffer, with_matrix);
        let result = in_order(sizes.len(), &mut buffers, prepare, add);
        self.buffers = buffers;
        result
    }

    fn add_cell(&mut self, cell: usize, buffer: &CellBuffer, with_matrix: bool) {
        match self.matrix.pattern.block() {
            1 => self.add_blocks::<1>(cell, buffer, with_matrix),
            2 => self.add_blocks::<2>(cell, buffer, with_matrix),
            3 => self.add_blocks::<3>(cell, buffer, with_matrix),
            _ => self.add_blocks::<4>(cell, buffer, with_matrix),
        }
    }

    fn add_blocks<const B: usize>(&mut self, cell: usize, buffer: &CellBuffer, with_matrix: bool) {
        let nodes = &self.cells[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        let (sums, _) = self.rhs.as_chunks_mut::<B>();
        let (own, _) = buffer.vector.as_chunks::<B>();
        for (&node, own) in nodes.iter().zip(own) {
            for a in 0..B {
                sums[node as usize][a] += own[a];
            }
        }
        if !with_matrix {
            return;
        }
        let count = nodes.len();
        let (blocks, _) = self.matrix.values.as_chunks_mut::<B>();
        let places = &self.places[self.place_starts[cell]..self.place_starts[cell + 1]];
        for (i, places) in places.chunks_exact(count).enumerate() {
            let rows: [&[f64]; B] = std::array::from_fn(|a| &buffer.matrix[(i * B + a) * count * B..][..count * B]);
            for (j, &place) in places.iter().enumerate() {
                let target = &mut blocks[place as usize * B..][..B];
                for a in 0..B {
                    for b in 0..B {
                        target[a][b] += rows[a][b * count + j];
                    }
                }
            }
        }
    }

    /// Adds to a diagonal entry of the matrix.
    pub fn add_diagonal(&mut self, dof: usize, value: f64) {
        let block = self.matrix.pattern.block();
        if let Some(place) = self.matrix.pattern.position(dof / block, dof / block) {
            self.matrix.values[place as usize * block * block + (dof % block) * (block + 1)] += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two bar elements 0-1 and 1-2 of stiffness 2 and 3.
    fn bars(threads: usize) -> System {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut system = System::new(1, 3, vec![0, 1, 1, 2], vec![0, 2, 4]);
            system.clear(true);
            let compute = |cell: usize, buffer: &mut CellBuffer| {
                let k = 2.0 + cell as f64;
                buffer.matrix.copy_from_slice(&[k, -k, -k, k]);
                buffer.vector.copy_from_slice(&[1.0, 10.0]);
                Ok::<(), ()>(())
            };
            system.add_cells(true, compute).unwrap();
            system
        })
    }

    #[test]
    fn cells_add_up() {
        let mut system = bars(1);
        assert_eq!(system.rhs, [1.0, 11.0, 10.0]);
        system.add_diagonal(2, 7.0);
        let mut y = vec![0.0; 3];
        system.matrix.multiply(&[1.0, 2.0, 4.0], &mut y);
        assert_eq!(y, [-2.0, 2.0 - 6.0, 6.0 + 28.0]);
        assert_eq!(bars(2).matrix.values, bars(1).matrix.values);
    }

    #[test]
    fn the_first_failing_cell_is_named() {
        let mut system = bars(1);
        let failed = system.add_cells(false, |cell, _| if cell == 1 { Err(cell) } else { Ok(()) });
        assert_eq!(failed, Err(1));
    }
}
