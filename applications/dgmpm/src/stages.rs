//! Time integration as stages of one form,
//!
//! U ← base U⁰ + keep U + step Δt L(U),
//!
//! where U⁰ are the nodal values that the points give at the start of the step (Shu and Osher, J.
//! Comput. Phys. 77 (1988) 439-471). The points are mapped to the nodes before the first stage and
//! back after the last one alone.

/// Where values stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Site {
    /// At the points of a cell.
    Points,
    /// At its own nodes.
    Nodes,
}

/// One stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// Where U comes from.
    pub from: Site,
    /// Where it goes.
    pub to: Site,
    /// Factor of the values at the start of the step, if U is not those.
    pub base: f64,
    /// Factor of U.
    pub keep: f64,
    /// Share of the time step.
    pub step: f64,
    /// Weight of this stage's fluxes in the whole step.
    pub weight: f64,
}

/// Time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeIntegration {
    /// Forward Euler.
    Euler,
    /// Mid-point rule of order 2.
    MidPoint,
    /// Strong-stability-preserving scheme of order 3.
    StrongStability3,
}

const fn stage(from: Site, to: Site, [base, keep, step]: [f64; 3], weight: f64) -> Stage {
    Stage { from, to, base, keep, step, weight }
}

impl TimeIntegration {
    /// Names in the input.
    pub const NAMES: &'static [&'static str] = &["euler", "rk2", "ssp_rk3"];

    /// From a name in the input.
    pub fn of(name: &str) -> Self {
        match name {
            "rk2" => Self::MidPoint,
            "ssp_rk3" => Self::StrongStability3,
            _ => Self::Euler,
        }
    }

    /// Its stages.
    pub const fn stages(self) -> &'static [Stage] {
        use Site::{Nodes, Points};
        match self {
            Self::Euler => const { &[stage(Points, Points, [0.0, 1.0, 1.0], 1.0)] },
            Self::MidPoint => {
                const { &[stage(Points, Nodes, [0.0, 1.0, 0.5], 0.0), stage(Nodes, Points, [1.0, 0.0, 1.0], 1.0)] }
            }
            Self::StrongStability3 => {
                const {
                    &[
                        stage(Points, Nodes, [0.0, 1.0, 1.0], 1.0 / 6.0),
                        stage(Nodes, Nodes, [0.75, 0.25, 0.25], 1.0 / 6.0),
                        stage(Nodes, Points, [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], 2.0 / 3.0),
                    ]
                }
            }
        }
    }

    /// Name for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Euler => "forward Euler",
            Self::MidPoint => "mid-point rule (RK2)",
            Self::StrongStability3 => "strong-stability-preserving RK3",
        }
    }
}
