//! Materials as cells use them: first Piola–Kirchhoff stress Π from the displacement gradient H = F − 1,
//! and impedances of waves along a normal N,
//!
//! Z = (ρ₀ A)^½,  A_ij = N_a ∂Π_ia/∂F_jb N_b  (the acoustic tensor),
//!
//! whose eigenvalues are ρ₀ times the speeds of the waves. At small strain the law is replaced by Hooke's
//! law with its tangent in the undeformed state, Π = σ = λ tr H 1 + μ (H + Hᵀ).

use crate::matrix::{Matrix, Vector, square_root};
use bia_constitutive::{Deformation, Law, LawError, Response, Voigt, Want};
use nalgebra::Matrix3;

/// Points that a law answers for at once.
const BATCH: usize = 16;

/// Hooke's law in `D` dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hooke {
    /// λ (Pa); in one dimension the whole modulus.
    pub lambda: f64,
    /// μ (Pa); 0 in one dimension.
    pub mu: f64,
    /// Stress across the plane over the trace of the strain in it (Pa).
    pub across: f64,
}

/// A material.
pub struct Material {
    /// Id of its properties.
    pub id: u32,
    /// Name of its law in the materials file.
    pub name: String,
    /// Mass per reference volume (kg/m³).
    pub density: f64,
    /// Extent across the mesh: thickness (m), cross area (m²) or 1.
    pub extent: f64,
    /// The law, linearised in the undeformed state.
    pub hooke: Hooke,
    /// The law at finite strain; none at small strain.
    pub law: Option<Box<dyn Law>>,
}

/// Why a law cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub enum Unsuitable {
    /// It has no answer in the undeformed state.
    NoAnswer(LawError),
    /// Its tangent there is not isotropic, or not positive.
    Tangent,
    /// It keeps a history, which stages at nodes would need too.
    History,
}

/// The deformation of a displacement gradient, embedded in space.
fn deformation<const D: usize>(gradient: &Matrix<D>) -> Deformation {
    let mut full = Matrix3::identity();
    for i in 0..D {
        for a in 0..D {
            full[(i, a)] += gradient[i][a];
        }
    }
    Deformation::from_gradient(full)
}

/// F⁻¹ and J of the components in the space of the mesh.
#[inline]
fn inverse_and_volume<const D: usize>(gradient: &Matrix<D>) -> (Matrix<D>, f64) {
    let mut full = *gradient;
    (0..D).for_each(|i| full[i][i] += 1.0);
    let (mut inverse, volume) = bia_kernel::geometry::adjugate(&full);
    inverse.as_flattened_mut().iter_mut().for_each(|entry| *entry /= volume);
    (inverse, volume)
}

/// Index of a pair of axes in Voigt's order xx, yy, zz, xy, yz, xz.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

impl Hooke {
    /// The law's tangent in the undeformed state.
    ///
    /// # Errors
    /// It has none, or none that is isotropic and positive.
    pub fn of(law: &dyn Law, dimension: usize) -> Result<Self, Unsuitable> {
        let mut state = vec![0.0; law.state_len()];
        law.initial_state(&mut state);
        let mut answer = [Response::default()];
        let undeformed = [Deformation::from_gradient(Matrix3::identity())];
        law.respond(&undeformed, &mut state, &mut answer, Want::StressAndTangent)
            .map_err(|(_, error)| Unsuitable::NoAnswer(error))?;
        let c = answer[0].tangent;
        if dimension == 1 {
            let across = c[1][0];
            let positive = c[0][0] > 0.0;
            return positive.then_some(Self { lambda: c[0][0], mu: 0.0, across }).ok_or(Unsuitable::Tangent);
        }
        let (lambda, mu) = (c[0][1], c[3][3]);
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * c[0][0].abs();
        let isotropic = close(c[0][0], lambda + 2.0 * mu)
            && close(c[1][1], c[0][0])
            && close(c[1][0], lambda)
            && (dimension == 2 || close(c[2][2], c[0][0]) && close(c[4][4], mu) && close(c[5][5], mu));
        let positive = mu > 0.0 && lambda + 2.0 * mu > 0.0;
        (isotropic && positive).then_some(Self { lambda, mu, across: c[2][0] }).ok_or(Unsuitable::Tangent)
    }

    /// Stress of a displacement gradient.
    #[inline(always)]
    pub fn stress<const D: usize>(&self, gradient: &Matrix<D>) -> Matrix<D> {
        let mut trace = 0.0;
        for i in 0..D {
            trace += gradient[i][i];
        }
        let mut stress = [[0.0; D]; D];
        for i in 0..D {
            for a in 0..D {
                stress[i][a] = self.mu * (gradient[i][a] + gradient[a][i]);
            }
            stress[i][i] += self.lambda * trace;
        }
        stress
    }

    /// Speeds of pressure and shear waves (m/s).
    pub fn speeds(&self, density: f64) -> [f64; 2] {
        [((self.lambda + 2.0 * self.mu) / density).sqrt(), (self.mu / density).sqrt()]
    }

    /// ρ₀ (c₁ N ⊗ N + c₂ (1 − N ⊗ N)).
    pub fn impedance<const D: usize>(&self, density: f64, normal: &Vector<D>) -> Matrix<D> {
        let [fast, slow] = self.speeds(density).map(|speed| density * speed);
        let mut impedance = [[0.0; D]; D];
        for i in 0..D {
            for j in 0..D {
                impedance[i][j] = (fast - slow) * normal[i] * normal[j];
            }
            impedance[i][i] += slow;
        }
        impedance
    }
}

impl Material {
    /// Fastest wave in the undeformed material (m/s).
    pub fn wave_speed(&self) -> f64 {
        self.hooke.speeds(self.density)[0]
    }

    /// Stresses of displacement gradients.
    ///
    /// # Errors
    /// The first place without an answer, and why.
    pub fn stresses<const D: usize>(
        &self,
        gradients: &[Matrix<D>],
        out: &mut [Matrix<D>],
    ) -> Result<(), (usize, LawError)> {
        let Some(law) = &self.law else {
            for (gradient, stress) in gradients.iter().zip(out) {
                *stress = self.hooke.stress(gradient);
            }
            return Ok(());
        };
        let mut deformations = [Deformation::from_gradient(Matrix3::identity()); BATCH];
        let mut cauchy: [Voigt; BATCH] = [[0.0; 6]; BATCH];
        for (batch, (gradients, out)) in gradients.chunks(BATCH).zip(out.chunks_mut(BATCH)).enumerate() {
            let count = gradients.len();
            for (to, gradient) in deformations.iter_mut().zip(gradients) {
                *to = deformation(gradient);
            }
            law.stresses(&deformations[..count], &mut [], &mut cauchy[..count])
                .map_err(|(point, error)| (batch * BATCH + point, error))?;
            for ((gradient, stress), cauchy) in gradients.iter().zip(out).zip(&cauchy) {
                *stress = first_piola_kirchhoff(cauchy, gradient);
            }
        }
        Ok(())
    }

    /// Strain energy per reference volume (J/m³), where the law has one.
    pub fn energy<const D: usize>(&self, gradient: &Matrix<D>) -> Option<f64> {
        match &self.law {
            Some(law) => law.energy(&deformation(gradient)),
            None => {
                let stress = self.hooke.stress(gradient);
                let both = stress.as_flattened().iter().zip(gradient.as_flattened());
                Some(0.5 * both.map(|(s, h)| s * h).sum::<f64>())
            }
        }
    }

    /// Cauchy stress with the components across the mesh.
    ///
    /// # Errors
    /// The law has no answer.
    pub fn cauchy<const D: usize>(&self, gradient: &Matrix<D>) -> Result<Voigt, LawError> {
        if let Some(law) = &self.law {
            let mut out = [[0.0; 6]];
            law.stresses(&[deformation(gradient)], &mut [], &mut out).map_err(|(_, error)| error)?;
            return Ok(out[0]);
        }
        let (stress, mut out) = (self.hooke.stress(gradient), [0.0; 6]);
        for i in 0..D {
            for a in 0..=i {
                out[VOIGT[i][a]] = stress[i][a];
            }
        }
        let trace: f64 = (0..D).map(|i| gradient[i][i]).sum();
        (D..3).for_each(|i| out[i] = self.hooke.across * trace);
        Ok(out)
    }

    /// Deformation gradient in space, row by row.
    pub fn deformation_gradient<const D: usize>(gradient: &Matrix<D>) -> Matrix3<f64> {
        deformation(gradient).gradient
    }

    /// Impedances along each normal at a displacement gradient, and the speed of the fastest wave along
    /// each; only at finite strain.
    ///
    /// # Errors
    /// The law has no answer, or (none) waves have no speed there.
    pub fn impedances<const D: usize>(
        &self,
        gradient: &Matrix<D>,
        normals: &[Vector<D>],
        out: &mut [Matrix<D>],
        speeds: &mut [f64],
    ) -> Result<(), Option<LawError>> {
        let Some(law) = &self.law else { return Ok(()) };
        let mut answer = [Response::default()];
        law.respond(&[deformation(gradient)], &mut [], &mut answer, Want::StressAndTangent)
            .map_err(|(_, error)| Some(error))?;
        let (inverse, volume) = inverse_and_volume(gradient);
        for ((normal, out), speed) in normals.iter().zip(out).zip(speeds) {
            let mut pushed = [0.0; D];
            for a in 0..D {
                for b in 0..D {
                    pushed[a] += inverse[b][a] * normal[b];
                }
            }
            let (root, largest) = square_root(&acoustic(&answer[0], &pushed, volume * self.density)).ok_or(None)?;
            *speed = largest.sqrt() / self.density;
            *out = root;
        }
        Ok(())
    }
}

/// P = J σ F⁻ᵀ.
#[inline]
fn first_piola_kirchhoff<const D: usize>(cauchy: &Voigt, gradient: &Matrix<D>) -> Matrix<D> {
    let (inverse, volume) = inverse_and_volume(gradient);
    let mut stress = [[0.0; D]; D];
    for i in 0..D {
        for a in 0..D {
            let mut sum = 0.0;
            for b in 0..D {
                sum += cauchy[VOIGT[i][b]] * inverse[a][b];
            }
            stress[i][a] = volume * sum;
        }
    }
    stress
}

/// `scale` n_a n_b (c_iajb + σ_ab δ_ij) with n = F⁻ᵀ N.
#[inline]
fn acoustic<const D: usize>(answer: &Response, n: &Vector<D>, scale: f64) -> Matrix<D> {
    let mut geometric = 0.0;
    for a in 0..D {
        for b in 0..D {
            geometric += n[a] * n[b] * answer.stress[VOIGT[a][b]];
        }
    }
    let mut tensor = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            let mut sum = if i == j { geometric } else { 0.0 };
            for a in 0..D {
                for b in 0..D {
                    sum += n[a] * n[b] * answer.tangent[VOIGT[i][a]][VOIGT[j][b]];
                }
            }
            tensor[i][j] = scale * sum;
        }
    }
    tensor
}
