//! The mixed displacement-pressure formulation and its stabilisation.

use bia_constitutive::VolumetricLaw;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range, Settings};

/// Keys of `stabilization_parameters`.
pub const PARAMETERS: &[Key] = &[
    Key::new("c1", Kind::Number(Range::POSITIVE), "1.0", "tau1 = 1 / (2 c1 mu / h² + c_t rho / (beta dt²))"),
    Key::optional(
        "c2",
        Kind::Number(Range::NOT_NEGATIVE),
        "tau2 = 1 / (1 / (c2 (2 mu + s h²)) + 1 / kappa), in fluids s = c_t rho / (10 beta dt²), else 0; by default 1, but 0 in \
         solids unless asgs",
    ),
    Key::optional(
        "c_t",
        Kind::Number(Range::NOT_NEGATIVE),
        "dynamic part of tau1; by default 0 in solids, 1 in fluids",
    ),
    Key::optional("inertia", Kind::Bool, "asgs: inertia in the residual; by default false in solids, true in fluids"),
    Key::new(
        "volume_correction",
        Kind::Number(Range::FRACTION),
        "0.0",
        "fluids in dynamics: share of the volume by which points overfill the surroundings of a node that each step \
         takes out by moving them apart; 0.1 for runs of many steps, in which water would sink into itself",
    ),
    Key::new(
        "element_size",
        Kind::Choice(&["edge", "circle"]),
        "\"edge\"",
        "h: edge of the square or cube like a cell, or the diameter of its circle as before Kratos 10",
    ),
];

/// How pressures are kept from oscillating.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stabilization {
    /// Not at all.
    None,
    /// Polynomial pressure projection (Dohrmann and Bochev 2004).
    Ppp,
    /// Algebraic subgrid scales.
    Asgs,
    /// Orthogonal subgrid scales.
    Osgs,
}

/// Whose formulas a stabilisation takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// Those of Kratos: 10.4.4 for none and PPP, its development branch for ASGS.
    Kratos,
    /// Consistent ones with the exact tangent.
    Consistent,
}

/// How large a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementSize {
    /// Edge of the square or cube of equal area or volume, by the edges at the cell's first corner.
    Edge,
    /// Diameter of the circle of equal area; in space 0.60046878 times the root of the volume.
    Circle,
}

/// Settings of the formulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixedSettings {
    /// Stabilisation.
    pub stabilization: Stabilization,
    /// Variant; none if not given, which means Kratos's where Kratos is repeated and else the
    /// consistent one.
    pub variant: Option<Variant>,
    /// Volumetric law.
    pub volumetric: VolumetricLaw,
    /// Constant of τ1.
    pub c1: f64,
    /// Constant of τ2, if given.
    pub c2: Option<f64>,
    /// Dynamic part of τ1, if given.
    pub c_t: Option<f64>,
    /// Inertia in the residual of ASGS, if given.
    pub inertia: Option<bool>,
    /// Element size.
    pub size: ElementSize,
    /// Share of too much volume that a step takes out.
    pub volume_correction: f64,
}

impl MixedSettings {
    /// As the settings say; none without `pressure_dofs`.
    pub fn of(s: &Settings) -> Option<Self> {
        if !s.flag("pressure_dofs") {
            return None;
        }
        let stabilization = match s.text("stabilization") {
            "none" => Stabilization::None,
            "asgs" => Stabilization::Asgs,
            "osgs" => Stabilization::Osgs,
            _ => Stabilization::Ppp,
        };
        let variant = s.given("stabilization_variant").then(|| match s.text("stabilization_variant") {
            "kratos" => Variant::Kratos,
            _ => Variant::Consistent,
        });
        let volumetric = if s.text("volumetric_law") == "miehe" { VolumetricLaw::Miehe } else { VolumetricLaw::Linear };
        let nested = s.nested("stabilization_parameters");
        let number = |key: &str| nested.filter(|n| n.given(key)).map(|n| n.number(key));
        Some(Self {
            stabilization,
            variant,
            volumetric,
            c1: number("c1").unwrap_or(1.0),
            c2: number("c2"),
            c_t: number("c_t"),
            inertia: nested.filter(|n| n.given("inertia")).map(|n| n.flag("inertia")),
            volume_correction: number("volume_correction").unwrap_or(0.0),
            size: match nested.map(|n| n.text("element_size")) {
                Some("circle") => ElementSize::Circle,
                _ => ElementSize::Edge,
            },
        })
    }

    /// The variant of a run.
    pub fn variant(&self, kratos_exact: bool) -> Variant {
        self.variant.unwrap_or(if kratos_exact { Variant::Kratos } else { Variant::Consistent })
    }
}

/// What the formulation cannot be combined with.
pub fn check_mixed(s: &Settings, is_explicit: bool, errors: &mut InputErrors) {
    let Some(mixed) = MixedSettings::of(s) else { return };
    let mut refuse = |wrong: bool, key: &str, message: &str, help: &str| {
        if wrong {
            errors.push(s.error(key, message).help(help));
        }
    };
    refuse(is_explicit, "pressure_dofs", "is for implicit runs", "set time_integration_method to \"implicit\"");
    let dimension = s.integer("domain_size");
    refuse(
        s.flag("axis_symmetric_flag") || dimension == 1,
        "pressure_dofs",
        "is for plane strain and three dimensions",
        "set pressure_dofs to false and use a compressible law",
    );
    refuse(s.text("basis") != "mesh", "basis", "must be \"mesh\" with pressure_dofs", "leave it out");
    let conserves = s.given("scheme_type") && s.text("scheme_type") == "energy_conserving";
    refuse(conserves, "scheme_type", "\"energy_conserving\" has no nodal pressures", "use newmark or bossak");
    refuse(
        mixed.variant == Some(Variant::Kratos) && mixed.stabilization == Stabilization::Osgs,
        "stabilization_variant",
        "\"kratos\" has no osgs",
        "set it to \"consistent\", or stabilization to \"asgs\"",
    );
}
