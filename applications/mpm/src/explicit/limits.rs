//! What bounds the time step, and how a run ends that broke it.

use super::Explicit;
use super::to_points::{Cause, Trouble};
use crate::points::MaterialPoints;
use crate::settings::{Frame, Scheme, Stepping};
use bia_kernel::error::{Error, Failure};

/// What bounds the time step.
pub struct Limits {
    /// Smallest height of each cell in metres.
    pub sizes: Vec<f64>,
    /// The smallest among active cells.
    pub smallest: f64,
    /// Fastest wave in m/s.
    pub wave: f64,
    /// Fastest point in m/s; none in the total frame, where points do not move through the grid.
    pub point: f64,
    /// By how much compression speeds up waves across the cells of the total frame: max ‖F⁻¹‖, else 1.
    pub shortening: f64,
    /// Courant number at which a wave becomes unstable.
    pub courant: f64,
}

impl Limits {
    /// Nothing known but the Courant number.
    pub fn of(courant: f64) -> Self {
        Self { sizes: Vec::new(), smallest: 0.0, wave: 0.0, point: 0.0, shortening: 1.0, courant }
    }

    /// C h/(c ‖F⁻¹‖ + v); infinite while nothing moves and no wave runs, or before the run.
    pub fn stable_step(&self) -> f64 {
        self.stable_step_of(self.smallest)
    }

    /// The same for cells of this smallest height.
    pub fn stable_step_of(&self, smallest: f64) -> f64 {
        let speed = self.wave * self.shortening + self.point;
        if self.sizes.is_empty() || speed <= 0.0 { f64::INFINITY } else { self.courant * smallest / speed }
    }

    /// The smallest height among the cells of these points.
    pub fn smallest_under(&self, points: &MaterialPoints) -> f64 {
        let cells = points.blocks.iter().flat_map(|block| &block.cell);
        cells.filter_map(|&cell| self.sizes.get(cell as usize)).fold(f64::INFINITY, |least, size| least.min(*size))
    }

    pub fn describe(&self) -> String {
        let Self { smallest, wave, point, shortening, courant, .. } = self;
        let compressed =
            if *shortening > 1.0 { format!(", {shortening:.3} times as fast where compressed") } else { String::new() };
        format!(
            "Courant number {courant:.3}, cells of {smallest:.4e} m, waves of {wave:.4e} m/s{compressed}, \
             points of {point:.4e} m/s"
        )
    }
}

impl Explicit {
    /// The end of an unstable run.
    pub(super) fn failure(&self, points: &MaterialPoints, trouble: &Trouble, time_step: f64) -> Error {
        let block = &points.blocks[trouble.block];
        let name = format!("material point {}", block.ids[trouble.point]);
        let advice = match self.limits.stable_step() {
            stable if time_step > stable => {
                format!("a time step of at most {stable:.4e} s, or \"time_step\": \"auto\"")
            }
            _ if self.settings.scheme == Scheme::UpdateStressLast
                && self.frame() == Frame::Updated
                && self.scene.space.is_mesh() =>
            {
                "\"stress_update\": \"musl\" or \"basis\": \"b_spline\": the step was within the stable one, and \
                 cells that hold little material break up this way; else look at the loads"
                    .to_string()
            }
            _ => "a smaller time step; this step was within the stable one, so look at loads and at cells that hold \
                  little material"
                .to_string(),
        };
        let jacobian = block.describe(trouble.point);
        let (what, detail) = match &trouble.cause {
            Cause::Law(error) => (format!("the law {} has no answer: {error}", block.law.name()), jacobian),
            Cause::Inverted(jacobian) => {
                let what = "the run is unstable: a material point is turned inside out";
                (what.to_string(), format!("J = {jacobian:e} in this step; {}", block.describe(trouble.point)))
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
        if !std::mem::replace(&mut self.told.step, true) {
            tracing::warn!("{what} ({})", self.limits.describe());
        }
        Ok(())
    }
}
