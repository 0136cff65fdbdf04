//! The cells of the points from step to step: only points that may have left theirs are looked for,
//! and points are put in the order of their cells when too many are out of it.

use super::cells::{Mapping, is_affine};
use super::kratos_faults::KratosFaults;
use crate::active::ActiveCells;
use crate::points::{MaterialPoints, Scratch};
use crate::scene::Scene;
use crate::settings::{Basis, Discretisation, Frame};
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::ModelPart;
use bia_kernel::with_shape;
use rayon::prelude::*;

/// Order is restored when points of one cell lie, on average, in more runs than this.
const RUNS_PER_CELL: f64 = 1.25;

/// Points that one thread looks for at a time.
const LEAVERS: usize = 256;

/// What is known of the points' cells.
#[derive(Default)]
pub struct Search {
    /// Points that may have left their cell since the last search: (block, point).
    pub leavers: Vec<(u32, u32)>,
    found: Vec<Option<(u32, [f64; 3])>>,
    searched: bool,
    order: Vec<u32>,
    counts: Vec<u32>,
    scratch: Scratch,
}

impl Search {
    /// Finds the cells of points that may have left theirs. Tells whether any has. A point just outside
    /// its cell must change it, unless a fault of Kratos is wanted: the negative functions that it would
    /// have there can leave a node without mass, and the force on that node would be lost.
    ///
    /// # Errors
    /// All points, or a condition, have left the grid.
    pub fn find(
        &mut self,
        scene: &mut Scene,
        points: &mut MaterialPoints,
        frame: Frame,
        faults: KratosFaults,
    ) -> Result<bool, Error> {
        if !std::mem::replace(&mut self.searched, true) {
            scene.search(points)?;
            return Ok(true);
        }
        if frame == Frame::Total {
            return Ok(false);
        }
        let Some(locator) = &scene.locator else { return Ok(false) };
        let mut lost = self.leavers.len() > points.len() / 2;
        let mut moved = lost;
        if !lost {
            let blocks = &points.blocks;
            let locate = |&(block, point): &(u32, u32)| {
                let (block, point) = (&blocks[block as usize], point as usize);
                let (x, hint) = (block.coordinates(point), Some(block.cell[point]));
                if faults.0 { locator.locate(x, hint) } else { locator.locate_inside(x, hint) }
            };
            self.leavers.par_iter().with_min_len(LEAVERS).map(locate).collect_into_vec(&mut self.found);
            for (&(block, point), found) in self.leavers.iter().zip(&self.found) {
                let Some((cell, xi)) = found else {
                    (lost, moved) = (true, true);
                    break;
                };
                let (block, point) = (&mut points.blocks[block as usize], point as usize);
                moved |= block.cell[point] != *cell;
                block.cell[point] = *cell;
                if block.local.is_used() {
                    let local = block.local.row_mut(point);
                    local.copy_from_slice(&xi[..local.len()]);
                }
            }
        }
        self.leavers.clear();
        if lost || !points.conditions.is_empty() {
            // It erases, keeps or reports them, and finds the conditions.
            scene.search(points)?;
        }
        Ok(moved)
    }

    /// Saves or loads which points may have left their cells.
    ///
    /// # Errors
    /// The checkpoint does not hold them.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut leavers: Vec<[u32; 2]> = self.leavers.iter().map(|&(block, point)| [block, point]).collect();
        archive.column("leavers", &mut leavers)?;
        if archive.is_loading() {
            self.leavers = leavers.into_iter().map(|[block, point]| (block, point)).collect();
        }
        archive.flag("searched", &mut self.searched)
    }

    /// Puts the points of each block in the order of their cells if too many are out of it. Tells
    /// whether it did.
    pub fn restore_order(&mut self, points: &mut MaterialPoints, active: &ActiveCells, cells: usize) -> bool {
        let runs = |cell: &[u32]| cell.chunk_by(|a, b| a == b).count();
        let runs: usize = points.blocks.iter().map(|block| runs(&block.cell)).sum();
        if runs as f64 <= RUNS_PER_CELL * (active.len() * points.blocks.len().min(2)) as f64 {
            return false;
        }
        for block in &mut points.blocks {
            if block.cell.is_sorted() {
                continue;
            }
            self.counts.clear();
            self.counts.resize(cells + 2, 0);
            let place = |cell: u32| (cell as usize).min(cells);
            block.cell.iter().for_each(|&cell| self.counts[place(cell) + 1] += 1);
            (1..self.counts.len()).for_each(|c| self.counts[c] += self.counts[c - 1]);
            self.order.clear();
            self.order.resize(block.len(), 0);
            for (point, &cell) in block.cell.iter().enumerate() {
                let next = &mut self.counts[place(cell)];
                self.order[*next as usize] = point as u32;
                *next += 1;
            }
            block.reorder(&self.order, &mut self.scratch);
        }
        true
    }
}

/// Moves points that lie on an edge of their cell by a thousandth of their path, as Kratos does
/// when asked, and finds their cells again.
pub fn leave_edges(scene: &Scene, points: &mut MaterialPoints, grid: &ModelPart, time_step: f64) {
    let Some(locator) = &scene.locator else { return };
    for block in &mut points.blocks {
        for point in 0..block.len() {
            let Some(&shape) = grid.elements.shapes.get(block.cell[point] as usize) else { continue };
            let mut functions = [0.0; 8];
            let Some((_, xi)) = locator.locate(block.coordinates(point), Some(block.cell[point])) else { continue };
            shape.functions(xi, &mut functions[..shape.node_count()]);
            if functions[..shape.node_count()].iter().all(|n| *n >= f64::EPSILON) {
                continue;
            }
            let velocity = block.velocity.row(point);
            let step = time_step / 1000.0;
            block.position.row_mut(point).iter_mut().zip(velocity).for_each(|(x, v)| *x += step * v);
            if let Some((cell, xi)) = locator.locate(block.coordinates(point), Some(block.cell[point])) {
                block.cell[point] = cell;
                if block.local.is_used() {
                    let local = block.local.row_mut(point);
                    local.copy_from_slice(&xi[..local.len()]);
                }
            }
        }
    }
}

/// How local coordinates are had on a grid.
pub fn mapping(grid: &ModelPart, choice: &Discretisation) -> Mapping {
    let is_parallel = |cell: usize| {
        let shape = grid.elements.shapes[cell];
        with_shape!(shape, |S, D, N| is_affine::<S, D, N>(&corners(grid, cell)), else true)
    };
    let affine = choice.basis != Basis::Mesh || (0..grid.elements.len()).all(is_parallel);
    Mapping { affine, stored: choice.frame == Frame::Total || !affine }
}

fn corners<const D: usize, const N: usize>(grid: &ModelPart, cell: usize) -> [[f64; D]; N] {
    let nodes = grid.elements.nodes_of(cell);
    std::array::from_fn(|i| std::array::from_fn(|a| grid.nodes.coordinates[nodes[i] as usize][a]))
}
