//! The two faces of a law: [`ConstitutiveLaw`], what its author writes for one point, and [`Law`],
//! what elements call for a batch of points.

use bia_kernel::lanes::Lanes;
use bytemuck::{Pod, Zeroable};
use nalgebra::Matrix3;

use crate::{Fault, LawError, Material, MaterialVariable, Tangent, Voigt, tensor::Tensor};

/// Points that a law answers for in step.
pub const WIDTH: usize = 8;

/// What a law may know about points in step, one in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Group {
    /// [`Deformation::gradient`]s.
    pub gradient: Tensor<Lanes<WIDTH>>,
    /// [`Deformation::strain`]s; zero for laws that take none.
    pub strain: [Lanes<WIDTH>; 6],
}

/// What a law may know about the motion of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deformation {
    /// Total deformation gradient F of the present iterate, 3×3 (see [`crate::Kinematics`]).
    pub gradient: Matrix3<f64>,
    /// Total deformation gradient at the start of the step.
    pub previous: Matrix3<f64>,
    /// Length of the step (s); 0 in statics.
    pub time_step: f64,
    /// Mean stress interpolated from the nodes (Pa), tension positive; only mixed u-p elements have it.
    pub pressure: Option<f64>,
    /// Strain accumulated in axes that turn with the material, shear doubled; only explicit elements
    /// have it.
    pub strain: Option<Voigt>,
}

impl Deformation {
    /// From the undeformed state in one step without duration and without nodal pressure.
    pub fn from_gradient(gradient: Matrix3<f64>) -> Self {
        Self { gradient, previous: Matrix3::identity(), time_step: 0.0, pressure: None, strain: None }
    }
}

/// A constitutive law at one point, in three dimensions.
///
/// With Kirchhoff stress τ = J σ, J = det F of [`Deformation::gradient`]:
/// - the *stress* is the Cauchy stress σ (Pa); the element integrates it over V = V₀ J;
/// - the *tangent* is c with Lᵥτ = J c : d, where Lᵥτ = τ̇ − l τ − τ lᵀ is the Lie derivative,
///   l = Ḟ F⁻¹ and d = sym l. The element adds the geometric part, K = V (Bᵀ c B + ∇N σ ∇Nᵀ).
///
/// [`crate::verify`] checks both by differences.
pub trait ConstitutiveLaw: Sized + Send + Sync + 'static {
    /// Name of the law for messages, independent of the kinematics.
    const NAME: &'static str;
    /// The law in one sentence, with its source.
    const HELP: &'static str;
    /// The constants that the law takes.
    const VARIABLES: &'static [MaterialVariable];
    /// History of one point, a `#[repr(C)]` struct of `f64`; `()` stores nothing.
    type State: Pod + Send + Sync;
    /// The law takes [`Deformation::strain`].
    const USES_STRAIN: bool = false;

    /// The law with the constants of `material`, each of which has passed its own range.
    ///
    /// # Errors
    /// Constants that do not go together.
    fn new(material: &Material) -> Result<Self, Fault>;

    /// History of a virgin point; all zero unless the law says otherwise.
    fn initial_state(&self) -> Self::State {
        Self::State::zeroed()
    }

    /// Cauchy stress. `state` comes in as of the start of the step and goes out as of its end; the
    /// element decides whether to keep it.
    ///
    /// # Errors
    /// The law has no answer at this deformation.
    fn stress(&self, deformation: &Deformation, state: &mut Self::State) -> Result<Voigt, LawError>;

    /// Cauchy stress and tangent; `state` as in [`stress`](Self::stress).
    ///
    /// # Errors
    /// The law has no answer at this deformation.
    fn stress_and_tangent(
        &self,
        deformation: &Deformation,
        state: &mut Self::State,
    ) -> Result<(Voigt, Tangent), LawError>;

    /// Strain for output, shear doubled; each law says which measure.
    fn strain(&self, deformation: &Deformation) -> Voigt;

    /// Speed of the fastest small wave in the undeformed material (m/s); `density` in kg/m³.
    fn wave_speed(&self, density: f64) -> f64;

    /// [`stress`](Self::stress) of points in step, for laws without history whose stress depends on
    /// the gradient and strain alone; not a number where the law has no answer.
    const IN_STEP: Option<fn(&Self, &Group) -> [Lanes<WIDTH>; 6]> = None;

    /// Strain energy per reference volume (J/m³), where the law has one.
    fn energy(&self, _deformation: &Deformation) -> Option<f64> {
        None
    }

    /// Whether the tangent has the major symmetry c_abcd = c_cdab.
    fn is_symmetric(&self) -> bool {
        true
    }
}

/// Stress and tangent at one point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Cauchy stress (Pa).
    pub stress: Voigt,
    /// Spatial tangent (Pa), already divided by J.
    pub tangent: Tangent,
}

/// What an element asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// The stress alone; tangents are left as they are.
    Stress,
    /// Stress and tangent.
    StressAndTangent,
}

/// A law as elements see it: one dynamic call per batch of points, history as plain numbers.
///
/// Every [`ConstitutiveLaw`] is one. Methods of a `dyn Law` need no import of this trait; with both
/// traits imported, those they share must be named in full.
pub trait Law: Send + Sync {
    /// Name for messages.
    fn name(&self) -> &str;

    /// Numbers of history per point.
    fn state_len(&self) -> usize;

    /// Writes the history of virgin points: any whole number of points, each `state_len` long.
    fn initial_state(&self, states: &mut [f64]);

    /// Answers for each deformation, in order. `states` is point-major, `state_len` numbers a
    /// point: in as of the start of the step, out as of its end. `out` has one entry a point.
    ///
    /// # Errors
    /// The first point without an answer, and why. Points before it have been answered.
    ///
    /// # Panics
    /// The lengths of the slices do not agree.
    fn respond(
        &self,
        deformations: &[Deformation],
        states: &mut [f64],
        out: &mut [Response],
        want: Want,
    ) -> Result<(), (usize, LawError)>;

    /// As [`respond`](Self::respond) with the stress alone, for explicit elements.
    ///
    /// # Errors
    /// The first point without an answer, and why. Points before it have been answered.
    ///
    /// # Panics
    /// The lengths of the slices do not agree.
    fn stresses(
        &self,
        deformations: &[Deformation],
        states: &mut [f64],
        out: &mut [Voigt],
    ) -> Result<(), (usize, LawError)>;

    /// Stresses of groups of points; false, with `out` as it was, if the law answers point by point
    /// only. Where it has no answer the stress is not a number: [`stresses`](Self::stresses) says why.
    ///
    /// # Panics
    /// The lengths of the slices do not agree.
    fn stresses_in_step(&self, groups: &[Group], out: &mut [[Lanes<WIDTH>; 6]]) -> bool;

    /// See [`ConstitutiveLaw::USES_STRAIN`].
    fn uses_strain(&self) -> bool;

    /// See [`ConstitutiveLaw::strain`].
    fn strain(&self, deformation: &Deformation) -> Voigt;

    /// See [`ConstitutiveLaw::wave_speed`].
    fn wave_speed(&self, density: f64) -> f64;

    /// See [`ConstitutiveLaw::energy`].
    fn energy(&self, deformation: &Deformation) -> Option<f64>;

    /// See [`ConstitutiveLaw::is_symmetric`].
    fn is_symmetric(&self) -> bool;
}

/// Numbers per point of a state. A state that is no sequence of f64-sized numbers does not compile.
const fn numbers_in<S: Pod>() -> usize {
    const {
        assert!(size_of::<S>().is_multiple_of(size_of::<f64>()), "a law's state must be made of f64");
        assert!(align_of::<S>() <= align_of::<f64>(), "a law's state must not be aligned beyond f64");
    }
    size_of::<S>() / size_of::<f64>()
}

/// The history of point `point` in a point-major column.
fn state_at<S: Pod>(states: &mut [f64], point: usize) -> &mut S {
    let len = numbers_in::<S>();
    bytemuck::from_bytes_mut(bytemuck::cast_slice_mut(&mut states[point * len..(point + 1) * len]))
}

impl<L: ConstitutiveLaw> Law for L {
    fn name(&self) -> &str {
        L::NAME
    }

    fn state_len(&self) -> usize {
        numbers_in::<L::State>()
    }

    fn initial_state(&self, states: &mut [f64]) {
        let virgin = ConstitutiveLaw::initial_state(self);
        let len = numbers_in::<L::State>();
        for point in 0..states.len().checked_div(len).unwrap_or(0) {
            *state_at(states, point) = virgin;
        }
    }

    fn respond(
        &self,
        deformations: &[Deformation],
        states: &mut [f64],
        out: &mut [Response],
        want: Want,
    ) -> Result<(), (usize, LawError)> {
        assert_eq!(deformations.len(), out.len(), "one answer per deformation");
        assert_eq!(deformations.len() * numbers_in::<L::State>(), states.len(), "one state per deformation");
        for (point, (deformation, answer)) in deformations.iter().zip(out).enumerate() {
            let state = state_at::<L::State>(states, point);
            let at_point = |error| (point, error);
            match want {
                Want::Stress => answer.stress = self.stress(deformation, state).map_err(at_point)?,
                Want::StressAndTangent => {
                    let (stress, tangent) = self.stress_and_tangent(deformation, state).map_err(at_point)?;
                    *answer = Response { stress, tangent };
                }
            }
            if !answer.stress.iter().sum::<f64>().is_finite() {
                return Err((point, LawError::NonFinite));
            }
        }
        Ok(())
    }

    fn stresses(
        &self,
        deformations: &[Deformation],
        states: &mut [f64],
        out: &mut [Voigt],
    ) -> Result<(), (usize, LawError)> {
        assert_eq!(deformations.len(), out.len(), "one answer per deformation");
        assert_eq!(deformations.len() * numbers_in::<L::State>(), states.len(), "one state per deformation");
        for (point, (deformation, answer)) in deformations.iter().zip(out).enumerate() {
            let state = state_at::<L::State>(states, point);
            *answer = self.stress(deformation, state).map_err(|error| (point, error))?;
            if !answer.iter().sum::<f64>().is_finite() {
                return Err((point, LawError::NonFinite));
            }
        }
        Ok(())
    }

    fn stresses_in_step(&self, groups: &[Group], out: &mut [[Lanes<WIDTH>; 6]]) -> bool {
        assert_eq!(groups.len(), out.len(), "one answer per group");
        let Some(stress) = L::IN_STEP else { return false };
        // In the machine's widest vectors: inlined into the closure, the formula is compiled for them.
        pulp::Arch::new().dispatch(|| {
            for (group, out) in groups.iter().zip(out) {
                *out = stress(self, group);
            }
        });
        true
    }

    fn uses_strain(&self) -> bool {
        L::USES_STRAIN
    }

    fn strain(&self, deformation: &Deformation) -> Voigt {
        ConstitutiveLaw::strain(self, deformation)
    }

    fn wave_speed(&self, density: f64) -> f64 {
        ConstitutiveLaw::wave_speed(self, density)
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        ConstitutiveLaw::energy(self, deformation)
    }

    fn is_symmetric(&self) -> bool {
        ConstitutiveLaw::is_symmetric(self)
    }
}
