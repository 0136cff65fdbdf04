//! From the points to the nodes of their cells: mass, momentum, forces.

use super::cells::{Cell, CellOf, Mapping};
use super::kinematics::inverse;
use super::kratos_faults::KratosFaults;
use super::patches::Patches;
use super::rows::{Rows, groups};
use super::strain::load_gradient;
use super::sample::type_of;
use crate::active::ActiveCells;
use crate::points::Block;
use crate::settings::Frame;
use crate::space::{Space, with_basis};
use bia_constitutive::Kinematics;
use bia_constitutive::tensor::Tensor;
use bia_kernel::lanes::{Lanes, Pack, WIDTH};
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
                self.arch.dispatch(task);
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

/// Sums over the points of a cell, which are in the lanes.
struct CellSums<S: Simd, const D: usize, const N: usize> {
    mass: [Lanes<S>; N],
    momentum: [[Lanes<S>; D]; N],
    force: [[Lanes<S>; D]; N],
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
            let zero = Lanes::splat(simd, 0.0);
            let mut sums = CellSums { mass: [zero; N], momentum: [[zero; D]; N], force: [[zero; D]; N] };
            // Runs of neighbouring points of one block.
            for run in active.points(index).chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1) {
                let block = &self.gather.blocks[run[0].0 as usize];
                let first = run[0].1 as usize;
                for rows in groups(simd, first..first + run.len()) {
                    self.add_points(simd, &cell, block, rows, &mut sums);
                }
            }
            self.add_sums(places, &sums);
        }
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cells<'a, '_, B, D, N> {
    /// Adds the sums of a cell to the nodes of the patch.
    #[inline(always)]
    fn add_sums<S: Simd>(&mut self, places: &[u32], sums: &CellSums<S, D, N>) {
        let width = 1 + 2 * D;
        for (i, &place) in places.iter().enumerate() {
            let node = &mut self.sums[place as usize * width..(place as usize + 1) * width];
            if self.wanted.momentum() {
                if self.wanted != Wanted::MovedMomentum {
                    node[0] += sums.mass[i].sum();
                }
                for a in 0..D {
                    node[1 + a] += sums.momentum[i][a].sum();
                }
            }
            if self.wanted.force() {
                for a in 0..D {
                    node[1 + D + a] += sums.force[i][a].sum();
                }
            }
        }
    }

    #[inline(always)]
    fn add_points<S: Simd>(
        &self,
        simd: S,
        cell: &Cell<B, D, N>,
        block: &Block,
        rows: Rows,
        sums: &mut CellSums<S, D, N>,
    ) {
        let at = self.at_points(simd, cell, block, rows);
        // Lanes beyond the last point count nothing.
        let mut counts = Pack([0.0; WIDTH]);
        counts.0[..rows.count].fill(1.0);
        let counts = Lanes::load(simd, &counts);
        let [mass] = rows.load::<S, 1>(simd, block.mass.values());
        let mass = mass * counts;
        if self.wanted.momentum() {
            let mut momentum = self.velocity(simd, block, rows);
            for a in 0..D {
                momentum[a] *= mass;
            }
            let functions = if self.wanted == Wanted::MovedMomentum { &at.functions } else { &at.all };
            for i in 0..N {
                for a in 0..D {
                    sums.momentum[i][a] += functions[i] * momentum[a];
                }
            }
            if self.wanted != Wanted::MovedMomentum {
                for i in 0..N {
                    sums.mass[i] += functions[i] * mass;
                }
            }
        }
        if self.wanted.force() {
            let [volume] = rows.load::<S, 1>(simd, block.volume.values());
            self.add_force(simd, &at, block, rows, [mass, volume * counts], sums);
        }
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
        self.gather.faults.misalign_lanes(&mut functions, &mut gradients);
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

    /// f = Σ N m g − V σ ∇N, ∇N = J⁻ᵀ ∂N/∂ξ; in the total frame ∇N = F⁻ᵀ ∂N/∂X.
    #[inline(always)]
    fn add_force<S: Simd>(
        &self,
        simd: S,
        at: &AtPoints<S, D, N>,
        block: &Block,
        rows: Rows,
        [mass, volume]: [Lanes<S>; 2],
        sums: &mut CellSums<S, D, N>,
    ) {
        let components = self.gather.kinematics.voigt();
        let stress = rows.load_components(simd, block.stress.values(), components);
        let stress = tensor(&stress);
        let mut pull = at.inverse;
        let mut hoop_scale = volume;
        if self.gather.frame == Frame::Total {
            let gradient = load_gradient::<S, D>(simd, rows, block.gradient.values(), self.gather.kinematics);
            let back = inverse(&gradient);
            for c in 0..D {
                for b in 0..D {
                    pull[c][b] = at.inverse[c][0] * back[0][b];
                    for k in 1..D {
                        pull[c][b] += at.inverse[c][k] * back[k][b];
                    }
                }
            }
            hoop_scale *= back[2][2];
        }
        let body = self.body(simd, block, rows);
        for a in 0..D {
            let mut row = [volume; D];
            for c in 0..D {
                let mut sum = stress[a][0] * pull[c][0];
                for b in 1..D {
                    sum += stress[a][b] * pull[c][b];
                }
                row[c] *= sum;
            }
            let weight = body[a] * mass;
            for i in 0..N {
                let mut inner = at.gradients[i][0] * row[0];
                for c in 1..D {
                    inner += at.gradients[i][c] * row[c];
                }
                sums.force[i][a] += at.all[i] * weight - inner;
            }
        }
        if self.gather.kinematics == Kinematics::Axisymmetric {
            let hoop = hoop_scale * stress[2][2] / at.radius;
            for i in 0..N {
                sums.force[i][0] -= at.functions[i] * hoop;
            }
        }
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
