//! One step: what the schemes do with points and grid, in which order.
//!
//! | scheme | |
//! |---|---|
//! | USF, central differences | momentum to the grid, strain, forces, kick and drift |
//! | USL | momentum and forces to the grid, strain, kick and drift |
//! | MUSL | momentum and forces to the grid, kick, momentum again, strain and drift |
//! | velocity Verlet | half a kick, momentum to the grid, strain and drift, forces, half a kick |
//! | Yoshida | three such stages, the second backwards |
//!
//! In the total frame points drift with the velocity that deforms them; in the updated frame, MUSL
//! lets them drift with the grid's first velocity, as Kratos does.

use super::sample::{Affine, Fields, Grid};
use super::to_grid::{Gather, Wanted};
use super::to_points::{self, Field, Strokes};
use super::{Explicit, TO_GRID, TO_POINTS};
use crate::loads::{Loads, are_any};
use crate::points::MaterialPoints;
use crate::projection::{ConsistentMass, nearest_velocity};
use crate::settings::{Frame, Scheme, Transfer};
use bia_constitutive::Kinematics;
use bia_kernel::error::Error;
use bia_kernel::model::ModelPart;
use bia_kernel::variables::Column;
use std::time::Instant;

/// Lengths of the stages of Yoshida's scheme of fourth order, in steps: w = 1/(2 − 2^⅓), 1 − 2w, w.
const YOSHIDA: [f64; 3] = [1.351_207_191_959_657_6, -1.702_414_383_919_315_3, 1.351_207_191_959_657_6];

impl Explicit {
    /// Takes momentum, and forces unless stresses come first, to the grid.
    ///
    /// # Errors
    /// A function of negative mass.
    pub(super) fn start(&mut self, points: &mut MaterialPoints, grid: &ModelPart, time_step: f64) -> Result<(), Error> {
        self.nodes.start(grid, &self.scene.space, time_step, self.faults);
        let wanted = if self.updates_stress_first() { Wanted::Momentum } else { Wanted::Both };
        self.gather(points, wanted, time_step);
        self.nodes.weigh(&self.scene.space, &self.active, self.faults)?;
        if self.nodes.begin_to_move() {
            let of_body = self.velocity_of_body(points).unwrap_or_else(|| self.nodes.mean_velocity());
            self.nodes.start_supports(&of_body, time_step);
        }
        Ok(())
    }

    /// The velocity of the grid that is nearest to that of the points. Those that do without local coordinates get
    /// them for this once.
    fn velocity_of_body(&self, points: &mut MaterialPoints) -> Option<Vec<f64>> {
        let (locator, space) = (self.scene.locator.as_ref()?, &self.scene.space);
        let dimension = points.dimension();
        let of_columns: Vec<bool> = points.blocks.iter().map(|block| block.local.is_used()).collect();
        for block in points.blocks.iter_mut().filter(|block| !block.local.is_used()) {
            block.local = Column::new(dimension, block.len());
            for point in 0..block.len() {
                let (x, cell) = (block.coordinates(point), block.cell[point]);
                let xi = locator.locate(x, Some(cell)).map_or([0.0; 3], |(_, xi)| xi);
                block.local.row_mut(point).copy_from_slice(&space.local(cell as usize, x, xi)[..dimension]);
            }
        }
        let velocity = nearest_velocity(&points.blocks, &self.active, space, &self.nodes.dofs);
        let unused = points.blocks.iter_mut().zip(of_columns).filter(|(_, used)| !used);
        unused.for_each(|(block, _)| block.local = Column::default());
        velocity
    }

    /// The acceleration of the grid, and its velocity after it.
    ///
    /// # Errors
    /// A point that the run breaks down at.
    pub(super) fn accelerate_grid(
        &mut self,
        points: &mut MaterialPoints,
        grid: &ModelPart,
        time_step: f64,
    ) -> Result<(), Error> {
        if self.updates_stress_first() {
            self.nodes.find_velocity();
            let velocity = std::mem::take(&mut self.nodes.velocity);
            let fields = Fields { deforming: &velocity, ..Fields::default() };
            let strained = self.strokes(points, time_step, fields, Strokes { strain: true, ..Strokes::default() });
            self.nodes.velocity = velocity;
            strained?;
            self.nodes.carry();
            self.gather(points, Wanted::Force, time_step);
        }
        self.answer_forces(points, grid, self.gamma() * time_step)?;
        if self.settings.scheme != Scheme::CentralDifference {
            self.nodes.find_velocity();
        }
        Ok(())
    }

    /// Adds the loads to the forces and finds the acceleration, and the momentum after a time.
    fn answer_forces(&mut self, points: &MaterialPoints, grid: &ModelPart, impulse: f64) -> Result<(), Error> {
        let axisymmetric = points.kinematics == Kinematics::Axisymmetric;
        let loads = Loads { grid, space: &self.scene.space, conditions: &points.conditions, axisymmetric };
        if are_any(grid, &points.conditions) {
            self.nodes.load(|dofs, forces| loads.add(dofs, &[], forces));
        }
        loads.tell_idle(&self.nodes.dofs, &mut self.told.idle_load);
        self.nodes.accelerate(impulse);
        if let Some(mut system) = self.system.take() {
            let found = self.consistent_mass(points).accelerations(&mut system, &self.nodes.sums.force);
            self.system = Some(system);
            self.nodes.set_free_accelerations(&found?);
        }
        Ok(())
    }

    fn consistent_mass<'a>(&'a self, points: &'a MaterialPoints) -> ConsistentMass<'a> {
        let (active, space, dofs) = (&self.active, &self.scene.space, &self.nodes.dofs);
        ConsistentMass { blocks: &points.blocks, active, space, dofs, frames: &self.nodes.frames }
    }

    /// Takes the points to the end of the step.
    ///
    /// # Errors
    /// A point that the run breaks down at.
    pub(super) fn move_points(
        &mut self,
        points: &mut MaterialPoints,
        grid: &ModelPart,
        time_step: f64,
    ) -> Result<(), Error> {
        if !(self.updates_stress_first() && self.frame() == Frame::Total) {
            self.nodes.carry();
        }
        if let Transfer::Xpic(projections) = self.settings.transfer {
            self.filter(points, time_step, projections)?;
        }
        let strokes = Strokes { kick: true, drift: true, ..Strokes::default() };
        match self.settings.scheme {
            Scheme::UpdateStressLast => self.kick(points, time_step, Strokes { strain: true, ..strokes }),
            Scheme::ModifiedUpdateStressLast => {
                self.kick(points, time_step, Strokes { drift: false, ..strokes })?;
                self.map_again(points, time_step)
            }
            Scheme::VelocityVerlet => self.stages(points, grid, time_step, &[1.0]),
            Scheme::Yoshida => self.stages(points, grid, time_step, &YOSHIDA),
            _ => self.kick(points, time_step, strokes),
        }
    }

    /// Kick, drift, kick for each stage; kicks that follow each other are one.
    fn stages(
        &mut self,
        points: &mut MaterialPoints,
        grid: &ModelPart,
        time_step: f64,
        lengths: &[f64],
    ) -> Result<(), Error> {
        let kick = Strokes { kick: true, ..Strokes::default() };
        let mut last = 0.0;
        for &length in lengths {
            self.kick(points, 0.5 * (last + length) * time_step, kick)?;
            self.map_again(points, length * time_step)?;
            self.nodes.sums.force.fill(0.0);
            self.gather(points, Wanted::Force, time_step);
            self.answer_forces(points, grid, 0.0)?;
            last = length;
        }
        self.kick(points, 0.5 * last * time_step, kick)
    }

    /// Changes the velocity of the points, and what else is wanted, by the motion of the grid.
    fn kick(&mut self, points: &mut MaterialPoints, time_step: f64, strokes: Strokes) -> Result<(), Error> {
        // Stresses that come first have no moment about the places at the end of the step.
        let carried_first = strokes.drift && self.updates_stress_first();
        if carried_first {
            self.displace_nodes(time_step);
        }
        let acceleration = std::mem::take(&mut self.nodes.acceleration);
        let velocity = std::mem::take(&mut self.nodes.velocity);
        let carrying = std::mem::take(&mut self.nodes.carrying);
        let displacement = std::mem::take(&mut self.nodes.displacement);
        let fields = Fields {
            deforming: if strokes.strain { &carrying } else { &[] },
            carrying: if strokes.drift { &carrying } else { &[] },
            acceleration: &acceleration,
            smooth: if matches!(self.settings.transfer, Transfer::Flip(1.0) | Transfer::Xpic(_)) {
                &[]
            } else {
                &velocity
            },
            affine: self.affine(),
            displacement: &displacement,
        };
        let keep = fields.affine != Affine::None;
        let kicked = self.strokes(points, time_step, fields, Strokes { keep, ..strokes });
        self.nodes.acceleration = acceleration;
        (self.nodes.velocity, self.nodes.carrying) = (velocity, carrying);
        self.nodes.displacement = displacement;
        if strokes.drift && !carried_first {
            self.displace_nodes(time_step);
        }
        kicked
    }

    /// Deforms points by the velocity that their own new velocities give the grid, and moves them.
    fn map_again(&mut self, points: &mut MaterialPoints, time_step: f64) -> Result<(), Error> {
        self.nodes.sums.momentum.fill(0.0);
        self.gather(points, Wanted::MovedMomentum, time_step);
        self.nodes.find_velocity();
        if let Some(mut system) = self.system.take() {
            let mut velocity = std::mem::take(&mut self.nodes.velocity);
            let projected = self.consistent_mass(points).project(&mut system, &mut velocity);
            (self.nodes.velocity, self.system) = (velocity, Some(system));
            projected?;
        }
        let same = self.frame() == Frame::Total;
        if same {
            self.nodes.carry();
        }
        let velocity = std::mem::take(&mut self.nodes.velocity);
        let carrying = std::mem::take(&mut self.nodes.carrying);
        let carried = if same { &velocity } else { &carrying };
        let fields = Fields { deforming: &velocity, carrying: carried, ..Fields::default() };
        let moved =
            self.strokes(points, time_step, fields, Strokes { strain: true, drift: true, ..Strokes::default() });
        (self.nodes.velocity, self.nodes.carrying) = (velocity, carrying);
        self.displace_nodes(time_step);
        moved
    }

    /// Carries the nodes along in the total frame.
    fn displace_nodes(&mut self, time_step: f64) {
        if self.frame() == Frame::Total && self.affine() == Affine::Moments {
            self.nodes.displacement.resize(self.nodes.carrying.len(), 0.0);
            let moved = self.nodes.displacement.iter_mut().zip(&self.nodes.carrying);
            moved.for_each(|(u, v)| *u += time_step * v);
        }
    }

    /// Leaves of the points' velocities what is left after so many times taking away what the grid
    /// shows of them, and keeps the whole beside (Hammerquist & Nairn 2017).
    fn filter(&mut self, points: &mut MaterialPoints, time_step: f64, projections: usize) -> Result<(), Error> {
        for block in &mut points.blocks {
            block.transfer.values_mut().copy_from_slice(block.velocity.values());
        }
        for _ in 0..projections {
            self.nodes.sums.momentum.fill(0.0);
            self.gather(points, Wanted::MovedMomentum, time_step);
            let shown = self.nodes.mean_velocity();
            let fields = Fields { smooth: &shown, ..Fields::default() };
            self.strokes(points, time_step, fields, Strokes { filter: true, ..Strokes::default() })?;
        }
        Ok(())
    }

    /// The affine part of the velocity that points keep.
    pub(super) fn affine(&self) -> Affine {
        match self.settings.transfer {
            Transfer::Apic => Affine::Moments,
            Transfer::Tpic => Affine::Gradient,
            _ => Affine::None,
        }
    }

    /// Sums the points up on the nodes.
    pub(super) fn gather(&mut self, points: &MaterialPoints, wanted: Wanted, time_step: f64) {
        let begin = Instant::now();
        let central = self.settings.scheme == Scheme::CentralDifference;
        let gather = Gather {
            blocks: &points.blocks,
            active: &self.active,
            patches: &self.patches,
            space: &self.scene.space,
            mapping: self.mapping,
            frame: self.frame(),
            kinematics: points.kinematics,
            affine: self.affine(),
            displacement: &self.nodes.displacement,
            ahead: if central { 0.5 * time_step } else { 0.0 },
            faults: self.faults,
            arch: self.arch,
        };
        self.nodes.sums.add(&gather, wanted);
        self.stages[TO_GRID].1 += begin.elapsed();
    }

    /// Does these strokes with the points, by these fields of the grid.
    pub(super) fn strokes(
        &mut self,
        points: &mut MaterialPoints,
        time_step: f64,
        fields: Fields,
        strokes: Strokes,
    ) -> Result<(), Error> {
        let begin = Instant::now();
        let mut records = std::mem::take(&mut self.records);
        records.fill(&fields, points.dimension());
        let grid = Grid {
            space: &self.scene.space,
            patches: &self.patches,
            mapping: self.mapping,
            kinematics: points.kinematics,
            faults: self.faults,
            arch: self.arch,
        };
        let total = self.frame() == Frame::Total;
        let field = Field {
            grid,
            fields,
            records: &records,
            frame: self.frame(),
            time_step,
            gamma: self.gamma(),
            transfer: self.settings.transfer,
            // In the total frame a body may fly however far it likes.
            reach: if total { f64::INFINITY } else { self.faults.reach(self.limits.smallest) },
            compressible: self.settings.compressible,
            moves_by_point: self.settings.moves_by_point,
            turns_moments: total && self.affine() == Affine::Moments && !self.updates_stress_first(),
        };
        let found = to_points::apply(points, &field, strokes);
        self.records = records;
        self.stages[TO_POINTS].1 += begin.elapsed();
        let found = found.map_err(|trouble| self.failure(points, &trouble, time_step))?;
        if strokes.kick && self.frame() == Frame::Updated {
            self.limits.point = found.fastest;
        }
        self.search.leavers.extend(found.leavers);
        Ok(())
    }

    fn gamma(&self) -> f64 {
        if self.settings.scheme == Scheme::CentralDifference { 0.5 } else { 1.0 }
    }

    fn updates_stress_first(&self) -> bool {
        matches!(self.settings.scheme, Scheme::UpdateStressFirst | Scheme::CentralDifference)
    }
}
