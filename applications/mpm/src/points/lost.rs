//! Points that leave the grid: what becomes of them, and the account of it.

use super::MaterialPoints;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Failure;
use bia_kernel::geometry::CellLocator;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::parameters::Settings;

/// What becomes of points that leave the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LostPoints {
    /// They are erased, with their mass.
    Erase,
    /// They stay without a cell and without effect.
    Keep,
    /// The run stops.
    Error,
    /// They are put back to the border of the grid, which they meet like a smooth wall.
    Clamp,
}

impl LostPoints {
    /// As the settings of the solver say: `lost_points`, or Kratos's rule of the search.
    pub fn of(settings: &Settings) -> Self {
        let erases = settings.nested("element_search_settings").is_none_or(|n| n.flag("remove_entities_not_found"));
        match settings.get("lost_points").and_then(|given| given.value().as_str()) {
            Some("error") => LostPoints::Error,
            Some("clamp") => LostPoints::Clamp,
            Some(_) => LostPoints::Erase,
            None if erases => LostPoints::Erase,
            None => LostPoints::Keep,
        }
    }
}

impl LostPoints {
    /// Refuses two answers to one question.
    pub fn check(settings: &Settings, errors: &mut InputErrors) {
        let search = settings.nested("element_search_settings");
        if settings.given("lost_points") && search.is_some_and(|search| search.given("remove_entities_not_found")) {
            let message = "stands beside \"remove_entities_not_found\", which says what becomes of lost points, too";
            errors.push(settings.error("lost_points", message).help("keep \"lost_points\""));
        }
    }
}

/// Ids of lost points that are named; the rest is counted.
const NAMED: usize = 10;

/// What has left the grid so far.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Losses {
    /// Points erased.
    pub count: usize,
    /// Mass erased with them, in kg.
    pub mass: f64,
    /// Ids of the points erased, in the order in which they left.
    pub ids: Vec<u32>,
    /// How often a point was put back to the border.
    pub clamped: usize,
}

impl Losses {
    /// Adds a point that was erased.
    pub fn add(&mut self, id: u32, mass: f64) {
        self.count += 1;
        self.mass += mass;
        self.ids.push(id);
    }

    /// Which points left the grid after the first `count`, that had `mass` in kg.
    pub fn since(&self, (count, mass): (usize, f64)) -> String {
        let ids = &self.ids[count.min(self.ids.len())..];
        let named: Vec<String> = ids.iter().take(NAMED).map(u32::to_string).collect();
        let more = if ids.len() > NAMED { ", …" } else { "" };
        let (s, mass) = (if ids.len() == 1 { "" } else { "s" }, self.mass - mass);
        format!(
            "{} material point{s} (id{s} {}{more}) left the grid, {mass:.6e} kg with them",
            ids.len(),
            named.join(", ")
        )
    }

    /// Saves or loads the account.
    ///
    /// # Errors
    /// The checkpoint does not hold it.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.count("lost", &mut self.count)?;
        archive.number("lost mass", &mut self.mass)?;
        archive.column("lost ids", &mut self.ids)?;
        archive.count("clamped", &mut self.clamped)
    }
}

/// The failure of a run that may not lose this point.
pub fn failure(points: &MaterialPoints, block: usize, point: usize) -> Failure {
    let (x, block) = (points.blocks[block].coordinates(point), &points.blocks[block]);
    let advice = "a larger grid, walls that hold the bodies, a smaller time step, or \"lost_points\": \"erase\"";
    let failure = Failure::new("a material point has left the grid, and \"lost_points\" is \"error\"", advice);
    let failure = failure.at(format!("material point {}", block.ids[point]), x);
    let name = points.bodies.get(block.body).map_or("", String::as_str);
    let failure = failure.detail(format!("body {name}, mass {:.6e} kg", block.mass.row(point)[0]));
    let failure = failure.detail(block.describe(point));
    match block.velocity.is_used() {
        true => failure.detail(format!("velocity {:?} m/s", block.velocity.row(point))),
        false => failure,
    }
}

/// Puts a point back to the border of the grid: it keeps the velocity along the border and into the grid.
/// Gives its cell and local coordinates there; none if its position is not finite.
pub fn clamp(
    points: &mut MaterialPoints,
    locator: &CellLocator,
    block: usize,
    point: usize,
) -> Option<(u32, [f64; 3])> {
    let block = &mut points.blocks[block];
    let outside = block.coordinates(point);
    let (x, cell, xi) = locator.clamp(outside, block.cell[point])?;
    let way: [f64; 3] = std::array::from_fn(|i| outside[i] - x[i]);
    let square: f64 = way.iter().map(|a| a * a).sum();
    let shift = |row: &mut [f64]| row.iter_mut().zip(way).for_each(|(value, way)| *value -= way);
    shift(block.position.row_mut(point));
    if block.displacement.is_used() {
        shift(block.displacement.row_mut(point));
    }
    for column in [&mut block.velocity, &mut block.acceleration] {
        if column.is_used() && square > 0.0 {
            let row = column.row_mut(point);
            let outward = row.iter().zip(way).map(|(v, way)| v * way).sum::<f64>().max(0.0) / square;
            row.iter_mut().zip(way).for_each(|(v, way)| *v -= outward * way);
        }
    }
    points.losses.clamped += 1;
    Some((cell, xi))
}
