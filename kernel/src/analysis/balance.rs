//! Energy that comes or goes by itself: told at the end of a run on whose bodies all work is known.

use super::Analysis;
use crate::solving::solver::MechanicalEnergy;

/// Growth, as a share of what moves and strains, that is told.
const GROWTH: f64 = 0.01;
/// The same where loads or supports have worked: motion and strain that are half a step apart differ by up to a
/// fifth at the largest stable step.
const GROWTH_AT_WORK: f64 = 0.25;
/// Loss of what should be kept, as a share of the start, that is told: methods that dissipate do so by nature.
const LOSS: f64 = 0.1;
/// Share of the work that the weight could do beside which less motion is none.
const REST: f64 = 1e-3;

/// That energy came or went without work from the start to the end.
fn unbalanced(start: MechanicalEnergy, end: MechanicalEnergy) -> Option<String> {
    // At rest without weight there is nothing beside which round-off were small.
    let is_worked_on = end.work != 0.0;
    if start.own == 0.0 && start.height == 0.0 && !is_worked_on {
        return None;
    }
    let change = end.own + end.potential - start.own - start.potential - end.work;
    let scale = start.own.max(end.own).max(REST * end.height);
    let growth = if is_worked_on { GROWTH_AT_WORK } else { GROWTH };
    let (what, advice) = if change > growth * scale {
        (
            "grown",
            "a smaller time step, smoother functions or ones that stay with the body, or a scheme that conserves energy, keep it",
        )
    } else if end.is_kept && !is_worked_on && -change > LOSS * start.own {
        ("fallen", "finer cells and steps, functions that stay with the body, or less PIC, keep more of it")
    } else {
        return None;
    };
    let worked = match (is_worked_on, end.is_kept) {
        (true, _) => format!("loads and supports have worked {:.4e} J on the bodies, but", end.work),
        (_, true) => "nothing has worked on the bodies, and yet".to_string(),
        _ => "nothing but weight has worked on the bodies, and yet".to_string(),
    };
    let more = if is_worked_on { " more" } else { "" };
    let (change, own) = (change.abs(), start.own.max(end.own));
    Some(format!(
        "{worked} their energy has {what} by {change:.4e} J{more}, beside {own:.4e} J in motion and strain: {advice}"
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
        let heavy = |own, potential| MechanicalEnergy { own, potential, height: 10.0, ..MechanicalEnergy::default() };
        assert!(
            told(heavy(0.0, 10.0), heavy(5.0, 5.0)).is_empty() && told(heavy(0.0, 10.0), heavy(0.0, 3.0)).is_empty()
        );
        assert!(told(heavy(0.0, 10.0), heavy(5.1, 5.0)).contains("grown"));
        assert!(told(heavy(0.0, 10.0), heavy(1e-6, 10.0)).is_empty());
        // What loads have worked is no growth, and what comes beside is, beyond the error of their work.
        let worked = |own: f64| MechanicalEnergy { own, work: 1.0, ..MechanicalEnergy::default() };
        assert!(told(kept(0.0), worked(1.2)).is_empty() && told(kept(0.0), worked(0.5)).is_empty());
        assert!(
            told(kept(0.0), worked(1.5))
                .contains("have worked 1.0000e0 J on the bodies, but their energy has grown by 5.0000e-1 J more")
        );
    }
}
