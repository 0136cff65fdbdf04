//! Integrals of one background cell over its material points: internal and body forces, and the
//! tangent of the updated Lagrangian displacement formulation (spec 03 §4-5).
//!
//! With u the nodal increments of the step, N and ∇₀N at the start of the step:
//!
//! - updated frame: f = I + Σ u ⊗ ∇₀N, F = f Fₙ, ∇N = ∇₀N f⁻¹, V = V₀ det F;
//! - total frame, ∇₀N taken at the first positions for ever: F = Fₙ + Σ u ⊗ ∇₀N, ∇N = ∇₀N F⁻¹;
//! - residual  R_ia = N_i m g_a − V Σ_b ∂_b N_i σ_ab;
//! - tangent   K_ia,jb = V (B_iᵀ c B_j)_ab + V (∇N_i · σ ∇N_j) δ_ab.

use super::kratos_faults::KratosFaults;
use crate::points::{Block, law_failure};
use crate::settings::Frame;
use bia_constitutive::{Deformation, Kinematics, Response, Want};
use bia_kernel::error::Failure;
use bia_kernel::geometry::PlacedBasis;
use bia_kernel::solving::CellBuffer;
use nalgebra::Matrix3;

/// Points whose law is asked in one call.
pub const CHUNK: usize = 8;
/// Voigt index of a pair of directions.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// The work on one cell, for the widest vectors that the machine has.
pub struct CellTask<'a, B, const D: usize, const N: usize> {
    /// What all cells share.
    pub integrator: &'a Integrator<'a>,
    /// Nodal values.
    pub state: &'a CellState<D, N>,
    /// Points: (block, point).
    pub points: &'a [(u32, u32)],
    /// Where the cell's matrix and vector go.
    pub buffer: &'a mut CellBuffer,
    /// Whether the matrix is wanted.
    pub with_matrix: bool,
    /// The functions.
    pub basis: B,
}

impl<B: PlacedBasis<D, N>, const D: usize, const N: usize> pulp::WithSimd for CellTask<'_, B, D, N> {
    type Output = Result<(), Failure>;

    // Everything that is inlined here is compiled for the instruction set. The order of sums is
    // that of the source, so their bits do not depend on it.
    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { integrator, basis, state, points, buffer, with_matrix } = self;
        match integrator.rule {
            Rule::EndPoint => integrator.cell(&basis, state, points, buffer, with_matrix),
            Rule::MidPoint => integrator.midpoint_cell(&basis, state, points, buffer, with_matrix),
        }
    }
}

/// Where in the step the internal forces are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// At its end.
    EndPoint,
    /// In its middle, such that energy is kept ([`super::midpoint`]).
    MidPoint,
}

/// What all cells of a step share.
pub struct Integrator<'a> {
    /// Blocks of points.
    pub blocks: &'a [Block],
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// Where functions are evaluated.
    pub frame: Frame,
    /// Where in the step the internal forces are taken.
    pub rule: Rule,
    /// Time step in seconds.
    pub time_step: f64,
    /// Which of Kratos's faults act.
    pub faults: KratosFaults,
    /// (1 - alpha) c0 of a consistent mass, none if lumped or without inertia.
    pub consistent_mass: Option<f64>,
}

/// Nodal values of a cell.
pub struct CellState<const D: usize, const N: usize> {
    /// Displacement increments.
    pub increments: [[f64; D]; N],
    /// (1 - alpha) a + alpha a0, read with a consistent mass only.
    pub inertia: [[f64; D]; N],
}

/// Shape functions and kinematics at one point.
pub struct PointKinematics<const D: usize, const N: usize> {
    /// Shape functions.
    pub functions: [f64; N],
    /// Gradients in the current configuration of the iterate: derivative by x_k of N_i at `[k][i]`.
    pub gradients: [[f64; N]; D],
    /// Deformation gradient of the iterate.
    pub gradient: Matrix3<f64>,
    /// Deformation gradient at the start of the step.
    pub previous: Matrix3<f64>,
    /// Current radius; 0 unless axisymmetric.
    pub radius: f64,
}

/// Kinematics and stresses of as many points as are asked together.
pub struct Answers<const D: usize, const N: usize> {
    /// Kinematics; none beyond the last point.
    pub kinematics: [Option<PointKinematics<D, N>>; CHUNK],
    /// What the law answers.
    pub responses: [Response; CHUNK],
}

impl<const D: usize, const N: usize> Default for Answers<D, N> {
    fn default() -> Self {
        Self { kinematics: [const { None }; CHUNK], responses: [Response::default(); CHUNK] }
    }
}

impl<const D: usize, const N: usize> PointKinematics<D, N> {
    /// Kinematics of a point under nodal increments.
    ///
    /// # Errors
    /// The increments turn the point's surroundings inside out.
    #[inline(always)]
    pub fn new<B: PlacedBasis<D, N>>(
        basis: &B,
        block: &Block,
        point: usize,
        (kinematics, frame): (Kinematics, Frame),
        increments: &[[f64; D]; N],
    ) -> Result<Self, Failure> {
        let xi = block.local.get::<D>(point);
        let functions = basis.functions(&xi);
        let reference = basis.physical_gradients(&xi);
        let previous = block.deformation_gradient(point);
        // The map from where the gradients are taken to the place of the iterate.
        let mut map = if frame == Frame::Total { previous } else { Matrix3::identity() };
        for i in 0..N {
            for a in 0..D {
                for b in 0..D {
                    map[(a, b)] += increments[i][a] * reference[i][b];
                }
            }
        }
        let inverse = match map.try_inverse() {
            Some(inverse) if map.determinant() > 0.0 => inverse,
            _ => {
                let before = if frame == Frame::Total { previous.determinant() } else { 1.0 };
                return Err(inverted(block, point, map.determinant() / before));
            }
        };
        let gradients =
            std::array::from_fn(|b| std::array::from_fn(|i| (0..D).map(|k| reference[i][k] * inverse[(k, b)]).sum()));
        let mut radius = 0.0;
        if kinematics == Kinematics::Axisymmetric {
            let start = basis.position(&xi, &functions)[0];
            let moved = (0..N).map(|i| functions[i] * increments[i][0]).sum::<f64>();
            let radius_before = if frame == Frame::Total { map[(2, 2)] * start } else { start };
            radius = radius_before + moved;
            map[(2, 2)] = radius / start;
        }
        let gradient = if frame == Frame::Total { map } else { map * previous };
        Ok(Self { functions, gradients, gradient, previous, radius })
    }
}

impl Integrator<'_> {
    /// Adds the points of one cell to its buffer.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    #[inline(always)]
    pub fn cell<B: PlacedBasis<D, N>, const D: usize, const N: usize>(
        &self,
        basis: &B,
        state: &CellState<D, N>,
        points: &[(u32, u32)],
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let want = if with_matrix { Want::StressAndTangent } else { Want::Stress };
        let mut answers = Answers::default();
        for run in points.chunk_by(|a, b| a.0 == b.0).flat_map(|run| run.chunks(CHUNK)) {
            let block = &self.blocks[run[0].0 as usize];
            self.answer(basis, run, &state.increments, None, want, &mut answers)?;
            for (k, &(_, point)) in run.iter().enumerate() {
                let (Some(at), response) = (&answers.kinematics[k], &answers.responses[k]) else { continue };
                let mass = block.mass.get::<1>(point as usize)[0];
                let volume = mass / block.density * at.gradient.determinant();
                let body = block.body_acceleration_of::<D>(point as usize).map(|b| mass * b);
                self.forces(D, &body, volume, at, response, &mut buffer.vector);
                if with_matrix {
                    self.tangent(D, volume, at, response, &mut buffer.matrix);
                }
                if let Some(factor) = self.consistent_mass {
                    consistent_inertia(D, mass, factor, state, &at.functions, buffer, with_matrix);
                }
            }
        }
        Ok(())
    }

    /// Kinematics of a few points of one block, and what its law answers; with the nodal pressures of
    /// the cell, if it has any; into `answers`, whose size does not bear to be moved about for each cell.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    #[inline(always)]
    pub fn answer<B: PlacedBasis<D, N>, const D: usize, const N: usize>(
        &self,
        basis: &B,
        run: &[(u32, u32)],
        increments: &[[f64; D]; N],
        pressures: Option<&[f64; N]>,
        want: Want,
        answers: &mut Answers<D, N>,
    ) -> Result<(), Failure> {
        let block = &self.blocks[run[0].0 as usize];
        let mut deformations = [Deformation::from_gradient(Matrix3::identity()); CHUNK];
        for (k, &(_, point)) in run.iter().enumerate() {
            let of_scene = (self.kinematics, self.frame);
            let at = PointKinematics::<D, N>::new(basis, block, point as usize, of_scene, increments)?;
            deformations[k].gradient = at.gradient;
            deformations[k].previous = at.previous;
            deformations[k].time_step = self.time_step;
            if let Some(pressures) = pressures {
                deformations[k].pressure = Some(at.functions.iter().zip(pressures).map(|(n, p)| n * p).sum());
            }
            answers.kinematics[k] = Some(at);
        }
        let mut states = gather_states(block, run);
        let count = run.len();
        block
            .law
            .respond(&deformations[..count], &mut states, &mut answers.responses[..count], want)
            .map_err(|(k, error)| law_failure(block, run[k].1 as usize, &deformations[k].gradient, &error))?;
        Ok(())
    }

    /// External minus internal forces of one point; `stride` numbers a node in the vector.
    #[inline(always)]
    pub fn forces<const D: usize, const N: usize>(
        &self,
        stride: usize,
        body: &[f64; D],
        volume: f64,
        at: &PointKinematics<D, N>,
        response: &Response,
        vector: &mut [f64],
    ) {
        for i in 0..N {
            for a in 0..D {
                let inner: f64 = (0..D).map(|b| at.gradients[b][i] * response.stress[VOIGT[a][b]]).sum();
                vector[i * stride + a] += at.functions[i] * body[a] - volume * inner;
            }
            if self.kinematics == Kinematics::Axisymmetric {
                vector[i * stride] -= volume * at.functions[i] / at.radius * response.stress[2];
            }
        }
    }

    /// Tangent of one point; `stride` dofs a node in the matrix. All inner loops run over the nodes of
    /// the cell: they are the lanes of the vectors.
    #[inline(always)]
    pub fn tangent<const D: usize, const N: usize>(
        &self,
        stride: usize,
        volume: f64,
        at: &PointKinematics<D, N>,
        response: &Response,
        matrix: &mut [f64],
    ) {
        let axisymmetric = self.kinematics == Kinematics::Axisymmetric;
        let mut hoop = [0.0; N];
        if axisymmetric {
            hoop = at.functions.map(|n| n / at.radius);
        }
        // Rows of c B that some Bᵀ needs: all of them in space, xx, yy, xy (and θθ) in the plane.
        let rows: &[usize] = if D == 3 { &[0, 1, 2, 3, 4, 5] } else { self.kinematics.voigt() };
        let mut product = [[[0.0; N]; D]; 6];
        for &s in rows {
            let c = &response.tangent[s];
            for b in 0..D {
                for k in 0..D {
                    add_scaled(&mut product[s][b], volume * c[VOIGT[b][k]], &at.gradients[k]);
                }
            }
            if axisymmetric {
                add_scaled(&mut product[s][0], volume * c[2], &hoop);
            }
        }
        let (cell_rows, _) = matrix.as_chunks_mut::<N>();
        for i in 0..N {
            let mut geometric = [0.0; N];
            for b in 0..D {
                let traction: f64 = (0..D).map(|a| at.gradients[a][i] * response.stress[VOIGT[a][b]]).sum();
                add_scaled(&mut geometric, volume * traction, &at.gradients[b]);
            }
            for a in 0..D {
                for b in 0..D {
                    let mut sum = cell_rows[(i * stride + a) * stride + b];
                    for k in 0..D {
                        add_scaled(&mut sum, at.gradients[k][i], &product[VOIGT[a][k]][b]);
                    }
                    if axisymmetric && a == 0 {
                        add_scaled(&mut sum, hoop[i], &product[2][b]);
                    }
                    if a == b {
                        add_scaled(&mut sum, 1.0, &geometric);
                    }
                    cell_rows[(i * stride + a) * stride + b] = sum;
                }
            }
            if axisymmetric {
                let pair = self.faults.hoop(at.functions, hoop);
                add_scaled(&mut cell_rows[i * stride * stride], volume * response.stress[2] * pair[i], &pair);
            }
        }
    }
}

/// `sum` += `factor` `other`.
#[inline(always)]
pub fn add_scaled<const N: usize>(sum: &mut [f64; N], factor: f64, other: &[f64; N]) {
    for j in 0..N {
        sum[j] += factor * other[j];
    }
}

/// R −= m N_i N_j b_j and K += (1 - alpha) c0 m N_i N_j; `stride` dofs a node.
pub fn consistent_inertia<const D: usize, const N: usize>(
    stride: usize,
    mass: f64,
    factor: f64,
    state: &CellState<D, N>,
    functions: &[f64; N],
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let size = N * stride;
    for i in 0..N {
        for j in 0..N {
            let share = mass * functions[i] * functions[j];
            for a in 0..D {
                buffer.vector[i * stride + a] -= share * state.inertia[j][a];
                if with_matrix {
                    buffer.matrix[(i * stride + a) * size + a * N + j] += factor * share;
                }
            }
        }
    }
}

/// A copy of the points' history: iterations must not change what the step started from.
pub fn gather_states(block: &Block, run: &[(u32, u32)]) -> Vec<f64> {
    if !block.state.is_used() {
        return Vec::new();
    }
    run.iter().flat_map(|&(_, point)| block.state.row(point as usize)).copied().collect()
}

fn inverted(block: &Block, point: usize, jacobian: f64) -> Failure {
    Failure::new(
        "the deformation of this step turns a material point inside out",
        "a smaller time step, smaller loads per step, or a finer grid",
    )
    .at(format!("material point {}", block.ids[point]), block.coordinates(point))
    .detail(format!("J of this step = {jacobian:e}"))
    .detail(format!("before this step: {}", block.describe(point)))
}
