//! The solver: statics in load steps, Newmark and Bossak dynamics, central differences.

use crate::body::Body;
use crate::problem::Step;
use crate::results::{ELEMENTAL, ElementResults, NODAL, RECORDED, check_energies, save_state};
use crate::settings::{Regime, SolverSettings};
use crate::stability::Stability;
use crate::variables::{ACCELERATION, DISPLACEMENT, REACTION, VELOCITY};
use bia_constitutive::{BodyMaterial, Catalogue};
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::json::JsonObject;
use bia_kernel::linalg::{LinearSolver, solver};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::processes::{Clock, Context, Location, Requirements};
use bia_kernel::registry::Registry;
use bia_kernel::solving::newton::OnNoConvergence;
use bia_kernel::solving::solver::{ColumnUse, Counts, Inventory, Solver};
use bia_kernel::solving::{ActiveDofs, StepReport, Stepping, System};
use bia_kernel::variables::Variable;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Motion and forces of the nodes, all vectors over the dofs.
#[derive(Default)]
pub struct State {
    /// Displacements (m).
    pub displacement: Vec<f64>,
    /// Displacements at the start of the step (m).
    pub start: Vec<f64>,
    /// Velocities (m/s); empty in statics.
    pub velocity: Vec<f64>,
    /// Accelerations (m/s²); empty in statics.
    pub acceleration: Vec<f64>,
    /// Lumped mass of each dof (kg).
    pub mass: Vec<f64>,
    /// External forces at the end of the step (N).
    pub external: Vec<f64>,
    /// Forces that hold fixed dofs (N).
    pub reaction: Vec<f64>,
}

/// The solver with what it keeps from step to step.
pub struct Structural {
    pub(crate) settings: SolverSettings,
    materials: Vec<BodyMaterial>,
    catalogue: Catalogue,
    pub(crate) body: Option<Body>,
    pub(crate) dofs: ActiveDofs,
    /// Matrix and linear solver; none in explicit runs.
    pub(crate) linear: Option<(System, Box<dyn LinearSolver>)>,
    pub(crate) state: State,
    pub(crate) stability: Stability,
    /// Variables of elements to be written.
    elemental: Vec<Variable>,
    pub(crate) reactions: bool,
    stages: [(&'static str, Duration); 2],
    told_linear: bool,
}

const ASSEMBLY: usize = 0;
const LINEAR: usize = 1;

impl Structural {
    /// The solver of these settings.
    pub fn new(settings: SolverSettings) -> Self {
        Self {
            settings,
            materials: Vec::new(),
            catalogue: Catalogue::default(),
            body: None,
            dofs: ActiveDofs::default(),
            linear: None,
            state: State::default(),
            stability: Stability::default(),
            elemental: Vec::new(),
            reactions: false,
            stages: [("forces and tangent", Duration::ZERO), ("linear solver", Duration::ZERO)],
            told_linear: false,
        }
    }

    pub(crate) fn dynamic(&self) -> bool {
        self.settings.regime != Regime::Static
    }

    /// The step as elements see it.
    ///
    /// # Errors
    /// The solver has not been initialised.
    pub(crate) fn step<'a>(&'a self, model: &'a Model, time_step: f64) -> Result<Step<'a>, Failure> {
        match (model.part(&self.settings.part), &self.body) {
            (Some(part), Some(body)) => Ok(Step { part, body, dofs: &self.dofs, start: &self.state.start, time_step }),
            _ => Err(uninitialised()),
        }
    }

    /// What is to be written of nodes and elements.
    fn require(&mut self, requirements: &Requirements) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        requirements.choose(Location::Points, &[], &mut errors);
        requirements.choose(Location::PointConditions, &[], &mut errors);
        requirements.choose(Location::Nodes, NODAL, &mut errors);
        self.elemental = requirements.choose(Location::Elements, ELEMENTAL, &mut errors);
        if requirements.record {
            let more = RECORDED.iter().filter(|v| self.elemental.iter().all(|other| other.name != v.name));
            self.elemental.extend(more.copied().collect::<Vec<_>>());
        }
        self.reactions =
            self.settings.reactions || requirements.record || requirements.wants(Location::Nodes, REACTION.name);
        errors.or(())
    }

    /// Refuses conditions on nodes without elements, whose loads would be lost.
    fn check_conditions(&self, part: &ModelPart) -> Result<(), InputErrors> {
        let stray = (0..part.conditions.len())
            .find(|&c| part.conditions.nodes_of(c).iter().any(|&node| self.dofs.number(node).is_none()));
        match stray {
            Some(condition) => {
                let id = part.conditions.ids[condition];
                let message = format!("condition {id} has a node that belongs to no element");
                let place =
                    self.settings.mesh.file().map_or_else(Default::default, bia_kernel::diagnostic::Place::file);
                Err(Diagnostic::error(place, message).help("a load there would act on nothing").into())
            }
            None => Ok(()),
        }
    }

    /// Keeps the history of the laws and writes the wanted values of elements.
    fn finish_elements(&mut self, model: &mut Model, time_step: f64) -> Result<(), Error> {
        if self.elemental.is_empty() && self.body.as_ref().is_none_or(|body| body.states.is_empty()) {
            return Ok(());
        }
        let results = ElementResults::new(&self.step(model, time_step)?, &self.state.displacement)?;
        if let Some(part) = model.part_mut(&self.settings.part) {
            results.write(part, &self.elemental, self.settings.kinematics.voigt());
        }
        if let Some(body) = &mut self.body {
            body.states = results.states;
        }
        Ok(())
    }

    /// Writes displacements, motion and reactions to the columns of nodes.
    fn write_nodes(&self, part: &mut ModelPart) {
        let count = part.nodes.len();
        let state = &self.state;
        for (variable, values) in [
            (&DISPLACEMENT, &state.displacement),
            (&VELOCITY, &state.velocity),
            (&ACCELERATION, &state.acceleration),
            (&REACTION, &state.reaction),
        ] {
            if !values.is_empty() {
                self.dofs.scatter(values, part.node_fields.vector_mut(variable, count));
            }
        }
    }

    /// Tells the stable step of an explicit run, and what a fixed step above it means.
    fn check_stability(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        let Regime::Explicit { strict } = self.settings.regime else { return Ok(()) };
        let mut stability = std::mem::take(&mut self.stability);
        let stable = stability.update(&self.step(model, 0.0)?, &self.state.displacement);
        let id = model.part(&self.settings.part).and_then(|part| part.elements.ids.get(stability.element));
        self.stability = stability;
        let (stable, step) = (stable?, self.time_step(model, clock)?);
        let told = format!("the stable step is {stable:.6e} s, limited by element {}", id.copied().unwrap_or(0));
        tracing::info!("{told}");
        match step > stable {
            true if strict => {
                Err(Failure::new(format!("the time step {step:e} s is unstable: {told}"), "a smaller step").into())
            }
            true => {
                tracing::warn!("the time step {step:e} s is too large: {told}");
                Ok(())
            }
            false => Ok(()),
        }
    }
}

/// A fault of the program, told rather than left to a panic.
pub(crate) fn uninitialised() -> Failure {
    Failure::new("the solver was not initialised", "report this as a fault of Bia")
}

impl Solver for Structural {
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let settings = &self.settings;
        let source = (&settings.settings, "model_import_settings");
        let mut errors = InputErrors::default();
        errors.absorb(settings.mesh.import(model, &settings.part, settings.dimension, registry, source));
        self.catalogue = registry.catalogue::<Catalogue>().cloned().unwrap_or_default();
        if let Some(part) = model.part_mut(&settings.part) {
            let roots = [settings.part.as_str()];
            self.materials =
                errors.absorb(settings.materials.assign(part, &roots, &self.catalogue)).unwrap_or_default();
        }
        errors.or(())
    }

    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors> {
        self.require(requirements)?;
        let Some(part) = model.part(&self.settings.part) else { return Ok(()) };
        let body = Body::new(part, &self.materials, &self.settings, &self.catalogue, self.dynamic())?;
        check_energies(&body, requirements)?;
        let all: Vec<u32> = (0..part.elements.len() as u32).collect();
        self.dofs = ActiveDofs::of_cells(self.settings.dimension, part.nodes.len(), &part.elements, &all);
        self.check_conditions(part)?;
        if !matches!(self.settings.regime, Regime::Explicit { .. }) {
            let symmetric = body.materials.iter().all(|material| material.built.law.is_symmetric());
            let system = System::of_cells(&part.elements, &all, &self.dofs);
            self.linear = Some((system, solver(self.settings.linear_method(symmetric)?)));
        }
        self.state.reaction = vec![0.0; self.dofs.order()];
        self.body = Some(body);
        Ok(())
    }

    fn before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.start(context.model)?;
        self.check_stability(context.model, context.clock)?;
        self.finish_elements(context.model, 0.0)?;
        if let Some(part) = context.model.part_mut(&self.settings.part) {
            self.write_nodes(part);
        }
        Ok(())
    }

    fn exchange_state(&mut self, _: &mut Model, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.exchange(archive)
    }

    fn time_step(&mut self, model: &Model, clock: &Clock) -> Result<f64, Error> {
        let mut stable = f64::INFINITY;
        if matches!(self.settings.stepping, Stepping::Courant(_)) {
            let mut stability = std::mem::take(&mut self.stability);
            let updated = stability.update(&self.step(model, 0.0)?, &self.state.displacement);
            self.stability = stability;
            stable = updated?;
        }
        self.settings.stepping.step(clock, stable)
    }

    fn stable_time_step(&self, model: &Model) -> Option<f64> {
        if !matches!(self.settings.regime, Regime::Explicit { .. }) {
            return None;
        }
        let at_first = || Stability::at_first(&self.step(model, 0.0).ok()?, &self.state.displacement);
        self.stability.last().or_else(at_first)
    }

    fn on_no_convergence(&self) -> OnNoConvergence {
        OnNoConvergence::of(&self.settings.settings)
    }

    fn plans_steps(&self) -> bool {
        !matches!(self.settings.stepping, Stepping::Courant(_))
    }

    fn predict(&mut self, context: &mut Context) -> Result<(), Error> {
        let time_step = context.clock.time_step;
        self.state.start.clone_from(&self.state.displacement);
        if let Some(part) = context.model.part(&self.settings.part) {
            match self.settings.regime {
                Regime::Explicit { .. } => self.drift(part, time_step),
                _ => self.prescribe(part, time_step),
            }
        }
        self.state.external = self.step(context.model, time_step)?.external()?;
        Ok(())
    }

    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error> {
        let (begin, time_step) = (Instant::now(), context.clock.time_step);
        let report = match self.settings.regime {
            Regime::Explicit { .. } => self.kick(context.model, time_step)?,
            _ => self.solve(context.model, time_step)?,
        };
        self.stages[LINEAR].1 += report.linear;
        self.stages[ASSEMBLY].1 += begin.elapsed().saturating_sub(report.linear);
        if let Some((_, linear)) = self.linear.as_ref().filter(|_| !self.told_linear) {
            tracing::info!("linear solver: {}", linear.name());
            report.note.iter().for_each(|note| tracing::warn!("linear solver: {note}"));
            self.told_linear = true;
        }
        Ok(report)
    }

    fn finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        self.finish_elements(context.model, context.clock.time_step)?;
        if let Some(part) = context.model.part_mut(&self.settings.part) {
            self.keep_held_velocities(part);
            self.write_nodes(part);
        }
        Ok(())
    }

    fn inventory(&self, model: &Model) -> Inventory {
        let mut inventory = Inventory::default();
        let (Some(part), Some(body)) = (model.part(&self.settings.part), &self.body) else { return inventory };
        let mut line = |what: &str, text: String| inventory.lines.push((what.into(), text));
        line("mesh", format!("{} nodes, {} elements", part.nodes.len(), part.elements.len()));
        line("parts", part.paths().join(", "));
        for (material, read) in body.materials.iter().zip(&self.materials) {
            let speed = match material.density > 0.0 {
                true => format!(", wave speed {:.4e} m/s", material.built.law.wave_speed(material.density)),
                false => String::new(),
            };
            let (name, kinematics) = (&material.built.name, material.built.kinematics);
            line(&format!("material {}", read.properties.id), format!("{name}, {kinematics}{speed}"));
        }
        line("loads", format!("{} conditions", part.conditions.len()));
        line("dofs", self.dofs.order().to_string());
        line("history of the laws", format!("{} bytes", 8 * body.states.len()));
        let (of_dofs, moves) = (8 * self.dofs.order(), self.settings.regime != Regime::Static);
        let columns = [
            ("displacement", 2 * of_dofs),
            ("forces", 2 * of_dofs),
            ("velocity", if moves { of_dofs } else { 0 }),
            ("acceleration", if moves { of_dofs } else { 0 }),
            ("lumped mass", 8 * self.state.mass.len()),
            ("law history", 8 * body.states.len()),
        ];
        let (cells, nodes) = (part.elements.len(), part.nodes.len());
        inventory.counts = Counts { cells, nodes, points: 0, unknowns: self.dofs.order() };
        inventory.warnings = self.materials.iter().flat_map(|material| material.warnings(true)).collect();
        inventory.columns = columns.map(|(name, bytes)| ColumnUse { name, bytes }).into();
        inventory
    }

    fn energies(&self, model: &Model) -> Vec<(&'static str, f64)> {
        self.step(model, 0.0).map_or(Vec::new(), |step| self.state.energies(&step, self.settings.is_consistent()))
    }

    fn account(&self, model: &Model) -> serde_json::Map<String, serde_json::Value> {
        let mut head = serde_json::Map::new();
        if let Some(part) = model.part(&self.settings.part) {
            head.insert("n_nodes".into(), part.nodes.len().into());
            head.insert("n_elements".into(), part.elements.len().into());
        }
        head
    }

    fn snapshot(&self, model: &Model, out: &mut JsonObject) -> std::io::Result<()> {
        self.step(model, 0.0).map_or(Ok(()), |step| self.state.snapshot(&step, self.settings.is_consistent(), out))
    }

    fn stages(&self) -> Vec<(&'static str, Duration)> {
        self.stages.to_vec()
    }

    fn save_state(&self, model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        save_state(model, &self.step(model, 0.0)?, &self.state, folder)
    }
}
