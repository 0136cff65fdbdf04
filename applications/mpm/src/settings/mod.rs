//! `solver_settings` of all solvers, with Kratos's keys and defaults.

mod checks;
mod discretisation;
mod keys;
mod mixed;

pub use bia_kernel::solving::Stepping;
pub use discretisation::{Basis, Discretisation, Frame, Placement, Transfer};
pub use keys::KEYS;
pub use mixed::{ElementSize, MixedSettings, Stabilization, Variant};

use crate::points::lost::LostPoints;
use bia_constitutive::{Kinematics, MaterialSource};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::linalg::Method;
use bia_kernel::parameters::{Parameters, Settings};
use bia_kernel::processes::RunOptions;
use bia_kernel::solving::linear::{self, Nature};
use bia_kernel::solving::{Criterion, MeshSource, Newmark, Newton};
use checks::{check_explicit, check_implicit, check_scheme};
use discretisation::check_frame;
use mixed::check_mixed;

/// What kind of equilibrium is sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// No inertia; each step starts from the displacement increment of the last.
    Static,
    /// No inertia; each step starts from zero.
    QuasiStatic,
    /// With inertia.
    Dynamic,
}

/// When the stress follows the grid's velocity, and which velocity that is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Forward Euler, stress before the forces (Bardenhagen 2002, update stress first).
    UpdateStressFirst,
    /// Forward Euler, stress after the points have moved.
    UpdateStressLast,
    /// As before, with the velocity of the moved points (Sulsky, Zhou & Schreyer 1995).
    ModifiedUpdateStressLast,
    /// Staggered velocities half a step ahead; stress before the forces.
    CentralDifference,
    /// Symplectic: half a kick, a drift with the velocity that the points then give the grid, half a
    /// kick. Velocity and deformation are known at the same time, and the energy error does not drift.
    VelocityVerlet,
    /// Three such stages of different lengths: fourth order (Yoshida 1990).
    Yoshida,
}

impl Scheme {
    /// Kick, drift, kick: velocity and deformation are known at the same time.
    pub fn is_symplectic(self) -> bool {
        matches!(self, Scheme::VelocityVerlet | Scheme::Yoshida)
    }
}

/// What explicit runs alone have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExplicitSettings {
    /// Time scheme.
    pub scheme: Scheme,
    /// Volume and density follow the deformation; else they stay as they were.
    pub compressible: bool,
    /// Points are moved off the edges of cells.
    pub leave_edges: bool,
    /// A step above the stable one stops the run.
    pub strict: bool,
    /// How velocity returns to the points.
    pub transfer: Transfer,
    /// Points move with their own velocity instead of the grid's.
    pub moves_by_point: bool,
    /// The whole mass matrix instead of row sums.
    pub consistent_mass: bool,
}

/// Checked settings.
pub struct SolverSettings {
    /// Name of the part of points.
    pub part: String,
    /// Kinematics (plane stress is refined by the law's name).
    pub axisymmetric: bool,
    /// Dimension of space.
    pub dimension: usize,
    /// Regime.
    pub regime: Regime,
    /// Explicit dynamics; none if implicit.
    pub explicit: Option<ExplicitSettings>,
    /// Time scheme of dynamics.
    pub newmark: Newmark,
    /// Held nodes of the updated frame start an implicit step with the velocity of their support.
    pub imposes_held_motion: bool,
    /// Weight of the new acceleration in the points' velocity.
    pub point_gamma: f64,
    /// Implicit dynamics by the mid-point rule that keeps energy.
    pub conserves_energy: bool,
    /// Share of FLIP in the velocity of the points of implicit dynamics; the rest is PIC.
    pub flip_fraction: f64,
    /// Nodal pressures, if the formulation has them.
    pub mixed: Option<MixedSettings>,
    /// Newton's method.
    pub newton: Newton,
    /// The user's linear solver settings.
    pub linear: Option<Parameters>,
    /// Time step.
    pub stepping: Stepping,
    /// Reactions wanted.
    pub reactions: bool,
    /// Consistent mass.
    pub consistent_mass: bool,
    /// Frame, functions and placement of points.
    pub discretisation: Discretisation,
    /// Tolerance of the search in local coordinates.
    pub search_tolerance: f64,
    /// What becomes of points that leave the grid.
    pub lost_points: LostPoints,
    /// Mesh of the grid.
    pub grid: MeshSource,
    /// Mesh of the bodies.
    pub bodies: MeshSource,
    /// Materials.
    pub materials: MaterialSource,
    /// The settings as read, for places in messages.
    pub settings: Settings,
}

impl SolverSettings {
    /// Reads and checks.
    ///
    /// # Errors
    /// All faults together.
    pub fn read(parameters: &Parameters, options: &RunOptions) -> Result<Self, InputErrors> {
        let folder = &options.folder;
        let s = parameters.read(KEYS)?;
        let mut errors = InputErrors::default();
        let dimension = s.integer("domain_size") as usize;
        if !(1..=3).contains(&dimension) {
            errors.push(s.error("domain_size", format!("is {dimension}, must be 1, 2 or 3")));
        }
        let axisymmetric = s.flag("axis_symmetric_flag");
        if axisymmetric && dimension != 2 {
            errors.push(s.error("axis_symmetric_flag", "needs domain_size 2"));
        }
        let regime = match s.text("solver_type").to_lowercase().replace('-', "_").as_str() {
            "static" => Regime::Static,
            "quasi_static" => Regime::QuasiStatic,
            _ => Regime::Dynamic,
        };
        let is_explicit = regime == Regime::Dynamic && s.text("time_integration_method") == "explicit";
        check_scheme(&s, is_explicit, &mut errors);
        check_mixed(&s, is_explicit, &mut errors);
        check_frame(&s, &mut errors);
        LostPoints::check(&s, &mut errors);
        if is_explicit {
            check_explicit(&s, &mut errors);
        } else {
            check_implicit(&s, regime, &mut errors);
        }
        let stepping = errors.absorb(Stepping::read(&s, is_explicit));
        let grid = errors.absorb(MeshSource::read(&s, "grid_model_import_settings", folder));
        let bodies = errors.absorb(MeshSource::read(&s, "model_import_settings", folder));
        let materials = errors.absorb(MaterialSource::read(&s, folder));
        let parts = (stepping, grid, bodies, materials);
        let (Some(stepping), Some(grid), Some(bodies), Some(materials)) = parts else {
            return Err(errors);
        };
        let built = Self {
            part: s.text("model_part_name").into(),
            axisymmetric,
            dimension,
            regime,
            explicit: is_explicit.then(|| explicit(&s)),
            newmark: newmark(&s),
            imposes_held_motion: s.text("held_motion") == "imposed",
            point_gamma: if s.text("point_velocity_rule") == "scheme" { newmark(&s).gamma() } else { 0.5 },
            conserves_energy: conserves_energy(&s),
            flip_fraction: if let Transfer::Flip(fraction) = Transfer::of(&s) { fraction } else { 1.0 },
            mixed: MixedSettings::of(&s),
            newton: newton(&s, options.kratos_exact),
            linear: s.get("linear_solver_settings").cloned(),
            stepping,
            reactions: s.flag("compute_reactions"),
            consistent_mass: s.flag("consistent_mass_matrix"),
            discretisation: Discretisation::of(&s),
            search_tolerance: s.nested("element_search_settings").map_or(1e-5, |n| n.number("searching_tolerance")),
            lost_points: LostPoints::of(&s),
            grid,
            bodies,
            materials,
            settings: s,
        };
        errors.absorb(built.linear_method(true));
        errors.or(built)
    }

    /// Keys that were given a value of their own but that the chosen method does not read.
    pub fn unread(&self) -> Vec<String> {
        let (method, keys): (_, &'static [&'static str]) = match (self.regime, &self.explicit) {
            (_, Some(_)) => ("an explicit", &["newmark_beta", "damp_factor_m", "max_iteration"]),
            (Regime::Dynamic, None) => ("an implicit", &["stress_update", "compressible", "position_update"]),
            (_, None) => (
                "a static or quasi-static",
                &[
                    "stress_update",
                    "compressible",
                    "newmark_beta",
                    "damp_factor_m",
                    "consistent_mass_matrix",
                    "transfer",
                    "flip_fraction",
                    "position_update",
                ],
            ),
        };
        let of_pressures: &'static [&'static str] = match self.mixed {
            Some(_) => &[],
            None => &["stabilization", "stabilization_parameters", "volumetric_law"],
        };
        let default = |key: &str| KEYS.iter().find(|k| k.name == key).map(|k| k.default);
        let is_default = |key: &str| match (default(key), self.settings.get(key)) {
            (Some(bia_kernel::parameters::Default::Json(text)), Some(given)) => {
                serde_json::from_str::<serde_json::Value>(text).is_ok_and(|value| value == *given.value())
            }
            _ => true,
        };
        let unread = |keys: &'static [&'static str]| {
            keys.iter().filter(|key| self.settings.given(key) && !is_default(key)).copied()
        };
        let tell =
            |key: &str, place: &str| self.settings.error(key, format!("{key:?} has no effect {place}")).to_string();
        let of_method = unread(keys).map(|key| tell(key, &format!("in {method} run")));
        of_method.chain(unread(of_pressures).map(|key| tell(key, "without pressure_dofs"))).collect()
    }

    /// When in a step the forces act that move the points, as a share of it: with the deformation at
    /// its start, in its middle or at its end. Of kick, drift and kick, the mean of both kicks.
    pub fn load_time(&self) -> f64 {
        match &self.explicit {
            Some(explicit) => match explicit.scheme {
                Scheme::UpdateStressFirst | Scheme::CentralDifference => 1.0,
                Scheme::UpdateStressLast | Scheme::ModifiedUpdateStressLast => 0.0,
                Scheme::VelocityVerlet | Scheme::Yoshida => 0.5,
            },
            None if self.conserves_energy => 0.5,
            None => 1.0,
        }
    }

    /// The linear solver for symmetric or unsymmetric tangents.
    ///
    /// # Errors
    /// Unknown solver names and keys.
    pub fn linear_method(&self, symmetric: bool) -> Result<Method, InputErrors> {
        let definite = self.mixed.is_none();
        linear::method(self.linear.as_ref(), Nature { symmetric, definite, dimension: self.dimension })
    }

    /// Kinematics of the scene; plane stress is a matter of each law.
    pub fn kinematics(&self) -> Kinematics {
        match (self.dimension, self.axisymmetric) {
            (3, _) => Kinematics::ThreeDimensional,
            (1, _) => Kinematics::UniaxialStrain,
            (_, true) => Kinematics::Axisymmetric,
            _ => Kinematics::PlaneStrain,
        }
    }
}

fn newmark(s: &Settings) -> Newmark {
    let alpha = if scheme_name(s).is_none_or(|name| name == "bossak") { s.number("damp_factor_m") } else { 0.0 };
    Newmark { alpha, beta: s.number("newmark_beta") }
}

fn scheme_name(s: &Settings) -> Option<&str> {
    s.given("scheme_type").then(|| s.text("scheme_type"))
}

fn conserves_energy(s: &Settings) -> bool {
    scheme_name(s) == Some("energy_conserving")
}

fn explicit(s: &Settings) -> ExplicitSettings {
    let scheme = match (scheme_name(s), s.text("stress_update")) {
        (Some("forward_euler"), "usl") => Scheme::UpdateStressLast,
        (Some("forward_euler"), "musl") => Scheme::ModifiedUpdateStressLast,
        (Some("forward_euler"), _) => Scheme::UpdateStressFirst,
        (Some("velocity_verlet"), _) => Scheme::VelocityVerlet,
        (Some("yoshida"), _) => Scheme::Yoshida,
        _ => Scheme::CentralDifference,
    };
    ExplicitSettings {
        scheme,
        compressible: s.flag("compressible"),
        leave_edges: s.flag("is_fix_explicit_mp_on_grid_edge"),
        strict: s.nested("time_stepping").is_some_and(|nested| nested.text("time_step_policy") == "strict"),
        transfer: Transfer::of(s),
        moves_by_point: s.text("position_update") == "point",
        consistent_mass: s.flag("consistent_mass_matrix"),
    }
}

/// Newton's method; energy is kept as well as the equations are solved, so that a scheme that conserves
/// it has tight tolerances unless others are given.
fn newton(s: &Settings, kratos_exact: bool) -> Newton {
    // Kratos has no such scheme whose tolerances could be repeated.
    let conserves_energy = conserves_energy(s);
    let mut newton = Newton::read(s, kratos_exact && !conserves_energy);
    if let Some(Criterion::Residual(tolerances)) = &mut newton.criterion
        && conserves_energy
        && !s.given("residual_relative_tolerance")
    {
        tolerances.relative = 1e-11;
    }
    newton
}
