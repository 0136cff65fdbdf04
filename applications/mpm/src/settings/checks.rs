//! Choices that do not go together.

use super::{Basis, Discretisation, ExplicitSettings, Frame, Regime, Scheme, Transfer};
use super::{conserves_energy, explicit, scheme_name};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::Settings;
use bia_kernel::solving::newton::OnNoConvergence;

/// What the energy-conserving scheme and implicit transfers cannot be combined with.
pub fn check_implicit(s: &Settings, regime: Regime, errors: &mut InputErrors) {
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
pub fn check_scheme(s: &Settings, is_explicit: bool, errors: &mut InputErrors) {
    let explicit_schemes = ["forward_euler", "central_difference", "velocity_verlet", "yoshida"];
    if let Some(name) = scheme_name(s)
        && explicit_schemes.contains(&name) != is_explicit
    {
        let help = if is_explicit {
            "explicit: forward_euler, central_difference, velocity_verlet or yoshida"
        } else {
            "for explicit schemes set solver_type \"dynamic\" and time_integration_method \"explicit\""
        };
        let method = if is_explicit { "explicit" } else { "implicit" };
        errors.push(s.error("scheme_type", format!("{name:?} is no {method} scheme")).help(help));
    }
    if s.flag("is_pqmpm") {
        let help = "set is_pqmpm to false: each point then belongs to one cell";
        errors.push(s.error("is_pqmpm", "the partitioned quadrature is not part of this build").help(help));
    }
}

/// Choices of explicit runs that do not go together.
pub fn check_explicit(s: &Settings, errors: &mut InputErrors) {
    check_polynomials(s, errors);
    OnNoConvergence::refuse(s, errors);
    let ExplicitSettings { scheme, transfer, compressible, moves_by_point, consistent_mass, .. } = explicit(s);
    let frame = Discretisation::of(s).frame;
    let mut refuse = |wrong: bool, key: &str, message: &str, help: &str| {
        if wrong {
            errors.push(s.error(key, message).help(help));
        }
    };
    let (total, flip) = (frame == Frame::Total, transfer == Transfer::Flip(1.0));
    let symplectic = scheme.is_symplectic();
    let add_frame = "add \"frame\": \"total_lagrangian\"";
    refuse(symplectic && !total, "scheme_type", "needs the total Lagrangian frame", add_frame);
    refuse(
        symplectic && !flip,
        "transfer",
        "must be \"flip\" with flip_fraction 1: PIC dissipates",
        "or forward_euler",
    );
    refuse(total && !compressible, "compressible", "must be true in the total Lagrangian frame", "leave it out");
    refuse(moves_by_point && !total, "position_update", "\"point\" is for the total Lagrangian frame", add_frame);
    let musl = scheme == Scheme::ModifiedUpdateStressLast;
    let help =
        "forward_euler with stress_update \"musl\", velocity_verlet or yoshida, and \"flip\" with flip_fraction 1";
    refuse(
        consistent_mass && !((symplectic || musl) && flip),
        "consistent_mass_matrix",
        "does not go with this scheme or transfer",
        help,
    );
    let affine = matches!(transfer, Transfer::Apic | Transfer::Tpic);
    let axisymmetric = s.flag("axis_symmetric_flag");
    refuse(affine && axisymmetric, "transfer", "an affine transfer is not for axisymmetric scenes", "use \"flip\"");
    refuse(
        affine && scheme == Scheme::CentralDifference,
        "transfer",
        "an affine transfer needs forward_euler",
        "set scheme_type to \"forward_euler\"",
    );
    refuse(
        !flip && scheme == Scheme::CentralDifference,
        "transfer",
        "central_difference has \"flip\" with flip_fraction 1",
        "set scheme_type to \"forward_euler\"",
    );
}

/// Lagrange polynomials of degree 2 and more change sign: some projections amplify, whatever the step.
fn check_polynomials(s: &Settings, errors: &mut InputErrors) {
    let ExplicitSettings { scheme, transfer, consistent_mass, .. } = explicit(s);
    let Basis::Lagrange(degree @ 2..) = Discretisation::of(s).basis else { return };
    let mut refuse = |wrong: bool, key: &str, message: &str, help: &str| {
        if wrong {
            errors.push(s.error(key, message).help(help));
        }
    };
    refuse(
        transfer == Transfer::Apic,
        "transfer",
        "\"apic\" does not exist for Lagrange polynomials of degree 2 and more: they reproduce quadratics",
        "use \"flip\" or \"b_spline\"",
    );
    refuse(
        transfer == Transfer::Tpic,
        "transfer",
        "\"tpic\" is unstable with Lagrange polynomials of degree 2 and more, whatever the step",
        "use \"flip\" or \"b_spline\"",
    );
    refuse(
        degree > 2 && !consistent_mass && (transfer != Transfer::Flip(1.0) || scheme == Scheme::UpdateStressLast),
        "basis_order",
        "Lagrange polynomials of degree 3 and more with lumped mass need flip_fraction 1 and any stress_update but \
         \"usl\": else the run is unstable, whatever the step",
        "use flip_fraction 1, a lower order, or \"b_spline\"",
    );
    refuse(
        degree > 5 && !consistent_mass,
        "basis_order",
        "lumped masses of Lagrange polynomials of degree 6 are negative",
        "set consistent_mass_matrix to true",
    );
}
