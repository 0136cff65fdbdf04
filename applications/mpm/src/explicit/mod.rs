//! The explicit solver: forward Euler with the stress updated first, last or last with mapped
//! velocities (USF, USL, MUSL), and central differences (spec 04).
//!
//! A step: mass m = Σ N m_p and momentum q = Σ N m_p v_p of the nodes; v = q/m; f = f_ext − Σ V σ ∇N;
//! a = f/m; q ← q + γ Δt f; points v_p ← v_p + Δt ((1 − γ) a_p + γ Σ N a), x_p ← x_p + Δt Σ N v.
//! Forward Euler has γ = 1 and carries points with the new velocity; central differences have γ = ½,
//! momentum half a step ahead, Σ N m_p (v_p + Δt/2 a_p), and carry points with that.
//!
//! Sources: Sulsky, Zhou & Schreyer 1995; Bardenhagen 2002; Nairn 2003.

mod affine;
mod affine_state;
mod cells;
mod chunk;
mod courant;
mod exchange;
mod kinematics;
mod kratos_faults;
mod limits;
mod modes;
mod nodal_output;
mod nodes;
mod patches;
mod rows;
mod sample;
mod search;
mod stability;
mod steps;
mod strain;
mod to_grid;
mod to_points;

use crate::active::ActiveCells;
use crate::grid::GRID;
use crate::points::{Columns, MaterialPoints};
use crate::projection::ConsistentMass;
use crate::scene::{Scene, move_conditions, points_of, with_points};
use crate::settings::{Basis, Discretisation, ExplicitSettings, Frame, Scheme, SolverSettings, Stepping, Transfer};
use crate::variables::{ACCELERATION, DISPLACEMENT, NODAL_MASS, REACTION, VELOCITY};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::processes::{Clock, Context, Location, Process, Requirements, ResetNodes, RunOptions};
use bia_kernel::registry::Registry;
use bia_kernel::solving::solver::{Inventory, MechanicalEnergy, Reached, Solver};
use bia_kernel::solving::{StepReport, System};
use cells::Mapping;
use kratos_faults::KratosFaults;
use limits::Limits;
use nodes::Nodes;
use patches::Patches;
use sample::{Affine, Records};
use search::Search;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Steps between two looks at how far points are compressed.
const SURVEY: usize = 8;
const SEARCH: usize = 0;
const TO_GRID: usize = 1;
const TO_POINTS: usize = 2;

/// What the log has been told once.
#[derive(Default, Clone, Copy)]
struct Told {
    step: bool,
    idle_load: bool,
}

/// The solver with what it keeps from step to step.
pub struct Explicit {
    scene: Scene,
    settings: ExplicitSettings,
    faults: KratosFaults,
    mapping: Mapping,
    search: Search,
    active: ActiveCells,
    patches: Patches,
    records: Records,
    nodes: Nodes,
    /// The consistent mass, where it is wanted.
    system: Option<System>,
    limits: Limits,
    /// Steps since the compression was last surveyed.
    surveyed: usize,
    /// Nodal variables that someone reads.
    shown: Vec<&'static str>,
    stages: [(&'static str, Duration); 3],
    told: Told,
    arch: pulp::Arch,
}

impl Explicit {
    /// The solver of these settings.
    pub fn new(settings: SolverSettings, explicit: ExplicitSettings, options: RunOptions) -> Self {
        let Discretisation { frame, basis, .. } = settings.discretisation;
        // Kratos knows neither the total frame nor other functions.
        let faults = KratosFaults(options.kratos_exact && frame == Frame::Updated && basis == Basis::Mesh);
        let courant = courant::limit(&explicit, settings.discretisation, settings.dimension);
        // Nodes without mass are dragged along here; one of next to nothing would answer a force wildly.
        let mut scene = Scene::new(settings, options);
        scene.insets = false;
        Self {
            scene,
            settings: explicit,
            faults,
            mapping: Mapping { affine: false, stored: true },
            search: Search::default(),
            active: ActiveCells::default(),
            patches: Patches::default(),
            records: Records::default(),
            nodes: Nodes::default(),
            system: None,
            limits: Limits::of(courant),
            surveyed: 0,
            shown: Vec::new(),
            stages: ["search", "points to grid", "grid to points"].map(|name| (name, Duration::ZERO)),
            told: Told::default(),
            arch: pulp::Arch::new(),
        }
    }

    /// Finds the points' cells; numbers the nodes again if the cells have changed.
    fn update_active(&mut self, points: &mut MaterialPoints, grid: &ModelPart, time_step: f64) -> Result<(), Error> {
        let frame = self.frame();
        let mut moved = self.search.find(&mut self.scene, points, frame, self.faults)?;
        if self.settings.leave_edges {
            search::leave_edges(&self.scene, points, grid, time_step);
            moved = true;
        }
        if moved {
            let before = std::mem::take(&mut self.active.cells);
            self.active.gather(&points.blocks, grid.elements.len());
            if before != self.active.cells || self.patches.len() == 0 {
                self.renumber(points);
            }
            if self.search.restore_order(points, &self.active, grid.elements.len()) {
                self.active.gather(&points.blocks, grid.elements.len());
            }
        }
        Ok(())
    }

    fn renumber(&mut self, points: &MaterialPoints) {
        self.nodes.renumber(&self.scene.space, &self.active, points.dimension());
        self.patches.renew(&self.scene.space, &self.active, &self.nodes.dofs);
        if self.settings.consistent_mass {
            let (active, space, dofs) = (&self.active, &self.scene.space, &self.nodes.dofs);
            self.system = Some(
                ConsistentMass { blocks: &points.blocks, active, space, dofs, frames: &self.nodes.frames }.system(),
            );
        }
        let sizes = self.active.cells.iter().map(|&cell| self.limits.sizes[cell as usize]);
        self.limits.smallest = sizes.fold(f64::INFINITY, f64::min);
    }

    fn frame(&self) -> Frame {
        self.scene.settings.discretisation.frame
    }
}

impl Solver for Explicit {
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        self.scene.import(model, registry)
    }

    fn processes(&self) -> Vec<Box<dyn Process>> {
        if self.faults.shows_old_nodes() {
            return Vec::new();
        }
        vec![Box::new(ResetNodes { part: GRID, variables: vec![DISPLACEMENT] })]
    }

    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors> {
        let recorded = |name: &str| requirements.record && [DISPLACEMENT.name, NODAL_MASS.name].contains(&name);
        for variable in [&DISPLACEMENT, &VELOCITY, &ACCELERATION, &REACTION, &NODAL_MASS] {
            if requirements.wants(Location::Nodes, variable.name) || recorded(variable.name) {
                self.shown.push(variable.name);
            }
        }
        if self.scene.settings.reactions && !self.shows(REACTION.name) {
            self.shown.push(REACTION.name);
        }
        if let Some(grid) = model.part(GRID) {
            self.mapping = search::mapping(grid, &self.scene.settings.discretisation);
            self.mapping.stored |= self.settings.consistent_mass;
        }
        let dimension = self.scene.settings.dimension;
        let needed = Columns {
            velocity: true,
            acceleration: self.settings.scheme == Scheme::CentralDifference,
            local: self.mapping.stored,
            stress: true,
            volume: true,
            transfer: match self.settings.transfer {
                Transfer::Flip(_) => 0,
                Transfer::Apic | Transfer::Tpic => dimension * dimension,
                Transfer::Xpic(_) => dimension,
            },
            affine: self.affine() != Affine::None,
            ..Columns::default()
        };
        self.scene.make_points(model, requirements, needed)?;
        if let (true, Some(points)) =
            (self.settings.transfer == Transfer::Apic, model.extension_mut::<MaterialPoints>())
        {
            points.blocks.iter_mut().for_each(|block| block.moments = true);
        }
        let Some((grid, points)) = model.part(GRID).zip(points_of(model)) else { return Ok(()) };
        self.limits.sizes = stability::cell_sizes(grid);
        self.limits.wave = stability::wave_speed(points);
        let stiff = |law: &dyn bia_constitutive::Law| !law.uses_strain();
        let blocks = &points.blocks;
        match blocks.iter().find(|block| !self.settings.compressible && stiff(block.law.as_ref())) {
            Some(block) if !self.scene.options.kratos_exact => {
                let message =
                    format!("is false, but {} takes its stress from the deformation gradient", block.law_name);
                let help = "set compressible to true, or use a linear elastic law";
                Err(self.scene.settings.settings.error("compressible", message).help(help).into())
            }
            _ => Ok(()),
        }
    }

    fn before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        if let (true, Some(grid)) = (self.shows(DISPLACEMENT.name), context.model.part_mut(GRID)) {
            let count = grid.nodes.len();
            grid.node_fields.vector_mut(&DISPLACEMENT, count);
        }
        let Some((grid, points)) = context.model.part(GRID).zip(points_of(context.model)) else { return Ok(()) };
        self.active.gather(&points.blocks, grid.elements.len());
        self.renumber(points);
        if self.frame() == Frame::Updated {
            self.limits.point = stability::point_speed(points);
        }
        with_points(context.model, |points, _| self.start_affine(points))?;
        tracing::info!("stable time step {:.4e} s: {}", self.limits.stable_step(), self.limits.describe());
        Ok(())
    }

    fn exchange_state(&mut self, model: &mut Model, archive: &mut Archive) -> Result<(), CheckpointError> {
        let missing = || CheckpointError::Missing("material points".into());
        let mut points = model.take::<MaterialPoints>().ok_or_else(missing)?;
        let exchanged = self.exchange(&mut points, archive);
        model.put(points);
        exchanged
    }

    fn load_time(&self) -> f64 {
        // Kratos takes loads at the end of the step, whatever the scheme.
        if self.scene.options.kratos_exact { 1.0 } else { self.scene.settings.load_time() }
    }

    fn time_step(&mut self, model: &Model, clock: &Clock) -> Result<f64, Error> {
        if let (Frame::Total, Some(points)) = (self.frame(), points_of(model)) {
            if self.surveyed.is_multiple_of(SURVEY) {
                self.limits.shortening = stability::shortening(points);
            }
            self.surveyed += 1;
        }
        // Before the run nothing is known that bounds the step.
        let stable = if self.active.cells.is_empty() { f64::INFINITY } else { self.limits.stable_step() };
        let stepping = &self.scene.settings.stepping;
        if matches!(stepping, Stepping::Courant(_)) {
            return last_step(stepping.step(clock, stable)?, clock);
        }
        let step = stepping.step(clock, stable)?;
        self.judge_step(step, stable)?;
        Ok(step)
    }

    fn stable_time_step(&self, model: &Model) -> Option<f64> {
        let stable = match self.active.cells.is_empty() {
            // Before the run the points alone know their cells.
            true => self.limits.stable_step_of(self.limits.smallest_under(points_of(model)?)),
            false => self.limits.stable_step(),
        };
        stable.is_finite().then_some(stable)
    }

    fn plans_steps(&self) -> bool {
        !matches!(self.scene.settings.stepping, Stepping::Courant(_))
    }

    fn predict(&mut self, context: &mut Context) -> Result<(), Error> {
        let time_step = context.clock.time_step;
        with_points(context.model, |points, grid| {
            let begin = Instant::now();
            self.update_active(points, grid, time_step)?;
            self.stages[SEARCH].1 += begin.elapsed();
            self.start(points, grid, time_step)
        })
    }

    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error> {
        let time_step = context.clock.time_step;
        with_points(context.model, |points, grid| {
            self.accelerate_grid(points, grid, time_step)?;
            Ok(StepReport { converged: true, ..StepReport::default() })
        })
    }

    fn finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        let time_step = context.clock.time_step;
        with_points(context.model, |points, grid| {
            self.move_points(points, grid, time_step)?;
            self.scene.work += self.nodes.work(time_step) + work_of_body_forces(points, time_step);
            self.show_affine_energy(points);
            let carrying = &self.nodes.carrying;
            let mut increments = Vec::new();
            if !points.conditions.is_empty() || (self.shows(DISPLACEMENT.name) && !self.faults.shows_old_nodes()) {
                increments.extend(carrying.iter().map(|v| v * time_step));
                let least = self.faults.least_function();
                let motion = [&increments[..], &carrying[..]];
                move_conditions(&mut points.conditions, &self.scene.space, &self.nodes.dofs, motion, least);
            }
            if self.faults.shows_old_nodes() {
                increments.clear();
                increments.resize(self.nodes.dofs.order(), 0.0);
            }
            self.write_nodes(grid, &increments);
            Ok(())
        })
    }

    fn inventory(&self, model: &Model) -> Inventory {
        self.scene.inventory(model)
    }

    fn energies(&self, model: &Model) -> Vec<(&'static str, f64)> {
        let mut energies = crate::energy::energies(model);
        if let Some((_, kinetic)) = energies.iter_mut().find(|(name, _)| *name == "kinetic") {
            *kinetic += self.hidden_energy(model);
        }
        energies
    }

    fn mechanical_energy(&self, model: &Model) -> Option<MechanicalEnergy> {
        let energy = self.scene.mechanical_energy(model)?;
        Some(MechanicalEnergy { own: energy.own + self.hidden_energy(model), ..energy })
    }

    fn remarks(&self, model: &Model) -> Vec<String> {
        self.scene.remarks(model)
    }

    fn reached(&self, model: &Model) -> Option<Reached> {
        Some(self.active.reached_nodes(model.part(GRID)?))
    }

    fn account(&self, model: &Model) -> serde_json::Map<String, serde_json::Value> {
        crate::record::account(model)
    }

    fn snapshot(&self, model: &Model, out: &mut JsonObject) -> std::io::Result<()> {
        crate::record::snapshot(model, out)
    }

    fn stages(&self) -> Vec<(&'static str, Duration)> {
        self.stages.to_vec()
    }

    fn save_state(&self, model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        crate::inventory::save_state(model, folder)
    }
}

/// Work in J of the body forces that are functions, in a step of this length.
fn work_of_body_forces(points: &MaterialPoints, time_step: f64) -> f64 {
    let mut power = 0.0;
    for block in points.blocks.iter().filter(|block| block.body_acceleration.is_used()) {
        for (point, mass) in block.mass.values().iter().enumerate() {
            let (force, velocity) = (block.body_acceleration.row(point), block.velocity.row(point));
            power += mass * force.iter().zip(velocity).map(|(b, v)| b * v).sum::<f64>();
        }
    }
    time_step * power
}

/// The step, cut so that the run ends at its end and the last two steps are not far apart.
fn last_step(step: f64, clock: &Clock) -> Result<f64, Error> {
    let left = clock.end - clock.time;
    if left > 2.0 * step {
        return Ok(step);
    }
    if left > step {
        return Ok(0.5 * left);
    }
    // Rounding must not leave a sliver of time.
    let rounding = f64::EPSILON * clock.end.abs();
    Ok(if clock.time + left < clock.end { left + rounding } else { left })
}
