//! Reads a survey: scenes, methods, and what each run must keep.

use super::beside::{Measured, Program};
use super::criterion::Criterion;
use super::draft::{Criteria, RunDraft, SceneDraft, read_criteria};
use super::keys::{METHOD, SURVEY};
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
#[derive(Debug, Clone, Default)]
pub struct Method {
    /// Its name.
    pub label: String,
    /// A line about it.
    pub text: String,
    /// What it sets in the projects of scenes.
    pub changes: Changes,
    /// What its runs must keep besides the criteria of their scenes.
    pub criteria: Vec<Criterion>,
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
        let mut drafts: Vec<SceneDraft> = Vec::new();
        let mut scenes: Vec<Scene> = Vec::new();
        for place in settings.get("scenes").map_or(Vec::new(), Parameters::entries) {
            let read = SceneDraft::read(&place, &common.methods, &drafts);
            let Some(draft) = errors.absorb(read) else { continue };
            if drafts.iter().any(|other| other.id == draft.id) {
                errors.push(place.error(format!("another scene is called {:?}, too", draft.id)));
            }
            scenes.extend(errors.absorb(Scene::of(&draft, &common)));
            drafts.push(draft);
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
    fn of(draft: &SceneDraft, common: &Common) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let mut run = |(method, run): (&Method, &Option<RunDraft>)| {
            run.as_ref().and_then(|run| errors.absorb(Run::of(run, draft, method, common)))
        };
        let runs = common.methods.iter().zip(&draft.runs).map(&mut run).collect();
        let (id, title, text) = (draft.id.clone(), draft.title.clone(), draft.text.clone());
        errors.or(Self { id, title, text, runs })
    }
}

impl Run {
    fn of(draft: &RunDraft, scene: &SceneDraft, method: &Method, common: &Common) -> Result<Self, InputErrors> {
        if let Some(reason) = &draft.cannot {
            return Ok(Self::Cannot(reason.clone()));
        }
        let shared = method.changes.clone().then(&scene.changes);
        let shared = if draft.project.is_some() { shared.without(|_| true) } else { shared };
        let Some(project) = draft.project.as_ref().or(scene.project.as_ref()) else {
            return Err(draft.place.error("needs either \"project\" or \"cannot\"").into());
        };
        let mut errors = InputErrors::default();
        for (pointer, place) in &draft.unset {
            if let Some(place) = place.as_ref().filter(|_| !shared.sets(pointer)) {
                errors.push(place.error("is set neither by the method nor by the scene"));
            }
        }
        let is_unset = |pointer: &str| draft.unset.iter().any(|(unset, _)| unset == pointer);
        let changes = shared.without(is_unset).then(&draft.changes);
        let (name, limit) = (format!("{}, {}", scene.id, method.label), scene.time_limit.unwrap_or(common.time_limit));
        let case = errors.absorb(Case::new(name, common.folder.join(project), &changes, common.threads, limit));
        let criteria = match &draft.criteria {
            Criteria::All(criteria) => criteria.clone(),
            Criteria::More(more) => [&scene.criteria, more, &method.criteria].into_iter().flatten().cloned().collect(),
        };
        if criteria.is_empty() {
            errors.push(draft.place.error("has no criteria, and its scene none for all"));
        }
        let (must, text) = (draft.must, draft.text.clone());
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
        let changes = errors.absorb(Changes::default().with(&method)).unwrap_or_default();
        let criteria = errors.absorb(read_criteria(&method, "criteria")).unwrap_or_default();
        if methods.iter().any(|other| other.label == label) {
            errors.push(place.error(format!("another method is called {label:?}, too")));
        }
        methods.push(Method { label, text, changes, criteria });
    }
    errors.or(methods)
}
