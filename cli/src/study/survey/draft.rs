//! What a survey file says of its scenes and runs, before it is put together: each may be like another, and
//! says only in what it differs.

use super::criterion::Criterion;
use super::keys::{RUN, SCENE};
use super::plan::Method;
use crate::study::case::{Changes, in_order};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Parameters, Settings};

/// What is said of a run.
#[derive(Debug, Clone)]
pub struct RunDraft {
    /// Where it is said.
    pub place: Parameters,
    /// Why it cannot be run.
    pub cannot: Option<String>,
    /// Its project, if it is not that of its scene.
    pub project: Option<String>,
    /// Pointers of its method and its scene that it does not set, with the place of those that must be there.
    pub unset: Vec<(String, Option<Parameters>)>,
    /// What it sets itself.
    pub changes: Changes,
    /// What it must keep, or what besides the criteria of its scene.
    pub criteria: Criteria,
    /// Theory says that it passes.
    pub must: bool,
    /// Explanation.
    pub text: String,
}

/// What a run must keep.
#[derive(Debug, Clone)]
pub enum Criteria {
    /// Nothing else.
    All(Vec<Criterion>),
    /// Besides those of its scene and its method.
    More(Vec<Criterion>),
}

/// What is said of a scene.
#[derive(Debug, Clone)]
pub struct SceneDraft {
    /// Short name.
    pub id: String,
    /// Name.
    pub title: String,
    /// What it is.
    pub text: String,
    /// The project of all runs that name none.
    pub project: Option<String>,
    /// What these runs set.
    pub changes: Changes,
    /// What its runs must keep.
    pub criteria: Vec<Criterion>,
    /// Wall time in seconds, if not the survey's.
    pub time_limit: Option<f64>,
    /// For each method.
    pub runs: Vec<Option<RunDraft>>,
}

impl SceneDraft {
    /// Reads a scene that may be like an earlier one.
    ///
    /// # Errors
    /// Everything that is wrong in it.
    pub fn read(place: &Parameters, methods: &[Method], earlier: &[Self]) -> Result<Self, InputErrors> {
        let settings = place.read(SCENE)?;
        let mut errors = InputErrors::default();
        let names = || earlier.iter().map(|scene| scene.id.as_str());
        let base = named(&settings, names, "scene before this one").map(|index| index.map(|index| &earlier[index]))?;
        let changes = base.map_or_else(Changes::default, |base| base.changes.clone());
        let changes = errors.absorb(changes.with(&settings)).unwrap_or_default();
        let mut criteria = base.map_or(Vec::new(), |base| base.criteria.clone());
        if settings.given("criteria") {
            criteria = errors.absorb(read_criteria(&settings, "criteria")).unwrap_or_default();
        }
        let mut runs = base.map_or_else(|| methods.iter().map(|_| None).collect(), |base| base.runs.clone());
        if !settings.given("runs") && base.is_none() {
            errors.push(place.error("has no \"runs\", and is like no other scene"));
        }
        for (method, place) in settings.get("runs").map_or(Ok(Vec::new()), in_order)? {
            let Some(column) = methods.iter().position(|column| column.label == method) else {
                let known = methods.iter().map(|column| column.label.as_str());
                errors.push(place.error(format!("{method:?} is no method of this survey")).allowed(&method, known));
                continue;
            };
            if let Some(run) = errors.absorb(RunDraft::read(&place, methods, &runs, column)) {
                runs[column] = Some(run);
            }
        }
        let text = |key: &str| settings.given(key).then(|| settings.text(key).to_string());
        errors.or(Self {
            id: settings.text("id").into(),
            title: settings.text("title").into(),
            text: text("text").or_else(|| base.map(|base| base.text.clone())).unwrap_or_default(),
            project: text("project").or_else(|| base.and_then(|base| base.project.clone())),
            changes,
            criteria,
            time_limit: (settings.given("time_limit").then(|| settings.number("time_limit")))
                .or_else(|| base.and_then(|base| base.time_limit)),
            runs,
        })
    }
}

impl RunDraft {
    /// Reads a run that may be like that of another method; else it is like that of the scene which its own
    /// scene is like, which stands in its column.
    fn read(place: &Parameters, methods: &[Method], runs: &[Option<Self>], column: usize) -> Result<Self, InputErrors> {
        let settings = place.read(RUN)?;
        let mut errors = InputErrors::default();
        let text = |key: &str| settings.given(key).then(|| settings.text(key).to_string());
        let names = || methods.iter().zip(runs).filter(|(_, run)| run.is_some()).map(|(method, _)| &*method.label);
        let base = match named(&settings, names, "method with a run before this one")? {
            Some(index) => runs.iter().flatten().nth(index),
            None => runs[column].as_ref(),
        };
        let is_alone = ["project", "set", "criteria", "more_criteria", "must"].iter().all(|key| !settings.given(key));
        let cannot = text("cannot").or_else(|| base.filter(|_| is_alone).and_then(|base| base.cannot.clone()));
        let base = base.filter(|base| base.cannot.is_none() && cannot.is_none());
        if settings.given("cannot") && !is_alone {
            errors.push(place.error("needs either \"project\" or \"cannot\""));
        }
        let inherited = base.map_or_else(Changes::default, |base| base.changes.clone());
        let own_unset = errors.absorb(pointers(&settings, &inherited)).unwrap_or_default();
        let changes = inherited.without(|pointer| own_unset.iter().any(|(unset, _)| unset == pointer));
        let changes = errors.absorb(changes.with(&settings)).unwrap_or_default();
        let mut criteria = base.map_or(Criteria::More(Vec::new()), |base| base.criteria.clone());
        for (key, make) in [("criteria", Criteria::All as fn(_) -> _), ("more_criteria", Criteria::More)] {
            if settings.given(key) {
                criteria = make(errors.absorb(read_criteria(&settings, key)).unwrap_or_default());
            }
        }
        errors.or(Self {
            place: place.clone(),
            cannot,
            project: text("project").or_else(|| base.and_then(|base| base.project.clone())),
            unset: match base {
                // Another method may set less.
                Some(base) if !settings.given("unset") => {
                    base.unset.iter().map(|(pointer, _)| (pointer.clone(), None)).collect()
                }
                _ => own_unset,
            },
            changes,
            criteria,
            must: if settings.given("must") { settings.flag("must") } else { base.is_some_and(|base| base.must) },
            text: text("text").or_else(|| base.map(|base| base.text.clone())).unwrap_or_default(),
        })
    }
}

/// Which of these names `like` is.
fn named<'a, I: Iterator<Item = &'a str>>(
    settings: &Settings,
    names: impl Fn() -> I,
    what: &str,
) -> Result<Option<usize>, InputErrors> {
    if !settings.given("like") {
        return Ok(None);
    }
    let wanted = settings.text("like");
    let fault = || settings.error("like", format!("{wanted:?} is no {what}")).allowed(wanted, names());
    names().position(|name| name == wanted).map(Some).ok_or_else(|| fault().into())
}

/// What is not set, with the place of what is not among the inherited changes.
fn pointers(settings: &Settings, inherited: &Changes) -> Result<Vec<(String, Option<Parameters>)>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut list = Vec::new();
    for entry in settings.get("unset").map_or(Vec::new(), Parameters::entries) {
        match entry.value().as_str().map(str::to_string) {
            Some(pointer) if inherited.sets(&pointer) => list.push((pointer, None)),
            Some(pointer) => list.push((pointer, Some(entry))),
            None => errors.push(entry.error("must be a JSON pointer")),
        }
    }
    errors.or(list)
}

/// The criteria of a list.
///
/// # Errors
/// Everything that is wrong in them.
pub fn read_criteria(settings: &Settings, key: &str) -> Result<Vec<Criterion>, InputErrors> {
    let mut errors = InputErrors::default();
    let entries = settings.get(key).map_or(Vec::new(), Parameters::entries);
    let list = entries.iter().filter_map(|entry| errors.absorb(Criterion::read(entry))).collect();
    errors.or(list)
}
