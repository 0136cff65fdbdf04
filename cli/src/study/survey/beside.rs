//! What another program did on a survey's scenes: measured once by other means, kept in a file, and judged
//! here by the same criteria as the survey's own methods.

use super::criterion::{Criterion, Finding};
use super::keys::{BESIDE, RESULT};
use super::plan::{Method, Run, Scene};
use crate::study::case::in_order;
use crate::study::outcome::Outcome;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Document, Parameters, Settings};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Another program.
#[derive(Debug)]
pub struct Program {
    /// Name and version.
    pub name: String,
    /// How it was measured, and when.
    pub text: String,
    /// Its columns, each with the column of the method whose criteria judge it.
    pub columns: Vec<(usize, usize)>,
}

/// What it did on a scene.
#[derive(Debug)]
pub struct Measured {
    /// How it ended, with its steps and its CPU time.
    pub outcome: Outcome,
    /// By what it is judged.
    pub criteria: Vec<Criterion>,
    /// What these look at, by their texts; null where it was not finite.
    found: Map<String, Value>,
}

impl Measured {
    /// What each criterion finds.
    pub fn findings(&self) -> Vec<Finding> {
        let number = |criterion: &Criterion| self.found.get(criterion.text()).map(Value::as_f64);
        self.criteria.iter().map(|criterion| criterion.look_beside(self.outcome.end(), number(criterion))).collect()
    }
}

impl Program {
    /// Reads a file of results, and adds its columns behind the methods and in each scene.
    ///
    /// # Errors
    /// Scenes, methods and criteria that the survey has not: what was measured is no longer what is asked.
    pub fn read(path: &Path, methods: &mut Vec<Method>, scenes: &mut [Scene]) -> Result<Self, InputErrors> {
        let settings = Parameters::root(Document::read(path)?).read(BESIDE)?;
        let mut errors = InputErrors::default();
        let name = format!("{} {}", settings.text("program"), settings.text("version"));
        let mut columns = Vec::new();
        for (method, place) in settings.get("methods").map_or(Ok(Vec::new()), in_order)? {
            let Some(own) = errors.absorb(column_of(&method, &place, methods)) else { continue };
            columns.push((methods.len(), own));
            let label = format!("{name}: {}", place.value().as_str().unwrap_or(&method));
            methods.push(Method { label, ..Method::default() });
        }
        for scene in scenes.iter_mut() {
            scene.runs.resize_with(methods.len(), || None);
        }
        for (id, place) in settings.get("scenes").map_or(Ok(Vec::new()), Parameters::object)? {
            let Some(scene) = scenes.iter_mut().find(|scene| scene.id == id) else {
                errors.push(place.error(format!("{id:?} is no scene of this survey")));
                continue;
            };
            for (method, place) in place.object()? {
                let Some(own) = errors.absorb(column_of(&method, &place, methods)) else { continue };
                let Some((column, _)) = columns.iter().find(|(_, other)| *other == own) else {
                    errors.push(place.error(format!("{method:?} is none of the methods above")));
                    continue;
                };
                scene.runs[*column] = errors.absorb(read_result(&place, scene.runs[own].as_ref()));
            }
        }
        let date = settings.text("date");
        let text = format!("{name}, measured {date}: {}", settings.text("text"));
        errors.or(Self { name, text, columns })
    }
}

/// The column of one of the survey's own methods.
fn column_of(method: &str, place: &Parameters, methods: &[Method]) -> Result<usize, InputErrors> {
    let labels = || methods.iter().map(|method| method.label.as_str());
    labels()
        .position(|label| label == method)
        .ok_or_else(|| place.error(format!("{method:?} is no method of this survey")).allowed(method, labels()).into())
}

/// A result with the criteria of the survey's own run of the scene.
fn read_result(place: &Parameters, own: Option<&Run>) -> Result<Run, InputErrors> {
    let settings = place.read(RESULT)?;
    let (end, reason) = (settings.text("end"), settings.text("reason"));
    if end == "cannot" {
        return Ok(Run::Cannot(reason.into()));
    }
    let Some(Run::Wanted(own)) = own else {
        return Err(place.error("is a result of what the survey does not run itself").into());
    };
    let mut errors = InputErrors::default();
    let mut found = Map::new();
    for (text, number) in settings.get("found").map_or(Ok(Vec::new()), Parameters::object)? {
        let known = || own.criteria.iter().map(Criterion::text);
        if !known().any(|known| known == text) {
            errors.push(number.error(format!("{text:?} is no criterion of this run")).allowed(&text, known()));
        } else if !number.value().is_number() && !number.value().is_null() {
            errors.push(number.error("must be a number, or null"));
        }
        found.insert(text, number.value().clone());
    }
    let number = |settings: &Settings, key: &str| settings.given(key).then(|| settings.number(key));
    let summary = json!({"steps": number(&settings, "steps"), "loop_cpu_s": number(&settings, "cpu_s")});
    let outcome = Outcome::new(vec![json!({"end": end, "reason": reason, "summary": summary})]);
    errors.or(Run::Measured(Box::new(Measured { outcome, criteria: own.criteria.clone(), found })))
}
