//! Values that are numbers or functions of space and time, and the interval in which they act.

use super::csv_table;
use crate::diagnostic::InputErrors;
use crate::error::Failure;
use crate::expression::{Arguments, Expression};
use crate::model::Table;
use crate::parameters::Parameters;

/// A number, a function of x, y, z, X, Y, Z and t, or a table over the time.
#[derive(Debug, Clone)]
pub struct SpaceTimeValue {
    source: Source,
    factor: f64,
}

#[derive(Debug, Clone)]
enum Source {
    Expression(Expression),
    Table(Table),
}

impl SpaceTimeValue {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self { source: Source::Expression(Expression::constant(value)), factor: 1.0 }
    }

    /// From a JSON number, a text, or an object that names a csv table with Kratos's keys.
    ///
    /// # Errors
    /// A text that is no expression, with the place inside it; a table that cannot be read.
    pub fn read(parameters: &Parameters) -> Result<Self, InputErrors> {
        match (parameters.value().as_f64(), parameters.value().as_str()) {
            (Some(number), _) => Ok(Self::constant(number)),
            (None, Some(text)) => match Expression::parse(text) {
                Ok(expression) => match expression.as_constant() {
                    Some(value) if !value.is_finite() => {
                        Err(parameters.error(format!("the function {text:?} is {value}, which is not finite")).into())
                    }
                    _ => Ok(Self { source: Source::Expression(expression), factor: 1.0 }),
                },
                Err(error) => Err(parameters.error(format!("the function {text:?} is wrong: {error}")).into()),
            },
            _ if parameters.value().is_object() => {
                Ok(Self { source: Source::Table(csv_table::read(parameters)?), factor: 1.0 })
            }
            _ => Err(parameters.error("must be a number, a function as text, or a csv table").into()),
        }
    }

    /// Three of them from a list; null leaves a component out.
    ///
    /// # Errors
    /// As [`SpaceTimeValue::read`], for all three together.
    pub fn read3(parameters: &Parameters) -> Result<[Option<Self>; 3], InputErrors> {
        let mut errors = InputErrors::default();
        let mut values = parameters
            .entries()
            .into_iter()
            .map(|entry| if entry.value().is_null() { None } else { errors.absorb(Self::read(&entry)) });
        let three = std::array::from_fn(|_| values.next().flatten());
        drop(values);
        errors.or(three)
    }

    /// This value times a number.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { factor: self.factor * factor, ..self.clone() }
    }

    /// The value at a position (and initial position) in metres and a time in seconds.
    pub fn at(&self, position: [f64; 3], initial: [f64; 3], time: f64) -> f64 {
        let [x, y, z] = position;
        let value = match &self.source {
            Source::Expression(expression) => expression.evaluate(&Arguments { x, y, z, initial, t: time }),
            Source::Table(table) => table.value(time),
        };
        self.factor * value
    }

    /// True when it is a number whatever the position and time.
    pub fn as_constant(&self) -> Option<f64> {
        match &self.source {
            Source::Expression(expression) => expression.as_constant().map(|value| self.factor * value),
            Source::Table(_) => None,
        }
    }

    /// True when it changes in time.
    pub fn depends_on_time(&self) -> bool {
        match &self.source {
            Source::Expression(expression) => expression.depends_on_time(),
            Source::Table(_) => true,
        }
    }

    /// True when it changes in space.
    pub fn depends_on_space(&self) -> bool {
        matches!(&self.source, Source::Expression(expression) if expression.depends_on_space())
    }
}

/// A process would give a variable a value that is infinite or not a number; the caller adds the
/// node, point or condition.
pub fn not_finite(process: &str, variable: &str, value: f64) -> Failure {
    let what = format!("{process} gives {variable} the value {value}, which is not finite");
    Failure::new(what, "look at the function of this process near this place and time")
}

/// From a start to an end time in seconds, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval(pub [f64; 2]);

impl Interval {
    /// Whether a time lies inside, up to round-off of the accumulated time.
    pub fn contains(&self, time: f64) -> bool {
        let [start, end] = self.0;
        let slack = |bound: f64| 1e-14 * bound.abs().max(1.0);
        time >= start - slack(start) && time <= end + slack(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_include_their_ends_up_to_round_off() {
        let interval = Interval([0.1, 0.3]);
        assert!(interval.contains(0.1) && interval.contains(0.1 + 0.1 + 0.1) && interval.contains(0.2));
        assert!(!interval.contains(0.0999) && !interval.contains(0.3001));
    }
}
