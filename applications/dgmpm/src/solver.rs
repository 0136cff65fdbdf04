//! The solver: set-up, the stable step, the loop's hooks, and what is told of the scene.

use crate::engine::{Points, Stability, build};
use crate::fields::{DERIVED, OF_CELLS, OF_NODES, OF_POINTS, check_energies, energies};
use crate::processes::CellFields;
use crate::results::{save_state, snapshot};
use crate::settings::SolverSettings;
use crate::variables::VOLUME_ACCELERATION;
use bia_constitutive::{BodyMaterial, Catalogue};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart, PointSet};
use bia_kernel::processes::{Clock, Context, Location, Process, Requirements};
use bia_kernel::registry::Registry;
use bia_kernel::solving::solver::{ColumnUse, Counts, Inventory, MechanicalEnergy, Solver};
use bia_kernel::solving::{StepReport, Stepping};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A step above the stable one by less than this is round-off.
const SLACK: f64 = 1e-9;

/// The solver.
pub struct DiscontinuousGalerkin {
    settings: SolverSettings,
    materials: Vec<BodyMaterial>,
    catalogue: Catalogue,
    told_unstable: bool,
}

impl DiscontinuousGalerkin {
    /// The solver of these settings.
    pub fn new(settings: SolverSettings) -> Self {
        Self { settings, materials: Vec::new(), catalogue: Catalogue::default(), told_unstable: false }
    }

    /// Lets the points and the part with their cells work together.
    fn with<T>(
        &self,
        model: &mut Model,
        work: impl FnOnce(&mut Points, &ModelPart) -> Result<T, Failure>,
    ) -> Result<T, Error> {
        let missing = || Failure::new("the solver was not initialised", "report this as a fault of Bia");
        let mut points = model.take::<Points>().ok_or_else(missing)?;
        let result = model.part(&self.settings.part).ok_or_else(missing).and_then(|part| work(&mut points, part));
        model.put(points);
        Ok(result?)
    }

    /// The number of a layout that counts as stable.
    fn limit(&self, stability: &Stability) -> Option<f64> {
        let limits = stability.limits?;
        let chosen = if self.settings.no_overshoot { limits.no_overshoot } else { Some(limits.spectral) };
        chosen.filter(|&limit| limit > 0.0)
    }

    /// The largest stable step now (s), with what limits it.
    fn stable_step(&self, points: &Points) -> (f64, Option<Stability>) {
        let groups = points.body.stability();
        let step = |group: &Stability| self.limit(group).map_or(f64::INFINITY, |limit| limit * group.crossing);
        let least = groups.into_iter().min_by(|a, b| step(a).total_cmp(&step(b)));
        (least.as_ref().map_or(f64::INFINITY, step), least)
    }

    /// Says once that a fixed step is above the stable one.
    fn check_step(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        if self.told_unstable || matches!(self.settings.stepping, Stepping::Courant(_)) {
            return Ok(());
        }
        let Some(points) = model.extension::<Points>() else { return Ok(()) };
        let ((stable, group), step) = (self.stable_step(points), clock.time_step);
        let Some(group) = group.filter(|_| step > stable * (1.0 + SLACK)) else { return Ok(()) };
        self.told_unstable = true;
        let (limit, courant) = (stable / group.crossing, step / group.crossing);
        let told = format!(
            "the time step {step:e} s is above the stable one, {stable:e} s: Courant number {courant:.4} where the \
             layout allows {limit:.4} (material {})",
            group.material
        );
        if self.settings.strict {
            return Err(Failure::new(told, "a smaller step, or \"time_step\": \"auto\"").into());
        }
        tracing::warn!("{told}");
        Ok(())
    }

    /// Layouts for which no step is stable.
    fn check_limits(&self, points: &Points) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        for group in points.body.stability().iter().filter(|group| self.limit(group).is_none()) {
            let message = format!("no time step is stable for the layout of points of material {}", group.material);
            let help = "use another layout of points, time_integration or stability_criterion";
            errors.push(self.settings.settings.error("time_integration", message).help(help));
        }
        errors.or(())
    }
}

impl Solver for DiscontinuousGalerkin {
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let settings = &self.settings;
        let source = (&settings.settings, "model_import_settings");
        let dimension = settings.kinematics.dimension();
        let mut errors = InputErrors::default();
        errors.absorb(settings.mesh.import(model, &settings.part, dimension, registry, source));
        self.catalogue = registry.catalogue::<Catalogue>().cloned().unwrap_or_default();
        if let Some(part) = model.part_mut(&settings.part) {
            let roots = [settings.part.as_str()];
            self.materials =
                errors.absorb(settings.materials.assign(part, &roots, &self.catalogue)).unwrap_or_default();
        }
        errors.or(())
    }

    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        requirements.choose(Location::Points, &[OF_POINTS, DERIVED].concat(), &mut errors);
        requirements.choose(Location::PointConditions, &[], &mut errors);
        requirements.choose(Location::Nodes, OF_NODES, &mut errors);
        let wanted = requirements.choose(Location::Elements, OF_CELLS, &mut errors);
        errors.or(())?;
        let Some(part) = model.part(&self.settings.part) else { return Ok(()) };
        let mut points = build(model, part, &self.materials, &self.settings, &self.catalogue)?;
        points.wanted = wanted;
        // The stable step is asked for before the loop.
        points.body.start(part).map_err(|failure| {
            let report = failure.report();
            InputErrors::from(
                self.settings.settings.error("material_import_settings", &report.what).help(&report.advice),
            )
        })?;
        self.check_limits(&points)?;
        check_energies(points.body.as_ref(), requirements)?;
        model.extend(points);
        model.set_points(|model| model.extension::<Points>().map(|points| points as &dyn PointSet));
        Ok(())
    }

    fn processes(&self) -> Vec<Box<dyn Process>> {
        vec![Box::new(CellFields { part: self.settings.part.clone() })]
    }

    fn before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.with(context.model, |points, part| points.body.start(part))
    }

    fn exchange_state(&mut self, model: &mut Model, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.flag("told unstable", &mut self.told_unstable)?;
        let missing = || CheckpointError::Missing("points".into());
        model.extension_mut::<Points>().ok_or_else(missing)?.body.exchange(archive)
    }

    fn time_step(&mut self, model: &Model, clock: &Clock) -> Result<f64, Error> {
        let stable = match (&self.settings.stepping, model.extension::<Points>()) {
            (Stepping::Courant(_), Some(points)) => self.stable_step(points).0,
            _ => f64::INFINITY,
        };
        self.settings.stepping.step(clock, stable)
    }

    fn stable_time_step(&self, model: &Model) -> Option<f64> {
        let stable = model.extension::<Points>().map(|points| self.stable_step(points).0);
        stable.filter(|stable| stable.is_finite())
    }

    fn plans_steps(&self) -> bool {
        self.settings.small_strain || !matches!(self.settings.stepping, Stepping::Courant(_))
    }

    fn predict(&mut self, context: &mut Context) -> Result<(), Error> {
        self.check_step(context.model, context.clock)
    }

    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error> {
        let clock = *context.clock;
        self.with(context.model, |points, part| points.body.step(part, &clock))?;
        Ok(StepReport { converged: true, ..StepReport::default() })
    }

    fn finalize_solution_step(&mut self, _: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    fn inventory(&self, model: &Model) -> Inventory {
        let mut inventory = Inventory::default();
        let (Some(part), Some(points)) = (model.part(&self.settings.part), model.extension::<Points>()) else {
            return inventory;
        };
        let mut line = |what: &str, text: String| inventory.lines.push((what.into(), text));
        let [cells, kinds, inner, boundary, loaded, open] = points.body.counts();
        line("cells", format!("{cells} of {kinds} forms, {} nodes of the mesh", part.nodes.len()));
        line(
            "faces",
            format!("{inner} between cells, {boundary} at the boundary, {loaded} loaded, {open} transmitting"),
        );
        line("parts", part.paths().join(", "));
        for (id, text) in points.body.describe() {
            line(&format!("material {id}"), text);
        }
        let method = self.settings.method;
        let corrected = if method.transverse { " with transverse correction" } else { "" };
        let (scheme, riemann) = (method.time_integration.name(), method.riemann.name());
        line("scheme", format!("{scheme}{corrected}, {riemann} Riemann solver"));
        for group in points.body.stability() {
            if let Some(limits) = group.limits {
                let overshoot =
                    limits.no_overshoot.map_or(String::new(), |c| format!(", without overshoot up to {c:.3}"));
                let text = format!(
                    "{:.3}{overshoot} with {} points a cell; a wave crosses the smallest cell in {:.6e} s",
                    limits.spectral, group.points, group.crossing
                );
                line("stable Courant number", text);
            }
        }
        let bytes = points.body.bytes();
        let count = points.body.len().max(1);
        let all = bytes.iter().sum::<usize>();
        line("memory", format!("{:.3} MB, {:.0} bytes a point", all as f64 / 1e6, all as f64 / count as f64));
        let (used, left) = columns(bytes, part);
        line("columns in use", used);
        line("left out", left);
        let [of_points, of_nodes, of_faces] = bytes;
        let sizes = [
            ("points: position, displacement, velocity, displacement gradient, stress", of_points),
            ("cells' own nodes between stages", of_nodes),
            ("faces: states, fluxes, impedances", of_faces),
            ("acceleration", 0),
            ("history", 0),
            ("grid fields shared by cells", 0),
        ];
        let unknowns = 2 * points.body.kinematics().dimension() * points.body.len();
        inventory.counts = Counts { cells, nodes: part.nodes.len(), points: points.body.len(), unknowns };
        inventory.columns = sizes.map(|(name, bytes)| ColumnUse { name, bytes }).into();
        inventory
    }

    fn energies(&self, model: &Model) -> Vec<(&'static str, f64)> {
        let Some(points) = model.extension::<Points>() else { return Vec::new() };
        let (kinetic, strain) = energies(points.body.as_ref(), 0..points.body.len());
        let mut list = vec![("kinetic", kinetic)];
        list.extend(strain.map(|strain| ("strain", strain)));
        list.push(("supplied", points.body.work()));
        list
    }

    fn mechanical_energy(&self, model: &Model) -> Option<MechanicalEnergy> {
        // What body forces do is not counted.
        let has_forces = model.part(&self.settings.part)?.node_fields.vector(&VOLUME_ACCELERATION).is_some();
        let points = model.extension::<Points>().filter(|points| points.body.work() == 0.0 && !has_forces)?;
        let (kinetic, strain) = energies(points.body.as_ref(), 0..points.body.len());
        Some(MechanicalEnergy { own: kinetic + strain?, is_kept: true, ..MechanicalEnergy::default() })
    }

    fn account(&self, model: &Model) -> serde_json::Map<String, serde_json::Value> {
        let mut head = serde_json::Map::new();
        if let (Some(part), Some(points)) = (model.part(&self.settings.part), model.extension::<Points>()) {
            head.insert("n_mp".into(), points.body.len().into());
            head.insert("n_elements".into(), part.elements.len().into());
            let limits: Vec<f64> = points.body.stability().iter().filter_map(|group| self.limit(group)).collect();
            head.insert("stable_courant_numbers".into(), limits.into());
        }
        head
    }

    fn snapshot(&self, model: &Model, out: &mut JsonObject) -> std::io::Result<()> {
        model.extension::<Points>().map_or(Ok(()), |points| snapshot(points.body.as_ref(), out))
    }

    fn stages(&self) -> Vec<(&'static str, Duration)> {
        Vec::new()
    }

    fn save_state(&self, model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        model.extension::<Points>().map_or(Ok(Vec::new()), |points| save_state(points.body.as_ref(), folder))
    }
}

/// Columns that the scene has, and those that it does without.
fn columns([_, nodes, _]: [usize; 3], part: &ModelPart) -> (String, String) {
    let mut used =
        vec!["position", "displacement", "velocity", "displacement gradient", "first Piola-Kirchhoff stress"];
    let mut left = vec!["acceleration", "history", "grid fields shared by cells"];
    let forces = part.node_fields.vector(&crate::variables::VOLUME_ACCELERATION).is_some();
    (if nodes > 0 { &mut used } else { &mut left }).push("cells' own nodes between stages");
    (if forces { &mut used } else { &mut left }).push("body force");
    (used.join(", "), left.join(", "))
}
