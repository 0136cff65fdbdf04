//! Points that a solver moves, as processes of the kernel read them without knowing the solver.

use super::Model;
use crate::variables::Variable;

/// A point: block and index at this moment. Solvers may sort their points between steps.
pub type PointHandle = (u32, u32);

/// Where a point is, and how much of the body it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointPlace {
    /// Its id, which never changes.
    pub id: u32,
    /// Position now, in metres.
    pub position: [f64; 3],
    /// Position at the start, in metres; asked for with
    /// [`Requirements::initial_positions`](crate::processes::Requirements::initial_positions).
    pub initial: [f64; 3],
    /// Volume at the start, in m³.
    pub volume: f64,
}

/// The points of an application, a model extension of which the kernel knows only this.
pub trait PointSet {
    /// The points of a part, in the order of their ids; none if no part has this name.
    fn select(&self, model: &Model, part: &str) -> Option<Vec<PointHandle>>;

    /// Where a point is.
    fn place(&self, point: PointHandle) -> PointPlace;

    /// Appends the numbers that a variable has at a point; nothing if points do not have it.
    fn append(&self, point: PointHandle, variable: &Variable, out: &mut Vec<f64>);
}

/// Finds the points in a model that holds them.
pub type PointAccess = for<'a> fn(&'a Model) -> Option<&'a dyn PointSet>;

impl Model {
    /// Says how the kernel finds the points that an application keeps beside the model parts.
    pub fn set_points(&mut self, access: PointAccess) {
        self.points = Some(access);
    }

    /// The points, if a solver has any.
    pub fn points(&self) -> Option<&dyn PointSet> {
        self.points.and_then(|access| access(self))
    }
}
