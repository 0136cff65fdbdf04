//! Energy that comes or goes by itself: told at the end of a run that nothing but weight has worked on.

use super::Analysis;
use crate::solving::solver::MechanicalEnergy;

/// Growth, as a share of what moves and strains, that is told.
const GROWTH: f64 = 0.01;
/// Loss of what should be kept, as a share of the start, that is told: methods that dissipate do so by nature.
const LOSS: f64 = 0.1;
/// Share of the work that the weight could do beside which less motion is none.
const REST: f64 = 1e-3;

/// That energy came or went without work from the start to the end.
fn unbalanced(start: MechanicalEnergy, end: MechanicalEnergy) -> Option<String> {
    // At rest without weight there is nothing beside which round-off were small.
    if start.own == 0.0 && start.height == 0.0 {
        return None;
    }
    let change = end.own + end.potential - start.own - start.potential;
    let scale = start.own.max(end.own).max(REST * end.height);
    let (what, advice) = if change > GROWTH * scale {
        ("grown", "a smaller time step, or a scheme that conserves energy, keeps it")
    } else if end.is_kept && -change > LOSS * start.own {
        ("fallen", "finer cells and steps, functions that stay with the body, or less PIC, keep more of it")
    } else {
        return None;
    };
    let weight = if end.is_kept { "nothing" } else { "nothing but weight" };
    Some(format!(
        "{weight} has worked on the bodies, and yet their energy has {what} by {:.4e} J, beside {:.4e} J in motion and \
         strain: {advice}",
        change.abs(),
        start.own.max(end.own)
    ))
}

impl Analysis {
    /// That energy came or went without work. A scene that is known to work on its bodies is not judged.
    pub(super) fn unbalanced(&self) -> Option<String> {
        unbalanced(self.energy_at_start?, self.solver.mechanical_energy(&self.model)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_and_loss_are_told_beyond_their_shares() {
        let kept = |own: f64| MechanicalEnergy { own, is_kept: true, ..MechanicalEnergy::default() };
        let told = |start, end| unbalanced(start, end).unwrap_or_default();
        assert!(told(kept(1.0), kept(1.02)).contains("grown by 2.0000e-2 J"));
        assert!(told(kept(1.0), kept(0.8)).contains("fallen"));
        assert!(told(kept(1.0), kept(1.005)).is_empty() && told(kept(1.0), kept(0.95)).is_empty());
        assert!(told(kept(0.0), kept(1.0)).is_empty());
        // A weight may be lost to friction and impact, but not won; at rest motion is measured by its height.
        let heavy = |own, potential| MechanicalEnergy { own, potential, height: 10.0, is_kept: false };
        assert!(
            told(heavy(0.0, 10.0), heavy(5.0, 5.0)).is_empty() && told(heavy(0.0, 10.0), heavy(0.0, 3.0)).is_empty()
        );
        assert!(told(heavy(0.0, 10.0), heavy(5.1, 5.0)).contains("grown"));
        assert!(told(heavy(0.0, 10.0), heavy(1e-6, 10.0)).is_empty());
    }
}
