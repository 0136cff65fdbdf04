//! Points whose velocity has an affine part: what they start with, and the energy of that part.

use super::Explicit;
use super::sample::{Affine, Fields};
use super::to_grid::Wanted;
use super::to_points::Strokes;
use crate::active::NO_CELL;
use crate::points::{Block, MaterialPoints};
use crate::scene::points_of;
use crate::settings::Frame;
use bia_kernel::error::Error;
use bia_kernel::model::Model;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Rounds after which the affine part at the start is what it is.
const ROUNDS: usize = 50;
/// Share of the largest number by which it may still change.
const SETTLED: f64 = 1e-12;
/// Points that one thread takes at a time.
const POINTS: usize = 1024;

impl Explicit {
    /// Gives points the affine part of their initial velocities: that which comes back when they are carried to the
    /// grid with it. Without one, a body that starts turning would turn slower after the first step, which
    /// keeps its angular momentum and adds the inertia of the affine part.
    ///
    /// # Errors
    /// A function of negative mass.
    pub(super) fn start_affine(&mut self, points: &mut MaterialPoints) -> Result<(), Error> {
        let moves = |block: &Block| block.velocity.values().iter().any(|v| *v != 0.0);
        if self.affine() == Affine::None || !points.blocks.iter().any(moves) {
            return Ok(());
        }
        self.nodes.clear();
        self.gather(points, Wanted::Momentum, 0.0);
        self.nodes.weigh(&self.scene.space, &self.active, self.faults)?;
        for _ in 0..ROUNDS {
            self.nodes.find_velocity();
            let before: Vec<Vec<f64>> = points.blocks.iter().map(|block| block.transfer.values().to_vec()).collect();
            let velocity = std::mem::take(&mut self.nodes.velocity);
            let fields = Fields { smooth: &velocity, affine: self.affine(), ..Fields::default() };
            let kept = self.strokes(points, 0.0, fields, Strokes { keep: true, ..Strokes::default() });
            self.nodes.velocity = velocity;
            kept?;
            let now = points.blocks.iter().flat_map(|block| block.transfer.values());
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for (now, before) in now.zip(before.iter().flatten()) {
                change = change.max((now - before).abs());
                largest = largest.max(now.abs());
            }
            if change <= SETTLED * largest {
                break;
            }
            self.nodes.sums.momentum.fill(0.0);
            self.gather(points, Wanted::MovedMomentum, 0.0);
        }
        self.show_affine_energy(points);
        Ok(())
    }

    /// Writes the energies of the affine parts to their column, if it is used.
    pub(super) fn show_affine_energy(&self, points: &mut MaterialPoints) {
        for block in points.blocks.iter_mut().filter(|block| block.affine_energy.is_used()) {
            let mut energies = std::mem::take(&mut block.affine_energy);
            let chunks = energies.values_mut().par_chunks_mut(POINTS).enumerate();
            chunks.for_each(|(chunk, energies)| {
                let mut functions = Vec::new();
                for (point, energy) in (chunk * POINTS..).zip(energies) {
                    *energy = self.affine_energy(block, point, &mut functions);
                }
            });
            block.affine_energy = energies;
        }
    }

    /// Energy in J of the affine parts that no column holds.
    pub(super) fn hidden_energy(&self, model: &Model) -> f64 {
        let hides = |block: &&Block| self.affine() != Affine::None && !block.affine_energy.is_used();
        let mut functions = Vec::new();
        let mut sum = 0.0;
        for block in points_of(model).iter().flat_map(|points| &points.blocks).filter(hides) {
            for point in block.in_order_of_id() {
                let point = point as usize;
                sum += block.mass.row(point)[0] * self.affine_energy(block, point, &mut functions);
            }
        }
        sum
    }

    /// ½ tr(C D Cᵀ) in J/kg, D = Σ N (x_i − x_p) ⊗ (x_i − x_p), of the velocity v_p + C (x − x_p) that a point
    /// carries; C = B D⁻¹ where moments B are kept (Jiang, Schroeder & Teran 2017).
    fn affine_energy(&self, block: &Block, point: usize, functions: &mut Vec<f64>) -> f64 {
        let (space, dimension) = (&self.scene.space, block.kinematics.dimension());
        let (total, moments) = (self.frame() == Frame::Total, self.affine() == Affine::Moments);
        let place = block.coordinates(point);
        let (cell, xi) = match &self.scene.locator {
            _ if block.cell[point] == NO_CELL => return 0.0,
            Some(locator) if !total => match locator.locate(place, Some(block.cell[point])) {
                Some((cell, xi)) => (cell as usize, space.local(cell as usize, place, xi)),
                None => return 0.0,
            },
            _ => {
                let row = block.local.row(point);
                (block.cell[point] as usize, std::array::from_fn(|a| row.get(a).copied().unwrap_or(0.0)))
            }
        };
        space.evaluate(cell, xi, functions);
        // Moments are about present places, gradients with respect to the first.
        let displacement = if moments { &self.nodes.displacement[..] } else { &[] };
        let anchor = |node: u32| {
            let (mut x, first) = (space.position(node as usize), self.nodes.dofs.number(node).map(|n| n * dimension));
            for a in 0..dimension {
                x[a] += first.and_then(|first| displacement.get(first + a)).unwrap_or(&0.0);
            }
            x
        };
        let nodes = || space.nodes_of(cell).iter().zip(&*functions).map(|(&node, &n)| (anchor(node), n));
        let mut center = [0.0; 3];
        nodes().for_each(|(x, n)| (0..3).for_each(|a| center[a] += n * x[a]));
        let mut spread = Matrix3::zeros();
        for (x, n) in nodes() {
            let lever = nalgebra::Vector3::from_fn(|a, _| if a < dimension { x[a] - center[a] } else { 0.0 });
            spread += n * lever * lever.transpose();
        }
        let row = block.transfer.row(point);
        let kept = Matrix3::from_fn(|a, b| if a.max(b) < dimension { row[a * dimension + b] } else { 0.0 });
        if !moments {
            return 0.5 * (kept * spread * kept.transpose()).trace();
        }
        // On a node D has no inverse, and B vanishes with it.
        let least = spread.trace() * f64::EPSILON + f64::MIN_POSITIVE;
        let inverse = (spread + Matrix3::identity() * least).try_inverse().unwrap_or_default();
        0.5 * (kept * inverse * kept.transpose()).trace()
    }
}
