//! Values of entities in time as JSON: written, and compared with a file (spec 07 §8).
//!
//! The processes are the same for nodes and for an application's own entities: an
//! [`EntitySource`] hands out the values.

mod check;
mod nodes;
mod output;

pub use check::{JsonCheck, READING};
pub use output::{JsonOutput, WRITING};

use super::quantity::Quantity;
use super::{Clock, Location};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::model::Model;
use crate::parameters::{Key, Kind, Range, Settings};
use crate::registry::Registry;

/// Keys that writing and checking share.
const SHARED: [Key; 8] = [
    Key::optional("help", Kind::Any, "ignored"),
    Key::required("model_part_name", Kind::Text, "part whose entities are meant"),
    Key::new("sub_model_part_name", Kind::Text, "\"\"", "a part below it"),
    Key::new("check_for_flag", Kind::Text, "\"\"", "entities have no flags: must be empty"),
    Key::new(
        "time_frequency",
        Kind::Number(Range::NOT_NEGATIVE),
        "1.0",
        "acts at the first step after which more than this time has passed since it acted last [s]",
    ),
    Key::new("historical_value", Kind::Bool, "true", "accepted: a node has one value of a variable"),
    Key::new("use_node_coordinates", Kind::Bool, "false", "name nodes by their coordinates instead of their ids"),
    Key::new(
        "entity_type",
        Kind::Choice(&["Element", "Condition"]),
        "\"Element\"",
        "which entities are meant where both carry values",
    ),
];

/// An entity with values.
#[derive(Debug, Clone, Copy)]
pub struct Entity<'a> {
    /// Key in the file, such as `NODE_5`.
    pub key: &'a str,
    /// Kind for messages, such as `node`.
    pub kind: &'static str,
    /// Id.
    pub id: u32,
}

/// Where the values come from.
pub trait EntitySource: Send {
    /// Resolves the name of the part once the meshes are read.
    ///
    /// # Errors
    /// There is no such part.
    fn connect(&mut self, model: &Model) -> Result<(), InputErrors>;

    /// Where the variables must be provided.
    fn location(&self) -> Location;

    /// Numbers of a symmetric tensor; 0 if the entities have none.
    fn tensor_length(&self, model: &Model) -> usize;

    /// Calls `visit` for each entity, ascending by id, with the values of all quantities, one
    /// after the other.
    ///
    /// # Errors
    /// A part that does not exist after all; a value that the entities do not have.
    fn visit(&self, model: &Model, quantities: &[Quantity], visit: &mut dyn FnMut(Entity, &[f64]))
    -> Result<(), Error>;
}

/// Registers the processes of the kernel.
pub fn register(registry: &mut Registry) {
    nodes::register(registry);
}

/// The dotted path that `model_part_name` and `sub_model_part_name` give together.
pub fn part_path(settings: &Settings) -> String {
    let (part, below) = (settings.text("model_part_name"), settings.text("sub_model_part_name"));
    if below.is_empty() { part.to_string() } else { format!("{part}.{below}") }
}

/// Refuses settings that would select by flags.
fn refuse_flags(settings: &Settings) -> Result<(), InputErrors> {
    if settings.text("check_for_flag").is_empty() {
        return Ok(());
    }
    let diagnostic = settings.error("check_for_flag", "entities have no flags in Bia");
    Err(diagnostic.help("name a sub model part instead, and leave the flag empty").into())
}

/// Deals with the list `other` that the process of the other kind of entity has: of nodes there
/// are no values on grid elements; where entities carry values of their own, Kratos ignores it.
fn other_list(settings: &Settings, other: &str, instead: &str, location: Location) -> Result<(), InputErrors> {
    if settings.texts(other).is_empty() {
        return Ok(());
    }
    if location == Location::Nodes {
        let diagnostic = settings.error(other, "grid elements have no values of their own");
        let help = "use the process of the application whose entities carry such values";
        return Err(diagnostic.help(help).into());
    }
    let place = settings.get(other).unwrap_or(settings.parameters()).place();
    tracing::warn!("{place}: {other:?} has no effect here; {instead:?} has");
    Ok(())
}

/// Kratos's rule of time: the steps are added up, and once the sum exceeds the given time the
/// process acts and the sum begins anew. (So 0.1 s with steps of 0.05 s acts every third step.)
#[derive(Debug, Clone, Copy, PartialEq)]
struct Countdown {
    every: f64,
    passed: f64,
    last: Option<f64>,
}

impl Countdown {
    fn new(settings: &Settings) -> Self {
        Self { every: settings.number("time_frequency"), passed: 0.0, last: None }
    }

    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let (mut has_acted, mut last) = (self.last.is_some(), self.last.unwrap_or_default());
        archive.number("passed", &mut self.passed)?;
        archive.flag("has a last time", &mut has_acted)?;
        archive.number("last time", &mut last)?;
        self.last = has_acted.then_some(last);
        Ok(())
    }

    /// To be called once a step.
    fn is_due(&mut self, clock: &Clock) -> bool {
        // Kratos's step is the difference of two times, which rounds otherwise than the step itself.
        self.passed += clock.time - self.last.unwrap_or(clock.start);
        self.last = Some(clock.time);
        let due = self.passed > self.every;
        if due {
            self.passed = 0.0;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times that Kratos 10.4.4 wrote for steps of 0.01 s and a frequency of 0.05 s.
    #[test]
    fn the_countdown_is_that_of_kratos() {
        let mut countdown = Countdown { every: 0.05, passed: 0.0, last: None };
        let mut clock = Clock::default();
        let mut times = Vec::new();
        for _ in 0..20 {
            clock.time += 0.01;
            if countdown.is_due(&clock) {
                times.push(clock.time);
            }
        }
        assert_eq!(times, [0.060000000000000005, 0.11999999999999998, 0.17]);
    }
}
