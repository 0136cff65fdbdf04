//! The part of the grid that holds points: cells with their points, nodes with their dofs.

use crate::grid::GRID;
use crate::points::lost::{self, LostPoints};
use crate::points::{Block, MaterialPoints};
use crate::space::Space;
use bia_kernel::error::Failure;
use bia_kernel::geometry::CellLocator;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::solver::Reached;
use rayon::prelude::*;

/// Marks a point that has no cell.
pub const NO_CELL: u32 = u32::MAX;

/// Neighbouring points of a block that share a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Block.
    pub block: u32,
    /// First point.
    pub first: u32,
    /// Points.
    pub count: u32,
}

/// Active cells, ascending, with their points by block and index.
#[derive(Default)]
pub struct ActiveCells {
    /// Cells.
    pub cells: Vec<u32>,
    /// Where each cell's runs start, one more entry than cells.
    starts: Vec<u32>,
    runs: Vec<Run>,
    counts: Vec<u32>,
    /// Cells that have held points at any time.
    reached: Vec<bool>,
}

impl ActiveCells {
    /// Number of active cells.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Runs of points of an active cell, by block and point.
    pub fn runs(&self, index: usize) -> &[Run] {
        &self.runs[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// Points of an active cell: (block, point).
    pub fn points(&self, index: usize) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.runs(index).iter().flat_map(|run| (run.first..run.first + run.count).map(|point| (run.block, point)))
    }

    /// Nodes of the grid whose cells hold points, and have held some at any time.
    pub fn reached_nodes(&self, grid: &ModelPart) -> Reached {
        let nodes_of = |cells: &mut dyn Iterator<Item = usize>| {
            let mut nodes = vec![false; grid.nodes.len()];
            cells.for_each(|cell| grid.elements.nodes_of(cell).iter().for_each(|node| nodes[*node as usize] = true));
            nodes
        };
        let now = nodes_of(&mut self.cells.iter().map(|cell| *cell as usize));
        let ever = nodes_of(&mut (0..self.reached.len()).filter(|cell| self.reached[*cell]));
        Reached { root: GRID, now, ever }
    }

    /// Saves or loads the cells as they are: a point may have changed its cell since they were gathered.
    ///
    /// # Errors
    /// The checkpoint does not hold them.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut runs: Vec<[u32; 3]> = self.runs.iter().map(|run| [run.block, run.first, run.count]).collect();
        archive.column("cells", &mut self.cells)?;
        archive.column("starts", &mut self.starts)?;
        archive.column("runs", &mut runs)?;
        if archive.is_loading() {
            self.runs = runs.into_iter().map(|[block, first, count]| Run { block, first, count }).collect();
        }
        Ok(())
    }

    /// Saves or loads which cells have held points.
    ///
    /// # Errors
    /// The checkpoint does not hold them.
    pub fn exchange_reached(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.flags("cells that have held points", &mut self.reached)
    }

    /// Sorts the points of all blocks into their cells.
    pub fn gather(&mut self, blocks: &[Block], total: usize) {
        self.counts.clear();
        self.counts.resize(total, 0);
        self.reached.resize(total, false);
        let all = || blocks.iter().enumerate().flat_map(|(block, points)| runs_of(block, &points.cell));
        all().for_each(|(cell, _)| self.counts[cell as usize] += 1);
        self.cells.clear();
        self.starts.clear();
        let mut next = 0;
        for (cell, count) in self.counts.iter_mut().enumerate().filter(|(_, count)| **count > 0) {
            self.cells.push(cell as u32);
            self.reached[cell] = true;
            self.starts.push(next);
            next += std::mem::replace(count, next);
        }
        self.starts.push(next);
        self.runs.clear();
        self.runs.resize(next as usize, Run { block: 0, first: 0, count: 0 });
        for (cell, run) in all() {
            let place = &mut self.counts[cell as usize];
            self.runs[*place as usize] = run;
            *place += 1;
        }
    }
}

/// The runs of a block's points with their cells.
fn runs_of(block: usize, cells: &[u32]) -> impl Iterator<Item = (u32, Run)> {
    let mut first = 0;
    let runs = cells.chunk_by(|a, b| a == b).map(move |run| {
        let (start, count) = (first, run.len() as u32);
        first += count;
        (run[0], Run { block: block as u32, first: start, count })
    });
    runs.filter(|(cell, _)| *cell != NO_CELL)
}

/// Finds the cell of every point, starting from its last one; what becomes of points that left the grid is
/// for `policy` to say.
///
/// # Errors
/// No point is left: then none is erased, so that the state can be saved. A point has left that may not.
pub fn search(
    points: &mut MaterialPoints,
    locator: &CellLocator,
    space: &Space,
    policy: LostPoints,
) -> Result<(), Failure> {
    let dimension = points.dimension();
    if policy != LostPoints::Clamp
        && let Some(failure) = all_outside(points, locator)
    {
        return Err(failure);
    }
    for b in 0..points.blocks.len() {
        let block = &points.blocks[b];
        let position = &block.position;
        let found: Vec<Option<(u32, [f64; 3])>> = block
            .cell
            .par_iter()
            .with_min_len(256)
            .enumerate()
            .map(|(point, &cell)| {
                let row = position.row(point);
                let x = std::array::from_fn(|i| row.get(i).copied().unwrap_or(0.0));
                if cell == NO_CELL {
                    return None;
                }
                locator.locate(x, Some(cell)).map(|(cell, xi)| (cell, space.local(cell as usize, x, xi)))
            })
            .collect();
        let mut keep = Vec::new();
        for (point, mut found) in found.into_iter().enumerate() {
            if found.is_none() {
                found = lost(points, (b, point), locator, policy)?;
                if let Some((cell, xi)) = &mut found {
                    *xi = space.local(*cell as usize, points.blocks[b].coordinates(point), *xi);
                }
            }
            let block = &mut points.blocks[b];
            match found {
                Some((cell, xi)) => {
                    block.cell[point] = cell;
                    if block.local.is_used() {
                        block.local.row_mut(point).copy_from_slice(&xi[..dimension]);
                    }
                }
                None if policy == LostPoints::Erase => {
                    keep.resize(block.len(), true);
                    keep[point] = false;
                    let (id, mass) = (block.ids[point], block.mass.row(point)[0]);
                    points.losses.add(id, mass);
                }
                None => block.cell[point] = NO_CELL,
            }
        }
        if !keep.is_empty() {
            points.blocks[b].retain(&keep);
        }
    }
    Ok(())
}

/// Deals with a point that is in no cell; gives a cell if it has got one again.
fn lost(
    points: &mut MaterialPoints,
    (block, point): (usize, usize),
    locator: &CellLocator,
    policy: LostPoints,
) -> Result<Option<(u32, [f64; 3])>, Failure> {
    let of = &points.blocks[block];
    if !of.position.row(point).iter().all(|x| x.is_finite()) {
        let advice = "a smaller time step, and look at the loads and material constants";
        let failure = Failure::new("the position of a material point is not finite", advice);
        let failure = failure.at(format!("material point {}", of.ids[point]), of.coordinates(point));
        return Err(failure.detail(of.describe(point)));
    }
    match policy {
        LostPoints::Error => Err(lost::failure(points, block, point)),
        LostPoints::Clamp => Ok(lost::clamp(points, locator, block, point)),
        LostPoints::Erase | LostPoints::Keep => Ok(None),
    }
}

/// The failure of points none of which is in the grid. Ends at the first that is, so it costs
/// nothing in a sound run.
fn all_outside(points: &MaterialPoints, locator: &CellLocator) -> Option<Failure> {
    let mut first = None;
    for block in &points.blocks {
        for point in 0..block.len() {
            let x = block.coordinates(point);
            if block.cell[point] != NO_CELL && locator.locate(x, Some(block.cell[point])).is_some() {
                return None;
            }
            first.get_or_insert((block.ids[point], x));
        }
    }
    let failure = Failure::new(
        "all material points have left the grid",
        "a larger grid, walls that hold the bodies, or a smaller time step",
    );
    Some(match first {
        Some((id, x)) => failure.at(format!("material point {id}"), x),
        None => failure,
    })
}
