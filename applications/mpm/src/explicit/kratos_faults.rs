//! Faults of Kratos's explicit solver: here in full, and nowhere else. They act under
//! `kratos_exact` alone, where results are to be compared with those of Kratos 10.4.4 (spec 04).

use bia_constitutive::tensor::{Tensor, product, transpose};
use bia_kernel::lanes::{Lanes, Real};
use nalgebra::Matrix3;
use pulp::Simd;

/// Whether a run repeats the faults.
#[derive(Debug, Clone, Copy)]
pub struct KratosFaults(pub bool);

impl KratosFaults {
    /// A point may lie outside its cell by less than the search tolerance. Kratos then leaves the
    /// nodes with negative functions out of its list of nodes but not their rows out of the
    /// gradients, so that nodes behind them get the gradient of another node.
    #[inline(always)]
    pub fn misalign<const D: usize, const N: usize>(self, functions: &mut [f64; N], gradients: &mut [[f64; D]; N]) {
        if !self.0 || functions.iter().all(|n| *n >= 0.0) {
            return;
        }
        let rows = *gradients;
        let mut row = 0;
        for i in 0..N {
            if functions[i] < 0.0 {
                (functions[i], gradients[i]) = (0.0, [0.0; D]);
            } else {
                gradients[i] = rows[row];
                row += 1;
            }
        }
    }

    /// Whether [`misalign`](Self::misalign) does anything at one of several points in step.
    #[inline(always)]
    pub fn misaligns<S: Simd, const N: usize>(self, functions: &[Lanes<S>; N]) -> bool {
        if !self.0 {
            return false;
        }
        let mut least = functions[0];
        for i in 1..N {
            least = least.min(functions[i]);
        }
        !least.all_within(0.0, f64::MAX)
    }

    /// Kratos turns the increment of strain instead of the strain, and deforms with the increment
    /// instead of the velocity gradient: F has no rotation and stress does not turn with the body.
    /// `step` is Δt times the velocity gradient. None without the fault.
    #[inline(always)]
    pub fn increment<R: Real>(self, step: &Tensor<R>) -> Option<Tensor<R>> {
        // No closure: that would not be compiled for the vectors' machine (see `bia_kernel::lanes`).
        if !self.0 {
            return None;
        }
        let turned = transpose(step);
        let (mut rate, mut spin) = (*step, *step);
        for i in 0..3 {
            for j in 0..3 {
                rate[i][j] = (step[i][j] + turned[i][j]) * 0.5;
                spin[i][j] = (step[i][j] - turned[i][j]) * 0.5;
            }
        }
        let (forward, backward) = (product(&rate, &spin), product(&spin, &rate));
        for i in 0..3 {
            for j in 0..3 {
                rate[i][j] += forward[i][j] - backward[i][j];
            }
        }
        Some(rate)
    }

    /// The deformation gradient that laws take for that of the step's start: Kratos never commits
    /// it, so that it is always the identity and a fluid's resistance grows with its strain.
    #[inline(always)]
    pub fn previous(self, gradient: &Matrix3<f64>) -> Matrix3<f64> {
        if self.0 { Matrix3::identity() } else { *gradient }
    }

    /// Kratos does not commit the history of laws.
    pub fn forgets_history(self) -> bool {
        self.0
    }

    /// What is shown as strain: Kratos shows the accumulated one for every law.
    pub fn shows_accumulated_strain(self) -> bool {
        self.0
    }

    /// Walls to slide along do not act in explicit runs of Kratos.
    pub fn ignores_walls(self) -> bool {
        self.0
    }

    /// Kratos holds nodes with an imposed displacement, whatever its value.
    pub fn imposed_velocity(self, displacement: f64, time_step: f64) -> f64 {
        if self.0 { 0.0 } else { displacement / time_step }
    }

    /// Kratos resets active nodes alone: others show what they had when they last were active, and
    /// active ones show no displacement.
    pub fn shows_old_nodes(self) -> bool {
        self.0
    }

    /// Mass below which a node is left alone, given the largest nodal mass: Kratos takes an absolute
    /// number.
    pub fn least_mass(self, largest: f64) -> f64 {
        if self.0 { f64::EPSILON } else { f64::EPSILON * largest }
    }

    /// Whether nodes without mass are at rest, even where a point's gradients reach them, and light nodes move
    /// by their own forces.
    pub fn stops_light_nodes(self) -> bool {
        self.0
    }

    /// Functions up to this one do not carry conditions; none to let all do so.
    pub fn least_function(self) -> Option<f64> {
        self.0.then_some(f64::EPSILON)
    }

    /// How far a point may move in one step, given the smallest active cell: Kratos does not look.
    pub fn reach(self, smallest_cell: f64) -> f64 {
        if self.0 { f64::INFINITY } else { smallest_cell }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of spec 04 §2b, from a run of Kratos.
    #[test]
    fn nodes_behind_a_negative_function_get_the_gradient_of_another() {
        let mut functions = [0.437, -7e-7, -9e-7, 0.563];
        let mut gradients = [[1.0, 10.0], [2.0, 20.0], [3.0, 30.0], [4.0, 40.0]];
        let (functions_before, gradients_before) = (functions, gradients);
        KratosFaults(false).misalign(&mut functions, &mut gradients);
        assert_eq!((functions, gradients), (functions_before, gradients_before));
        KratosFaults(true).misalign(&mut functions, &mut gradients);
        assert_eq!(functions, [0.437, 0.0, 0.0, 0.563]);
        assert_eq!(gradients, [[1.0, 10.0], [0.0; 2], [0.0; 2], [2.0, 20.0]]);
    }
}
