//! The fields of the grid at points in step: the one loop from the nodes to the points that knows
//! the functions of the cells. What is done with the samples is written once for all functions.

use super::cells::{AffineMap, Cell, CellOf, Mapping};
use super::chunk::Chunk;
use super::kratos_faults::KratosFaults;
use super::rows::{Rows, groups};
use crate::active::NO_CELL;
use crate::grid::{numbers, vectors_of};
use crate::space::{Space, with_basis};
use bia_constitutive::Kinematics;
use bia_constitutive::tensor::Tensor;
use bia_kernel::lanes::{Lanes, Pack, Real, WIDTH, dispatch, turns};
use bia_kernel::solving::ActiveDofs;
use pulp::Simd;
use std::marker::PhantomData;
use std::ops::Range;

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

/// What sampling needs to know of the grid.
pub struct Grid<'a> {
    /// Its functions.
    pub space: &'a Space,
    /// Numbers of the active functions.
    pub dofs: &'a ActiveDofs,
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

/// Samples of a chunk, kept from chunk to chunk.
#[derive(Default)]
pub struct Samples {
    samples: Vec<Sample>,
    len: usize,
}

impl Samples {
    /// Samples the fields at all points of a chunk that have a cell.
    pub fn take(&mut self, chunk: &Chunk, grid: &Grid, fields: &Fields) -> &[Sample] {
        self.len = 0;
        for (range, first) in kinds(chunk.cell, grid.space) {
            with_basis!(grid.space, first, |basis, D, N| {
                let samples = &mut *self;
                let task = Take::<_, D, N> { chunk, range, grid, fields, samples, basis: type_of(&basis) };
                dispatch(grid.arch, task);
            }, else ());
        }
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

/// Runs of points whose cells' functions have one type, and the first cell.
fn kinds<'a>(cells: &'a [u32], space: &'a Space) -> impl Iterator<Item = (Range<usize>, usize)> + 'a {
    let alike = |a: u32, b: u32| a == b || (a != NO_CELL && b != NO_CELL && space.alike(a as usize, b as usize));
    let mut end = 0;
    cells.chunk_by(move |a, b| alike(*a, *b)).filter_map(move |run| {
        let range = end..end + run.len();
        end = range.end;
        (run[0] != NO_CELL).then_some((range, run[0] as usize))
    })
}

/// The type of a value, for tasks that make their own.
pub fn type_of<T>(_: &T) -> PhantomData<T> {
    PhantomData
}

/// Samples at points in cells of one type.
struct Take<'a, 'b, B, const D: usize, const N: usize> {
    chunk: &'b Chunk<'b>,
    range: Range<usize>,
    grid: &'a Grid<'a>,
    fields: &'a Fields<'a>,
    samples: &'b mut Samples,
    basis: PhantomData<B>,
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> pulp::WithSimd for Take<'a, '_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { chunk, grid, fields, samples, .. } = self;
        let mut first = self.range.start;
        for run in chunk.cell[self.range].chunk_by(|a, b| a == b) {
            let (index, points) = (run[0] as usize, first..first + run.len());
            first = points.end;
            let Some(cell) = Cell::<B, D, N>::of(grid.space, index, grid.mapping) else { continue };
            let numbers = numbers::<N>(grid.dofs, grid.space.nodes_of(index));
            let mut nodal = Nodal::<D, N> { deforming: vectors_of(&numbers, fields.deforming), ..Nodal::ZERO };
            if !std::ptr::eq(fields.carrying, fields.deforming) {
                nodal.carrying = vectors_of(&numbers, fields.carrying);
            }
            nodal.acceleration = vectors_of(&numbers, fields.acceleration);
            nodal.smooth = vectors_of(&numbers, fields.smooth);
            if fields.affine == Affine::Moments {
                nodal.places = places(grid.space, index, &numbers, fields.displacement);
            }
            for rows in groups(simd, points) {
                // Most cells have one group: what is spread over the lanes ahead of this loop is spilled.
                let nodal = std::hint::black_box(&nodal);
                let sample = samples.next();
                (sample.rows, sample.cell) = (rows, cell.place());
                let xi = cell.local(&rows.load(simd, chunk.position), || rows.load(simd, chunk.local));
                let (functions, gradients) = grid.functions(&cell, &xi, !fields.deforming.is_empty());
                if !fields.deforming.is_empty() {
                    grid.gradient(&cell, &xi, &functions, &gradients, &nodal.deforming, &mut sample.gradient);
                }
                if !fields.carrying.is_empty() {
                    let same = std::ptr::eq(fields.carrying, fields.deforming);
                    let carrying = if same { &nodal.deforming } else { &nodal.carrying };
                    interpolate(&functions, carrying, &mut sample.carrying);
                }
                if !fields.acceleration.is_empty() {
                    interpolate(&functions, &nodal.acceleration, &mut sample.acceleration);
                }
                if !fields.smooth.is_empty() {
                    interpolate(&functions, &nodal.smooth, &mut sample.smooth);
                    match fields.affine {
                        Affine::None => {}
                        Affine::Gradient => {
                            let (_, gradients) = grid.functions(&cell, &xi, true);
                            grid.gradient(&cell, &xi, &functions, &gradients, &nodal.smooth, &mut sample.affine);
                        }
                        Affine::Moments => {
                            let position = rows.load(simd, chunk.position);
                            moments(&functions, &position, nodal, &mut sample.affine);
                        }
                    }
                }
            }
        }
    }
}

/// Fields at the nodes of a cell.
struct Nodal<const D: usize, const N: usize> {
    deforming: [[f64; D]; N],
    carrying: [[f64; D]; N],
    acceleration: [[f64; D]; N],
    smooth: [[f64; D]; N],
    /// Present places.
    places: [[f64; D]; N],
}

impl<const D: usize, const N: usize> Nodal<D, N> {
    const ZERO: Self = {
        let zero = [[0.0; D]; N];
        Self { deforming: zero, carrying: zero, acceleration: zero, smooth: zero, places: zero }
    };
}

/// Present places of a cell's nodes: their anchors, displaced in the total frame.
#[inline(always)]
pub fn places<const D: usize, const N: usize>(
    space: &Space,
    cell: usize,
    numbers: &[usize; N],
    displacement: &[f64],
) -> [[f64; D]; N] {
    let mut places = space.corners::<D, N>(cell);
    let moved = vectors_of::<D, N>(numbers, displacement);
    for i in 0..turns::<N>() {
        for a in 0..D {
            places[i][a] += moved[i][a];
        }
    }
    places
}

/// Σ N v ⊗ (x_i − x_p).
#[inline(always)]
fn moments<S: Simd, const D: usize, const N: usize>(
    functions: &[Lanes<S>; N],
    position: &[Lanes<S>; D],
    nodal: &Nodal<D, N>,
    out: &mut Tensor<Pack>,
) {
    for b in 0..D {
        let mut column = [position[0].constant(0.0); D];
        for i in 0..turns::<N>() {
            let lever = functions[i] * (position[b].constant(nodal.places[i][b]) - position[b]);
            for a in 0..D {
                column[a] += lever * nodal.smooth[i][a];
            }
        }
        for a in 0..D {
            column[a].store(&mut out[a][b]);
        }
    }
}

impl Grid<'_> {
    /// Functions, and local gradients if wanted, with the faults that they are to have.
    #[inline(always)]
    fn functions<'a, S: Simd, B: CellOf<'a, D, N>, const D: usize, const N: usize>(
        &self,
        cell: &Cell<B, D, N>,
        xi: &[Lanes<S>; D],
        with_gradients: bool,
    ) -> ([Lanes<S>; N], [[Lanes<S>; D]; N]) {
        let mut functions = cell.basis.functions(xi);
        let mut gradients = [[xi[0]; D]; N];
        if with_gradients {
            gradients = cell.basis.gradients(xi);
        }
        if B::OF_MESH {
            self.faults.misalign_lanes(&mut functions, &mut gradients);
        }
        (functions, gradients)
    }

    /// ∂v/∂x = Σ v ⊗ J⁻ᵀ ∂N/∂ξ.
    #[inline(always)]
    fn gradient<'a, S: Simd, B: CellOf<'a, D, N>, const D: usize, const N: usize>(
        &self,
        cell: &Cell<B, D, N>,
        xi: &[Lanes<S>; D],
        functions: &[Lanes<S>; N],
        gradients: &[[Lanes<S>; D]; N],
        velocity: &[[f64; D]; N],
        out: &mut Tensor<Pack>,
    ) {
        let zero = xi[0].constant(0.0);
        let mut local = [[zero; D]; D];
        for i in 0..turns::<N>() {
            for a in 0..D {
                for c in 0..D {
                    local[a][c] += gradients[i][c] * velocity[i][a];
                }
            }
        }
        // Local gradients with a fault of Kratos have the Jacobian of those without.
        let inverse = cell.inverse_jacobian(xi);
        for a in 0..D {
            for b in 0..D {
                let mut sum = local[a][0] * inverse[0][b];
                for c in 1..D {
                    sum += local[a][c] * inverse[c][b];
                }
                sum.store(&mut out[a][b]);
            }
        }
        if D == 2 && self.kinematics == Kinematics::Axisymmetric {
            let mut radial = zero;
            for i in 0..turns::<N>() {
                radial += functions[i] * velocity[i][0];
            }
            (radial / cell.radius(xi)).store(&mut out[2][2]);
        }
    }
}

/// Σ N v.
#[inline(always)]
fn interpolate<S: Simd, const D: usize, const N: usize>(
    functions: &[Lanes<S>; N],
    values: &[[f64; D]; N],
    out: &mut [Pack; 3],
) {
    for a in 0..D {
        let mut sum = functions[0] * values[0][a];
        for i in 1..turns::<N>() {
            sum += functions[i] * values[i][a];
        }
        sum.store(&mut out[a]);
    }
}
