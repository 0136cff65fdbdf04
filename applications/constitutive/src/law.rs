//! The two faces of a law: [`ConstitutiveLaw`], what its author writes for one point, and [`Law`],
//! what elements call for a batch of points.

use bia_kernel::lanes::{Lanes, Pack, Real};
use bytemuck::{Pod, Zeroable};
use nalgebra::Matrix3;

use crate::{Fault, LawError, Material, MaterialVariable, MixedModuli, Tangent, Voigt, tensor::Tensor};

/// What a law may know about points in step, one in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Group {
    /// [`Deformation::gradient`]s.
    pub gradient: Tensor<Pack>,
    /// [`Deformation::strain`]s, for laws that take them.
    pub strain: [Pack; 6],
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

/// The pressure that a mixed element hands over.
///
/// # Errors
/// The element has none.
pub(crate) fn mixed_pressure(deformation: &Deformation) -> Result<f64, LawError> {
    let advice = "set \"pressure_dofs\" to true";
    deformation.pressure.ok_or(LawError::Unsuitable { problem: "needs the nodal pressure", advice })
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
    /// The constants that the law takes if they are given.
    const OPTIONAL: &'static [MaterialVariable] = &[];
    /// The law takes [`Deformation::pressure`] and has [`mixed`](Self::mixed).
    const MIXED: bool = false;
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

    /// The law has [`stress_in_step`](Self::stress_in_step).
    const IN_STEP: bool = false;

    /// [`stress`](Self::stress) from gradient and strain alone, for one point or several in step; not
    /// a number where the law has no answer. For laws without history; write it with loops and
    /// `#[inline(always)]` (see [`bia_kernel::lanes`]).
    fn stress_in_step<R: Real>(&self, _gradient: &Tensor<R>, strain: &[R; 6]) -> [R; 6] {
        *strain
    }

    /// Strain energy per reference volume (J/m³), where the law has one.
    fn energy(&self, _deformation: &Deformation) -> Option<f64> {
        None
    }

    /// Whether the tangent has the major symmetry c_abcd = c_cdab.
    fn is_symmetric(&self) -> bool {
        true
    }

    /// What mixed displacement-pressure elements need beside stress and tangent.
    fn mixed(&self) -> Option<MixedModuli> {
        None
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

    /// Whether the law has [`ConstitutiveLaw::stress_in_step`].
    fn answers_in_step(&self) -> bool;

    /// Stresses of groups of points; false if the law answers point by point only, or has no answer
    /// for some of them: [`stresses`](Self::stresses) then says more.
    ///
    /// # Panics
    /// The lengths of the slices do not agree.
    fn stresses_in_step(&self, groups: &[Group], out: &mut [[Pack; 6]]) -> bool;

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

    /// See [`ConstitutiveLaw::mixed`].
    fn mixed(&self) -> Option<MixedModuli>;
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

/// Stresses of groups of points on the machine's vectors.
struct StressInStep<'a, L> {
    law: &'a L,
    groups: &'a [Group],
    out: &'a mut [[Pack; 6]],
}

impl<L: ConstitutiveLaw> pulp::WithSimd for StressInStep<'_, L> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> bool {
        let mut check = Lanes::splat(simd, 0.0);
        for (group, out) in self.groups.iter().zip(self.out) {
            let mut gradient = [[Lanes::splat(simd, 0.0); 3]; 3];
            for a in 0..3 {
                for b in 0..3 {
                    gradient[a][b] = Lanes::load(simd, &group.gradient[a][b]);
                }
            }
            let mut strain = [Lanes::splat(simd, 0.0); 6];
            if L::USES_STRAIN {
                for k in 0..6 {
                    strain[k] = Lanes::load(simd, &group.strain[k]);
                }
            }
            let stress = self.law.stress_in_step(&gradient, &strain);
            for k in 0..6 {
                stress[k].store(&mut out[k]);
                // Zero for every number, and not a number otherwise.
                check += stress[k] * 0.0;
            }
        }
        check.all_within(0.0, 0.0)
    }
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

    fn answers_in_step(&self) -> bool {
        L::IN_STEP
    }

    fn stresses_in_step(&self, groups: &[Group], out: &mut [[Pack; 6]]) -> bool {
        assert_eq!(groups.len(), out.len(), "one answer per group");
        L::IN_STEP && pulp::Arch::new().dispatch(StressInStep { law: self, groups, out })
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

    fn mixed(&self) -> Option<MixedModuli> {
        ConstitutiveLaw::mixed(self)
    }
}
