//! `solver_settings`, with Kratos's keys and defaults where Kratos has them.

use bia_constitutive::{Kinematics, MATERIAL_IMPORT, MaterialSource};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::linalg::Method;
use bia_kernel::parameters::{Key, Kind, Parameters, Range, Settings};
use bia_kernel::processes::RunOptions;
use bia_kernel::solving::linear::{self, Nature};
use bia_kernel::solving::mesh::MESH_IMPORT;
use bia_kernel::solving::newton::{CONVERGENCE, OnNoConvergence};
use bia_kernel::solving::stepping::TIME_STEPPING;
use bia_kernel::solving::{MeshSource, Newmark, Newton, Stepping};

/// Keys of `solver_settings`.
pub const KEYS: &[Key] = &Key::join::<8, 18, 26>(
    CONVERGENCE,
    [
        Key::required("solver_type", Kind::Text, "structural_static or structural_dynamic"),
        Key::new("model_part_name", Kind::Text, "\"Structure\"", "root part with the body's mesh"),
        Key::required("domain_size", Kind::Integer { min: 1 }, "dimension of space: 1, 2 or 3"),
        Key::new("echo_level", Kind::Integer { min: 0 }, "0", "ignored: --quiet and the log level rule"),
        Key::new(
            "time_integration_method",
            Kind::Choice(&["implicit", "explicit"]),
            "\"implicit\"",
            "dynamic: implicit or explicit",
        ),
        Key::optional(
            "scheme_type",
            Kind::Choice(&["newmark", "bossak", "central_differences", "central_difference"]),
            "dynamic: time scheme, by default bossak if implicit and central_differences if explicit",
        ),
        Key::new("damp_factor_m", Kind::Number(Range::NOT_POSITIVE), "-0.01", "Bossak's alpha").adjustable(),
        Key::new("newmark_beta", Kind::Number(Range::POSITIVE), "0.25", "Newmark's beta for alpha = 0"),
        Key::new("consistent_mass_matrix", Kind::Bool, "true", "implicit: consistent instead of lumped mass"),
        Key::required("time_stepping", Kind::Object(TIME_STEPPING), "the time step, or the load step [s]").adjustable(),
        Key::new("compute_reactions", Kind::Bool, "true", "compute REACTION on fixed nodes"),
        Key::new("axis_symmetric_flag", Kind::Bool, "false", "axisymmetric about the y axis, x is the radius"),
        Key::new("rotation_dofs", Kind::Bool, "false", "must be false: solids have none"),
        Key::new("volumetric_strain_dofs", Kind::Bool, "false", "must be false: no mixed formulation"),
        Key::new("move_mesh_flag", Kind::Bool, "false", "accepted: the mesh stays where it was"),
        Key::optional("linear_solver_settings", Kind::Any, "the linear solver").adjustable(),
        Key::new("model_import_settings", Kind::Object(MESH_IMPORT), "{}", "mesh of the body"),
        Key::new("material_import_settings", Kind::Object(MATERIAL_IMPORT), "{}", "materials"),
    ],
);

/// What is solved for in each step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Regime {
    /// Equilibrium under the loads of each step.
    Static,
    /// Newmark's or Bossak's scheme.
    Implicit {
        /// The scheme.
        newmark: Newmark,
        /// Consistent instead of lumped mass.
        consistent: bool,
    },
    /// Central differences with lumped mass.
    Explicit {
        /// A step above the stable one stops the run.
        strict: bool,
    },
}

/// Checked settings.
pub struct SolverSettings {
    /// Root part with the body's mesh.
    pub part: String,
    /// Dimension of space.
    pub dimension: usize,
    /// Kinematics; plane stress is a matter of each law.
    pub kinematics: Kinematics,
    /// Static, implicit or explicit.
    pub regime: Regime,
    /// Newton's method.
    pub newton: Newton,
    /// Time step.
    pub stepping: Stepping,
    /// Reactions wanted.
    pub reactions: bool,
    /// Mesh.
    pub mesh: MeshSource,
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
        let kinematics = match (dimension, s.flag("axis_symmetric_flag")) {
            (1, false) => Kinematics::UniaxialStrain,
            (2, false) => Kinematics::PlaneStrain,
            (2, true) => Kinematics::Axisymmetric,
            (3, false) => Kinematics::ThreeDimensional,
            (1 | 3, true) => {
                errors.push(s.error("axis_symmetric_flag", "needs domain_size 2"));
                Kinematics::Axisymmetric
            }
            _ => {
                errors.push(s.error("domain_size", format!("is {dimension}, must be 1, 2 or 3")));
                Kinematics::PlaneStrain
            }
        };
        for key in ["rotation_dofs", "volumetric_strain_dofs"].into_iter().filter(|key| s.flag(key)) {
            errors.push(s.error(key, "the elements of this build have displacements alone").help("set it to false"));
        }
        let regime = errors.absorb(regime(&s));
        let explicit = matches!(regime, Some(Regime::Explicit { .. }));
        if explicit {
            OnNoConvergence::refuse(&s, &mut errors);
        }
        let stepping = errors.absorb(Stepping::read(&s, explicit));
        let mesh = errors.absorb(MeshSource::read(&s, "model_import_settings", folder));
        let materials = errors.absorb(MaterialSource::read(&s, folder));
        let (Some(regime), Some(stepping), Some(mesh), Some(materials)) = (regime, stepping, mesh, materials) else {
            return Err(errors);
        };
        let (newton, part) = (Newton::read(&s, options.kratos_exact), s.text("model_part_name").to_string());
        let reactions = s.flag("compute_reactions");
        let built =
            Self { part, dimension, kinematics, regime, newton, stepping, reactions, mesh, materials, settings: s };
        errors.absorb(built.linear_method(true));
        errors.or(built)
    }

    /// Whether inertia acts by the consistent mass.
    pub fn is_consistent(&self) -> bool {
        matches!(self.regime, Regime::Implicit { consistent: true, .. })
    }

    /// The linear solver for symmetric or unsymmetric tangents.
    ///
    /// # Errors
    /// Unknown solver names and keys.
    pub fn linear_method(&self, symmetric: bool) -> Result<Method, InputErrors> {
        let nature = Nature { symmetric, definite: true, dimension: self.dimension };
        linear::method(self.settings.get("linear_solver_settings"), nature)
    }
}

fn regime(s: &Settings) -> Result<Regime, InputErrors> {
    if s.text("solver_type").to_lowercase().ends_with("static") {
        return Ok(Regime::Static);
    }
    let explicit = s.text("time_integration_method") == "explicit";
    let scheme = s.given("scheme_type").then(|| s.text("scheme_type"));
    if let Some(name) = scheme.filter(|name| name.starts_with("central") != explicit) {
        let method = if explicit { "explicit" } else { "implicit" };
        let help = "newmark and bossak are implicit, central_differences is explicit (time_integration_method)";
        return Err(s.error("scheme_type", format!("{name:?} is no {method} scheme")).help(help).into());
    }
    if explicit {
        let strict = s.nested("time_stepping").is_some_and(|nested| nested.text("time_step_policy") == "strict");
        return Ok(Regime::Explicit { strict });
    }
    let alpha = if scheme == Some("newmark") { 0.0 } else { s.number("damp_factor_m") };
    let newmark = Newmark { alpha, beta: s.number("newmark_beta") };
    Ok(Regime::Implicit { newmark, consistent: s.flag("consistent_mass_matrix") })
}
