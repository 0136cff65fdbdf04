//! The Courant number c Δt/h at which a wave becomes unstable, for each scheme and basis.
//!
//! FLIP with the stress updated first or with mapped velocities, velocity Verlet and central differences
//! are the leapfrog of a mass that is M with the consistent mass and M_L M⁻¹ M_L with the lumped one:
//! c Δt/h = 2/ω_max. Last updated stresses and the other transfers have the spectral radius of the map
//! from step to step instead. Computed for a uniform grid with free ends, with two or more points a cell
//! and direction (consistent mass: more than the degree for Lagrange polynomials), evenly placed or at
//! Gauss points, and Poisson's ratios up to 0.45; the least is given, rounded down. Bodies one or two
//! cells thick bear 10 % less.

use crate::settings::{Basis, Discretisation, ExplicitSettings, Frame, Scheme, Transfer};

/// Limits of one basis.
struct Limits {
    /// FLIP with lumped mass, in one, two and three dimensions.
    lumped: [f64; 3],
    /// The same with consistent mass.
    consistent: [f64; 3],
    /// Stress updated last, on a line.
    last: f64,
    /// Affine transfers on a line, else and with the stress updated last.
    affine: [f64; 2],
}

const HATS: Limits =
    Limits { lumped: [1.63, 1.43, 1.28], consistent: [0.5, 0.4, 0.34], last: 0.7, affine: [0.99, 0.99] };
const LAGRANGE: [Limits; 4] = [
    Limits { lumped: [0.5, 0.4, 0.35], consistent: [0.19, 0.15, 0.12], last: 0.3, affine: [0.0; 2] },
    Limits { lumped: [0.26, 0.18, 0.15], consistent: [0.097, 0.079, 0.063], last: 0.0, affine: [0.0; 2] },
    // Of higher degree on lines alone.
    Limits { lumped: [0.068; 3], consistent: [0.055; 3], last: 0.0, affine: [0.0; 2] },
    Limits { lumped: [0.05; 3], consistent: [0.031; 3], last: 0.0, affine: [0.0; 2] },
];
const SEXTIC: Limits = Limits { lumped: [0.0; 3], consistent: [0.018; 3], last: 0.0, affine: [0.0; 2] };
const QUADRATIC_SPLINES: Limits =
    Limits { lumped: [1.37, 1.18, 1.02], consistent: [0.37, 0.25, 0.2], last: 0.66, affine: [0.93, 0.78] };
const CUBIC_SPLINES: Limits =
    Limits { lumped: [1.07, 0.94, 0.8], consistent: [0.15, 0.1, 0.075], last: 0.5, affine: [0.74, 0.58] };

/// What Yoshida's longest stage leaves of the limit of a single stage: 1.5734/2.
const YOSHIDA: f64 = 0.786;

/// Courant number that a wave bears with these choices, in so many dimensions; at most 1 in the updated
/// frame, where points may stand anywhere in their cells.
pub fn limit(explicit: &ExplicitSettings, discretisation: Discretisation, dimension: usize) -> f64 {
    let Discretisation { frame, basis, .. } = discretisation;
    let limits = match basis {
        Basis::Mesh | Basis::Lagrange(..=1) | Basis::BSpline(..=1) => &HATS,
        Basis::Lagrange(degree) => LAGRANGE.get(degree - 2).unwrap_or(&SEXTIC),
        Basis::BSpline(2) => &QUADRATIC_SPLINES,
        Basis::BSpline(_) => &CUBIC_SPLINES,
    };
    let last = explicit.scheme == Scheme::UpdateStressLast;
    let on_a_line = match explicit.transfer {
        Transfer::Apic | Transfer::Tpic => limits.affine[usize::from(last)],
        _ if last => limits.last,
        // PIC costs hats and splines 15 % of the step, XPIC 3 %.
        Transfer::Flip(share) if limits.affine[0] > 0.0 => limits.lumped[0] * (0.85 + 0.15 * share),
        Transfer::Xpic(_) => limits.lumped[0] * 0.97,
        Transfer::Flip(_) => limits.lumped[0],
    };
    let in_space = dimension.clamp(1, 3) - 1;
    let wave =
        if explicit.consistent_mass { limits.consistent[in_space] } else { on_a_line * limits.lumped_share(in_space) };
    let staged = if explicit.scheme == Scheme::Yoshida { YOSHIDA * wave } else { wave };
    if frame == Frame::Updated { staged.min(1.0) } else { staged }
}

impl Limits {
    /// What more dimensions leave of the limit on a line.
    fn lumped_share(&self, in_space: usize) -> f64 {
        if self.lumped[0] > 0.0 { self.lumped[in_space] / self.lumped[0] } else { 0.0 }
    }
}
