//! Compares values of entities in time with a JSON file.

use super::{Countdown, Entity, EntitySource, SHARED, other_list, refuse_flags};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::history::{History, Lookup};
use crate::model::Model;
use crate::parameters::{Key, Kind, Range};
use crate::processes::quantity::Quantity;
use crate::processes::{Clock, Context, Process, Requirements};
use crate::registry::Building;
use serde_json::Value;
use std::path::PathBuf;

/// Keys of a process that checks.
pub const READING: &[Key] = &Key::join::<8, 6, 14>(
    SHARED,
    [
        Key::new("check_variables", Kind::Texts, "[]", "variables to be compared"),
        Key::new(
            "gauss_points_check_variables",
            Kind::Texts,
            "[]",
            "accepted where entities have such values: without effect",
        ),
        Key::required("input_file_name", Kind::Text, "the file, relative to the project"),
        Key::new("tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-3", "allowed difference, in the variable's unit"),
        Key::new("relative_tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-6", "allowed relative difference"),
        Key::new("check_only_local_entities", Kind::Bool, "false", "accepted: there is one process"),
    ],
);

/// The process. It fails at the end of the first step whose values differ.
pub struct JsonCheck<S> {
    name: &'static str,
    source: S,
    quantities: Vec<Quantity>,
    path: PathBuf,
    history: History,
    comparison: Comparison,
    countdown: Countdown,
    /// Times at which it was to compare, and numbers that it compared then.
    due: usize,
    compared: usize,
}

/// When two numbers are equal, and with which stored number one is compared.
#[derive(Debug, Clone, Copy)]
struct Comparison {
    lookup: Lookup,
    /// Lists: Kratos takes the entry of the step's number, whatever its time.
    lists_by_step: bool,
    absolute: f64,
    relative: f64,
}

impl Comparison {
    /// What is no finite number is equal to nothing, not even where everything is allowed.
    fn equal(&self, value: f64, expected: f64) -> bool {
        if !value.is_finite() || !expected.is_finite() {
            return false;
        }
        let scale = value.abs().max(expected.abs());
        (value - expected).abs() <= (self.relative * scale).max(self.absolute)
    }
}

impl<S: EntitySource> JsonCheck<S> {
    /// From settings with the keys [`READING`]. Reads the file.
    ///
    /// # Errors
    /// Unknown variables; a file that cannot be read or is no history.
    pub fn new(name: &'static str, building: &Building, source: S, lookup: Lookup) -> Result<Self, InputErrors> {
        let settings = &building.settings;
        let mut errors = InputErrors::default();
        errors.absorb(refuse_flags(settings));
        let other = "gauss_points_check_variables";
        errors.absorb(other_list(settings, other, "check_variables", source.location()));
        let read = Quantity::read_list(settings, "check_variables", building.registry);
        let quantities = errors.absorb(read).unwrap_or_default();
        let path = building.options.folder.join(settings.text("input_file_name"));
        let history = if path.is_file() {
            errors.absorb(History::read(&path))
        } else {
            let message = format!("the file {} does not exist", path.display());
            errors.push(settings.error("input_file_name", message));
            None
        };
        let comparison = Comparison {
            lookup,
            lists_by_step: lookup == Lookup::Nearest && building.options.kratos_exact,
            absolute: settings.number("tolerance"),
            relative: settings.number("relative_tolerance"),
        };
        let countdown = Countdown::new(settings);
        match history {
            Some(history) => {
                let (due, compared) = (0, 0);
                errors.or(Self { name, source, quantities, path, history, comparison, countdown, due, compared })
            }
            None => Err(errors),
        }
    }

    /// Why nothing was compared; none if something was.
    fn idle(&self, clock: &Clock) -> Option<String> {
        let why = if self.compared > 0 {
            return None;
        } else if self.quantities.is_empty() {
            "\"check_variables\" is empty".to_string()
        } else if self.due == 0 {
            let (every, length) = (self.countdown.every, clock.time - clock.start);
            format!("\"time_frequency\" is {every} s, and the run of {length} s must be longer than that")
        } else {
            "the part has no entities".to_string()
        };
        Some(format!("{}: nothing was compared with {}: {why}", self.name, self.path.display()))
    }

    /// Compares all entities now; the number of numbers that were compared.
    fn compare(&self, model: &Model, clock: &Clock) -> Result<usize, Error> {
        let tensor = self.source.tensor_length(model);
        let (mut faults, mut first, mut compared) = (0, None, 0);
        self.source.visit(model, &self.quantities, &mut |entity, values| {
            let mut rest = values;
            for series in self.quantities.iter().flat_map(|quantity| quantity.series(tensor)) {
                let (now, later) = rest.split_at(series.list.unwrap_or(1).min(rest.len()));
                rest = later;
                compared += now.len();
                if let Err(fault) = self.compare_series(&entity, &series.name, series.list.is_some(), now, clock) {
                    faults += 1;
                    first.get_or_insert(fault);
                }
            }
        })?;
        match first {
            None => Ok(compared),
            Some(first) if faults == 1 => Err(Error::Check(first)),
            Some(first) => Err(Error::Check(format!("{first}\n  and {} more values differ", faults - 1))),
        }
    }

    fn compare_series(
        &self,
        entity: &Entity,
        series: &str,
        list: bool,
        values: &[f64],
        clock: &Clock,
    ) -> Result<(), String> {
        let place = format!("{} {}, {series}, step {}, time {} s", entity.kind, entity.id, clock.step, clock.time);
        let key = entity.key;
        let Some(stored) = self.history.values(key, series) else {
            let file = self.path.display();
            return Err(format!("{place}: {file} holds no values of {key}/{series} at all its times"));
        };
        for (component, &value) in values.iter().enumerate() {
            let at = |entry: &Value| if list { entry.get(component)?.as_f64() } else { entry.as_f64() };
            let expected = if list && self.comparison.lists_by_step {
                stored.get(clock.step.saturating_sub(1)).and_then(at)
            } else {
                let numbers: Option<Vec<f64>> = stored.iter().map(at).collect();
                numbers.and_then(|numbers| self.history.at(&numbers, clock.time, self.comparison.lookup))
            };
            let which = if list { format!(", component {}", component + 1) } else { String::new() };
            let Some(expected) = expected else {
                return Err(format!("{place}{which}: {} holds no number for it", self.path.display()));
            };
            if !self.comparison.equal(value, expected) {
                let Comparison { absolute, relative, .. } = self.comparison;
                return Err(format!(
                    "{place}{which}: {value:e} differs from the expected {expected:e} by {:.3e}; \
                     allowed: {absolute:e} or the part {relative:e} ({})",
                    (value - expected).abs(),
                    self.path.display()
                ));
            }
        }
        Ok(())
    }
}

impl<S: EntitySource> Process for JsonCheck<S> {
    fn name(&self) -> &str {
        self.name
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.source.connect(model)
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, self.source.location(), requirements);
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        if self.countdown.is_due(context.clock) {
            self.due += 1;
            self.compared += self.compare(context.model, context.clock)?;
        }
        Ok(())
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.countdown.exchange(archive)?;
        archive.count("due", &mut self.due)?;
        archive.count("compared", &mut self.compared)
    }

    /// A check that compared nothing has not passed.
    fn execute_finalize(&mut self, context: &mut Context) -> Result<(), Error> {
        self.idle(context.clock).map_or(Ok(()), |message| Err(Error::Check(message)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_equal_within_either_tolerance_and_only_if_finite() {
        let comparison =
            |absolute, relative| Comparison { lookup: Lookup::Linear, lists_by_step: false, absolute, relative };
        assert!(comparison(0.5, 0.0).equal(1.0, 1.5) && !comparison(0.25, 0.0).equal(1.0, 1.5));
        assert!(comparison(0.0, 0.5).equal(2.0, 4.0) && !comparison(0.0, 0.25).equal(2.0, 4.0));
        let lenient = comparison(f64::MAX, 1.0);
        for other in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!lenient.equal(other, 1.0) && !lenient.equal(1.0, other) && !lenient.equal(other, other));
        }
    }
}
