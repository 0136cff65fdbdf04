//! Energies of a scene: those that are written, and those by which it is judged at its end.

use crate::points::fields::{energies as of_point, total_energies};
use crate::points::{Block, Selection};
use crate::scene::{Scene, points_of};
use bia_kernel::model::Model;
use bia_kernel::solving::solver::MechanicalEnergy;

/// Energies that the columns in use allow.
pub fn energies(model: &Model) -> Vec<(&'static str, f64)> {
    let Some(points) = points_of(model) else { return Vec::new() };
    let energies = total_energies(points, Selection::All);
    let block = points.blocks.first();
    let mut list = vec![("potential", energies.potential)];
    if block.is_some_and(|block| block.velocity.is_used()) {
        list.push(("kinetic", energies.kinetic));
    }
    let told = |block: &Block| block.has_energy || (block.strain.is_used() && block.volume.is_used());
    if points.blocks.iter().all(told) {
        list.push(("strain", energies.strain));
    }
    list
}

impl Scene {
    /// Energy of bodies and the work on them, unless something worked on them in any step whose work is not known. What
    /// no law tells is none at the start, so that what is told may only fall.
    pub fn mechanical_energy(&self, model: &Model) -> Option<MechanicalEnergy> {
        let points = points_of(model)?;
        // Implicit steps do not count the work of body forces that are functions.
        let counts = self.settings.explicit.is_some();
        let known = |block: &Block| {
            block.velocity.is_used()
                && (counts || !block.body_acceleration.is_used())
                && (block.has_energy || !block.starts_stressed)
        };
        if self.was_worked_on || points.losses.clamped > 0 || !points.blocks.iter().all(known) {
            return None;
        }
        let lasts = |block: &Block| block.has_energy && !block.state.is_used() && block.gravity == [0.0; 3];
        // Points that are lost take energy along.
        let is_kept = points.losses.count == 0 && points.blocks.iter().all(lasts);
        let mut energy = MechanicalEnergy { is_kept, work: self.work, ..MechanicalEnergy::default() };
        for block in &points.blocks {
            let height = |point: usize| -> f64 {
                -block.position.row(point).iter().zip(block.gravity).map(|(x, g)| g * x).sum::<f64>()
            };
            let lowest = (0..block.len()).map(height).fold(f64::INFINITY, f64::min);
            for point in block.in_order_of_id() {
                let point = point as usize;
                let (mass, height, of_point) = (block.mass.row(point)[0], height(point), of_point(block, point));
                energy.own += of_point.kinetic + if block.has_energy { of_point.strain } else { 0.0 };
                energy.potential += mass * height;
                energy.height += mass * (height - lowest);
            }
        }
        Some(energy)
    }
}
