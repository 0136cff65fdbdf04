//! The implicit solver: static, quasi-static, Newmark and Bossak dynamics (spec 03).

mod element;
mod exchange;
mod forgiving;
mod kratos_faults;
mod midpoint;
mod mixed;
mod motion;
mod nodal_output;
mod prediction;
mod problem;
mod transfer;

use crate::active::ActiveCells;
use crate::grid::GRID;
use crate::loads::{Loads, are_any};
use crate::points::{Columns, MaterialPoints};
use crate::scene::{Scene, move_conditions, points_of, with_points};
use crate::settings::{Frame, Regime, SolverSettings};
use crate::space::Space;
use crate::variables::{ACCELERATION, DISPLACEMENT, PRESSURE, VELOCITY};
use bia_constitutive::Deformation;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::json::JsonObject;
use bia_kernel::linalg::{LinearSolver, solver};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::processes::{Clock, Context, Location, Process, Requirements, ResetNodes, RunOptions};
use bia_kernel::registry::Registry;
use bia_kernel::solving::newton::OnNoConvergence;
use bia_kernel::solving::solver::{Inventory, MechanicalEnergy, Reached, Solver};
use bia_kernel::solving::{ActiveDofs, Criterion, NodalFrames, StepReport, System};
use element::Rule;
use kratos_faults::KratosFaults;
use mixed::{Mixed, check_fluids, relax_fluids, stray_volume};
use motion::Motion;
use nalgebra::Matrix3;
use nodal_output::NodalOutput;
use problem::{Inertia, Problem};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use transfer::{NodalResults, NodalSums, update_points};

/// What the log has been told once.
#[derive(Default, Clone, Copy)]
struct Told {
    linear: bool,
    fall_back: bool,
    imposed: bool,
    idle_load: bool,
    leap: bool,
    weight: bool,
}

/// The solver with what it keeps from step to step.
pub struct Implicit {
    scene: Scene,
    linear: Option<Box<dyn LinearSolver>>,
    active: ActiveCells,
    dofs: ActiveDofs,
    /// Frames of nodes that slide along walls.
    frames: NodalFrames,
    system: Option<System>,
    sums: NodalSums,
    inertia: Option<Inertia>,
    motion: Motion,
    mixed: Option<Mixed>,
    increments: Vec<f64>,
    assembled: Vec<f64>,
    /// DISPLACEMENT at the end of the last step, which is what Kratos's prediction reads.
    previous: Vec<[f64; 3]>,
    output: NodalOutput,
    stages: [(&'static str, Duration); 5],
    told: Told,
    arch: pulp::Arch,
}

const SEARCH: usize = 0;
const TO_GRID: usize = 1;
const ASSEMBLY: usize = 2;
const LINEAR: usize = 3;
const TO_POINTS: usize = 4;

impl Implicit {
    /// The solver of these settings.
    pub fn new(settings: SolverSettings, options: RunOptions) -> Self {
        let stages = ["search", "points to grid", "assembly", "linear solver", "grid to points"];
        let mixed = settings.mixed.map(|mixed| Mixed::new(mixed, options.kratos_exact));
        Self {
            scene: Scene::new(settings, options),
            mixed,
            linear: None,
            active: ActiveCells::default(),
            dofs: ActiveDofs::default(),
            frames: NodalFrames::default(),
            system: None,
            sums: NodalSums::default(),
            inertia: None,
            motion: Motion::default(),
            increments: Vec::new(),
            assembled: Vec::new(),
            previous: Vec::new(),
            output: NodalOutput::default(),
            stages: stages.map(|name| (name, Duration::ZERO)),
            told: Told::default(),
            arch: pulp::Arch::new(),
        }
    }

    fn dynamic(&self) -> bool {
        self.scene.settings.regime == Regime::Dynamic
    }

    /// Finds the points' cells and numbers the dofs; keeps the system while the cells stay the same.
    fn update_active(&mut self, points: &mut MaterialPoints, grid: &ModelPart) -> Result<(), Error> {
        self.scene.search(points)?;
        let before = std::mem::take(&mut self.active.cells);
        self.active.gather(&points.blocks, grid.elements.len());
        if before != self.active.cells || self.system.is_none() {
            self.dofs = self.scene.space.active_dofs(&self.active.cells, points.dimension());
            self.system = Some(match &mut self.mixed {
                Some(mixed) => mixed.number(&self.scene.space, &self.active.cells, points.dimension()),
                None => system(&self.scene.space, &self.active.cells, &self.dofs),
            });
        }
        Ok(())
    }

    fn faults(&self) -> KratosFaults {
        KratosFaults(self.scene.options.kratos_exact)
    }

    fn problem<'a>(&'a self, points: &'a MaterialPoints, grid: &'a ModelPart, time_step: f64) -> Problem<'a> {
        Problem {
            grid,
            space: &self.scene.space,
            frame: self.scene.settings.discretisation.frame,
            rule: if self.scene.settings.conserves_energy { Rule::MidPoint } else { Rule::EndPoint },
            points,
            active: &self.active,
            dofs: &self.dofs,
            sums: &self.sums,
            inertia: self.inertia.as_ref(),
            time_step,
            faults: self.faults(),
            arch: self.arch,
            increments: self.increments.clone(),
            assembled: self.increments.clone(),
        }
    }

    fn timed<T>(&mut self, stage: usize, work: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let result = work(self);
        self.stages[stage].1 += start.elapsed();
        result
    }
}

impl Solver for Implicit {
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        self.scene.import(model, registry)
    }

    fn processes(&self) -> Vec<Box<dyn Process>> {
        // In statics each step starts from the increments of the last one, as in Kratos.
        match self.scene.settings.regime {
            Regime::Static => Vec::new(),
            _ => vec![Box::new(ResetNodes { part: GRID, variables: vec![DISPLACEMENT] })],
        }
    }

    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors> {
        let wants = |name: &str| requirements.wants(Location::Nodes, name);
        self.output = NodalOutput {
            mass: requirements.record || wants("NODAL_MASS"),
            velocity: wants("VELOCITY"),
            acceleration: wants("ACCELERATION"),
            reaction: self.scene.settings.reactions || (wants("REACTION") && !self.faults().hides_reactions()),
        };
        if let Some(mixed) = &mut self.mixed {
            let wanted = self.output.reaction || wants("PRESSURE_REACTION");
            mixed.show_reaction(wanted);
            self.output.reaction = wanted;
            if let Some(grid) = model.part_mut(GRID) {
                let count = grid.nodes.len();
                grid.node_fields.scalar_mut(&PRESSURE, count);
            }
        }
        let moves = self.dynamic();
        let pressure = self.mixed.is_some();
        let needed = Columns { velocity: moves, acceleration: moves, local: true, pressure, ..Columns::default() };
        let conserves_energy = self.scene.settings.conserves_energy;
        let symmetric = self.scene.make_points(model, requirements, needed)?
            && !conserves_energy
            && self.mixed.as_ref().is_none_or(Mixed::is_symmetric);
        if let Some(points) = points_of(model).filter(|_| conserves_energy) {
            check_energies(points, &self.scene.settings)?;
        }
        if let Some(points) = points_of(model) {
            check_fluids(points, &self.scene.settings)?;
        }
        let linear = solver(self.scene.settings.linear_method(symmetric)?);
        self.linear = Some(self.faults().forgive(linear, symmetric));
        Ok(())
    }

    fn before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        if let Some(grid) = context.model.part_mut(GRID).filter(|_| self.scene.settings.regime != Regime::Static) {
            let count = grid.nodes.len();
            self.previous = grid.node_fields.vector_mut(&DISPLACEMENT, count).to_vec();
        }
        Ok(())
    }

    fn exchange_state(&mut self, model: &mut Model, archive: &mut Archive) -> Result<(), CheckpointError> {
        let missing = || CheckpointError::Missing("material points".into());
        let mut points = model.take::<MaterialPoints>().ok_or_else(missing)?;
        let exchanged = self.exchange(&mut points, archive);
        model.put(points);
        exchanged
    }

    fn on_no_convergence(&self) -> OnNoConvergence {
        OnNoConvergence::of(&self.scene.settings.settings)
    }

    fn load_time(&self) -> f64 {
        self.scene.settings.load_time()
    }

    fn time_step(&mut self, _: &Model, clock: &Clock) -> Result<f64, Error> {
        self.scene.settings.stepping.step(clock, f64::INFINITY)
    }

    fn predict(&mut self, context: &mut Context) -> Result<(), Error> {
        let (time_step, share) = (context.clock.time_step, context.clock.share);
        let this = self;
        with_points(context.model, |points, grid| {
            this.timed(SEARCH, |this| this.update_active(points, grid))?;
            this.timed(TO_GRID, |this| {
                this.gather(points);
                this.write_nodal_mass(grid);
                this.predict_increments(grid, share);
                this.predict_pressures(points, grid);
                if let Some(mixed) = this.mixed.as_ref().filter(|_| this.dynamic()) {
                    mixed.tell_weight(points, &mut this.told.weight);
                }
                this.prepare_inertia(points, grid, time_step)
            })
        })
    }

    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error> {
        let time_step = context.clock.time_step;
        let this = self;
        with_points(context.model, |points, grid| {
            let (Some(mut system), Some(mut linear)) = (this.system.take(), this.linear.take()) else {
                return Ok(StepReport::default());
            };
            this.scene.was_worked_on |= are_any(grid, &points.conditions);
            let loads = Loads { grid, space: &this.scene.space, conditions: &points.conditions, axisymmetric: false };
            loads.tell_idle(&this.dofs, &mut this.told.idle_load);
            let mut mixed = this.mixed.take();
            let result = match &mut mixed {
                Some(mixed) => this.solve_mixed(mixed, (points, grid), time_step, &mut system, linear.as_mut()),
                None => {
                    let mut problem = this.problem(points, grid, time_step);
                    let newton = &this.scene.settings.newton;
                    let result = this.frames.solve(newton, &mut problem, &mut system, linear.as_mut());
                    (this.increments, this.assembled) = (problem.increments, problem.assembled);
                    result
                }
            };
            (this.system, this.linear, this.mixed) = (Some(system), Some(linear), mixed);
            let report = result?;
            this.stages[ASSEMBLY].1 += report.assembly;
            this.stages[LINEAR].1 += report.linear;
            if !std::mem::replace(&mut this.told.linear, true) {
                tracing::info!("linear solver: {}", this.linear.as_ref().map_or(String::new(), |linear| linear.name()));
            }
            if let Some(note) = report.note.as_ref().filter(|_| !this.told.fall_back) {
                this.told.fall_back = true;
                tracing::warn!("linear solver: {note}");
            }
            Ok(report)
        })
    }

    fn finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        let time_step = context.clock.time_step;
        let this = self;
        with_points(context.model, |points, grid| {
            let start = Instant::now();
            if this.output.reaction {
                this.write_reactions(points, grid, time_step)?;
            }
            let mut increments = std::mem::take(&mut this.increments);
            let accelerations = this.inertia.as_ref().map_or(Vec::new(), |i| i.final_acceleration(&increments));
            let velocities = this.inertia.as_ref().map_or(Vec::new(), |i| i.final_velocity(&increments));
            let spread = this.mixed.as_ref().map_or(&[][..], Mixed::spread);
            increments.iter_mut().zip(spread).for_each(|(u, s)| *u += s);
            let needs_residual = this.scene.settings.newton.criterion.as_ref().is_some_and(Criterion::needs_residual);
            let lags = this.faults().shows_old_volume(needs_residual);
            let of_volume = if lags { &this.assembled } else { &increments };
            let space = &this.scene.space;
            // The grid of the total frame remembers its motion and need not ask the points for it.
            let is_total = this.scene.settings.discretisation.frame == Frame::Total;
            let before = this.inertia.as_ref().filter(|_| is_total).map_or(&[][..], |i| &i.velocity);
            let velocity_changes: Vec<f64> = velocities.iter().zip(before).map(|(v, v0)| v - v0).collect();
            let starts = this.mixed.as_ref().is_some_and(Mixed::starts);
            let nodal = NodalResults {
                space,
                frame: this.scene.settings.discretisation.frame,
                dofs: &this.dofs,
                increments: &increments,
                increments_of_volume: of_volume,
                pressures: this.mixed.as_ref().map_or(&[], Mixed::pressures),
                shifts_stress: this.faults().shifts_stress(),
                accelerations: &accelerations,
                velocities: &velocities,
                velocity_changes: &velocity_changes,
                flip_fraction: this.scene.settings.flip_fraction,
                time_step,
                gamma: if starts { 1.0 } else { this.scene.settings.point_gamma },
                least_function: this.faults().least_function(),
            };
            let leap = update_points(points, &nodal)?;
            if this.scene.settings.regime == Regime::Dynamic {
                leap.tell(points, &mut this.told.leap);
            }
            if !is_total {
                relax_fluids(points);
            }
            this.write_pressures(grid);
            let least = nodal.least_function;
            move_conditions(&mut points.conditions, space, &this.dofs, [&increments, &velocities], least);
            space.write_field(grid, &this.dofs, &DISPLACEMENT, &increments);
            if this.output.velocity && this.dynamic() {
                space.write_field(grid, &this.dofs, &VELOCITY, &velocities);
            }
            if this.output.acceleration && this.dynamic() {
                space.write_field(grid, &this.dofs, &ACCELERATION, &accelerations);
            }
            if this.faults().ignores_imposed(this.scene.settings.regime) {
                let count = grid.nodes.len();
                this.previous.copy_from_slice(grid.node_fields.vector_mut(&DISPLACEMENT, count));
            }
            this.increments = increments;
            this.mixed.iter_mut().for_each(Mixed::has_stepped);
            if is_total {
                (this.motion.velocity, this.motion.acceleration) = (velocities, accelerations);
            }
            this.stages[TO_POINTS].1 += start.elapsed();
            Ok(())
        })
    }

    fn inventory(&self, model: &Model) -> Inventory {
        self.scene.inventory(model)
    }

    fn energies(&self, model: &Model) -> Vec<(&'static str, f64)> {
        crate::energy::energies(model)
    }

    fn mechanical_energy(&self, model: &Model) -> Option<MechanicalEnergy> {
        self.scene.mechanical_energy(model)
    }

    fn remarks(&self, model: &Model) -> Vec<String> {
        let mut remarks = self.scene.remarks(model);
        remarks.extend(points_of(model).and_then(stray_volume));
        remarks
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

/// The energy-conserving scheme is for laws that have an energy and no history.
fn check_energies(points: &MaterialPoints, settings: &SolverSettings) -> Result<(), InputErrors> {
    let undeformed = Deformation::from_gradient(Matrix3::identity());
    let mut errors = InputErrors::default();
    for block in &points.blocks {
        if block.law.energy(&undeformed).is_none() || block.state.is_used() {
            let message = format!("\"energy_conserving\" needs a strain energy, which {} has not", block.law_name);
            errors.push(settings.settings.error("scheme_type", message).help("use a hyperelastic law, or newmark"));
        }
    }
    errors.or(())
}

/// The system that couples the nodes of each active cell.
fn system(space: &Space, cells: &[u32], dofs: &ActiveDofs) -> System {
    let (mut numbers, mut starts) = (Vec::new(), vec![0]);
    for &cell in cells {
        let of_cell = space.nodes_of(cell as usize).iter().filter_map(|&node| dofs.number(node));
        numbers.extend(of_cell.map(|number| number as u32));
        starts.push(numbers.len() as u32);
    }
    System::new(dofs.block(), dofs.nodes().len(), numbers, starts)
}
