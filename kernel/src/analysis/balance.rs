//! Energy that nothing works on: told at the end of a run that has not kept it.

use super::Analysis;

/// Growth, as a share of the energy at the start, that is told.
const GROWTH: f64 = 0.01;
/// Loss, as a share of the energy at the start, that is told: methods that dissipate do so by nature.
const LOSS: f64 = 0.1;

impl Analysis {
    /// The energy of a scene in J, where all of it is known and nothing works on it.
    pub(super) fn closed_energy(&self) -> Option<f64> {
        let closed = self.solver.is_closed(&self.model);
        closed.then(|| self.solver.energies(&self.model).iter().map(|(_, energy)| energy).sum())
    }

    /// That energy came or went without work. A scene that works on its bodies at the start or at the end is
    /// not judged.
    pub(super) fn unbalanced(&self) -> Option<String> {
        let (start, end) = self.energy_at_start.zip(self.closed_energy())?;
        if start <= 0.0 || (end >= (1.0 - LOSS) * start && end <= (1.0 + GROWTH) * start) {
            return None;
        }
        let (what, advice) = match end > start {
            true => ("grown", "a smaller time step, or a scheme that conserves energy, keeps it"),
            false => {
                ("fallen", "finer cells and steps, functions that stay with the body, or less PIC, keep more of it")
            }
        };
        Some(format!(
            "nothing works on the bodies at the start and the end of the run, and yet their energy has {what} from \
             {start:.4e} J to {end:.4e} J: unless something worked in between, {advice}"
        ))
    }
}
