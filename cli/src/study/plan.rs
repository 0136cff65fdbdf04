//! Reads a study: which cases it runs, and what is told of them.

use super::case::{Case, Changes};
use super::keys::{STUDY, SWEEP, VARIANT};
use super::quantity::Quantity;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Document, Parameters, Settings};
use std::path::{Path, PathBuf};

/// A study.
#[derive(Debug)]
pub struct Study {
    /// Title of the report.
    pub title: String,
    /// What the reader should know.
    pub text: String,
    /// What a user should choose.
    pub advice: String,
    /// The error, from the summary of a run.
    pub error: Quantity,
    /// What the error is.
    pub error_name: String,
    /// What h is.
    pub size_name: String,
    /// Runs of each case.
    pub repetitions: usize,
    /// Orders that are shown as lines.
    pub slopes: Vec<f64>,
    /// Errors for which the cheapest variant is told.
    pub wanted: Vec<f64>,
    /// The variants.
    pub variants: Vec<Variant>,
}

/// A method.
#[derive(Debug)]
pub struct Variant {
    /// Its name.
    pub label: String,
    /// A line about it.
    pub text: String,
    /// Its cases, the coarsest first as the file has them.
    pub entries: Vec<Entry>,
}

/// A variant on one mesh, say.
#[derive(Debug)]
pub struct Entry {
    /// Name of the entry of the sweep.
    pub label: String,
    /// What is refined.
    pub size: Option<f64>,
    /// What is run.
    pub case: Case,
}

/// What holds for all cases.
struct Common {
    folder: PathBuf,
    changes: Changes,
    project: Option<String>,
    threads: usize,
    time_limit: f64,
    sweep: Option<Parameters>,
}

impl Study {
    /// Reads a study file and all projects that it names.
    ///
    /// # Errors
    /// Everything that is wrong in it, together.
    pub fn read(path: &Path) -> Result<Self, InputErrors> {
        let root = Parameters::root(Document::read(path)?);
        let settings = root.read(STUDY)?;
        let mut errors = InputErrors::default();
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let changes = errors.absorb(Changes::default().with(&settings)).unwrap_or_default();
        let project = settings.given("project").then(|| settings.text("project").to_string());
        let (threads, time_limit) = (settings.integer("threads") as usize, settings.number("time_limit"));
        let sweep = settings.get("sweep").cloned();
        let common = Common { folder, changes, project, threads, time_limit, sweep };
        let mut variants: Vec<Variant> = Vec::new();
        for place in settings.get("variants").map_or(Vec::new(), Parameters::entries) {
            let Some(variant) = errors.absorb(Variant::read(&place, &common)) else { continue };
            if variants.iter().any(|other| other.label == variant.label) {
                errors.push(place.error(format!("another variant is called {:?}, too", variant.label)));
            }
            variants.push(variant);
        }
        if variants.is_empty() && errors.0.is_empty() {
            errors.push(settings.error("variants", "names no variant"));
        }
        let error = settings.get("error").and_then(|place| errors.absorb(Quantity::of_error(place)));
        let slopes = errors.absorb(numbers(&settings, "reference_slopes")).unwrap_or_default();
        let wanted = errors.absorb(numbers(&settings, "wanted_errors")).unwrap_or_default();
        let text = |key: &str| settings.text(key).to_string();
        let Some(error) = error else { return Err(errors) };
        errors.or(Self {
            title: text("title"),
            text: text("text"),
            advice: text("advice"),
            error,
            error_name: text("error_name"),
            size_name: text("size_name"),
            repetitions: settings.integer("repetitions") as usize,
            slopes,
            wanted,
            variants,
        })
    }

    /// All cases, the sweep's first entry of every variant first.
    pub fn cases(&self) -> Vec<&Case> {
        let longest = self.variants.iter().map(|variant| variant.entries.len()).max().unwrap_or(0);
        let at = |index: usize| self.variants.iter().filter_map(move |variant| variant.entries.get(index));
        (0..longest).flat_map(at).map(|entry| &entry.case).collect()
    }
}

impl Variant {
    fn read(place: &Parameters, common: &Common) -> Result<Self, InputErrors> {
        let settings = place.read(VARIANT)?;
        let mut errors = InputErrors::default();
        let label = settings.text("label").to_string();
        let changes = common.changes.with(&settings)?;
        let own = settings.given("project").then(|| settings.text("project").to_string());
        let Some(project) = own.or_else(|| common.project.clone()) else {
            return Err(place.error("names no \"project\", and the study none for all").into());
        };
        let sweep = settings.get("sweep").or(common.sweep.as_ref());
        let Some(sweep) = sweep.map(Parameters::entries).filter(|entries| !entries.is_empty()) else {
            return Err(place.error("has no \"sweep\", and the study none for all").into());
        };
        let mut entries: Vec<Entry> = Vec::new();
        for place in sweep {
            let read = || -> Result<Entry, InputErrors> {
                let settings = place.read(SWEEP)?;
                let point = settings.text("label").to_string();
                let (name, project) = (format!("{label}, {point}"), common.folder.join(&project));
                let changes = changes.with(&settings)?;
                let case = Case::new(name, project, &changes, common.threads, common.time_limit)?;
                Ok(Entry { label: point, size: settings.given("h").then(|| settings.number("h")), case })
            };
            let Some(entry) = errors.absorb(read()) else { continue };
            if entries.iter().any(|other| other.label == entry.label) {
                errors.push(place.error(format!("another entry of the sweep is called {:?}, too", entry.label)));
            }
            entries.push(entry);
        }
        errors.or(Self { label, text: settings.text("text").to_string(), entries })
    }
}

/// The positive numbers of a list.
fn numbers(settings: &Settings, key: &str) -> Result<Vec<f64>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut list = Vec::new();
    for entry in settings.get(key).map_or(Vec::new(), Parameters::entries) {
        match entry.value().as_f64().filter(|number| *number > 0.0) {
            Some(number) => list.push(number),
            None => errors.push(entry.error("must be a number above 0")),
        }
    }
    errors.or(list)
}
