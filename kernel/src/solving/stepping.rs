//! The time step as a project gives it: constant, a table, or a share of the stable one.

use crate::diagnostic::InputErrors;
use crate::error::{Error, Failure};
use crate::model::Table;
use crate::parameters::{Key, Kind, Range, Settings};
use crate::processes::Clock;

const COURANT: Range = Range { low: 0.0, high: 1.0, low_open: true, text: "a number above 0 and at most 1" };

/// Keys of `time_stepping`.
pub const TIME_STEPPING: &[Key] = &[
    Key::optional("time_step", Kind::NumberOr(Range::POSITIVE, &["auto"]), "time step [s]; explicit also \"auto\""),
    Key::optional("time_step_table", Kind::List, "pairs [time, time step] [s]"),
    Key::new("courant_number", Kind::Number(COURANT), "0.9", "explicit: share of the stable step that \"auto\" takes"),
    Key::new(
        "time_step_policy",
        Kind::Choice(&["warn", "strict"]),
        "\"warn\"",
        "explicit: whether a step above the stable one is a warning or stops the run",
    ),
];

/// The step as a number or as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum Stepping {
    /// Always this step in seconds.
    Constant(f64),
    /// Interpolated at the time at which the step begins.
    Table(Table),
    /// This share of the stable step of an explicit scheme.
    Courant(f64),
}

impl Stepping {
    /// From the object `time_stepping` with the keys [`TIME_STEPPING`]; only explicit solvers know a
    /// stable step.
    ///
    /// # Errors
    /// No step or two of them; a table that is none; \"auto\" without a stable step.
    pub fn read(settings: &Settings, is_explicit: bool) -> Result<Self, InputErrors> {
        let Some(nested) = settings.nested("time_stepping") else {
            return Err(settings.error("time_stepping", "must be an object").into());
        };
        if nested.given("time_step") && nested.given("time_step_table") {
            let message = "names both \"time_step\" and \"time_step_table\"";
            return Err(settings.error("time_stepping", message).help("keep one of them").into());
        }
        if let Some(given) = nested.get("time_step") {
            return match given.value().as_f64() {
                Some(step) => Ok(Stepping::Constant(step)),
                None if is_explicit => Ok(Stepping::Courant(nested.number("courant_number"))),
                None => Err(given.error("\"auto\" is for explicit runs").help("name a time step in seconds").into()),
            };
        }
        let Some(list) = nested.get("time_step_table") else {
            let message = "names neither \"time_step\" nor \"time_step_table\"";
            return Err(settings.error("time_stepping", message).into());
        };
        let mut pairs = Vec::new();
        for entry in list.entries() {
            match entry.value().as_array().map(Vec::as_slice) {
                Some([t, dt]) if t.is_number() && dt.as_f64().is_some_and(|dt| dt > 0.0) => {
                    pairs.push((t.as_f64().unwrap_or(0.0), dt.as_f64().unwrap_or(0.0)));
                }
                _ => return Err(entry.error("must be a pair [time, time step] with a time step above 0").into()),
            }
        }
        Table::new(pairs).map(Stepping::Table).map_err(|message| list.error(message).into())
    }

    /// The step that begins now, given the stable one (infinite if there is none), in seconds.
    ///
    /// # Errors
    /// It does not advance the time.
    pub fn step(&self, clock: &Clock, stable: f64) -> Result<f64, Error> {
        let step = match self {
            Stepping::Constant(step) => *step,
            Stepping::Table(table) => table.value(clock.time),
            Stepping::Courant(share) => share * stable,
        };
        if step > 0.0 && clock.time + step > clock.time {
            return Ok(step);
        }
        let what = format!("the time step {step:?} does not advance the time {:?}", clock.time);
        Err(Failure::new(what, "a positive time step, also beyond the ends of the table").into())
    }
}
