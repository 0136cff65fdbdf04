//! Faults of Kratos's implicit solvers: each decision of the solver stands here. They act under
//! `kratos_exact` alone, where results are to be compared with those of Kratos 10.4.4 (spec 03).

use super::forgiving::Forgiving;
use crate::settings::Regime;
use bia_kernel::linalg::LinearSolver;

/// Whether a run repeats the faults.
#[derive(Debug, Clone, Copy)]
pub struct KratosFaults(pub bool);

impl KratosFaults {
    /// An imposed displacement keeps the value that stood on the node at the end of the last step;
    /// what processes write in this step is ignored, but in statics.
    pub fn ignores_imposed(self, regime: Regime) -> bool {
        self.0 && regime != Regime::Static
    }

    /// The static solver never resets NODAL_MASS.
    pub fn piles_up_mass(self, regime: Regime) -> bool {
        self.0 && regime == Regime::Static
    }

    /// Without a residual after the last correction the volume shown is that of the assembly before.
    pub fn shows_old_volume(self, needs_residual: bool) -> bool {
        self.0 && !needs_residual
    }

    /// Shape functions up to this one do not move points; none to use them all.
    pub fn least_function(self) -> Option<f64> {
        self.0.then_some(f64::EPSILON)
    }

    /// The hoop term of the axisymmetric geometric stiffness lacks 1/r²: this tangent is not the
    /// derivative, which shows in the iterates but not in the solution.
    #[inline(always)]
    pub fn hoop<const N: usize>(self, functions: [f64; N], hoop: [f64; N]) -> [f64; N] {
        if self.0 { functions } else { hoop }
    }

    /// REACTION stays zero unless `compute_reactions` asks for it, whoever reads it.
    pub fn hides_reactions(self) -> bool {
        self.0
    }

    /// Mixed formulations show normal stresses shifted by the difference of the pressure and their mean:
    /// in the plane that of two, which is not the mean stress.
    pub fn shifts_stress(self) -> bool {
        self.0
    }

    /// Singular but consistent systems are solved.
    pub fn forgive(self, solver: Box<dyn LinearSolver>, symmetric: bool) -> Box<dyn LinearSolver> {
        if self.0 && symmetric { Box::new(Forgiving::new(solver)) } else { solver }
    }
}

/// Shifts stresses such that their mean is `pressure`.
pub fn shift_mean(stresses: &mut [f64], pressure: f64) {
    let shift = pressure - stresses.iter().sum::<f64>() / stresses.len() as f64;
    stresses.iter_mut().for_each(|stress| *stress += shift);
}
