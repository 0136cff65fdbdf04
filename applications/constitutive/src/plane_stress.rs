//! Plane stress for any three-dimensional law without history: finds the thickness stretch F33 that
//! makes σ33 = 0, and condenses the tangent.
//!
//! With x = ln F33 and σ33 = 0 sought, Newton's method on τ33(x) uses dτ33/dx = J c33 + 2 τ33, which
//! follows from Lᵥτ = J c : d. The condensed tangent is c̄_IJ = c_IJ − c_I3 c_3J / c_33.
//!
//! Elements hand over F33 = 1 and integrate over V₀ J₂, J₂ = det F of the plane, as Kratos's
//! plane-stress elements do. So that forces and energy are right, the stress returned is τ/J₂: the
//! force per current length and *undeformed* thickness. The true Cauchy stress is that divided by F33.
//!
//! The law must be isotropic, or have the plane for a plane of symmetry (σ13 = σ23 = 0).

use crate::{ConstitutiveLaw, Deformation, Fault, LawError, Material, MaterialVariable, Tangent, Voigt};

const MAX_ITERATIONS: usize = 50;
/// Convergence is quadratic: the error left after a correction of this size is round-off.
const LAST_CORRECTION: f64 = 1e-9;
/// Largest change of ln F33 in one iteration.
const LARGEST_CORRECTION: f64 = 1.0;

/// `L` without stress across the plane. The state is ln F33, where the next search starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneStress<L>(pub L);

impl<L: ConstitutiveLaw<State = ()>> PlaneStress<L> {
    /// The deformation with the thickness stretch that frees the plane of σ33, and the law's answer
    /// to it; `log_stretch` goes in as first guess and out as result.
    fn solve(
        &self,
        deformation: &Deformation,
        log_stretch: &mut f64,
    ) -> Result<(Deformation, Voigt, Tangent), LawError> {
        let mut lifted = *deformation;
        let mut correction = f64::INFINITY;
        let mut iterations = 0;
        loop {
            lifted.gradient[(2, 2)] = log_stretch.exp();
            let (stress, tangent) = self.0.stress_and_tangent(&lifted, &mut ())?;
            if correction.abs() <= LAST_CORRECTION {
                return Ok((lifted, stress, tangent));
            }
            if iterations == MAX_ITERATIONS {
                let what = "the thickness stretch of plane stress";
                return Err(LawError::NoConvergence { what, iterations, correction });
            }
            let slope = tangent[2][2] + 2.0 * stress[2];
            if !(stress[2].is_finite() && slope.is_finite()) {
                return Err(LawError::NonFinite);
            }
            // Where the slope has the wrong sign Newton's method would run away from the solution.
            correction = if slope > 0.0 { -stress[2] / slope } else { -stress[2].signum() };
            correction = correction.clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
            *log_stretch += correction;
            iterations += 1;
        }
    }
}

impl<L: ConstitutiveLaw<State = ()>> ConstitutiveLaw for PlaneStress<L> {
    const NAME: &'static str = L::NAME;
    const HELP: &'static str = L::HELP;
    const VARIABLES: &'static [MaterialVariable] = L::VARIABLES;
    type State = f64;

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self(L::new(material)?))
    }

    fn stress(&self, deformation: &Deformation, log_stretch: &mut f64) -> Result<Voigt, LawError> {
        Ok(self.stress_and_tangent(deformation, log_stretch)?.0)
    }

    fn stress_and_tangent(
        &self,
        deformation: &Deformation,
        log_stretch: &mut f64,
    ) -> Result<(Voigt, Tangent), LawError> {
        let (lifted, mut stress, c) = self.solve(deformation, log_stretch)?;
        let thickness = lifted.gradient[(2, 2)];
        const IN_PLANE: [usize; 3] = [0, 1, 3];
        let mut condensed = [[0.0; 6]; 6];
        for row in IN_PLANE {
            stress[row] *= thickness;
            for column in IN_PLANE {
                condensed[row][column] = thickness * (c[row][column] - c[row][2] * c[2][column] / c[2][2]);
            }
        }
        for across in [2, 4, 5] {
            stress[across] = 0.0;
        }
        Ok((stress, condensed))
    }

    /// Strain of the law with the thickness stretch found; not a number when none is found.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        self.solve(deformation, &mut 0.0).map_or([f64::NAN; 6], |(lifted, ..)| self.0.strain(&lifted))
    }

    /// √(c̄₁₁/ρ) of the undeformed material.
    fn wave_speed(&self, density: f64) -> f64 {
        let undeformed = Deformation::from_gradient(nalgebra::Matrix3::identity());
        let answer = self.stress_and_tangent(&undeformed, &mut 0.0);
        answer.map_or(f64::NAN, |(_, tangent)| (tangent[0][0] / density).sqrt())
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let (lifted, ..) = self.solve(deformation, &mut 0.0).ok()?;
        self.0.energy(&lifted)
    }

    fn is_symmetric(&self) -> bool {
        self.0.is_symmetric()
    }
}
