//! Reads a survey: scenes, methods, and what each run must keep.

use super::beside::{Measured, Program};
use super::criterion::Criterion;
use super::keys::{METHOD, RUN, SCENE, SURVEY};
use crate::study::case::{Case, Changes};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Document, Parameters, Settings};
use std::path::{Path, PathBuf};

/// A survey.
#[derive(Debug)]
pub struct Survey {
    /// Title of the report.
    pub title: String,
    /// What the reader should know.
    pub text: String,
    /// What a user should take from it.
    pub advice: String,
    /// Runs of each cell.
    pub repetitions: usize,
    /// The methods, and behind them what stands beside: columns of the matrix.
    pub methods: Vec<Method>,
    /// Other programs.
    pub programs: Vec<Program>,
    /// The scenes.
    pub scenes: Vec<Scene>,
}

/// A column of the matrix.
#[derive(Debug, Clone)]
pub struct Method {
    /// Its name.
    pub label: String,
    /// A line about it.
    pub text: String,
}

/// A scene.
#[derive(Debug)]
pub struct Scene {
    /// Short name.
    pub id: String,
    /// Name.
    pub title: String,
    /// What it is.
    pub text: String,
    /// A run for each column, in their order; none where the survey says nothing.
    pub runs: Vec<Option<Run>>,
}

/// A method on a scene.
#[derive(Debug)]
pub enum Run {
    /// It cannot be run, for this reason.
    Cannot(String),
    /// It is run.
    Wanted(Box<Wanted>),
    /// Another program was run.
    Measured(Box<Measured>),
}

/// A run with what it must keep.
#[derive(Debug)]
pub struct Wanted {
    /// What is run.
    pub case: Case,
    /// What it must keep.
    pub criteria: Vec<Criterion>,
    /// Theory says that it passes.
    pub must: bool,
    /// Explanation.
    pub text: String,
}

/// What all scenes share.
struct Common {
    folder: PathBuf,
    methods: Vec<Method>,
    threads: usize,
    time_limit: f64,
}

impl Survey {
    /// Reads a survey file and all projects that it names.
    ///
    /// # Errors
    /// Everything that is wrong in it, together.
    pub fn read(path: &Path) -> Result<Self, InputErrors> {
        let root = Parameters::root(Document::read(path)?);
        let settings = root.read(SURVEY)?;
        let mut errors = InputErrors::default();
        let methods = errors.absorb(methods(&settings)).unwrap_or_default();
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let (threads, time_limit) = (settings.integer("threads") as usize, settings.number("time_limit"));
        let common = Common { folder, methods, threads, time_limit };
        let mut scenes: Vec<Scene> = Vec::new();
        for place in settings.get("scenes").map_or(Vec::new(), Parameters::entries) {
            let Some(scene) = errors.absorb(Scene::read(&place, &common)) else { continue };
            if scenes.iter().any(|other| other.id == scene.id) {
                errors.push(place.error(format!("another scene is called {:?}, too", scene.id)));
            }
            scenes.push(scene);
        }
        if scenes.is_empty() && errors.0.is_empty() {
            errors.push(settings.error("scenes", "names no scene"));
        }
        let mut methods = common.methods;
        let mut programs = Vec::new();
        for place in settings.get("beside").map_or(Vec::new(), Parameters::entries) {
            let Some(file) = place.value().as_str() else {
                errors.push(place.error("must be the name of a file"));
                continue;
            };
            programs.extend(errors.absorb(Program::read(&common.folder.join(file), &mut methods, &mut scenes)));
        }
        let text = |key: &str| settings.text(key).to_string();
        errors.or(Self {
            title: text("title"),
            text: text("text"),
            advice: text("advice"),
            repetitions: settings.integer("repetitions") as usize,
            methods,
            programs,
            scenes,
        })
    }

    /// All runs, scene after scene.
    pub fn wanted(&self) -> impl Iterator<Item = &Wanted> {
        self.scenes.iter().flat_map(|scene| scene.runs.iter().flatten()).filter_map(|run| match run {
            Run::Wanted(wanted) => Some(wanted.as_ref()),
            Run::Cannot(_) | Run::Measured(_) => None,
        })
    }
}

impl Scene {
    fn read(place: &Parameters, common: &Common) -> Result<Self, InputErrors> {
        let settings = place.read(SCENE)?;
        let mut errors = InputErrors::default();
        let (id, title) = (settings.text("id").to_string(), settings.text("title").to_string());
        let changes = errors.absorb(Changes::default().with(&settings)).unwrap_or_default();
        let criteria = errors.absorb(criteria(&settings)).unwrap_or_default();
        let limit = if settings.given("time_limit") { settings.number("time_limit") } else { common.time_limit };
        let mut runs: Vec<Option<Run>> = common.methods.iter().map(|_| None).collect();
        for (method, place) in settings.get("runs").map_or(Ok(Vec::new()), Parameters::object)? {
            let Some(column) = common.methods.iter().position(|column| column.label == method) else {
                let known = common.methods.iter().map(|column| column.label.as_str());
                errors.push(place.error(format!("{method:?} is no method of this survey")).allowed(&method, known));
                continue;
            };
            let name = format!("{id}, {method}");
            runs[column] = errors.absorb(Run::read(&place, name, &changes, &criteria, limit, common));
        }
        errors.or(Self { id, title, text: settings.text("text").into(), runs })
    }
}

impl Run {
    fn read(
        place: &Parameters,
        name: String,
        changes: &Changes,
        shared: &[Criterion],
        limit: f64,
        common: &Common,
    ) -> Result<Self, InputErrors> {
        let settings = place.read(RUN)?;
        match (settings.given("cannot"), settings.given("project")) {
            (true, false) => return Ok(Self::Cannot(settings.text("cannot").into())),
            (false, true) => {}
            _ => return Err(place.error("needs either \"project\" or \"cannot\"").into()),
        }
        let mut errors = InputErrors::default();
        let changes = errors.absorb(changes.with(&settings)).unwrap_or_default();
        let project = common.folder.join(settings.text("project"));
        let case = errors.absorb(Case::new(name, project, &changes, common.threads, limit));
        let criteria = match settings.given("criteria") {
            true => errors.absorb(criteria(&settings)).unwrap_or_default(),
            false => shared.to_vec(),
        };
        if criteria.is_empty() {
            errors.push(place.error("has no criteria, and its scene none for all"));
        }
        let (must, text) = (settings.flag("must"), settings.text("text").to_string());
        match case {
            Some(case) => errors.or(Self::Wanted(Box::new(Wanted { case, criteria, must, text }))),
            None => Err(errors),
        }
    }
}

fn methods(settings: &Settings) -> Result<Vec<Method>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut methods: Vec<Method> = Vec::new();
    for place in settings.get("methods").map_or(Vec::new(), Parameters::entries) {
        let Some(method) = errors.absorb(place.read(METHOD)) else { continue };
        let (label, text) = (method.text("label").to_string(), method.text("text").to_string());
        if methods.iter().any(|other| other.label == label) {
            errors.push(place.error(format!("another method is called {label:?}, too")));
        }
        methods.push(Method { label, text });
    }
    errors.or(methods)
}

fn criteria(settings: &Settings) -> Result<Vec<Criterion>, InputErrors> {
    let mut errors = InputErrors::default();
    let entries = settings.get("criteria").map_or(Vec::new(), Parameters::entries);
    let list = entries.iter().filter_map(|entry| errors.absorb(Criterion::read(entry))).collect();
    errors.or(list)
}
