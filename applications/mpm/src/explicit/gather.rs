//! From the points to the nodes of their cells: mass, momentum, forces.

use super::kinematics::{ShapeAt, jacobian};
use super::kratos_faults::KratosFaults;
use crate::active::ActiveCells;
use crate::grid::{corners, with_shape};
use crate::points::Block;
use bia_constitutive::Kinematics;
use bia_kernel::geometry::{CellShape, Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;
use std::marker::PhantomData;

/// Sums over the points, by active node and component.
#[derive(Default)]
pub struct NodalSums {
    /// Σ N m.
    pub mass: Vec<f64>,
    /// Σ N m v.
    pub momentum: Vec<f64>,
    /// Σ N m g − Σ V σ ∇N.
    pub force: Vec<f64>,
    buffers: Vec<Vec<f64>>,
}

/// What is summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// Mass and momentum.
    Momentum,
    /// Forces.
    Force,
    /// Both in one pass.
    Both,
    /// Momentum without mass, from points that have moved.
    MovedMomentum,
}

/// What all cells share.
pub struct Gather<'a> {
    /// Blocks of points.
    pub blocks: &'a [Block],
    /// Cells with points.
    pub active: &'a ActiveCells,
    /// The grid.
    pub grid: &'a ModelPart,
    /// Numbers of the active nodes.
    pub dofs: &'a ActiveDofs,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// Time by which velocities are carried ahead with the points' accelerations, in seconds.
    pub ahead: f64,
    /// Faults to repeat.
    pub faults: KratosFaults,
    /// Instruction set.
    pub arch: pulp::Arch,
}

impl NodalSums {
    /// Zeros for the active nodes.
    pub fn reset(&mut self, dofs: &ActiveDofs) {
        let order = dofs.order();
        for (sums, size) in
            [(&mut self.mass, order / dofs.block()), (&mut self.momentum, order), (&mut self.force, order)]
        {
            sums.clear();
            sums.resize(size, 0.0);
        }
    }

    /// Adds all points, cell by cell in a fixed order.
    pub fn add(&mut self, gather: &Gather, wanted: Wanted) {
        let (dimension, active, grid) = (gather.dofs.block(), gather.active, gather.grid);
        let width = 1 + 2 * dimension;
        let compute = |index: usize, buffer: &mut Vec<f64>| {
            let cell = active.cells[index] as usize;
            let nodes = grid.elements.nodes_of(cell);
            buffer.clear();
            buffer.resize(width * nodes.len(), 0.0);
            with_shape!(grid.elements.shapes[cell], |S, D, N| {
                let corners = corners::<D, N>(grid, nodes);
                let points = active.points(index);
                gather.arch.dispatch(CellTask::<S, D, N> { gather, corners, points, wanted, buffer, shape: PhantomData });
            }, else ());
            Ok::<(), ()>(())
        };
        let (mass, momentum, force) = (&mut self.mass, &mut self.momentum, &mut self.force);
        let add = |index: usize, buffer: &Vec<f64>| {
            let nodes = grid.elements.nodes_of(active.cells[index] as usize);
            for (sums, &node) in buffer.chunks_exact(width).zip(nodes) {
                let Some(number) = gather.dofs.number(node) else { continue };
                let range = number * dimension..(number + 1) * dimension;
                let (with_momentum, with_force) = sums[1..].split_at(dimension);
                if wanted != Wanted::Force {
                    mass[number] += sums[0];
                    momentum[range.clone()].iter_mut().zip(with_momentum).for_each(|(sum, value)| *sum += value);
                }
                if matches!(wanted, Wanted::Force | Wanted::Both) {
                    force[range].iter_mut().zip(with_force).for_each(|(sum, value)| *sum += value);
                }
            }
        };
        // The computation cannot fail.
        let _ = in_order(active.len(), &mut self.buffers, compute, add);
    }
}

/// The points of one cell, for the widest vectors that the machine has.
struct CellTask<'a, S, const D: usize, const N: usize> {
    gather: &'a Gather<'a>,
    corners: [[f64; D]; N],
    points: &'a [(u32, u32)],
    wanted: Wanted,
    buffer: &'a mut [f64],
    shape: PhantomData<S>,
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> pulp::WithSimd for CellTask<'_, S, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) {
        let Gather { blocks, faults, .. } = *self.gather;
        let (mut masses, mut momenta, mut forces) = ([0.0; N], [[0.0; D]; N], [[0.0; D]; N]);
        for &(block, point) in self.points {
            let (block, point) = (&blocks[block as usize], point as usize);
            let xi = block.local.get::<D>(point);
            let mass = block.mass.get::<1>(point)[0];
            let shape = match self.wanted {
                Wanted::Momentum | Wanted::MovedMomentum => ShapeAt::<D, N>::functions::<S>(&xi, faults),
                _ => ShapeAt::<D, N>::new::<S>(&self.corners, &xi, faults),
            };
            match self.wanted {
                Wanted::Momentum | Wanted::Both => {
                    let velocity = self.velocity(block, point);
                    add_momentum(&shape.all, mass, &velocity, &mut masses, &mut momenta);
                }
                Wanted::MovedMomentum => {
                    let velocity = block.velocity.get::<D>(point);
                    add_momentum(&shape.functions, mass, &velocity, &mut [0.0; N], &mut momenta);
                }
                Wanted::Force => {}
            }
            if matches!(self.wanted, Wanted::Force | Wanted::Both) {
                self.add_force(block, point, mass, &shape, &mut forces);
            }
        }
        for (i, sums) in self.buffer.chunks_exact_mut(1 + 2 * D).enumerate() {
            sums[0] = masses[i];
            sums[1..=D].copy_from_slice(&momenta[i]);
            sums[1 + D..].copy_from_slice(&forces[i]);
        }
    }
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> CellTask<'_, S, D, N> {
    #[inline(always)]
    fn velocity(&self, block: &Block, point: usize) -> [f64; D] {
        let mut velocity = block.velocity.get::<D>(point);
        if self.gather.ahead != 0.0 {
            let acceleration = block.acceleration.get::<D>(point);
            (0..D).for_each(|a| velocity[a] += self.gather.ahead * acceleration[a]);
        }
        velocity
    }

    #[inline(always)]
    fn add_force(&self, block: &Block, point: usize, mass: f64, shape: &ShapeAt<D, N>, forces: &mut [[f64; D]; N]) {
        let volume = mass / block.density * jacobian(block.gradient.row(point));
        let stress = block.stress.row(point);
        let mut scaled = [[0.0; D]; D];
        for a in 0..D {
            for b in 0..D {
                scaled[a][b] = volume * stress[stored_index::<D>(stress.len(), a, b)];
            }
        }
        let weight = block.body_acceleration_of::<D>(point).map(|g| mass * g);
        for i in 0..N {
            for a in 0..D {
                let mut inner = 0.0;
                for b in 0..D {
                    inner += scaled[a][b] * shape.gradients[i][b];
                }
                forces[i][a] += shape.all[i] * weight[a] - inner;
            }
        }
        if self.gather.kinematics == Kinematics::Axisymmetric {
            let hoop = volume * stress[2] / shape.radius(&self.corners);
            (0..N).for_each(|i| forces[i][0] -= hoop * shape.functions[i]);
        }
    }
}

#[inline(always)]
fn add_momentum<const D: usize, const N: usize>(
    functions: &[f64; N],
    mass: f64,
    velocity: &[f64; D],
    masses: &mut [f64; N],
    momenta: &mut [[f64; D]; N],
) {
    for i in 0..N {
        let share = functions[i] * mass;
        masses[i] += share;
        for a in 0..D {
            momenta[i][a] += share * velocity[a];
        }
    }
}

/// Where component ab of a tensor stands in a stored stress of `length` numbers.
#[inline(always)]
fn stored_index<const D: usize>(length: usize, a: usize, b: usize) -> usize {
    match (D, a == b) {
        (_, true) => a,
        // The shear of the plane is the last one stored.
        (2, false) => length - 1,
        // xy, yz, xz.
        _ => [3, 5, 4][a + b - 1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::tensor::VOIGT_PAIRS;

    #[test]
    fn stored_components_are_found() {
        for kinematics in Kinematics::ALL {
            for (place, &component) in kinematics.voigt().iter().enumerate() {
                let (a, b) = VOIGT_PAIRS[component];
                if kinematics.dimension() == 3 {
                    assert_eq!((stored_index::<3>(6, a, b), stored_index::<3>(6, b, a)), (place, place));
                } else if b < 2 {
                    let length = kinematics.voigt().len();
                    assert_eq!((stored_index::<2>(length, a, b), stored_index::<2>(length, b, a)), (place, place));
                }
            }
        }
    }
}
