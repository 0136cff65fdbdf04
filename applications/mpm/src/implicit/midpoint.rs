//! Integrals of one background cell for the energy-conserving mid-point rule in the total frame.
//!
//! With F₀, F₁ at the start and the end of the step, F̄ = (F₀ + F₁)/2, E = ½(FᵀF − I) and
//! ΔE = E₁ − E₀, the second Piola–Kirchhoff stress is the discrete gradient of the energy W
//! (Gonzalez 2000, eq. 3.8)
//!
//! S* = S(Ē) + q ΔE,  q = (W₁ − W₀ − S(Ē) : ΔE)/(ΔE : ΔE),  Ē = (E₀ + E₁)/2,
//!
//! for which S* : ΔE = W₁ − W₀. The forces −Σ V₀ F̄ S* ∇N then take from the points, over the step,
//! exactly the work that they store; in one dimension F̄ S* is the quotient (W₁ − W₀)/(F₁ − F₀).
//!
//! The tangent is the exact one, ∂P*/∂F₁ = ½ δ S* + F̄ ℂ* F₁ᵀ with
//! ℂ* = ½ℂ + q 𝕀 + ΔE ⊗ (S(E₁) − S(Ē) − ½ℂ : ΔE − 2q ΔE)/(ΔE : ΔE), which is not symmetric; beside
//! what [`SAME`] changes.

use super::element::{CHUNK, CellState, Integrator, consistent_inertia, gather_states};
use crate::points::{Block, law_failure};
use bia_constitutive::tensor::stress_from_voigt;
use bia_constitutive::{Deformation, Kinematics, Law, LawError, Response, Tangent, Voigt, Want};
use bia_kernel::error::Failure;
use bia_kernel::geometry::PlacedBasis;
use bia_kernel::solving::CellBuffer;
use nalgebra::{Matrix3, Matrix6, Vector6};

/// δ: q is taken with s/(s² + δ⁴) for 1/s, s = ΔE : ΔE. Where |ΔE| is less than δ, the rounding of W
/// would be divided by |ΔE|, up to 1/δ; without q the energy of such a step is wrong by |ΔE|³/24 moduli at most.
pub(super) const SAME: f64 = 2e-5;

/// Voigt indices as pairs.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
/// Voigt index of a pair.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// One point in the step.
struct Step<const D: usize, const N: usize> {
    functions: [f64; N],
    /// ∂N_i/∂X_k at `[k][i]`.
    gradients: [[f64; N]; D],
    /// N_i/R; zero unless axisymmetric.
    hoop: [f64; N],
    start: Matrix3<f64>,
    end: Matrix3<f64>,
}

impl<const D: usize, const N: usize> Step<D, N> {
    #[inline(always)]
    fn new<B: PlacedBasis<D, N>>(
        basis: &B,
        block: &Block,
        point: usize,
        kinematics: Kinematics,
        increments: &[[f64; D]; N],
    ) -> Self {
        let xi = block.local.get::<D>(point);
        let functions = basis.functions(&xi);
        let by_function = basis.physical_gradients(&xi);
        let gradients: [[f64; N]; D] = std::array::from_fn(|k| std::array::from_fn(|i| by_function[i][k]));
        let start = block.deformation_gradient(point);
        let mut end = start;
        for a in 0..D {
            for k in 0..D {
                end[(a, k)] += (0..N).map(|i| increments[i][a] * gradients[k][i]).sum::<f64>();
            }
        }
        let mut hoop = [0.0; N];
        if kinematics == Kinematics::Axisymmetric {
            let radius = basis.position(&xi, &functions)[0];
            hoop = functions.map(|n| n / radius);
            end[(2, 2)] += (0..N).map(|i| increments[i][0] * hoop[i]).sum::<f64>();
        }
        Self { functions, gradients, hoop, start, end }
    }

    fn middle(&self) -> Matrix3<f64> {
        0.5 * (self.start + self.end)
    }

    /// A deformation with the strain Ē: F̂ᵀF̂ = (C₀ + C₁)/2. The law must not see F̄, which is
    /// stretched where the step is a rotation.
    fn mean(&self) -> Option<Matrix3<f64>> {
        let mean = 0.5 * (self.start.tr_mul(&self.start) + self.end.tr_mul(&self.end));
        Some(mean.cholesky()?.l().transpose())
    }
}

/// S* and ℂ*.
struct Algorithmic {
    stress: Matrix3<f64>,
    tangent: Matrix6<f64>,
}

/// The law's answers in one step of a point: at the mean strain and at the end.
struct Answers<'a> {
    law: &'a dyn Law,
    mean: (&'a Matrix3<f64>, &'a Response),
    at_end: &'a Voigt,
}

impl Answers<'_> {
    #[inline(always)]
    fn algorithmic<const D: usize, const N: usize>(&self, step: &Step<D, N>, with_matrix: bool) -> Algorithmic {
        let (mean, response) = self.mean;
        let (start, end) = (&step.start, &step.end);
        let mut stress = pulled_back(mean, &response.stress);
        let difference = 0.5 * (end.tr_mul(end) - start.tr_mul(start));
        let square = difference.dot(&difference);
        let sum = square * square + SAME.powi(4);
        let share = square / sum;
        let mut tangent =
            if with_matrix { 0.5 * pulled_back_tangent(mean, &response.tangent) } else { Matrix6::zeros() };
        let energy = |f: &Matrix3<f64>| self.law.energy(&Deformation::from_gradient(*f)).unwrap_or(f64::NAN);
        let missing = energy(end) - energy(start) - stress.dot(&difference);
        let quotient = share * missing;
        if with_matrix {
            // As a linear form on strains, shear halves counted twice.
            let strain = Vector6::from_iterator(PAIRS.iter().map(|&(a, b)| weight(a, b) * difference[(a, b)]));
            let half = stress_from_voigt(&(tangent * strain).into());
            let by_share = 2.0 * missing * (SAME.powi(4) - square * square) / (sum * sum);
            let form = share * (pulled_back(end, self.at_end) - stress - half) + by_share * difference;
            for (i, &(a, b)) in PAIRS.iter().enumerate() {
                for (j, &(c, d)) in PAIRS.iter().enumerate() {
                    tangent[(i, j)] += difference[(a, b)] * form[(c, d)];
                }
                tangent[(i, i)] += quotient / weight(a, b);
            }
        }
        stress += quotient * difference;
        Algorithmic { stress, tangent }
    }
}

/// How often a component stands in a symmetric tensor.
fn weight(a: usize, b: usize) -> f64 {
    if a == b { 1.0 } else { 2.0 }
}

/// S = J F⁻¹ σ F⁻ᵀ.
#[inline(always)]
fn pulled_back(f: &Matrix3<f64>, stress: &Voigt) -> Matrix3<f64> {
    let inverse = f.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    f.determinant() * inverse * stress_from_voigt(stress) * inverse.transpose()
}

/// ℂ_ABCD = J F⁻¹_Aa F⁻¹_Bb F⁻¹_Cc F⁻¹_Dd c_abcd.
#[inline(always)]
fn pulled_back_tangent(f: &Matrix3<f64>, tangent: &Tangent) -> Matrix6<f64> {
    let inverse = f.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    let map = Matrix6::from_fn(|i, p| {
        let ((a, b), (c, d)) = (PAIRS[i], PAIRS[p]);
        let one = inverse[(a, c)] * inverse[(b, d)];
        if c == d { one } else { one + inverse[(a, d)] * inverse[(b, c)] }
    });
    f.determinant() * map * Matrix6::from_fn(|p, q| tangent[p][q]) * map.transpose()
}

impl Integrator<'_> {
    /// Adds the points of one cell to its buffer.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    #[inline(always)]
    pub fn midpoint_cell<B: PlacedBasis<D, N>, const D: usize, const N: usize>(
        &self,
        basis: &B,
        state: &CellState<D, N>,
        points: &[(u32, u32)],
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let mut steps: Vec<Step<D, N>> = Vec::with_capacity(CHUNK);
        for run in points.chunk_by(|a, b| a.0 == b.0).flat_map(|run| run.chunks(CHUNK)) {
            let block = &self.blocks[run[0].0 as usize];
            let of_point =
                |&(_, point): &(u32, u32)| Step::new(basis, block, point as usize, self.kinematics, &state.increments);
            steps.clear();
            steps.extend(run.iter().map(of_point));
            let failed = |(k, error): (usize, LawError)| law_failure(block, run[k].1 as usize, &steps[k].end, &error);
            let mut means = [Deformation::from_gradient(Matrix3::identity()); CHUNK];
            let mut ends = means;
            for (k, step) in steps.iter().enumerate() {
                // A negative determinant of F̂ cannot be; one of F₁ the law refuses.
                means[k].gradient = step.mean().unwrap_or(step.end);
                ends[k].gradient = step.end;
            }
            let (count, mut responses, mut at_end) = (run.len(), [Response::default(); CHUNK], [[0.0; 6]; CHUNK]);
            let want = if with_matrix { Want::StressAndTangent } else { Want::Stress };
            let mut states = gather_states(block, run);
            let mean = block.law.respond(&means[..count], &mut states, &mut responses[..count], want);
            mean.map_err(failed)?;
            let end = block.law.stresses(&ends[..count], &mut states, &mut at_end[..count]);
            end.map_err(failed)?;
            for (k, (step, &(_, point))) in steps.iter().zip(run).enumerate() {
                let mass = block.mass.get::<1>(point as usize)[0];
                let body = block.body_acceleration_of::<D>(point as usize).map(|b| mass * b);
                let law = block.law.as_ref();
                let answers = Answers { law, mean: (&means[k].gradient, &responses[k]), at_end: &at_end[k] };
                let algorithmic = answers.algorithmic(step, with_matrix);
                self.add_midpoint(mass / block.density, &body, step, &algorithmic, buffer, with_matrix);
                if let Some(factor) = self.consistent_mass {
                    consistent_inertia(D, mass, factor, state, &step.functions, buffer, with_matrix);
                }
            }
        }
        Ok(())
    }

    /// Forces and tangent of one point, over the components (a, K) of F that depend on the nodes.
    #[inline(always)]
    fn add_midpoint<const D: usize, const N: usize>(
        &self,
        volume: f64,
        body: &[f64; D],
        step: &Step<D, N>,
        algorithmic: &Algorithmic,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) {
        let middle = step.middle();
        let stress = volume * middle * algorithmic.stress;
        // (a, K, dof component, its row of the operator); the hoop stretch moves with the radius.
        let plane = (0..D).flat_map(|a| (0..D).map(move |k| (a, k, a)));
        let hoop = (self.kinematics == Kinematics::Axisymmetric).then_some((2, 2, 0));
        let components = || plane.clone().chain(hoop);
        let row = |k: usize, is_hoop: bool| if is_hoop { &step.hoop } else { &step.gradients[k] };
        for i in 0..N {
            for a in 0..D {
                buffer.vector[i * D + a] += step.functions[i] * body[a];
            }
        }
        let is_hoop = |a: usize| a >= D;
        for (a, k, component) in components() {
            let operator = row(k % D, is_hoop(a));
            for i in 0..N {
                buffer.vector[i * D + component] -= stress[(a, k)] * operator[i];
            }
        }
        if !with_matrix {
            return;
        }
        let (cell_rows, _) = buffer.matrix.as_chunks_mut::<N>();
        for (a, k, component) in components() {
            let mut products = [[0.0; N]; D];
            for (b, l, other) in components() {
                let entry = volume * two_point(algorithmic, &middle, &step.end, [a, k, b, l]);
                let operator = row(l % D, is_hoop(b));
                (0..N).for_each(|j| products[other][j] += entry * operator[j]);
            }
            let operator = row(k % D, is_hoop(a));
            for i in 0..N {
                for (b, product) in products.iter().enumerate() {
                    let sum = &mut cell_rows[(i * D + component) * D + b];
                    (0..N).for_each(|j| sum[j] += operator[i] * product[j]);
                }
            }
        }
    }
}

/// ∂P*_aK/∂F₁_bL = ½ δ_ab S*_KL + F̄_aM ℂ*_MKCL F₁_bC.
#[inline(always)]
fn two_point(of: &Algorithmic, middle: &Matrix3<f64>, end: &Matrix3<f64>, [a, k, b, l]: [usize; 4]) -> f64 {
    let mut sum = if a == b { 0.5 * of.stress[(k, l)] } else { 0.0 };
    for m in 0..3 {
        for c in 0..3 {
            sum += middle[(a, m)] * of.tangent[(VOIGT[m][k], VOIGT[c][l])] * end[(b, c)];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::tensor::stress_to_voigt;
    use bia_constitutive::{LameParameters, NeoHookean};

    /// P* for given F₀ and F₁, and ∂P*/∂F₁.
    fn answer(start: Matrix3<f64>, end: Matrix3<f64>) -> (Matrix3<f64>, Algorithmic, f64) {
        let law: Box<dyn Law> = Box::new(NeoHookean::from_lame(LameParameters { lambda: 3.0, mu: 2.0 }));
        let step = Step::<3, 1> { functions: [0.0], gradients: [[0.0]; 3], hoop: [0.0], start, end };
        let mean = step.mean().unwrap();
        let (mut responses, mut at_end) = ([Response::default()], [[0.0; 6]]);
        law.respond(&[Deformation::from_gradient(mean)], &mut [], &mut responses, Want::StressAndTangent).unwrap();
        law.stresses(&[Deformation::from_gradient(end)], &mut [], &mut at_end).unwrap();
        let answers = Answers { law: law.as_ref(), mean: (&mean, &responses[0]), at_end: &at_end[0] };
        let algorithmic = answers.algorithmic(&step, true);
        let energy = |f: Matrix3<f64>| law.energy(&Deformation::from_gradient(f)).unwrap();
        (step.middle() * algorithmic.stress, algorithmic, energy(end) - energy(start))
    }

    fn gradients() -> [Matrix3<f64>; 2] {
        let start = Matrix3::new(1.1, 0.2, 0.0, -0.1, 0.9, 0.1, 0.05, 0.0, 1.05);
        let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::y_axis(), 0.7);
        [start, turn.matrix() * Matrix3::new(1.2, 0.1, 0.1, -0.2, 1.1, 0.0, 0.0, 0.1, 0.8)]
    }

    #[test]
    fn the_stress_works_what_the_energy_gains() {
        let [start, end] = gradients();
        let (stress, _, gain) = answer(start, end);
        assert!((stress.dot(&(end - start)) - gain).abs() < 1e-10 * gain.abs(), "{gain}");
        // A rotation needs no stress beside that which turns with it.
        let turned = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), 1.0).matrix() * start;
        let (_, of, gain) = answer(start, turned);
        let (_, at_start, _) = answer(start, start);
        assert!(gain.abs() < 1e-14 && (of.stress - at_start.stress).norm() < 1e-13);
    }

    #[test]
    fn the_tangent_is_the_derivative() {
        let [start, end] = gradients();
        for end in [end, start + 1e-3 * end] {
            let (_, algorithmic, _) = answer(start, end);
            let h = 1e-6;
            for b in 0..3 {
                for l in 0..3 {
                    let moved = |by: f64| {
                        let mut end = end;
                        end[(b, l)] += by;
                        answer(start, end).0
                    };
                    let difference = (moved(h) - moved(-h)) / (2.0 * h);
                    for a in 0..3 {
                        for k in 0..3 {
                            let middle = 0.5 * (start + end);
                            let exact = two_point(&algorithmic, &middle, &end, [a, k, b, l]);
                            assert!((difference[(a, k)] - exact).abs() < 1e-7, "{a}{k}{b}{l} {exact}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn voigt_pairs_agree() {
        let tensor = Matrix3::new(1.0, 4.0, 6.0, 4.0, 2.0, 5.0, 6.0, 5.0, 3.0);
        let voigt = stress_to_voigt(&tensor);
        for (i, &(a, b)) in PAIRS.iter().enumerate() {
            assert_eq!((voigt[i], VOIGT[a][b]), (tensor[(a, b)], i));
        }
    }
}
