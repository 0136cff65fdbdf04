//! The error of a field against a reference solution, in a norm, in time.
//!
//! With e = q − q_ref, |e| its Euclidean norm over the components, and weights w of the entities (the volume
//! of a point at the start, the share of a node of the volume of its cells, 1 for probes):
//! L1 = Σ w |e|, L2 = √(Σ w |e|²), rms = √(Σ w |e|² / Σ w), max = max |e|. Relative errors are divided by the
//! same norm of the reference. Over the measured times errors are joined as the norm says: their mean for
//! L1, their root mean square for L2 and rms, the largest for max.

mod norm;

use super::sample::{SOURCE, Samples, Source};
use super::{Measurement, TABLE, TableOutput};
use crate::analysis::number;
use crate::diagnostic::InputErrors;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::table::Heading;
use crate::model::Model;
use crate::parameters::{Key, Kind, Parameters};
use crate::processes::{Clock, Process, Requirements, Results};
use crate::reference::{Compared, Place, ReferenceSolution};
use crate::registry::{Building, ProcessEntry, Registry};
use norm::{Norm, OverTime, Sums};
use serde_json::json;

const KEYS: &[Key] = &Key::join::<11, 4, 15>(
    Key::join::<7, 4, 11>(TABLE, SOURCE),
    [
        Key::required("label", Kind::Text, "name of the error in the summary of the run"),
        Key::required("variable", Kind::Text, "such as MP_DISPLACEMENT, VELOCITY_X or MP_CAUCHY_STRESS_VECTOR_XX"),
        Key::new("norm", Kind::Choice(&["L1", "L2", "max", "rms"]), "\"L2\"", "how errors are joined to a number"),
        Key::required("reference", Kind::Any, "{\"type\": name, …}: bia info shows the reference solutions"),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "error_process",
        aliases: &[],
        application: None,
        keys: KEYS,
        help: "error of a field against a reference solution, in time as a table and in the summary of the run",
        build,
    });
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = &building.settings;
    let mut errors = InputErrors::default();
    let label = settings.text("label").to_string();
    if label.is_empty() || label.contains(['/', '\\', '~']) {
        let help = "a label is a part of file names and of JSON pointers";
        errors.push(settings.error("label", format!("{label:?} is empty or holds a slash or tilde")).help(help));
    }
    let place = settings.get("variable").unwrap_or(settings.parameters()).clone();
    let compared = errors.absorb(Compared::named(settings.text("variable"), &place, building.registry));
    let source = errors.absorb(Source::read(&building));
    let reference = match (&compared, settings.get("reference")) {
        (Some(compared), Some(place)) => {
            let (registry, options, project) = (building.registry, building.options, building.project);
            errors.absorb(crate::reference::build(place, compared, registry, options, project))
        }
        _ => None,
    };
    let norm = Norm::named(settings.text("norm"));
    let (Some(compared), Some(source), Some(reference), Some(norm)) = (compared, source, reference, norm) else {
        return Err(errors);
    };
    errors.or(())?;
    let samples = Samples::default();
    let error = FieldError {
        label,
        place,
        compared,
        source,
        reference,
        norm,
        samples,
        over_time: OverTime::default(),
        time: 0.0,
    };
    Ok(Box::new(TableOutput::new(&building, error)?))
}

struct FieldError {
    label: String,
    /// Where the input names the variable.
    place: Parameters,
    compared: Compared,
    source: Source,
    reference: Box<dyn ReferenceSolution>,
    norm: Norm,
    samples: Samples,
    over_time: OverTime,
    time: f64,
}

impl Measurement for FieldError {
    fn name(&self) -> &'static str {
        "error"
    }

    fn file_name(&self) -> String {
        format!("error_{}", self.label.replace([' ', '.'], "_"))
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        self.source.connect(model)
    }

    fn require(&self, requirements: &mut Requirements) {
        self.source.require(self.compared.variable.name, &self.place, requirements);
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        self.source.find_points(model)?;
        // What is compared must have as many numbers as the reference, which shows only now.
        self.source.sample(model, &self.compared, &mut self.samples);
        let mut numbers = Vec::new();
        self.reference.append(&Place::default(), &mut numbers);
        match self.samples.width {
            0 => Err(self
                .place
                .error(format!("nothing of {:?} is there to be compared", self.compared.to_string()))
                .into()),
            width if width != numbers.len() => {
                let message = format!("{} has {width} numbers here, its reference {}", self.compared, numbers.len());
                Err(self.place.error(message).into())
            }
            _ => Ok(()),
        }
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.source.exchange(archive)?;
        self.over_time.exchange(archive)
    }

    fn headings(&mut self, _: &Model) -> Vec<Heading> {
        let unit = self.compared.variable.unit;
        vec![
            Heading::new("ERROR", self.norm.unit(unit, self.source.is_probe())),
            Heading::new("REFERENCE_NORM", self.norm.unit(unit, self.source.is_probe())),
            Heading::new("RELATIVE_ERROR", "1"),
        ]
    }

    fn tell(&mut self, clock: &Clock) {
        self.time = clock.time;
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        self.source.sample(model, &self.compared, &mut self.samples);
        let (mut sums, mut reference) = ([Sums::default(), Sums::default()], Vec::new());
        let width = self.samples.width.max(1);
        for ((place, weight), values) in self.samples.places.iter().zip(self.samples.values.chunks_exact(width)) {
            reference.clear();
            self.reference.append(&Place { time: self.time, ..*place }, &mut reference);
            let square = |sum: f64, x: f64| sum + x * x;
            let error = values.iter().zip(&reference).map(|(q, r)| q - r).fold(0.0, square).sqrt();
            sums[0].add(error, *weight);
            sums[1].add(reference.iter().copied().fold(0.0, square).sqrt(), *weight);
        }
        let [error, size] = sums.map(|sums| sums.norm(self.norm));
        self.over_time.add(error, size);
        rows.extend([error, size, error / size]);
    }

    fn results(&self, results: &mut Results) {
        let numbers = self.over_time.numbers(self.norm);
        let mut found = serde_json::Map::new();
        found.insert("field".into(), self.compared.to_string().into());
        found.insert("norm".into(), json!(self.norm.name()));
        found.extend(numbers.into_iter().map(|(name, value)| (name.to_string(), number(value))));
        results.errors.insert(self.label.clone(), found.into());
    }
}
