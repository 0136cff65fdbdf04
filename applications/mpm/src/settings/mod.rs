//! `solver_settings` of all solvers, with Kratos's keys and defaults.

mod discretisation;
mod keys;

pub use discretisation::{Basis, Discretisation, Frame, Placement, Transfer};
pub use keys::KEYS;

use bia_constitutive::Kinematics;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::linalg::Method;
use bia_kernel::model::Table;
use bia_kernel::parameters::{Parameters, Settings};
use bia_kernel::processes::Clock;
use bia_kernel::solving::linear::{self, Nature};
use bia_kernel::solving::{Criterion, Newmark, Newton, Tolerances};
use std::path::{Path, PathBuf};

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

/// Where a mesh comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeshSource {
    /// An mdpa file.
    File(PathBuf),
    /// A modeler has made the part.
    Modeler,
}

/// Where the materials come from.
#[derive(Debug, Clone)]
pub enum MaterialSource {
    /// A materials file.
    File(PathBuf),
    /// A list in the project.
    Project(Parameters),
}

impl MeshSource {
    /// The file, if it is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            MeshSource::File(file) => Some(file),
            MeshSource::Modeler => None,
        }
    }
}

/// The step as a number or as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum Stepping {
    /// Always this step in seconds.
    Constant(f64),
    /// Interpolated at the time at which the step begins.
    Table(Table),
    /// This share of the stable step of an explicit scheme.
    Courant(f64),
}

impl Stepping {
    /// The step that begins now, given the stable one (infinite if there is none), in seconds.
    ///
    /// # Errors
    /// It does not advance the time.
    pub fn step(&self, clock: &Clock, stable: f64) -> Result<f64, Error> {
        let step = match self {
            Stepping::Constant(step) => *step,
            Stepping::Table(table) => table.value(clock.time),
            Stepping::Courant(share) => share * stable,
        };
        if step > 0.0 && clock.time + step > clock.time {
            return Ok(step);
        }
        let what = format!("the time step {step:?} does not advance the time {:?}", clock.time);
        Err(Failure::new(what, "a positive time step, also beyond the ends of the table").into())
    }
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
    /// Weight of the new acceleration in the points' velocity.
    pub point_gamma: f64,
    /// Implicit dynamics by the mid-point rule that keeps energy.
    pub conserves_energy: bool,
    /// Share of FLIP in the velocity of the points of implicit dynamics; the rest is PIC.
    pub flip_fraction: f64,
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
    /// Points that leave the grid are erased; else they stay without a cell and without effect.
    pub erase_lost: bool,
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
    /// Reads and checks; `folder` is that of the project.
    ///
    /// # Errors
    /// All faults together.
    pub fn read(parameters: &Parameters, folder: &Path) -> Result<Self, InputErrors> {
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
        if s.flag("pressure_dofs") {
            errors.push(
                s.error("pressure_dofs", "the mixed displacement-pressure formulation is not part of this build")
                    .help("set pressure_dofs to false and use a compressible law"),
            );
        }
        let regime = match s.text("solver_type").to_lowercase().replace('-', "_").as_str() {
            "static" => Regime::Static,
            "quasi_static" => Regime::QuasiStatic,
            _ => Regime::Dynamic,
        };
        let is_explicit = regime == Regime::Dynamic && s.text("time_integration_method") == "explicit";
        check_scheme(&s, is_explicit, &mut errors);
        if !is_explicit {
            check_implicit(&s, regime, &mut errors);
        }
        let stepping = errors.absorb(stepping(&s, is_explicit));
        let grid = errors.absorb(mesh(&s, "grid_model_import_settings", folder));
        let bodies = errors.absorb(mesh(&s, "model_import_settings", folder));
        let materials = errors.absorb(materials(&s, folder));
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
            point_gamma: if s.text("point_velocity_rule") == "scheme" { newmark(&s).gamma() } else { 0.5 },
            conserves_energy: conserves_energy(&s),
            flip_fraction: if let Transfer::Flip(fraction) = Transfer::of(&s) { fraction } else { 1.0 },
            newton: newton(&s),
            linear: s.get("linear_solver_settings").cloned(),
            stepping,
            reactions: s.flag("compute_reactions"),
            consistent_mass: s.flag("consistent_mass_matrix"),
            discretisation: Discretisation::of(&s),
            search_tolerance: s.nested("element_search_settings").map_or(1e-5, |n| n.number("searching_tolerance")),
            erase_lost: s.nested("element_search_settings").is_none_or(|n| n.flag("remove_entities_not_found")),
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
        let (method, keys): (_, &[&str]) = match (self.regime, &self.explicit) {
            (_, Some(_)) => {
                ("an explicit", &["consistent_mass_matrix", "newmark_beta", "damp_factor_m", "max_iteration"])
            }
            (Regime::Dynamic, None) => ("an implicit", &["stress_update", "compressible"]),
            (_, None) => (
                "a static or quasi-static",
                &["stress_update", "compressible", "newmark_beta", "damp_factor_m", "consistent_mass_matrix"],
            ),
        };
        let default = |key: &str| KEYS.iter().find(|k| k.name == key).map(|k| k.default);
        let is_default = |key: &str| match (default(key), self.settings.get(key)) {
            (Some(bia_kernel::parameters::Default::Json(text)), Some(given)) => {
                serde_json::from_str::<serde_json::Value>(text).is_ok_and(|value| value == *given.value())
            }
            _ => true,
        };
        let unread = keys.iter().filter(|key| self.settings.given(key) && !is_default(key));
        unread
            .map(|key| self.settings.error(key, format!("{key:?} has no effect in {method} run")).to_string())
            .collect()
    }

    /// The linear solver for symmetric or unsymmetric tangents.
    ///
    /// # Errors
    /// Unknown solver names and keys.
    pub fn linear_method(&self, symmetric: bool) -> Result<Method, InputErrors> {
        linear::method(self.linear.as_ref(), Nature { symmetric, dimension: self.dimension })
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

/// What the energy-conserving scheme and implicit transfers cannot be combined with.
fn check_implicit(s: &Settings, regime: Regime, errors: &mut InputErrors) {
    if conserves_energy(s) {
        if regime != Regime::Dynamic {
            errors.push(s.error("scheme_type", "\"energy_conserving\" needs solver_type \"dynamic\""));
        }
        if Discretisation::of(s).frame != Frame::Total {
            let help = "add \"frame\": \"total_lagrangian\"";
            errors.push(s.error("scheme_type", "\"energy_conserving\" needs the total Lagrangian frame").help(help));
        }
        if s.text("analysis_type") == "linear" {
            errors.push(s.error("analysis_type", "\"energy_conserving\" needs \"non_linear\""));
        }
        if Transfer::of(s) != Transfer::Flip(1.0) {
            errors
                .push(s.error("transfer", "\"energy_conserving\" needs \"flip\" with flip_fraction 1: PIC dissipates"));
        }
    } else if !matches!(Transfer::of(s), Transfer::Flip(_)) {
        let message = format!("{:?} is for explicit runs", s.text("transfer"));
        errors.push(s.error("transfer", message).help("implicit: \"flip\" with a flip_fraction, or \"pic\""));
    }
}

/// Schemes of the other method, and what this build does not have.
fn check_scheme(s: &Settings, is_explicit: bool, errors: &mut InputErrors) {
    let explicit_schemes = ["forward_euler", "central_difference"];
    if let Some(name) = scheme_name(s)
        && explicit_schemes.contains(&name) != is_explicit
    {
        let help = if is_explicit {
            "explicit: forward_euler or central_difference"
        } else {
            "for forward_euler and central_difference set solver_type \"dynamic\" and time_integration_method \"explicit\""
        };
        let method = if is_explicit { "explicit" } else { "implicit" };
        errors.push(s.error("scheme_type", format!("{name:?} is no {method} scheme")).help(help));
    }
    if s.flag("is_pqmpm") {
        let help = "set is_pqmpm to false: each point then belongs to one cell";
        errors.push(s.error("is_pqmpm", "the partitioned quadrature is not part of this build").help(help));
    }
}

fn explicit(s: &Settings) -> ExplicitSettings {
    let scheme = match (scheme_name(s), s.text("stress_update")) {
        (Some("forward_euler"), "usl") => Scheme::UpdateStressLast,
        (Some("forward_euler"), "musl") => Scheme::ModifiedUpdateStressLast,
        (Some("forward_euler"), _) => Scheme::UpdateStressFirst,
        _ => Scheme::CentralDifference,
    };
    ExplicitSettings {
        scheme,
        compressible: s.flag("compressible"),
        leave_edges: s.flag("is_fix_explicit_mp_on_grid_edge"),
        strict: s.nested("time_stepping").is_some_and(|nested| nested.text("time_step_policy") == "strict"),
        transfer: Transfer::of(s),
        moves_by_point: s.text("position_update") == "point",
    }
}

fn newton(s: &Settings) -> Newton {
    // Energy is kept as well as the equations are solved.
    let number = |key: String, tight: f64| if conserves_energy(s) && !s.given(&key) { tight } else { s.number(&key) };
    let tolerances = |kind: &str| Tolerances {
        relative: number(format!("{kind}_relative_tolerance"), 1e-11),
        absolute: number(format!("{kind}_absolute_tolerance"), 0.0),
    };
    let (displacement, residual) = (tolerances("displacement"), tolerances("residual"));
    let criterion = match s.text("convergence_criterion") {
        "displacement_criterion" => Criterion::Displacement(displacement),
        "and_criterion" => Criterion::And(displacement, residual),
        "or_criterion" => Criterion::Or(displacement, residual),
        _ => Criterion::Residual(residual),
    };
    let linear = s.text("analysis_type") == "linear";
    Newton { max_iterations: s.integer("max_iteration") as usize, criterion: (!linear).then_some(criterion) }
}

fn stepping(s: &Settings, is_explicit: bool) -> Result<Stepping, InputErrors> {
    let Some(nested) = s.nested("time_stepping") else {
        return Err(s.error("time_stepping", "must be an object").into());
    };
    if nested.given("time_step") && nested.given("time_step_table") {
        let message = "names both \"time_step\" and \"time_step_table\"";
        return Err(s.error("time_stepping", message).help("keep one of them").into());
    }
    if let Some(given) = nested.get("time_step") {
        return match given.value().as_f64() {
            Some(step) => Ok(Stepping::Constant(step)),
            None if is_explicit => Ok(Stepping::Courant(nested.number("courant_number"))),
            None => Err(given.error("\"auto\" is for explicit runs").help("name a time step in seconds").into()),
        };
    }
    let Some(list) = nested.get("time_step_table") else {
        let message = "names neither \"time_step\" nor \"time_step_table\"";
        return Err(s.error("time_stepping", message).into());
    };
    let mut pairs = Vec::new();
    for entry in list.entries() {
        match entry.value().as_array().map(Vec::as_slice) {
            Some([t, dt]) if t.is_number() && dt.as_f64().is_some_and(|dt| dt > 0.0) => {
                pairs.push((t.as_f64().unwrap_or(0.0), dt.as_f64().unwrap_or(0.0)));
            }
            _ => return Err(entry.error("must be a pair [time, time step] with a time step above 0").into()),
        }
    }
    Table::new(pairs).map(Stepping::Table).map_err(|message| list.error(message).into())
}

fn mesh(s: &Settings, key: &str, folder: &Path) -> Result<MeshSource, InputErrors> {
    let Some(nested) = s.nested(key) else {
        return Ok(MeshSource::Modeler);
    };
    if nested.text("input_type") == "use_input_model_part" {
        return Ok(MeshSource::Modeler);
    }
    let name = nested.text("input_filename");
    if name.is_empty() {
        let message = "the key \"input_filename\" is missing";
        return Err(nested
            .parameters()
            .error(message)
            .help("name an mdpa file, or set input_type to \"use_input_model_part\" and let a modeler make the mesh")
            .into());
    }
    let mut file = folder.join(name);
    if file.extension().is_none_or(|extension| extension != "mdpa") {
        file.as_mut_os_string().push(".mdpa");
    }
    Ok(MeshSource::File(file))
}

fn materials(s: &Settings, folder: &Path) -> Result<MaterialSource, InputErrors> {
    let Some(nested) = s.nested("material_import_settings") else {
        return Err(s.error("material_import_settings", "must be an object").into());
    };
    match (nested.text("materials_filename"), nested.get("materials")) {
        ("", Some(list)) => Ok(MaterialSource::Project(list.clone())),
        ("", None) => {
            let message = "\"materials_filename\" is missing";
            let help = "name the materials file, or write its list here as \"materials\"";
            Err(s.error("material_import_settings", message).help(help).into())
        }
        (name, None) => Ok(MaterialSource::File(folder.join(name))),
        (_, Some(list)) => {
            let message = "the materials stand here and in \"materials_filename\"";
            Err(list.error(message).help("keep one of the two").into())
        }
    }
}
