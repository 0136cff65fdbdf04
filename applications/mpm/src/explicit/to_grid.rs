//! From the points to the nodes of their cells: mass, momentum, forces.

use super::cells::{Cell, CellOf, Mapping};
use super::kinematics::inverse as invert;
use super::kratos_faults::KratosFaults;
use super::patches::Patches;
use super::rows::{AHEAD, Rows, groups, prefetch_rows};
use super::sample::{Affine, type_of};
use super::strain::load_gradient;
use crate::active::ActiveCells;
use crate::points::Block;
use crate::settings::Frame;
use crate::space::{Space, with_basis};
use bia_constitutive::Kinematics;
use bia_kernel::lanes::{Lanes, Pack, WIDTH, dispatch, turns};
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;
use pulp::Simd;
use rayon::prelude::*;
use std::marker::PhantomData;
use std::ops::Range;

/// Numbers that one thread sets to zero at a time.
const NUMBERS: usize = 8192;

/// Sums over the points, by active node and component.
#[derive(Default)]
pub struct NodalSums {
    /// Σ N m.
    pub mass: Vec<f64>,
    /// Σ N m v.
    pub momentum: Vec<f64>,
    /// Σ N m g − Σ V σ ∇N.
    pub force: Vec<f64>,
    buffers: Vec<Vec<Pack>>,
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
    pub(super) fn momentum(self) -> bool {
        self != Wanted::Force
    }

    pub(super) fn force(self) -> bool {
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
            sums.resize(size, 0.0);
            sums.par_chunks_mut(NUMBERS).for_each(|sums| sums.fill(0.0));
        }
    }

    /// Adds all points, patch by patch and cell by cell in a fixed order.
    pub fn add(&mut self, gather: &Gather, wanted: Wanted) {
        match gather.kinematics.dimension() {
            1 => self.add_in::<1>(gather, wanted),
            2 => self.add_in::<2>(gather, wanted),
            _ => self.add_in::<3>(gather, wanted),
        }
    }

    fn add_in<const D: usize>(&mut self, gather: &Gather, wanted: Wanted) {
        let compute = |patch: usize, buffer: &mut Vec<Pack>| {
            buffer.clear();
            buffer.resize(gather.patches.nodes(patch).len(), Pack([0.0; WIDTH]));
            gather.add_patch(patch, wanted, buffer);
            Ok::<(), ()>(())
        };
        let mass = &mut self.mass;
        let ((momentum, _), (force, _)) = (self.momentum.as_chunks_mut::<D>(), self.force.as_chunks_mut::<D>());
        let add = |patch: usize, buffer: &Vec<Pack>| {
            for (Pack(sums), &number) in buffer.iter().zip(gather.patches.nodes(patch)) {
                let number = number as usize;
                if wanted.momentum() {
                    mass[number] += sums[0];
                    (0..D).for_each(|a| momentum[number][a] += sums[1 + a]);
                }
                if wanted.force() {
                    (0..D).for_each(|a| force[number][a] += sums[1 + D + a]);
                }
            }
        };
        // The computation cannot fail.
        let _ = in_order(gather.patches.len(), &mut self.buffers, compute, add);
    }
}

impl Gather<'_> {
    /// Adds the points of a patch to its nodes.
    fn add_patch(&self, patch: usize, wanted: Wanted, sums: &mut [Pack]) {
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
pub(super) struct Cells<'a, 's, B, const D: usize, const N: usize> {
    pub(super) gather: &'a Gather<'a>,
    cells: Range<usize>,
    places: &'s [u32],
    pub(super) wanted: Wanted,
    /// A record for each node of the patch: mass, momentum, force, and room to fill up to eight.
    pub(super) sums: &'s mut [Pack],
    basis: PhantomData<B>,
}

/// What points bring to their nodes.
pub(super) struct Load<T, const D: usize> {
    /// m.
    pub(super) mass: T,
    /// m v.
    pub(super) momentum: [T; D],
    /// m g.
    pub(super) weight: [T; D],
    /// V σ J⁻ᵀ.
    pub(super) pull: [[T; D]; D],
    /// V σ_θθ/r of axisymmetric scenes, else zero.
    pub(super) hoop: T,
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> pulp::WithSimd for Cells<'a, '_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let Gather { active, space, mapping, affine, kinematics, .. } = *self.gather;
        let placed = affine != Affine::None || kinematics == Kinematics::Axisymmetric;
        let places = self.places;
        for (index, places) in self.cells.clone().zip(places.chunks_exact(N)) {
            let id = active.cells[index] as usize;
            let Some(cell) = Cell::<B, D, N>::of(space, id, mapping, placed) else { continue };
            for run in active.runs(index) {
                let block = &self.gather.blocks[run.block as usize];
                let first = run.first as usize;
                self.prefetch(block, first + AHEAD..first + AHEAD + run.count as usize);
                for rows in groups(simd, first..first + run.count as usize) {
                    self.add_points(simd, &cell, block, rows, places);
                    if affine != Affine::None && self.wanted.momentum() {
                        self.add_affine(simd, &cell, id, block, rows, places);
                    }
                }
            }
        }
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cells<'a, '_, B, D, N> {
    /// Asks for what points will bring.
    #[inline(always)]
    fn prefetch(&self, block: &Block, points: Range<usize>) {
        prefetch_rows(block.position.values(), D, points.clone());
        prefetch_rows(block.mass.values(), 1, points.clone());
        if self.wanted.momentum() {
            prefetch_rows(block.velocity.values(), D, points.clone());
        }
        if self.wanted.force() {
            prefetch_rows(block.volume.values(), 1, points.clone());
            prefetch_rows(block.stress.values(), block.stress.width(), points);
        }
    }

    /// Adds points to the nodes of their cell, which have these places in the patch.
    #[inline(always)]
    fn add_points<S: Simd>(&mut self, simd: S, cell: &Cell<B, D, N>, block: &Block, rows: Rows, places: &[u32]) {
        let position = rows.load::<S, D>(simd, block.position.values());
        let xi = if cell.is_stored() { rows.load(simd, block.local.values()) } else { cell.local(&position) };
        let mut load = self.load(simd, cell, &xi, block, rows);
        if B::OF_MESH && self.gather.faults.misaligns(&cell.basis.functions(&xi)) {
            return self.add_misaligned(cell, &packs(&xi), &load.packs(), rows.count, places);
        }
        load.weight[0] -= load.hoop;
        let at = cell.basis.at(&xi);
        let records = B::sums(simd, &at, &load, self.wanted);
        for part in (0..WIDTH).step_by(Lanes::<S>::COUNT) {
            let mut of_nodes = [Lanes::splat(simd, 0.0); N];
            for i in 0..turns::<N>() {
                of_nodes[i] = Lanes::load_slice(simd, &records[i].0[part..]);
            }
            B::collect(&mut of_nodes);
            for i in 0..turns::<N>() {
                let node = &mut self.sums[places[i] as usize].0[part..];
                (Lanes::load_slice(simd, node) + of_nodes[i]).store_slice(node);
            }
        }
    }

    /// What the points bring, over the scale of the modes. Lanes beyond the last point bring nothing.
    #[inline(always)]
    fn load<S: Simd>(
        &self,
        simd: S,
        cell: &Cell<B, D, N>,
        xi: &[Lanes<S>; D],
        block: &Block,
        rows: Rows,
    ) -> Load<Lanes<S>, D> {
        let zero = Lanes::splat(simd, 0.0);
        let scale = rows.counts(simd) * B::SCALE;
        let [mass] = rows.load::<S, 1>(simd, block.mass.values());
        let mass = mass * scale;
        let mut load = Load { mass, momentum: [zero; D], weight: [zero; D], pull: [[zero; D]; D], hoop: zero };
        if self.wanted.momentum() {
            load.momentum = self.velocity(simd, block, rows);
            for a in 0..D {
                load.momentum[a] *= mass;
            }
        }
        if self.wanted.force() {
            load.weight = self.body(simd, block, rows);
            for a in 0..D {
                load.weight[a] *= mass;
            }
            self.add_stress(simd, cell, xi, block, rows, scale, &mut load);
        }
        load
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

    /// The part −V σ ∇N of the nodal force, ∇N = J⁻ᵀ ∂N/∂ξ; in the total frame ∇N = F⁻ᵀ J⁻ᵀ ∂N/∂ξ.
    #[expect(clippy::too_many_arguments)]
    #[inline(always)]
    fn add_stress<S: Simd>(
        &self,
        simd: S,
        cell: &Cell<B, D, N>,
        xi: &[Lanes<S>; D],
        block: &Block,
        rows: Rows,
        scale: Lanes<S>,
        load: &mut Load<Lanes<S>, D>,
    ) {
        let kinematics = self.gather.kinematics;
        let [volume] = rows.load::<S, 1>(simd, block.volume.values());
        let mut stress = rows.load_components::<S, D>(simd, block.stress.values(), kinematics.voigt());
        for component in &mut stress {
            *component *= volume * scale;
        }
        let [xx, yy, zz, xy, yz, xz] = stress;
        let full = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        for a in 0..D {
            load.pull[a].copy_from_slice(&full[a][..D]);
        }
        let mut hoop = zz;
        if self.gather.frame == Frame::Total {
            let back = invert(&load_gradient::<S, D>(simd, rows, block.gradient.values(), kinematics));
            for a in 0..D {
                for k in 0..D {
                    load.pull[a][k] = full[a][0] * back[k][0];
                    for b in 1..D {
                        load.pull[a][k] += full[a][b] * back[k][b];
                    }
                }
            }
            hoop *= back[2][2];
        }
        load.pull = cell.times_inverse(&load.pull, xi, true);
        if D == 2 && kinematics == Kinematics::Axisymmetric {
            load.hoop = hoop / cell.radius(xi);
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

#[inline(always)]
pub(super) fn packs<S: Simd, const C: usize>(lanes: &[Lanes<S>; C]) -> [Pack; C] {
    let mut packs = [Pack([0.0; WIDTH]); C];
    for c in 0..C {
        lanes[c].store(&mut packs[c]);
    }
    packs
}

impl<S: Simd, const D: usize> Load<Lanes<S>, D> {
    #[inline(always)]
    fn packs(&self) -> Load<Pack, D> {
        let mut pull = [[Pack([0.0; WIDTH]); D]; D];
        for a in 0..D {
            pull[a] = packs(&self.pull[a]);
        }
        let (mass, hoop) = (self.mass.pack(), self.hoop.pack());
        Load { mass, momentum: packs(&self.momentum), weight: packs(&self.weight), pull, hoop }
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cells<'a, '_, B, D, N> {
    /// Adds points some of which have misaligned gradients, one by one.
    #[inline(never)]
    fn add_misaligned(
        &mut self,
        cell: &Cell<B, D, N>,
        xi: &[Pack; D],
        load: &Load<Pack, D>,
        count: usize,
        places: &[u32],
    ) {
        let moved = self.wanted == Wanted::MovedMomentum;
        for l in 0..count {
            let xi: [f64; D] = std::array::from_fn(|a| xi[a].0[l]);
            // These carry mass, momentum and body forces to the grid.
            let all = cell.basis.functions(&xi);
            let (mut functions, mut gradients) = (all, cell.basis.gradients(&xi));
            self.gather.faults.misalign(&mut functions, &mut gradients);
            for i in 0..N {
                let node = &mut self.sums[places[i] as usize].0;
                let (all, function) = (all[i] / B::SCALE, functions[i] / B::SCALE);
                if self.wanted.momentum() {
                    node[0] += if moved { 0.0 } else { all * load.mass.0[l] };
                    for a in 0..D {
                        node[1 + a] += if moved { function } else { all } * load.momentum[a].0[l];
                    }
                }
                if self.wanted.force() {
                    for a in 0..D {
                        let pull: f64 = (0..D).map(|c| gradients[i][c] * load.pull[a][c].0[l]).sum();
                        node[1 + D + a] += all * load.weight[a].0[l] - pull / B::SCALE;
                    }
                    node[1 + D] -= function * load.hoop.0[l];
                }
            }
        }
    }
}
