//! The fields of the grid at points in step: the one loop from the nodes to the points that knows
//! the functions of the cells. What is done with the samples is written once for all functions.

use super::affine::Moments;
use super::cells::{AffineMap, Cell, CellOf, Mapping};
use super::chunk::Chunk;
use super::kratos_faults::KratosFaults;
use super::modes::Modes;
use super::patches::Patches;
use super::rows::{Rows, groups};
use super::to_grid::packs;
use crate::active::NO_CELL;
use crate::space::{Space, with_basis};
use bia_constitutive::Kinematics;
use bia_constitutive::tensor::Tensor;
use bia_kernel::lanes::{Lanes, Pack, WIDTH, dispatch, turns};
use pulp::Simd;
use rayon::prelude::*;
use std::marker::PhantomData;

/// Samples taken before something is done with them: so few that all streams of the points' numbers
/// advance together, so many that their loops pay.
const GROUPS: usize = 4;

/// Nodal fields, over the active dofs; those that are empty are not sampled.
#[derive(Clone, Copy, Default)]
pub struct Fields<'a> {
    /// Velocity whose gradient deforms points.
    pub deforming: &'a [f64],
    /// Velocity that carries points.
    pub carrying: &'a [f64],
    /// Acceleration.
    pub acceleration: &'a [f64],
    /// Velocity that points share in.
    pub smooth: &'a [f64],
    /// Wanted of the smooth velocity beside its value.
    pub affine: Affine,
    /// Displacement of the nodes in the total frame.
    pub displacement: &'a [f64],
}

/// The affine part of the velocity about a point that a transfer keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Affine {
    /// None.
    #[default]
    None,
    /// First moments Σ N v ⊗ (x_i − x_p), present places (Jiang et al. 2015).
    Moments,
    /// The gradient Σ v ⊗ ∂N/∂X (Nakamura et al. 2023).
    Gradient,
}

/// The fields once more, those of a node side by side.
#[derive(Default)]
pub struct Records {
    /// Deforming velocity and acceleration, each from a multiple of [`SECOND`] on; empty without both.
    moving: Vec<Pack>,
    /// Carrying and smooth velocity, where they are not the deforming one; empty without both.
    resting: Vec<Pack>,
}

/// Where the second field of a record starts.
const SECOND: usize = 4;

impl Records {
    /// Collects the fields, which have this many components.
    pub fn fill(&mut self, fields: &Fields, dimension: usize) {
        let other = |field: &'_ [f64]| if is_same(field, fields.deforming) { 0 } else { field.len() };
        let (carrying, smooth) = (&fields.carrying[..other(fields.carrying)], &fields.smooth[..other(fields.smooth)]);
        let fill = match dimension {
            1 => fill_pair::<1>,
            2 => fill_pair::<2>,
            _ => fill_pair::<3>,
        };
        fill(&mut self.moving, fields.deforming, fields.acceleration);
        fill(&mut self.resting, carrying, smooth);
    }
}

/// Records of two fields, either of which may be empty.
fn fill_pair<const D: usize>(records: &mut Vec<Pack>, first: &[f64], second: &[f64]) {
    let ((first, _), (second, _)) = (first.as_chunks::<D>(), second.as_chunks::<D>());
    records.resize(first.len().max(second.len()), Pack([0.0; WIDTH]));
    records.par_iter_mut().with_min_len(4096).enumerate().for_each(|(node, record)| {
        *record = Pack([0.0; WIDTH]);
        for (field, place) in [(first, 0), (second, SECOND)] {
            if let Some(vector) = field.get(node) {
                record.0[place..place + D].copy_from_slice(vector);
            }
        }
    });
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    !a.is_empty() && std::ptr::eq(a, b)
}

/// What sampling needs to know of the grid.
pub struct Grid<'a> {
    /// Its functions.
    pub space: &'a Space,
    /// Numbers of the active functions of each cell.
    pub patches: &'a Patches,
    /// How positions become local coordinates.
    pub mapping: Mapping,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// Faults to repeat.
    pub faults: KratosFaults,
    /// Instruction set.
    pub arch: pulp::Arch,
}

/// Fields at up to [`WIDTH`] points of one cell; components beyond the dimension are zero.
#[derive(Clone, Copy)]
pub struct Sample {
    /// The points.
    pub rows: Rows,
    /// Gradient of the deforming velocity, with the hoop rate if axisymmetric.
    pub gradient: Tensor<Pack>,
    /// Carrying velocity.
    pub carrying: [Pack; 3],
    /// Acceleration.
    pub acceleration: [Pack; 3],
    /// Smooth velocity.
    pub smooth: [Pack; 3],
    /// Affine part of the smooth velocity.
    pub affine: Tensor<Pack>,
    /// Where the cell is, if that tells which positions it holds.
    pub cell: Option<AffineMap<3>>,
}

impl Sample {
    const EMPTY: Self = {
        let zero = Pack([0.0; WIDTH]);
        Self {
            rows: Rows { first: 0, count: 0 },
            gradient: [[zero; 3]; 3],
            carrying: [zero; 3],
            acceleration: [zero; 3],
            smooth: [zero; 3],
            affine: [[zero; 3]; 3],
            cell: None,
        }
    };
}

/// Samples, kept to be filled again.
#[derive(Default)]
pub struct Samples {
    samples: Vec<Sample>,
    len: usize,
}

impl Samples {
    /// Samples the fields at the next few points of a chunk, leaving out those without a cell. Yields
    /// where the ones after them start.
    pub fn take(&mut self, chunk: &Chunk, first: usize, grid: &Grid, fields: &Fields, records: &Records) -> usize {
        self.len = 0;
        let cell = chunk.cell[first];
        if cell == NO_CELL {
            return first + chunk.cell[first..].iter().take_while(|cell| **cell == NO_CELL).count();
        }
        with_basis!(grid.space, cell as usize, |basis, D, N| {
            let samples = &mut *self;
            let task = Take::<_, D, N> { chunk, first, grid, fields, records, samples, basis: type_of(&basis) };
            dispatch(grid.arch, task)
        }, else chunk.cell.len())
    }

    /// The samples.
    pub fn taken(&self) -> &[Sample] {
        &self.samples[..self.len]
    }

    #[inline(always)]
    fn next(&mut self) -> &mut Sample {
        if self.len == self.samples.len() {
            self.samples.push(Sample::EMPTY);
        }
        self.len += 1;
        &mut self.samples[self.len - 1]
    }
}

/// The type of a value, for tasks that make their own.
pub fn type_of<T>(_: &T) -> PhantomData<T> {
    PhantomData
}

/// Samples at points in cells of one type.
struct Take<'a, 'b, B, const D: usize, const N: usize> {
    chunk: &'b Chunk<'b>,
    first: usize,
    grid: &'a Grid<'a>,
    fields: &'a Fields<'a>,
    records: &'a Records,
    samples: &'b mut Samples,
    basis: PhantomData<B>,
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> pulp::WithSimd for Take<'a, '_, B, D, N> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let Self { chunk, mut first, grid, fields, records, samples, .. } = self;
        let placed = fields.affine != Affine::None || grid.kinematics == Kinematics::Axisymmetric;
        let kind = chunk.cell[first] as usize;
        while first < chunk.cell.len() && samples.len < GROUPS {
            let id = chunk.cell[first];
            if id == NO_CELL || !grid.space.alike(kind, id as usize) {
                break;
            }
            let mut end = first + 1;
            while end < chunk.cell.len() && chunk.cell[end] == id {
                end += 1;
            }
            let points = first..end;
            first = end;
            let Some(cell) = Cell::<B, D, N>::of(grid.space, id as usize, grid.mapping, placed) else { continue };
            let numbers = grid.patches.numbers(grid.space, id as usize);
            let (mut moving, mut resting): (Room<N>, Room<N>) = (None, None);
            let nodal = Nodal::<N> {
                moving: coefficients::<S, B, D, N>(simd, &records.moving, numbers, &mut moving),
                resting: coefficients::<S, B, D, N>(simd, &records.resting, numbers, &mut resting),
            };
            for rows in groups(simd, points) {
                // Most cells have one group: what is spread over the lanes ahead of this loop is spilled.
                let nodal = std::hint::black_box(&nodal);
                let sample = samples.next();
                (sample.rows, sample.cell) = (rows, cell.place());
                let position = rows.load::<S, D>(simd, chunk.position);
                let xi = if cell.is_stored() { rows.load(simd, chunk.local) } else { cell.local(&position) };
                if B::OF_MESH && grid.faults.misaligns(&cell.basis.functions(&xi)) {
                    misaligned(grid, fields, &cell, &packs(&xi), numbers, sample);
                } else {
                    aligned(grid, fields, &cell, &xi, nodal, sample);
                }
                if fields.affine == Affine::Moments {
                    let fields = [fields.smooth, fields.displacement];
                    let (cell, out) = ((&cell.basis, (grid.space, id as usize)), &mut sample.affine);
                    Moments { basis: cell.0, cell: cell.1, numbers, fields, xi: packs(&xi), out }.find(simd);
                }
            }
        }
        first
    }
}

/// Coefficients of the modes of a cell.
struct Nodal<'a, const N: usize> {
    moving: &'a [Pack; N],
    resting: &'a [Pack; N],
}

/// Room that is not filled before it is needed.
type Room<const N: usize> = Option<[Pack; N]>;

/// Records of nodes as coefficients of the modes; without records zeros.
#[inline(always)]
fn coefficients<'r, S: Simd, B: Modes<D, N>, const D: usize, const N: usize>(
    simd: S,
    records: &[Pack],
    numbers: &[u32],
    room: &'r mut Room<N>,
) -> &'r [Pack; N] {
    if records.is_empty() {
        return const { &[Pack([0.0; WIDTH]); N] };
    }
    let out = room.insert([Pack([0.0; WIDTH]); N]);
    let numbers = &numbers[..N];
    for part in (0..WIDTH).step_by(Lanes::<S>::COUNT) {
        let mut lanes = [Lanes::splat(simd, 0.0); N];
        for i in 0..turns::<N>() {
            lanes[i] = Lanes::load_slice(simd, &records[numbers[i] as usize].0[part..]);
            if B::SCALE != 1.0 {
                lanes[i] = lanes[i] * B::SCALE;
            }
        }
        B::expand(&mut lanes);
        for i in 0..turns::<N>() {
            lanes[i].store_slice(&mut out[i].0[part..]);
        }
    }
    out
}

/// The fields at points in step.
#[inline(always)]
fn aligned<'a, S: Simd, B: CellOf<'a, D, N>, const D: usize, const N: usize>(
    grid: &Grid,
    fields: &Fields,
    cell: &Cell<B, D, N>,
    xi: &[Lanes<S>; D],
    nodal: &Nodal<N>,
    sample: &mut Sample,
) {
    let affine = fields.affine == Affine::Gradient && !fields.smooth.is_empty();
    let at = cell.basis.at(xi);
    if !fields.deforming.is_empty() {
        gradient::<S, B, D, N>(grid, cell, xi, &at, nodal.moving, 0, &mut sample.gradient);
    }
    if !fields.carrying.is_empty() {
        let same = is_same(fields.carrying, fields.deforming);
        vector::<S, B, D, N>(&at, if same { nodal.moving } else { nodal.resting }, 0, &mut sample.carrying);
    }
    if !fields.acceleration.is_empty() {
        vector::<S, B, D, N>(&at, nodal.moving, SECOND, &mut sample.acceleration);
    }
    if !fields.smooth.is_empty() {
        let same = is_same(fields.smooth, fields.deforming);
        let (from, first) = if same { (nodal.moving, 0) } else { (nodal.resting, SECOND) };
        vector::<S, B, D, N>(&at, from, first, &mut sample.smooth);
        if affine {
            gradient::<S, B, D, N>(grid, cell, xi, &at, from, first, &mut sample.affine);
        }
    }
}

/// A vector whose components have coefficients from `first` on.
#[inline(always)]
fn vector<S: Simd, B: Modes<D, N>, const D: usize, const N: usize>(
    at: &B::At<Lanes<S>>,
    coefficients: &[Pack; N],
    first: usize,
    out: &mut [Pack; 3],
) {
    let vector = B::vector(at, coefficients, first);
    for a in 0..D {
        vector[a].store(&mut out[a]);
    }
}

/// ∂v/∂x = Σ v ⊗ J⁻ᵀ ∂N/∂ξ of such a vector.
#[inline(always)]
fn gradient<'a, S: Simd, B: CellOf<'a, D, N>, const D: usize, const N: usize>(
    grid: &Grid,
    cell: &Cell<B, D, N>,
    xi: &[Lanes<S>; D],
    at: &B::At<Lanes<S>>,
    coefficients: &[Pack; N],
    first: usize,
    out: &mut Tensor<Pack>,
) {
    let gradient = cell.times_inverse(&B::gradient(at, coefficients, first), xi, false);
    for a in 0..D {
        for b in 0..D {
            gradient[a][b].store(&mut out[a][b]);
        }
    }
    if D == 2 && grid.kinematics == Kinematics::Axisymmetric {
        (B::vector(at, coefficients, first)[0] / cell.radius(xi)).store(&mut out[2][2]);
    }
}

/// The same point by point, where some have misaligned gradients. Local gradients with that fault
/// have the Jacobian of those without.
#[inline(never)]
fn misaligned<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize>(
    grid: &Grid,
    fields: &Fields,
    cell: &Cell<B, D, N>,
    xi: &[Pack; D],
    numbers: &[u32],
    sample: &mut Sample,
) {
    for l in 0..WIDTH {
        let xi: [f64; D] = std::array::from_fn(|a| xi[a].0[l]);
        let (mut functions, mut gradients) = (cell.basis.functions(&xi), cell.basis.gradients(&xi));
        grid.faults.misalign(&mut functions, &mut gradients);
        let of_node = |field: &[f64], i: usize, a: usize| field[numbers[i] as usize * D + a];
        let value = |field: &[f64], a: usize| (0..N).map(|i| functions[i] * of_node(field, i, a)).sum::<f64>();
        for (field, out) in [
            (fields.carrying, &mut sample.carrying),
            (fields.acceleration, &mut sample.acceleration),
            (fields.smooth, &mut sample.smooth),
        ] {
            (0..D).filter(|_| !field.is_empty()).for_each(|a| out[a].0[l] = value(field, a));
        }
        let affine = if fields.affine == Affine::Gradient { fields.smooth } else { &[] };
        for (field, out) in [(fields.deforming, &mut sample.gradient), (affine, &mut sample.affine)] {
            if field.is_empty() {
                continue;
            }
            let slope = |a: usize, c: usize| (0..N).map(|i| gradients[i][c] * of_node(field, i, a)).sum();
            let local: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|c| slope(a, c)));
            let gradient = cell.times_inverse(&local, &xi, false);
            (0..D).for_each(|a| (0..D).for_each(|b| out[a][b].0[l] = gradient[a][b]));
            if grid.kinematics == Kinematics::Axisymmetric {
                out[2][2].0[l] = value(field, 0) / cell.radius(&xi);
            }
        }
    }
}
