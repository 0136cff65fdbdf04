//! From the points to the nodes of their cells: mass, momentum, forces.

use super::cells::{Cell, CellOf, Mapping};
use super::kinematics::inverse as invert;
use super::kratos_faults::KratosFaults;
use super::patches::Patches;
use super::rows::{Rows, groups};
use super::sample::{Affine, places, type_of};
use super::strain::load_gradient;
use crate::active::ActiveCells;
use crate::grid::numbers;
use crate::points::Block;
use crate::settings::Frame;
use crate::space::{Space, with_basis};
use bia_constitutive::Kinematics;
use bia_constitutive::tensor::Tensor;
use bia_kernel::lanes::{Lanes, Pack, WIDTH, dispatch, turns};
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;
use pulp::Simd;
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
    /// The grid's functions.
    pub space: &'a Space,
    /// Numbers of the active functions.
    pub dofs: &'a ActiveDofs,
    /// How positions become local coordinates.
    pub mapping: Mapping,
    /// Where functions are evaluated.
    pub frame: Frame,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// The affine part of the velocity that points carry.
    pub affine: Affine,
    /// Displacement of the nodes in the total frame.
    pub displacement: &'a [f64],
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
        let compute = |patch: usize, buffer: &mut Vec<f64>| {
            buffer.clear();
            buffer.resize(RECORD * gather.patches.nodes(patch).len(), 0.0);
            gather.add_patch(patch, wanted, buffer);
            Ok::<(), ()>(())
        };
        let (mass, momentum, force) = (&mut self.mass, &mut self.momentum, &mut self.force);
        let add = |patch: usize, buffer: &Vec<f64>| {
            for (sums, &number) in buffer.chunks_exact(RECORD).zip(gather.patches.nodes(patch)) {
                let number = number as usize;
                let (with_momentum, with_force) = sums[1..1 + 2 * dimension].split_at(dimension);
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
        let (mut first, mut places) = (range.start, self.patches.places(patch));
        let alike = |a: &u32, b: &u32| self.space.alike(*a as usize, *b as usize);
        for run in self.active.cells[range].chunk_by(alike) {
            let cells = first..first + run.len();
            first = cells.end;
            with_basis!(self.space, run[0] as usize, |basis, D, N| {
                let (of_run, rest) = places.split_at(run.len() * N);
                places = rest;
                let task =
                    Cells::<_, D, N> { gather: self, cells, places: of_run, wanted, sums, basis: type_of(&basis) };
                dispatch(self.arch, task);
            }, else ());
        }
    }
}

/// The points of cells of one type, for the widest vectors that the machine has.
struct Cells<'a, 's, B, const D: usize, const N: usize> {
    gather: &'a Gather<'a>,
    cells: Range<usize>,
    places: &'s [u32],
    wanted: Wanted,
    sums: &'s mut [f64],
    basis: PhantomData<B>,
}

/// Numbers that each node of a patch sums: mass, momentum, force, and room to fill up to eight.
const RECORD: usize = 8;

/// Share of the spread of a cell's nodes about a point that is added to it, so that it has an inverse.
const TINY: f64 = f64::EPSILON;

/// An affine velocity field about points.
struct AffineField<S: Simd, const D: usize, const N: usize> {
    /// From the point to each node.
    lever: [[Lanes<S>; D]; N],
    gradient: [[Lanes<S>; D]; D],
}

impl<S: Simd, const D: usize, const N: usize> AffineField<S, D, N> {
    /// Adds the momentum that the field gives node `i` beside that of the point.
    #[inline(always)]
    fn add(&self, i: usize, mass: Lanes<S>, momentum: &mut [Lanes<S>; D]) {
        for a in 0..D {
            let mut velocity = self.gradient[a][0] * self.lever[i][0];
            for b in 1..D {
                velocity += self.gradient[a][b] * self.lever[i][b];
            }
            momentum[a] += velocity * mass;
        }
    }
}

/// D × D entries of each row.
#[inline(always)]
fn load_tensor<S: Simd, const D: usize>(simd: S, rows: Rows, column: &[f64]) -> [[Lanes<S>; D]; D] {
    let mut out = [[Lanes::splat(simd, 0.0); D]; D];
    for a in 0..D {
        for b in 0..D {
            let mut pack = Pack([0.0; WIDTH]);
            for (l, point) in rows.points().enumerate() {
                pack.0[l] = column[(point * D + a) * D + b];
            }
            out[a][b] = Lanes::load(simd, &pack);
        }
    }
    out
}

/// What makes the nodal forces of points in step.
struct Force<S: Simd, const D: usize> {
    /// V σ J⁻ᵀ.
    pull: [[Lanes<S>; D]; D],
    /// m g.
    weight: [Lanes<S>; D],
    /// V σ_θθ/r of axisymmetric scenes, else zero.
    hoop: Lanes<S>,
}

/// Functions at points in step.
struct AtPoints<S: Simd, const D: usize, const N: usize> {
    /// All functions: they carry mass, momentum and body forces to the grid.
    all: [Lanes<S>; N],
    /// Functions for everything else; they differ from `all` by a fault of Kratos alone.
    functions: [Lanes<S>; N],
    /// Local gradients.
    gradients: [[Lanes<S>; D]; N],
    /// J⁻¹.
    inverse: [[Lanes<S>; D]; D],
    /// Distance from the axis of axisymmetric scenes.
    radius: Lanes<S>,
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> pulp::WithSimd for Cells<'a, '_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let Gather { active, space, mapping, .. } = *self.gather;
        let places = self.places;
        for (index, places) in self.cells.clone().zip(places.chunks_exact(N)) {
            let Some(cell) = Cell::<B, D, N>::of(space, active.cells[index] as usize, mapping) else { continue };
            // Runs of neighbouring points of one block.
            for run in active.points(index).chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1) {
                let block = &self.gather.blocks[run[0].0 as usize];
                let first = run[0].1 as usize;
                for rows in groups(simd, first..first + run.len()) {
                    self.add_points(simd, &cell, block, rows, places, index);
                }
            }
        }
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cells<'a, '_, B, D, N> {
    /// Adds points to the nodes of their cell, which have these places in the patch.
    #[inline(always)]
    fn add_points<S: Simd>(
        &mut self,
        simd: S,
        cell: &Cell<B, D, N>,
        block: &Block,
        rows: Rows,
        places: &[u32],
        index: usize,
    ) {
        let zero = Lanes::splat(simd, 0.0);
        let at = self.at_points(simd, cell, block, rows);
        // Lanes beyond the last point count nothing.
        let mut counts = Pack([1.0; WIDTH]);
        counts.0[rows.count..].fill(0.0);
        let [mass] = rows.load::<S, 1>(simd, block.mass.values());
        let mass = mass * Lanes::load(simd, &counts);
        let mut momentum = [zero; D];
        if self.wanted.momentum() {
            momentum = self.velocity(simd, block, rows);
            for a in 0..D {
                momentum[a] *= mass;
            }
        }
        let mut force = Force { pull: [[zero; D]; D], weight: [zero; D], hoop: zero };
        if self.wanted.force() {
            force = self.force(simd, &at, block, rows, mass);
        }
        let affine = if self.wanted.momentum() && self.gather.affine != Affine::None {
            Some(self.affine(simd, cell, &at, block, rows, index))
        } else {
            None
        };
        for (i, &place) in places.iter().enumerate() {
            let mut record = [zero; RECORD];
            if self.wanted.momentum() {
                let moved = self.wanted == Wanted::MovedMomentum;
                let function = if moved { at.functions[i] } else { at.all[i] };
                if !moved {
                    record[0] = function * mass;
                }
                let mut of_node = momentum;
                if let Some(affine) = &affine {
                    affine.add(i, mass, &mut of_node);
                }
                for a in 0..D {
                    record[1 + a] = function * of_node[a];
                }
            }
            if self.wanted.force() {
                for a in 0..D {
                    let mut sum = at.all[i] * force.weight[a];
                    for c in 0..D {
                        sum -= at.gradients[i][c] * force.pull[a][c];
                    }
                    record[1 + D + a] = sum;
                }
                record[1 + D] -= at.functions[i] * force.hoop;
            }
            let place = place as usize * RECORD;
            let node = &mut self.sums[place..place + RECORD];
            let sums = Lanes::sums(&record);
            for k in 0..RECORD {
                node[k] += sums[k];
            }
        }
    }

    /// The affine field about points: C = B D⁻¹, D = Σ N (x_i − x_p) ⊗ (x_i − x_p), from the moments B,
    /// or the gradient that is kept.
    #[inline(always)]
    fn affine<S: Simd>(
        &self,
        simd: S,
        cell: &Cell<B, D, N>,
        at: &AtPoints<S, D, N>,
        block: &Block,
        rows: Rows,
        index: usize,
    ) -> AffineField<S, D, N> {
        let Gather { active, space, dofs, displacement, affine, .. } = *self.gather;
        let id = active.cells[index] as usize;
        let numbers = numbers::<N>(dofs, space.nodes_of(id));
        let moments = affine == Affine::Moments;
        let displacement = if moments { displacement } else { &[] };
        let places = places::<D, N>(space, id, &numbers, displacement);
        let zero = Lanes::splat(simd, 0.0);
        let kept = load_tensor::<S, D>(simd, rows, block.transfer.values());
        let mut position = rows.load::<S, D>(simd, block.position.values());
        if !moments && self.gather.frame == Frame::Total {
            // The gradient is with respect to the first places.
            let xi = cell.local(&position, || rows.load(simd, block.local.values()));
            position = cell.basis.position(&xi, &at.all);
        }
        let (mut lever, mut spread) = ([[zero; D]; N], [[zero; 3]; 3]);
        for i in 0..turns::<N>() {
            for a in 0..D {
                lever[i][a] = zero + places[i][a] - position[a];
            }
            for a in 0..D {
                for b in 0..D {
                    spread[a][b] += at.all[i] * lever[i][a] * lever[i][b];
                }
            }
        }
        if !moments {
            return AffineField { lever, gradient: kept };
        }
        // Where the points lie on nodes, D has no inverse, and B vanishes with it.
        let mut trace = spread[0][0];
        for a in 1..D {
            trace += spread[a][a];
        }
        for a in 0..3 {
            let missing = if a < D { trace * TINY + f64::MIN_POSITIVE } else { zero + 1.0 };
            spread[a][a] += missing;
        }
        let inverse = invert(&spread);
        let mut gradient = [[zero; D]; D];
        for a in 0..D {
            for b in 0..D {
                for c in 0..D {
                    gradient[a][b] += kept[a][c] * inverse[c][b];
                }
            }
        }
        AffineField { lever, gradient }
    }

    #[inline(always)]
    fn at_points<S: Simd>(&self, simd: S, cell: &Cell<B, D, N>, block: &Block, rows: Rows) -> AtPoints<S, D, N> {
        let zero = Lanes::splat(simd, 0.0);
        let position = rows.load(simd, block.position.values());
        let xi = cell.local(&position, || rows.load(simd, block.local.values()));
        let all = cell.basis.functions(&xi);
        let (mut functions, mut gradients, mut inverse) = (all, [[zero; D]; N], [[zero; D]; D]);
        if self.wanted.force() {
            gradients = cell.basis.gradients(&xi);
            inverse = cell.inverse_jacobian(&xi);
        }
        let axisymmetric = self.gather.kinematics == Kinematics::Axisymmetric;
        let radius = if axisymmetric { cell.radius(&xi) } else { zero };
        if B::OF_MESH {
            self.gather.faults.misalign_lanes(&mut functions, &mut gradients);
        }
        AtPoints { all, functions, gradients, inverse, radius }
    }

    #[inline(always)]
    fn velocity<S: Simd>(&self, simd: S, block: &Block, rows: Rows) -> [Lanes<S>; D] {
        let mut velocity = rows.load::<S, D>(simd, block.velocity.values());
        if self.gather.ahead != 0.0 && self.wanted != Wanted::MovedMomentum {
            let acceleration = rows.load::<S, D>(simd, block.acceleration.values());
            for a in 0..D {
                velocity[a] += acceleration[a] * self.gather.ahead;
            }
        }
        velocity
    }

    /// What makes the nodal force f = Σ N m g − V σ ∇N, ∇N = J⁻ᵀ ∂N/∂ξ; in the total frame
    /// ∇N = F⁻ᵀ J⁻ᵀ ∂N/∂ξ.
    #[inline(always)]
    fn force<S: Simd>(
        &self,
        simd: S,
        at: &AtPoints<S, D, N>,
        block: &Block,
        rows: Rows,
        mass: Lanes<S>,
    ) -> Force<S, D> {
        let mut counts = Pack([1.0; WIDTH]);
        counts.0[rows.count..].fill(0.0);
        let [volume] = rows.load::<S, 1>(simd, block.volume.values());
        let volume = volume * Lanes::load(simd, &counts);
        let kinematics = self.gather.kinematics;
        let stress = tensor(&rows.load_components(simd, block.stress.values(), kinematics.voigt()));
        let mut inverse = at.inverse;
        let mut hoop = volume;
        if self.gather.frame == Frame::Total {
            let back = invert(&load_gradient::<S, D>(simd, rows, block.gradient.values(), kinematics));
            for c in 0..D {
                for b in 0..D {
                    inverse[c][b] = at.inverse[c][0] * back[0][b];
                    for k in 1..D {
                        inverse[c][b] += at.inverse[c][k] * back[k][b];
                    }
                }
            }
            hoop *= back[2][2];
        }
        let axisymmetric = kinematics == Kinematics::Axisymmetric;
        hoop = if axisymmetric { hoop * stress[2][2] / at.radius } else { Lanes::splat(simd, 0.0) };
        let (mut pull, mut weight) = ([[volume; D]; D], self.body(simd, block, rows));
        for a in 0..D {
            weight[a] *= mass;
            for c in 0..D {
                let mut sum = stress[a][0] * inverse[c][0];
                for b in 1..D {
                    sum += stress[a][b] * inverse[c][b];
                }
                pull[a][c] *= sum;
            }
        }
        Force { pull, weight, hoop }
    }

    /// Body force per mass.
    #[inline(always)]
    fn body<S: Simd>(&self, simd: S, block: &Block, rows: Rows) -> [Lanes<S>; D] {
        let mut body = [Lanes::splat(simd, 0.0); D];
        if block.body_acceleration.is_used() {
            body = rows.load(simd, block.body_acceleration.values());
        }
        for a in 0..D {
            body[a] = body[a] + block.gravity[a];
        }
        body
    }
}

/// The tensor of Voigt components.
#[inline(always)]
fn tensor<S: Simd>(v: &[Lanes<S>; 6]) -> Tensor<Lanes<S>> {
    [[v[0], v[3], v[5]], [v[3], v[1], v[4]], [v[5], v[4], v[2]]]
}
