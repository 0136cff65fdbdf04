//! Integrals of one background cell of the mixed formulation, whose nodes have displacement increments
//! and a pressure (spec 06 §1, §5).
//!
//! From the energy ∫ Ψ_dev + p (J − 1) − Ψ*(p) dV₀: beside the forces and the tangent of the
//! displacement formulation with the stress σ_dev + p I of the law,
//! - R_p,i = W N_i (p/κ − U), with W U = V₀ (J − 1);
//! - K_up = V ∂_a N_i N_j,  K_pu = V N_i ∂_b N_j (1 − [p/κ]),  K_pp = −W N_i N_j/κ,
//!
//! the bracket by Miehe's volumetric law only. K is minus the derivative of R.

use super::constants::Constants;
use super::{kratos, projected, subscales};
use crate::implicit::element::{
    Answers, CHUNK, CellState, Integrator, PointKinematics, add_scaled, consistent_inertia,
};
use bia_constitutive::Want;
use bia_constitutive::tensor::{displacement_gradient, tensor_of, volume_change};
use bia_kernel::error::Failure;
use bia_kernel::geometry::PlacedBasis;
use bia_kernel::solving::CellBuffer;

/// What is added to the Galerkin form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terms {
    /// Nothing.
    Galerkin,
    /// Projected pressures.
    Projected,
    /// Projected pressures with Kratos's matrix.
    KratosProjected,
    /// Subscales of displacement and pressure.
    Subscales,
    /// Subscales as in Kratos.
    KratosSubscales,
}

/// What all cells of a step share.
pub struct MixedIntegrator<'a> {
    /// That of the displacement formulation.
    pub base: Integrator<'a>,
    /// Constants of each block.
    pub constants: &'a [Constants],
    /// Stabilisation.
    pub terms: Terms,
}

/// Nodal values of a cell.
pub struct MixedState<const D: usize, const N: usize> {
    /// Of the displacement formulation.
    pub motion: CellState<D, N>,
    /// Weighted acceleration, for the residual of the subscales.
    pub acceleration: [[f64; D]; N],
    /// Pressures.
    pub pressures: [f64; N],
    /// Projected residuals.
    pub projection: [[f64; D]; N],
    /// Size of the cell in m.
    pub size: f64,
}

/// One point with what the rows of pressure need.
pub struct MixedPoint<'a, const D: usize, const N: usize> {
    /// Kinematics.
    pub at: &'a PointKinematics<D, N>,
    /// Constants of its block.
    pub constants: &'a Constants,
    /// Mass in kg.
    pub mass: f64,
    /// m b in N.
    pub body: [f64; D],
    /// Reference volume in m³.
    pub reference: f64,
    /// Current volume in m³.
    pub volume: f64,
    /// J − 1.
    pub change: f64,
    /// Pressure in Pa.
    pub pressure: f64,
    /// Its gradient in Pa/m.
    pub slope: [f64; D],
}

/// The work on one cell, for the widest vectors that the machine has.
pub struct MixedTask<'a, B, const D: usize, const N: usize, const DOFS: usize> {
    /// What all cells share.
    pub integrator: &'a MixedIntegrator<'a>,
    /// Nodal values.
    pub state: &'a MixedState<D, N>,
    /// Points: (block, point).
    pub points: &'a [(u32, u32)],
    /// Where the cell's matrix and vector go.
    pub buffer: &'a mut CellBuffer,
    /// Whether the matrix is wanted.
    pub with_matrix: bool,
    /// The functions.
    pub basis: B,
}

impl<B: PlacedBasis<D, N>, const D: usize, const N: usize, const DOFS: usize> pulp::WithSimd
    for MixedTask<'_, B, D, N, DOFS>
{
    type Output = Result<(), Failure>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { integrator, basis, state, points, buffer, with_matrix } = self;
        integrator.cell::<B, D, N, DOFS>(&basis, state, points, buffer, with_matrix)
    }
}

impl<'a, const D: usize, const N: usize> MixedPoint<'a, D, N> {
    /// Of a point with these kinematics in a cell with these pressures; `body` is the force per mass.
    #[inline(always)]
    pub fn new(
        at: &'a PointKinematics<D, N>,
        constants: &'a Constants,
        (mass, density): (f64, f64),
        body: [f64; D],
        pressures: &[f64; N],
    ) -> Self {
        let reference = mass / density;
        let sum = |weights: &[f64; N]| weights.iter().zip(pressures).map(|(n, p)| n * p).sum::<f64>();
        Self {
            at,
            constants,
            mass,
            body: body.map(|b| mass * b),
            reference,
            volume: reference * at.gradient.determinant(),
            change: volume_change(&tensor_of(&displacement_gradient(&at.gradient))),
            pressure: sum(&at.functions),
            slope: std::array::from_fn(|a| sum(&at.gradients[a])),
        }
    }

    /// Volume ratio J.
    #[inline(always)]
    pub fn jacobian(&self) -> f64 {
        1.0 + self.change
    }
}

impl MixedIntegrator<'_> {
    /// Adds the points of one cell to its buffer; `DOFS` is `D` + 1.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    #[inline(always)]
    fn cell<B: PlacedBasis<D, N>, const D: usize, const N: usize, const DOFS: usize>(
        &self,
        basis: &B,
        state: &MixedState<D, N>,
        points: &[(u32, u32)],
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let want = if with_matrix { Want::StressAndTangent } else { Want::Stress };
        let mut answers = Answers::default();
        for run in points.chunk_by(|a, b| a.0 == b.0).flat_map(|run| run.chunks(CHUNK)) {
            let index = run[0].0 as usize;
            let block = &self.base.blocks[index];
            self.base.answer(basis, run, &state.motion.increments, Some(&state.pressures), want, &mut answers)?;
            for (k, &(_, point)) in run.iter().enumerate() {
                let (Some(at), response) = (&answers.kinematics[k], &answers.responses[k]) else { continue };
                let mass = block.mass.get::<1>(point as usize)[0];
                let body = block.body_acceleration_of::<D>(point as usize);
                let point = MixedPoint::new(at, &self.constants[index], (mass, block.density), body, &state.pressures);
                self.base.forces(DOFS, &point.body, point.volume, at, response, &mut buffer.vector);
                if with_matrix {
                    self.base.tangent(DOFS, point.volume, at, response, &mut buffer.matrix);
                }
                if let Some(factor) = self.base.consistent_mass {
                    consistent_inertia(DOFS, mass, factor, &state.motion, &at.functions, buffer, with_matrix);
                }
                self.pressure_terms::<D, N, DOFS>(&point, state, buffer, with_matrix);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn pressure_terms<const D: usize, const N: usize, const DOFS: usize>(
        &self,
        point: &MixedPoint<D, N>,
        state: &MixedState<D, N>,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) {
        let share = match self.terms {
            Terms::Subscales | Terms::Projected => subscales::galerkin_share(point.constants, state.size),
            _ => 1.0,
        };
        galerkin::<D, N, DOFS>(point, share, buffer, with_matrix);
        match self.terms {
            Terms::Galerkin => {}
            Terms::Projected => {
                subscales::add_pressure::<D, N, DOFS>(point, state.size, buffer, with_matrix);
                projected::add::<D, N, DOFS>(point, state, buffer, with_matrix);
            }
            Terms::KratosProjected => kratos::add_projected::<D, N, DOFS>(point, state, buffer, with_matrix),
            Terms::Subscales => subscales::add::<D, N, DOFS>(point, state, buffer, with_matrix),
            Terms::KratosSubscales => kratos::add_subscales::<D, N, DOFS>(point, state, buffer, with_matrix),
        }
    }
}

/// Rows of pressure and its forces on displacements, multiplied by a share.
#[inline(always)]
fn galerkin<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    share: f64,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let (at, moduli) = (point.at, &point.constants.moduli);
    let relative = moduli.compressibility * point.pressure;
    let weight = share * point.reference * moduli.volumetric.weight(point.jacobian());
    let defect = weight * relative - share * point.reference * point.change;
    for i in 0..N {
        buffer.vector[i * DOFS + D] += at.functions[i] * defect;
    }
    if !with_matrix {
        return;
    }
    let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
    let coupling = share * point.volume;
    let back = coupling * (1.0 - moduli.volumetric.coupling(relative));
    for i in 0..N {
        for a in 0..D {
            add_scaled(&mut rows[(i * DOFS + a) * DOFS + D], coupling * at.gradients[a][i], &at.functions);
        }
        let row = (i * DOFS + D) * DOFS;
        for b in 0..D {
            add_scaled(&mut rows[row + b], back * at.functions[i], &at.gradients[b]);
        }
        add_scaled(&mut rows[row + D], -weight * moduli.compressibility * at.functions[i], &at.functions);
    }
}
