//! What bounds the time step, and how a run ends that broke it.

use super::Explicit;
use super::to_points::{Cause, Trouble};
use crate::points::MaterialPoints;
use crate::settings::{Basis, Scheme, Stepping};
use bia_kernel::error::{Error, Failure};

/// What bounds the time step.
#[derive(Default)]
pub struct Limits {
    /// Smallest height of each cell in metres.
    pub sizes: Vec<f64>,
    /// The smallest among active cells.
    pub smallest: f64,
    /// Fastest wave in m/s.
    pub wave: f64,
    /// Fastest point in m/s.
    pub point: f64,
    /// Courant number at which a wave becomes unstable.
    pub courant: f64,
}

impl Limits {
    /// C h/(c + v); infinite while nothing moves and no wave runs, or before the run.
    pub fn stable_step(&self) -> f64 {
        let speed = self.wave + self.point;
        if self.sizes.is_empty() || speed <= 0.0 { f64::INFINITY } else { self.courant * self.smallest / speed }
    }

    pub fn describe(&self) -> String {
        let Self { smallest, wave, point, .. } = self;
        format!("cells of {smallest:.4e} m, waves of {wave:.4e} m/s, points of {point:.4e} m/s")
    }
}

/// Courant number c Δt/h that a wave bears in a scheme with these functions: the least that points at
/// natural places in cells of a bar bear with two or three points a cell (measured, and equal to the
/// spectral radii of the maps from step to step to the two digits given); at most 1.
pub fn courant_limit(scheme: Scheme, basis: Basis, consistent_mass: bool) -> f64 {
    let degree = match basis {
        Basis::Mesh => 1,
        Basis::Lagrange(degree) | Basis::BSpline(degree) => degree,
    };
    let spline = matches!(basis, Basis::BSpline(_));
    let last = scheme == Scheme::UpdateStressLast;
    match (consistent_mass, last, spline, degree) {
        (true, _, _, 1) => 0.5,
        (true, _, true, 2) => 0.38,
        (true, _, true, _) | (true, _, false, 2) => 0.18,
        (false, true, _, 1) => 0.7,
        (false, true, true, 2) => 0.66,
        (false, true, true, _) => 0.5,
        (false, true, false, 2) => 0.3,
        (false, false, true, _) | (false, false, _, 1) => 1.0,
        (false, false, false, 2) => 0.5,
        // The shortest wave of a cell shortens with the square of the degree.
        (_, _, _, degree) => 0.18 * (3.0 / degree as f64).powi(2),
    }
}

impl Explicit {
    /// The end of an unstable run.
    pub(super) fn failure(&self, points: &MaterialPoints, trouble: &Trouble, time_step: f64) -> Error {
        let block = &points.blocks[trouble.block];
        let gradient = block.deformation_gradient(trouble.point);
        let name = format!("material point {}", block.ids[trouble.point]);
        let advice = match self.limits.stable_step() {
            stable if time_step > stable => {
                format!("a time step of at most {stable:.4e} s, or \"time_step\": \"auto\"")
            }
            _ => "a smaller time step; this step was within the stable one, so look at loads and at cells that hold \
                  little material"
                .to_string(),
        };
        let jacobian = format!("J = {:e}", gradient.determinant());
        let (what, detail) = match &trouble.cause {
            Cause::Law(error) => (format!("the law {} has no answer: {error}", block.law.name()), jacobian),
            Cause::Inverted(jacobian) => {
                let what = "the run is unstable: a material point is turned inside out";
                (what.to_string(), format!("J = {jacobian:e}"))
            }
            Cause::Moved(distance) => {
                let what = "the run is unstable: a material point moves farther than a cell in one step";
                (what.to_string(), format!("{jacobian}; it moves {distance:e} m"))
            }
        };
        let failure = Failure::new(what, advice).at(name, block.coordinates(trouble.point)).detail(detail);
        let speed = block.velocity.row(trouble.point);
        let failure = failure.detail(format!("velocity: {speed:?} m/s"));
        let stable = self.limits.stable_step();
        failure.detail(format!("time step {time_step:.4e} s, stable {stable:.4e} s: {}", self.limits.describe())).into()
    }

    /// Warns once, or stops, when a step of the user's is above the stable one.
    pub(super) fn judge_step(&mut self, step: f64, stable: f64) -> Result<(), Error> {
        if step <= stable || matches!(self.scene.settings.stepping, Stepping::Courant(_)) {
            return Ok(());
        }
        let what = format!("the time step {step:.4e} s is above the stable one, {stable:.4e} s");
        if self.settings.strict {
            let advice = "a smaller time step, or \"time_step\": \"auto\"";
            return Err(Failure::new(what, advice).detail(self.limits.describe()).into());
        }
        if !std::mem::replace(&mut self.told_step, true) {
            tracing::warn!("{what} ({})", self.limits.describe());
        }
        Ok(())
    }
}
