//! From the points to the nodes of their cells: mass, momentum, forces.

use super::cells::{Cell, Mapping};
use super::kinematics::inverse;
use super::kratos_faults::KratosFaults;
use super::patches::Patches;
use crate::active::ActiveCells;
use crate::grid::{GridCell, corners, with_shape};
use crate::points::{Block, expand};
use crate::settings::Frame;
use bia_constitutive::Kinematics;
use bia_constitutive::tensor::tensor_of;
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;
use std::marker::PhantomData;
use std::ops::Range;

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
    /// Momentum without mass, after the points' velocities have changed.
    MovedMomentum,
}

impl Wanted {
    fn momentum(self) -> bool {
        self != Wanted::Force
    }

    fn force(self) -> bool {
        matches!(self, Wanted::Force | Wanted::Both)
    }
}

/// What all cells share.
pub struct Gather<'a> {
    /// Blocks of points.
    pub blocks: &'a [Block],
    /// Cells with points.
    pub active: &'a ActiveCells,
    /// The same cells in patches.
    pub patches: &'a Patches,
    /// The grid.
    pub grid: &'a ModelPart,
    /// Numbers of the active nodes.
    pub dofs: &'a ActiveDofs,
    /// How positions become local coordinates.
    pub mapping: Mapping,
    /// Where functions are evaluated.
    pub frame: Frame,
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

    /// Adds all points, patch by patch and cell by cell in a fixed order.
    pub fn add(&mut self, gather: &Gather, wanted: Wanted) {
        let dimension = gather.dofs.block();
        let width = 1 + 2 * dimension;
        let compute = |patch: usize, buffer: &mut Vec<f64>| {
            buffer.clear();
            buffer.resize(width * gather.patches.nodes(patch).len(), 0.0);
            gather.add_patch(patch, wanted, buffer);
            Ok::<(), ()>(())
        };
        let (mass, momentum, force) = (&mut self.mass, &mut self.momentum, &mut self.force);
        let add = |patch: usize, buffer: &Vec<f64>| {
            for (sums, &number) in buffer.chunks_exact(width).zip(gather.patches.nodes(patch)) {
                let number = number as usize;
                let (with_momentum, with_force) = sums[1..].split_at(dimension);
                let add = |to: &mut [f64], from: &[f64]| {
                    let to = &mut to[number * dimension..(number + 1) * dimension];
                    to.iter_mut().zip(from).for_each(|(sum, value)| *sum += value);
                };
                if wanted.momentum() {
                    mass[number] += sums[0];
                    add(momentum, with_momentum);
                }
                if wanted.force() {
                    add(force, with_force);
                }
            }
        };
        // The computation cannot fail.
        let _ = in_order(gather.patches.len(), &mut self.buffers, compute, add);
    }
}

impl Gather<'_> {
    /// Adds the points of a patch to its nodes.
    fn add_patch(&self, patch: usize, wanted: Wanted, sums: &mut [f64]) {
        let range = self.patches.cells(patch);
        let shape = |cell: &u32| self.grid.elements.shapes[*cell as usize];
        let (mut first, mut places) = (range.start, self.patches.places(patch));
        for run in self.active.cells[range].chunk_by(|a, b| shape(a) == shape(b)) {
            let cells = first..first + run.len();
            first = cells.end;
            with_shape!(shape(&run[0]), |S, D, N| {
                let (of_run, rest) = places.split_at(run.len() * N);
                places = rest;
                let places = of_run;
                self.arch.dispatch(CellsTask::<S, D, N> { gather: self, cells, places, wanted, sums, shape: PhantomData });
            }, else ());
        }
    }
}

/// The points of cells of one shape, for the widest vectors that the machine has.
struct CellsTask<'a, 's, B, const D: usize, const N: usize> {
    gather: &'a Gather<'a>,
    cells: Range<usize>,
    places: &'a [u32],
    wanted: Wanted,
    sums: &'s mut [f64],
    shape: PhantomData<B>,
}

/// Sums of one cell: its nodes side by side, so that they fill vectors.
struct CellSums<const D: usize, const N: usize> {
    mass: [f64; N],
    momentum: [[f64; N]; D],
    force: [[f64; N]; D],
}

/// Functions at one point.
struct AtPoint<const D: usize, const N: usize> {
    /// All functions: they carry mass, momentum and body forces to the grid.
    all: [f64; N],
    /// Functions for everything else; they differ from `all` by a fault of Kratos alone.
    functions: [f64; N],
    /// Local gradients, `[axis][node]`.
    gradients: [[f64; N]; D],
    /// J⁻¹.
    inverse: [[f64; D]; D],
}

impl<B: GridCell<D, N>, const D: usize, const N: usize> pulp::WithSimd for CellsTask<'_, '_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) {
        let Gather { active, grid, mapping, .. } = *self.gather;
        for (index, places) in self.cells.clone().zip(self.places.chunks_exact(N)) {
            let id = active.cells[index] as usize;
            let cell = Cell::new(B::of(grid, id), corners::<D, N>(grid, grid.elements.nodes_of(id)), mapping);
            let mut sums = CellSums::<D, N> { mass: [0.0; N], momentum: [[0.0; N]; D], force: [[0.0; N]; D] };
            for &(block, point) in active.points(index) {
                self.add_point(&cell, &self.gather.blocks[block as usize], point as usize, &mut sums);
            }
            for (i, &place) in places.iter().enumerate() {
                let width = 1 + 2 * D;
                let node = &mut self.sums[place as usize * width..(place as usize + 1) * width];
                node[0] += sums.mass[i];
                for a in 0..D {
                    node[1 + a] += sums.momentum[a][i];
                    node[1 + D + a] += sums.force[a][i];
                }
            }
        }
    }
}

impl<B: GridCell<D, N>, const D: usize, const N: usize> CellsTask<'_, '_, B, D, N> {
    #[inline(always)]
    fn add_point(&self, cell: &Cell<B, D, N>, block: &Block, point: usize, sums: &mut CellSums<D, N>) {
        let at = self.at_point(cell, block, point);
        let mass = block.mass.get::<1>(point)[0];
        if self.wanted.momentum() {
            let velocity = self.velocity(block, point);
            let functions = if self.wanted == Wanted::MovedMomentum { &at.functions } else { &at.all };
            if self.wanted != Wanted::MovedMomentum {
                for i in 0..N {
                    sums.mass[i] += functions[i] * mass;
                }
            }
            for a in 0..D {
                let momentum = mass * velocity[a];
                for i in 0..N {
                    sums.momentum[a][i] += functions[i] * momentum;
                }
            }
        }
        if self.wanted.force() {
            self.add_force(cell, &at, block, point, mass, sums);
        }
    }

    #[inline(always)]
    fn at_point(&self, cell: &Cell<B, D, N>, block: &Block, point: usize) -> AtPoint<D, N> {
        let xi = cell.local(&block.position.get::<D>(point), || block.local.get::<D>(point));
        let all = cell.basis.functions(&xi);
        let (mut functions, mut local) = (all, [[0.0; D]; N]);
        let mut inverse = [[0.0; D]; D];
        if self.wanted.force() {
            local = cell.basis.gradients(&xi);
            inverse = cell.inverse_jacobian(&local);
        }
        self.gather.faults.misalign(&mut functions, &mut local);
        let mut gradients = [[0.0; N]; D];
        for i in 0..N {
            for c in 0..D {
                gradients[c][i] = local[i][c];
            }
        }
        AtPoint { all, functions, gradients, inverse }
    }

    #[inline(always)]
    fn velocity(&self, block: &Block, point: usize) -> [f64; D] {
        let mut velocity = block.velocity.get::<D>(point);
        if self.gather.ahead != 0.0 && self.wanted != Wanted::MovedMomentum {
            let acceleration = block.acceleration.get::<D>(point);
            for a in 0..D {
                velocity[a] += self.gather.ahead * acceleration[a];
            }
        }
        velocity
    }

    /// f = Σ N m g − V σ ∇N, ∇N = J⁻ᵀ ∂N/∂ξ; in the total frame ∇N = F⁻ᵀ ∂N/∂X.
    #[inline(always)]
    fn add_force(
        &self,
        cell: &Cell<B, D, N>,
        at: &AtPoint<D, N>,
        block: &Block,
        point: usize,
        mass: f64,
        sums: &mut CellSums<D, N>,
    ) {
        let stress = block.stress.row(point);
        let [volume] = block.volume.get::<1>(point);
        let mut pull = at.inverse;
        if self.gather.frame == Frame::Total {
            let back = inverse(&tensor_of(&expand(block.gradient.row(point))));
            for c in 0..D {
                for b in 0..D {
                    pull[c][b] = 0.0;
                    for k in 0..D {
                        pull[c][b] += at.inverse[c][k] * back[k][b];
                    }
                }
            }
        }
        let body = block.body_acceleration_of::<D>(point);
        for a in 0..D {
            let mut row = [0.0; D];
            for c in 0..D {
                for b in 0..D {
                    row[c] += stress[stored_index::<D>(stress.len(), a, b)] * pull[c][b];
                }
                row[c] *= volume;
            }
            let weight = mass * body[a];
            for i in 0..N {
                let mut inner = at.gradients[0][i] * row[0];
                for c in 1..D {
                    inner += at.gradients[c][i] * row[c];
                }
                sums.force[a][i] += at.all[i] * weight - inner;
            }
        }
        if self.gather.kinematics == Kinematics::Axisymmetric {
            let mut hoop = volume * stress[2] / cell.radius(&at.all);
            if self.gather.frame == Frame::Total {
                hoop /= expand(block.gradient.row(point))[(2, 2)];
            }
            for i in 0..N {
                sums.force[0][i] -= hoop * at.functions[i];
            }
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
