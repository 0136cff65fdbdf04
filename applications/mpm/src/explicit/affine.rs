//! Velocities that points carry with an affine part: what it adds to the momentum of the grid, and its
//! moments out of the grid's velocity.

use super::cells::{Cell, CellOf};
use super::kinematics::inverse as invert;
use super::rows::Rows;
use super::sample::Affine;
use super::to_grid::Cells;
use crate::grid::vectors_of;
use crate::points::Block;
use crate::settings::Frame;
use crate::space::Space;
use bia_constitutive::tensor::Tensor;
use bia_kernel::geometry::CellBasis;
use bia_kernel::lanes::{Lanes, Pack, Real, WIDTH, turns};
use pulp::Simd;

/// Share of the spread of a cell's nodes about a point that is added to it, so that it has an inverse.
const TINY: f64 = f64::EPSILON;

/// An affine velocity field about points.
struct AffineField<S: Simd, const D: usize, const N: usize> {
    /// From the point to each node.
    lever: [[Lanes<S>; D]; N],
    gradient: [[Lanes<S>; D]; D],
}

/// Present places of a cell's nodes: their anchors, displaced in the total frame.
fn places<const D: usize, const N: usize>(
    space: &Space,
    cell: usize,
    numbers: &[u32],
    displacement: &[f64],
) -> [[f64; D]; N] {
    let mut places = space.corners::<D, N>(cell);
    let mut of_nodes = [0; N];
    for (of_node, &number) in of_nodes.iter_mut().zip(numbers) {
        *of_node = number as usize;
    }
    let moved = vectors_of::<D, N>(&of_nodes, displacement);
    for i in 0..turns::<N>() {
        for a in 0..D {
            places[i][a] += moved[i][a];
        }
    }
    places
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

/// [`Cells::add_affine`] on the machine's vectors.
struct AddAffine<'a, 'c, 's, B, const D: usize, const N: usize> {
    cells: &'c mut Cells<'a, 's, B, D, N>,
    cell: &'c Cell<B, D, N>,
    id: usize,
    block: &'c Block,
    rows: Rows,
    places: &'c [u32],
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cells<'a, '_, B, D, N> {
    /// Adds the momentum that the affine part of the points' velocities gives the nodes.
    #[inline(never)]
    pub(super) fn add_affine<S: Simd>(
        &mut self,
        simd: S,
        cell: &Cell<B, D, N>,
        id: usize,
        block: &Block,
        rows: Rows,
        places: &[u32],
    ) {
        simd.vectorize(AddAffine { cells: self, cell, id, block, rows, places });
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> pulp::WithSimd for AddAffine<'a, '_, '_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { cell, block, rows, .. } = self;
        let [mass] = rows.load::<S, 1>(simd, block.mass.values());
        let mass = mass * rows.counts(simd);
        let position = rows.load::<S, D>(simd, block.position.values());
        let xi = if cell.is_stored() { rows.load(simd, block.local.values()) } else { cell.local(&position) };
        let functions = cell.basis.functions(&xi);
        let AffineField { lever, gradient } = self.field(simd, &xi, position, &functions);
        for i in 0..turns::<N>() {
            let share = functions[i] * mass;
            for a in 0..D {
                let mut velocity = gradient[a][0] * lever[i][0];
                for b in 1..D {
                    velocity += gradient[a][b] * lever[i][b];
                }
                self.cells.sums[self.places[i] as usize].0[1 + a] += (share * velocity).sum();
            }
        }
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> AddAffine<'a, '_, '_, B, D, N> {
    /// The affine field about points: C = B D⁻¹, D = Σ N (x_i − x_p) ⊗ (x_i − x_p), from the moments B,
    /// or the gradient that is kept.
    #[inline(always)]
    fn field<S: Simd>(
        &self,
        simd: S,
        xi: &[Lanes<S>; D],
        mut position: [Lanes<S>; D],
        functions: &[Lanes<S>; N],
    ) -> AffineField<S, D, N> {
        let gather = self.cells.gather;
        let moments = gather.affine == Affine::Moments;
        let displacement = if moments { gather.displacement } else { &[] };
        let numbers = gather.patches.numbers(gather.space, self.id);
        let places = places::<D, N>(gather.space, self.id, numbers, displacement);
        let zero = Lanes::splat(simd, 0.0);
        let kept = load_tensor::<S, D>(simd, self.rows, self.block.transfer.values());
        if !moments && gather.frame == Frame::Total {
            // The gradient is with respect to the first places.
            position = self.cell.basis.position(xi, functions);
        }
        let (mut lever, mut spread) = ([[zero; D]; N], [[zero; 3]; 3]);
        for i in 0..turns::<N>() {
            for a in 0..D {
                lever[i][a] = zero + places[i][a] - position[a];
            }
            for a in 0..D {
                for b in 0..D {
                    spread[a][b] += functions[i] * lever[i][a] * lever[i][b];
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
}

/// Σ N v ⊗ (x_i − x_p) at points in step, present places, x_p = Σ N x_i.
pub(super) struct Moments<'a, B, const D: usize, const N: usize> {
    /// The functions.
    pub(super) basis: &'a B,
    /// The space and the cell in it.
    pub(super) cell: (&'a Space, usize),
    /// Active numbers of the cell's nodes.
    pub(super) numbers: &'a [u32],
    /// Velocity and displacement of the nodes.
    pub(super) fields: [&'a [f64]; 2],
    /// Local coordinates of the points.
    pub(super) xi: [Pack; D],
    /// Where the moments go.
    pub(super) out: &'a mut Tensor<Pack>,
}

impl<B: CellBasis<D, N>, const D: usize, const N: usize> Moments<'_, B, D, N> {
    /// Finds the moments.
    #[inline(never)]
    pub(super) fn find<S: Simd>(self, simd: S) {
        simd.vectorize(self);
    }
}

impl<B: CellBasis<D, N>, const D: usize, const N: usize> pulp::WithSimd for Moments<'_, B, D, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Moments { basis, cell: (space, cell), numbers, fields: [velocity, displacement], xi, out } = self;
        let places = places::<D, N>(space, cell, numbers, displacement);
        let zero = Lanes::splat(simd, 0.0);
        let (mut at, mut position) = ([zero; D], [zero; D]);
        for a in 0..D {
            at[a] = Lanes::load(simd, &xi[a]);
        }
        let functions = basis.functions(&at);
        for i in 0..turns::<N>() {
            for a in 0..D {
                position[a] += functions[i] * places[i][a];
            }
        }
        for b in 0..D {
            let mut column = [position[0].constant(0.0); D];
            for i in 0..turns::<N>() {
                let lever = functions[i] * (position[b].constant(places[i][b]) - position[b]);
                for a in 0..D {
                    column[a] += lever * velocity[numbers[i] as usize * D + a];
                }
            }
            for a in 0..D {
                column[a].store(&mut out[a][b]);
            }
        }
    }
}
