//! `solver_settings`, with Kratos's keys and defaults where Kratos has them.

use crate::riemann::RiemannSolver;
use crate::scheme::Method;
use crate::stages::TimeIntegration;
use bia_constitutive::{Kinematics, MATERIAL_IMPORT, MaterialSource};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Parameters, Range, Settings};
use bia_kernel::solving::mesh::MESH_IMPORT;
use bia_kernel::solving::stepping::TIME_STEPPING;
use bia_kernel::solving::{MeshSource, Stepping};
use std::path::Path;

/// Keys of `solver_settings`.
pub const KEYS: &[Key] = &[
    Key::required("solver_type", Kind::Text, "dgmpm"),
    Key::new("model_part_name", Kind::Text, "\"Background_Grid\"", "root part with the cells, all of which are filled"),
    Key::required("domain_size", Kind::Integer { min: 1 }, "dimension of space: 1, 2 or 3"),
    Key::new("echo_level", Kind::Integer { min: 0 }, "0", "ignored: --quiet and the log level rule"),
    Key::new(
        "strain",
        Kind::Choice(&["finite", "small"]),
        "\"finite\"",
        "finite: first Piola-Kirchhoff stress of the law; small: Hooke's law with the law's tangent at the start",
    ),
    Key::new(
        "riemann_solver",
        Kind::Choice(RiemannSolver::NAMES),
        "\"linearized\"",
        "linearized: all waves, exact for linear laws; hll: the fastest wave alone; exact: shocks and fans, in 1D",
    ),
    Key::new(
        "transverse_correction",
        Kind::Bool,
        "false",
        "euler: corner transport upwind, which makes a Courant number of 1 stable in the plane",
    ),
    Key::new(
        "time_integration",
        Kind::Choice(TimeIntegration::NAMES),
        "\"euler\"",
        "forward Euler, mid-point rule, or strong-stability-preserving scheme of order 3",
    ),
    Key::new(
        "point_placement",
        Kind::Choice(&["even", "gauss"]),
        "\"even\"",
        "MATERIAL_POINTS_PER_ELEMENT points (1 by default) evenly spaced, or at Gauss points",
    ),
    Key::optional("point_positions", Kind::List, "instead: positions in every cell, each [x, …] from 0 to 1 across it"),
    Key::new(
        "stability_criterion",
        Kind::Choice(&["spectral", "no_overshoot"]),
        "\"spectral\"",
        "what the stable Courant number means: no wave grows, or (1D) no value leaves the range of its neighbours",
    ),
    Key::optional(
        "stable_courant_number",
        Kind::Number(Range::POSITIVE),
        "the stable Courant number, if it is known: spares its analysis at the start",
    ),
    Key::new("transmitting_parts", Kind::Texts, "[]", "parts of the mesh through whose boundary faces waves leave"),
    Key::required("time_stepping", Kind::Object(TIME_STEPPING), "the time step [s]").adjustable(),
    Key::new("model_import_settings", Kind::Object(MESH_IMPORT), "{}", "mesh of the cells"),
    Key::new("material_import_settings", Kind::Object(MATERIAL_IMPORT), "{}", "materials"),
];

/// Where the cells hold their points.
#[derive(Debug, Clone, PartialEq)]
pub enum Placement {
    /// Evenly spaced.
    Even,
    /// At Gauss points.
    Gauss,
    /// At these places, from 0 to 1 across the cell.
    At(Vec<[f64; 3]>),
}

/// Checked settings.
pub struct SolverSettings {
    /// Root part with the cells.
    pub part: String,
    /// Kinematics; plane stress is a matter of each law.
    pub kinematics: Kinematics,
    /// Hooke's law with the law's tangent.
    pub small_strain: bool,
    /// The scheme.
    pub method: Method,
    /// Points of a cell.
    pub placement: Placement,
    /// Criterion of the stable step is that nothing overshoots.
    pub no_overshoot: bool,
    /// The stable Courant number, if it is given.
    pub courant_limit: Option<f64>,
    /// Parts through which waves leave.
    pub transmitting: Vec<String>,
    /// A step above the stable one stops the run.
    pub strict: bool,
    /// Time step.
    pub stepping: Stepping,
    /// Mesh.
    pub mesh: MeshSource,
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
        let kinematics = match dimension {
            1 => Kinematics::UniaxialStrain,
            3 => Kinematics::ThreeDimensional,
            _ => Kinematics::PlaneStrain,
        };
        if dimension > 3 {
            errors.push(s.error("domain_size", format!("is {dimension}, must be 1, 2 or 3")));
        }
        let method = Method {
            time_integration: TimeIntegration::of(s.text("time_integration")),
            riemann: RiemannSolver::of(s.text("riemann_solver")),
            transverse: s.flag("transverse_correction"),
        };
        check_method(&s, method, dimension, &mut errors);
        let placement = errors.absorb(placement(&s, dimension));
        let stepping = errors.absorb(Stepping::read(&s, true));
        let mesh = errors.absorb(MeshSource::read(&s, "model_import_settings", folder));
        let materials = errors.absorb(MaterialSource::read(&s, folder));
        errors.or(())?;
        let (Some(placement), Some(stepping), Some(mesh), Some(materials)) = (placement, stepping, mesh, materials)
        else {
            return Err(InputErrors::default());
        };
        Ok(Self {
            part: s.text("model_part_name").to_string(),
            kinematics,
            small_strain: s.text("strain") == "small",
            method,
            placement,
            no_overshoot: s.text("stability_criterion") == "no_overshoot",
            courant_limit: s.get("stable_courant_number").map(|_| s.number("stable_courant_number")),
            transmitting: s.texts("transmitting_parts"),
            strict: s.nested("time_stepping").is_some_and(|nested| nested.text("time_step_policy") == "strict"),
            stepping,
            mesh,
            materials,
            settings: s,
        })
    }
}

/// Choices that do not go together.
fn check_method(s: &Settings, method: Method, dimension: usize, errors: &mut InputErrors) {
    if method.riemann == RiemannSolver::Exact && dimension > 1 {
        let message = "the exact Riemann solver is for one dimension";
        errors.push(s.error("riemann_solver", message).help("linearized is exact for linear laws in any dimension"));
    }
    if method.riemann == RiemannSolver::Exact && s.text("strain") == "small" {
        let message = "small strain has no shocks and fans";
        errors.push(s.error("riemann_solver", message).help("linearized is exact there"));
    }
    if method.transverse && method.time_integration != TimeIntegration::Euler {
        let message = "the transverse correction is for time_integration \"euler\"";
        errors.push(s.error("transverse_correction", message).help("rk2 with one point a cell has it built in"));
    }
    if s.text("stability_criterion") == "no_overshoot" && dimension > 1 {
        let message = "the criterion no_overshoot is for one dimension";
        errors.push(s.error("stability_criterion", message).help("use spectral"));
    }
}

fn placement(s: &Settings, dimension: usize) -> Result<Placement, InputErrors> {
    let Some(list) = s.get("point_positions") else {
        return Ok(if s.text("point_placement") == "gauss" { Placement::Gauss } else { Placement::Even });
    };
    let mut errors = InputErrors::default();
    let mut positions = Vec::new();
    for entry in list.entries() {
        let numbers = entry.entries();
        let values: Vec<f64> = numbers.iter().filter_map(|number| number.value().as_f64()).collect();
        if values.len() == dimension && numbers.len() == dimension && values.iter().all(|x| (0.0..=1.0).contains(x)) {
            positions.push(std::array::from_fn(|a| values.get(a).copied().unwrap_or(0.0)));
        } else {
            errors.push(entry.error(format!("must be a list of {dimension} numbers from 0 to 1")));
        }
    }
    if list.entries().is_empty() {
        errors.push(list.error("names no position"));
    }
    errors.or(Placement::At(positions))
}
