//! From the project to the analysis: every fault that can be found is told, and nothing is written.

use super::old_names::old_names;
use super::restart::Restart;
use super::{Analysis, Project};
use crate::diagnostic::{Diagnostic, InputErrors, Place, Severity};
use crate::error::Error;
use crate::model::Model;
use crate::parameters::{Document, Parameters};
use crate::processes::{Clock, Process, Requirements, RunOptions};
use crate::registry::{Modeler, Registry};
use crate::solving::solver::Solver;
use std::path::Path;

/// What a project names, built one by one; what cannot be built is left out.
struct Components {
    solver: Option<Box<dyn Solver>>,
    /// Without its faulty settings: it reads the meshes and materials, and is never run.
    spare: Option<Box<dyn Solver>>,
    processes: Vec<Box<dyn Process>>,
    /// None if one of them is faulty: parts that it would make would seem to be missing.
    modelers: Option<Vec<Box<dyn Modeler>>>,
}

impl Analysis {
    /// Reads all input of a project, checks it and makes the model; nothing is written.
    ///
    /// # Errors
    /// Every fault of all files of the input, but for those that merely follow from others.
    pub fn prepare(
        document: Document,
        registry: &Registry,
        mut options: RunOptions,
        record: bool,
    ) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let project = Project::read(Parameters::root(document), &mut errors);
        options.kratos_exact |= project.kratos_exact;
        errors.absorb(check_output(&options.output));
        let mut components = Components::build(&project, registry, &options, &mut errors);
        let mut model = Model::default();
        if components.import(&mut model, registry, &mut errors).is_none() {
            return Err(errors);
        }
        let mut warnings = project.warnings.clone();
        warnings.extend(idle_intervals(&project));
        match options.kratos_exact {
            true => warnings.push(KRATOS_EXACT.into()),
            false => warnings.extend(old_names(&project, registry)),
        }
        for part in model.parts_mut() {
            warnings.extend(part.apply_data(registry));
        }
        let Components { solver, mut processes, .. } = components;
        for process in &mut processes {
            errors.absorb(process.connect(&mut model));
        }
        let mut requirements =
            Requirements { record, providers: registry.providers().to_vec(), ..Requirements::default() };
        for process in &processes {
            process.require(&mut requirements);
        }
        errors.absorb(std::mem::take(&mut requirements.faults).or(()));
        let (Some(mut solver), Some(problem)) = (solver, project.problem.as_ref()) else { return Err(errors) };
        errors.absorb(solver.initialize(&mut model, &requirements));
        errors = errors.or(InputErrors::default())?;
        for process in &mut processes {
            errors.absorb(process.check(&model));
        }
        errors.or(())?;
        let (start, end) = (problem.number("start_time"), problem.number("end_time"));
        let clock = Clock { start, time: start, load_time: start, end, ..Clock::default() };
        warnings.extend(check_time_step(solver.as_mut(), &model, &clock, project.solver.as_ref())?);
        let restart = project.restart.as_ref().map(|settings| Restart::new(settings, &options.output));
        let keys = project.solver.as_ref().map_or(&[][..], |settings| registry.solver_keys(settings));
        let adjustable = keys.iter().filter(|key| key.adjustable).map(|key| key.name).collect();
        let (project, variables) = (project.root, registry.variables().to_vec());
        Ok(Self {
            model,
            solver,
            processes,
            clock,
            options,
            project,
            restart,
            identity: serde_json::Value::Null,
            variables,
            adjustable,
            warnings,
            reached_first: Vec::new(),
            energy_at_start: None,
            stages: Vec::new(),
            account: None,
            first_stable: None,
        })
    }
}

impl Components {
    fn build(project: &Project, registry: &Registry, options: &RunOptions, errors: &mut InputErrors) -> Self {
        let (mut solver, mut spare) = (None, None);
        if let Some(settings) = &project.solver {
            match registry.build_solver(settings, options) {
                Ok(built) => solver = Some(built),
                Err(faults) => {
                    spare = registry.build_solver(&without_faults(settings, &faults), options).ok();
                    errors.0.extend(faults.0);
                }
            }
        }
        let mut processes = solver.as_ref().map_or(Vec::new(), |solver| solver.processes());
        for block in project.processes.iter().chain(&project.outputs) {
            processes.extend(errors.absorb(registry.build_process(block, &project.root, options)));
        }
        let build = |block| errors.absorb(registry.build_modeler(block, &project.root, options));
        let modelers: Vec<Option<_>> = project.modelers.iter().map(build).collect();
        Self { solver, spare, processes, modelers: modelers.into_iter().collect() }
    }

    /// Makes and reads the meshes; none if there is no model to go on with.
    fn import(&mut self, model: &mut Model, registry: &Registry, errors: &mut InputErrors) -> Option<()> {
        for modeler in self.modelers.as_mut()? {
            errors.absorb(modeler.setup_geometry(model, registry))?;
        }
        for modeler in self.modelers.as_mut()? {
            errors.absorb(modeler.setup_model_part(model, registry))?;
        }
        errors.absorb(self.solver.as_mut().or(self.spare.as_mut())?.import(model, registry))
    }
}

/// The settings without the members that are wrong, so that their defaults take their place.
fn without_faults(settings: &Parameters, faults: &InputErrors) -> Parameters {
    let wrong = faults.0.iter().filter(|fault| fault.severity == Severity::Error);
    wrong.filter_map(|fault| fault.place.pointer.as_deref()).fold(settings.clone(), |kept, pointer| {
        // What is missing is told at the object that lacks it: there is nothing to leave out.
        pointer.strip_prefix(settings.pointer()).map_or(kept.clone(), |below| kept.without(below))
    })
}

const KRATOS_EXACT: &str = "kratos_exact: the run repeats Kratos 10.4.4, its faults included; they are right to compare \
                            with Kratos, and wrong to judge a structure by";

/// Processes whose interval lies outside of the run.
fn idle_intervals(project: &Project) -> Vec<String> {
    let Some(problem) = &project.problem else { return Vec::new() };
    let (start, end) = (problem.number("start_time"), problem.number("end_time"));
    let interval = |block: &Parameters| block.child("Parameters").and_then(|own| own.child("interval"));
    let idle = |interval: &Parameters| {
        let bound = |i: usize, open: f64| interval.value().get(i).and_then(|x| x.as_f64()).unwrap_or(open);
        // The last step may go beyond the end.
        bound(0, start) > end || bound(1, end) < start
    };
    let blocks = project.processes.iter().chain(&project.outputs);
    let told = blocks.filter_map(interval).filter(idle).map(|interval| {
        let message = format!("{} lies outside of the run, {start} s to {end} s", interval.describe());
        interval.warning(message + ": this process never acts").to_string()
    });
    told.collect()
}

/// Results go to a folder: one that is there, or can be made.
fn check_output(output: &Path) -> Result<(), InputErrors> {
    let refuse = |path: &Path, why: &str| {
        let message = format!("results cannot go to {}: {} {why}", output.display(), path.display());
        Err(Diagnostic::error(Place::default(), message).help("name another folder with --output").into())
    };
    // The folder, or the nearest one above it that is there.
    let Some((path, found)) = output.ancestors().find_map(|path| Some((path, path.metadata().ok()?))) else {
        return Ok(());
    };
    match found.is_dir() {
        false => refuse(path, "is no folder"),
        true if found.permissions().readonly() => refuse(path, "cannot be written"),
        true => Ok(()),
    }
}

/// Refuses steps so small that the loop would not end: at the end of the run a step must still
/// change the time, and so it does before. Warns of a first step that goes far beyond the end.
fn check_time_step(
    solver: &mut dyn Solver,
    model: &Model,
    clock: &Clock,
    settings: Option<&Parameters>,
) -> Result<Option<String>, InputErrors> {
    let place = || settings.and_then(|settings| settings.child("time_stepping").or_else(|| Some(settings.clone())));
    let mut first = None;
    for time in [clock.start, clock.end] {
        match solver.time_step(model, &Clock { time, ..*clock }) {
            Ok(step) => first = first.or(Some(step)),
            Err(Error::Input(errors)) => return Err(errors),
            Err(error) => {
                let (message, help) = match &error {
                    Error::Failure(failure) => (failure.report().what.clone(), failure.report().advice.clone()),
                    other => (other.to_string(), String::new()),
                };
                let place = place().map_or_else(Place::default, |place| place.place());
                return Err(Diagnostic::error(place, message).help(help).into());
            }
        }
    }
    let span = clock.end - clock.start;
    Ok(first.filter(|step| *step > span * (1.0 + 1e-9)).zip(place()).map(|(step, place)| {
        let message = format!("the first step, {step} s, is longer than the whole run, {span} s: it ends at {} s", {
            clock.start + step
        });
        place.warning(message).help("a smaller time step, or a later end_time").to_string()
    }))
}
