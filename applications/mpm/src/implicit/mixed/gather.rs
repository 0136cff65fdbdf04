//! Pressures from points to nodes: Σ N m p / Σ N m, the start values of a step.

use super::with_cell;
use crate::active::ActiveCells;
use crate::points::Block;
use crate::space::Space;
use bia_kernel::geometry::CellBasis;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;

/// Sums on the active nodes.
#[derive(Default)]
pub struct PressureSums {
    /// Σ N m p.
    pub weighted: Vec<f64>,
    /// Σ N m.
    pub mass: Vec<f64>,
    /// Σ N V₀.
    pub volume: Vec<f64>,
    /// The same in the measure of the mesh, in the plane m².
    pub area: Vec<f64>,
    buffers: Vec<Vec<[f64; 4]>>,
}

impl PressureSums {
    /// Gathers from all points.
    pub fn gather(&mut self, blocks: &[Block], active: &ActiveCells, space: &Space, dofs: &ActiveDofs) {
        let nodes = dofs.nodes().len();
        for sums in [&mut self.weighted, &mut self.mass, &mut self.volume, &mut self.area] {
            sums.clear();
            sums.resize(nodes, 0.0);
        }
        let compute = |index: usize, buffer: &mut Vec<[f64; 4]>| {
            let cell = active.cells[index] as usize;
            buffer.clear();
            buffer.resize(space.nodes_of(cell).len(), [0.0; 4]);
            with_cell!(space, cell, |basis, D, N, _DOFS| {
                for (block, point) in active.points(index) {
                    let (block, point) = (&blocks[block as usize], point as usize);
                    let functions: [f64; N] = basis.functions(&block.local.get::<D>(point));
                    let (mass, pressure) = (block.mass.get::<1>(point)[0], block.pressure.get::<1>(point)[0]);
                    let volume = mass / block.density;
                    let shares = [mass * pressure, mass, volume, volume / block.extent];
                    for (sums, n) in buffer.iter_mut().zip(functions) {
                        sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += n * share);
                    }
                }
            }, else ());
            Ok::<(), ()>(())
        };
        let (weighted, mass) = (&mut self.weighted, &mut self.mass);
        let (volume, area) = (&mut self.volume, &mut self.area);
        let add = |index: usize, buffer: &Vec<[f64; 4]>| {
            for (&node, sums) in space.nodes_of(active.cells[index] as usize).iter().zip(buffer) {
                let Some(number) = dofs.number(node) else { continue };
                weighted[number] += sums[0];
                mass[number] += sums[1];
                volume[number] += sums[2];
                area[number] += sums[3];
            }
        };
        // The computation cannot fail.
        let _ = in_order(active.len(), &mut self.buffers, compute, add);
    }

    /// Σ N m p / Σ N m of a node; zero where there is no mass.
    pub fn pressure(&self, number: usize) -> f64 {
        if self.mass[number] > f64::EPSILON { self.weighted[number] / self.mass[number] } else { 0.0 }
    }

    /// ‖Σ N V₀‖, by which the residuals of pressure are measured.
    pub fn scale(&self) -> f64 {
        self.volume.iter().map(|v| v * v).sum::<f64>().sqrt()
    }
}
