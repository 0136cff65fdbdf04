//! A number of the summary of a run, or of several.

use super::outcome::Outcome;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Parameters, Settings};
use serde_json::{Map, Value, json};

/// Keys of a number that is made of others: (quantity − minus)/over.
pub const QUANTITY: [Key; 4] = [
    Key::optional("quantity", Kind::Text, "JSON pointer into the summary of the run"),
    Key::optional("minus", Kind::Any, "number, or pointer to what is subtracted"),
    Key::optional("over", Kind::Any, "number, or pointer to what it is divided by"),
    Key::new("absolute", Kind::Bool, "true", "its absolute value counts"),
];
const ALONE: &[Key] = &QUANTITY;

/// A number, or where it stands in the summary.
#[derive(Debug, Clone)]
enum Term {
    Number(f64),
    Pointer(String),
}

impl Term {
    fn read(settings: &Settings, key: &str) -> Result<Option<Self>, InputErrors> {
        let Some(place) = settings.get(key) else { return Ok(None) };
        match (place.value().as_f64(), place.value().as_str()) {
            (Some(number), _) => Ok(Some(Self::Number(number))),
            (None, Some(pointer)) if pointer.starts_with('/') => Ok(Some(Self::Pointer(pointer.into()))),
            _ => Err(place.error("must be a number, or a JSON pointer into the summary").into()),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::Number(number) => json!(number),
            Self::Pointer(pointer) => json!(pointer),
        }
    }

    fn value(&self, outcome: &Outcome) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Pointer(pointer) => outcome.number(pointer),
        }
    }
}

/// (quantity − minus)/over, or its absolute value.
#[derive(Debug, Clone)]
pub struct Quantity {
    /// Where the quantity stands.
    pub pointer: String,
    minus: Option<Term>,
    over: Option<Term>,
    absolute: bool,
}

impl Quantity {
    /// Where a number stands as it is.
    pub fn at(pointer: String) -> Self {
        Self { pointer, minus: None, over: None, absolute: false }
    }

    /// From settings with the keys [`QUANTITY`] at a place.
    ///
    /// # Errors
    /// No pointer, terms that are none.
    pub fn read(settings: &Settings, place: &Parameters) -> Result<Self, InputErrors> {
        let pointer = if settings.given("quantity") { settings.text("quantity") } else { "" };
        let mut errors = InputErrors::default();
        if !pointer.starts_with('/') {
            let help = "\"quantity\": a JSON pointer into the summary of a run, such as /errors/u/largest";
            errors.push(place.error("looks at nothing").help(help));
        }
        let minus = errors.absorb(Term::read(settings, "minus")).flatten();
        let over = errors.absorb(Term::read(settings, "over")).flatten();
        errors.or(Self { pointer: pointer.into(), minus, over, absolute: settings.flag("absolute") })
    }

    /// The error of a study: a label, a pointer, or an object with the keys [`QUANTITY`].
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of_error(place: &Parameters) -> Result<Self, InputErrors> {
        match place.value().as_str() {
            Some(pointer) if pointer.starts_with('/') => Ok(Self::at(pointer.into())),
            Some(label) => Ok(Self::at(format!("/errors/{label}/relative_at_end"))),
            None => Self::read(&place.read(ALONE)?, place),
        }
    }

    /// As it is read.
    pub fn json(&self) -> Map<String, Value> {
        let mut members = Map::new();
        members.insert("quantity".into(), json!(self.pointer));
        for (key, term) in [("minus", &self.minus), ("over", &self.over)] {
            members.extend(term.as_ref().map(|term| (key.to_string(), term.json())));
        }
        members.insert("absolute".into(), json!(self.absolute));
        members
    }

    /// The number; none if a part of it is not there or not finite.
    pub fn value(&self, outcome: &Outcome) -> Option<f64> {
        let mut value = outcome.number(&self.pointer)?;
        if let Some(minus) = &self.minus {
            value -= minus.value(outcome)?;
        }
        if let Some(over) = &self.over {
            value /= over.value(outcome)?;
        }
        let value = self.sized(value);
        value.is_finite().then_some(value)
    }

    /// What of a number counts: its absolute value, or itself.
    pub fn sized(&self, value: f64) -> f64 {
        if self.absolute { value.abs() } else { value }
    }
}
