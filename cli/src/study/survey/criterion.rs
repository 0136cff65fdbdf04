//! What a run must keep, and how far it does.

use super::keys::CRITERION;
use crate::study::outcome::Outcome;
use crate::study::page::shown;
use crate::study::quantity::Quantity;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Parameters, Settings};
use serde_json::{Value, json};

/// How a cell of the matrix came out, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Nothing of it was measured, which happens beside the survey's own runs alone.
    Unmeasured,
    /// All criteria are kept.
    Pass,
    /// One is broken, but not by much.
    Degraded,
    /// One is broken, or the run ended as it should not.
    Fails,
    /// The input was refused, and that was not what was expected.
    Refused,
    /// The method cannot run the scene.
    Cannot,
}

impl Verdict {
    /// Its name, and its class in the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unmeasured => "unmeasured",
            Self::Pass => "pass",
            Self::Degraded => "degraded",
            Self::Fails => "fails",
            Self::Refused => "refused",
            Self::Cannot => "cannot",
        }
    }

    /// A sign beside the name, for those who do not see colours.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Unmeasured => "?",
            Self::Pass => "✓",
            Self::Degraded => "≈",
            Self::Fails => "✗",
            Self::Refused => "⊘",
            Self::Cannot => "–",
        }
    }
}

/// A criterion.
#[derive(Debug, Clone)]
pub enum Criterion {
    /// A bound of a quantity of the summary.
    Bound(Box<Bound>),
    /// How the run ends.
    End {
        /// `done`, `failed` or `input`.
        end: String,
        /// What the reason tells, or a warning.
        reason: String,
    },
}

/// A bound.
#[derive(Debug, Clone)]
pub struct Bound {
    quantity: Quantity,
    max: Option<f64>,
    min: Option<f64>,
    degraded: Option<f64>,
    text: String,
}

/// What a criterion found.
#[derive(Debug, Clone)]
pub struct Finding {
    /// How far it is kept.
    pub verdict: Verdict,
    /// What was looked at.
    pub what: String,
    /// The number, if there was one.
    pub number: Option<f64>,
    /// What it should have been.
    pub wanted: String,
}

impl Criterion {
    /// From its object.
    ///
    /// # Errors
    /// A criterion of nothing, or without a bound.
    pub fn read(place: &Parameters) -> Result<Self, InputErrors> {
        let settings = place.read(CRITERION)?;
        if settings.given("expect") {
            let (end, reason) = (settings.text("expect").to_string(), settings.text_if("reason_contains"));
            return Ok(Self::End { end, reason });
        }
        let mut errors = InputErrors::default();
        let quantity = errors.absorb(Quantity::read(&settings, place));
        let number = |key: &str| settings.given(key).then(|| settings.number(key));
        let (max, min, degraded) = (number("max"), number("min"), number("degraded"));
        if max.is_none() && min.is_none() {
            errors.push(place.error("has neither \"max\" nor \"min\""));
        }
        if let (Some(max), Some(min)) = (max, min)
            && (min > max || degraded.is_some())
        {
            errors.push(place.error("\"min\" is above \"max\", or \"degraded\" stands beside both"));
        }
        let text = settings.text("text").to_string();
        match quantity {
            Some(quantity) => errors.or(Self::Bound(Box::new(Bound { quantity, max, min, degraded, text }))),
            None => Err(errors),
        }
    }

    /// Whether it asks for another end than a good one.
    pub fn expects_trouble(&self) -> bool {
        matches!(self, Self::End { end, .. } if end != "done")
    }

    /// What it is about; nothing if it asks for an end.
    pub fn text(&self) -> &str {
        match self {
            Self::Bound(bound) => bound.what(),
            Self::End { .. } => "",
        }
    }

    /// As it is read.
    pub fn json(&self) -> Value {
        match self {
            Self::Bound(bound) => {
                let mut members = bound.quantity.json();
                for (key, bound) in [("max", bound.max), ("min", bound.min), ("degraded", bound.degraded)] {
                    members.extend(bound.map(|bound| (key.to_string(), json!(bound))));
                }
                members.insert("text".into(), json!(bound.text));
                members.into()
            }
            Self::End { end, reason } => json!({"expect": end, "reason_contains": reason}),
        }
    }

    /// Looks at what a run left.
    pub fn look(&self, outcome: &Outcome) -> Finding {
        match self {
            Self::Bound(bound) => bound.judge(bound.quantity.value(outcome)),
            Self::End { end, reason } => {
                let told = [&[outcome.reason()], outcome.warnings().as_slice()].concat().join("\n");
                let kept = outcome.end() == end && told.to_lowercase().contains(&reason.to_lowercase());
                let told = if reason.is_empty() { String::new() } else { format!(", and tells {reason:?}") };
                ended(outcome.end(), kept, format!("{end}{told}"))
            }
        }
    }

    /// Looks at what another program left: how it ended, in its own words, and the number that was measured;
    /// `Some(None)` was not finite.
    pub fn look_beside(&self, end: &str, number: Option<Option<f64>>) -> Finding {
        match (self, number) {
            (Self::Bound(bound), Some(number)) => bound.judge(number.map(|number| bound.quantity.sized(number))),
            (Self::Bound(bound), None) => Finding { verdict: Verdict::Unmeasured, ..bound.judge(None) },
            (Self::End { end: asked, .. }, _) => ended(end, end == asked, asked.clone()),
        }
    }
}

/// A run that ended so, and whether it should.
fn ended(end: &str, is_kept: bool, wanted: String) -> Finding {
    let verdict = if is_kept { Verdict::Pass } else { Verdict::Fails };
    Finding { verdict, what: format!("ends: {end}"), number: None, wanted }
}

/// A text that may stay away.
trait TextIf {
    /// The text, or nothing.
    fn text_if(&self, key: &str) -> String;
}

impl TextIf for Settings {
    fn text_if(&self, key: &str) -> String {
        if self.given(key) { self.text(key).to_string() } else { String::new() }
    }
}

impl Bound {
    fn what(&self) -> &str {
        if self.text.is_empty() { &self.quantity.pointer } else { &self.text }
    }

    /// How far the number keeps to it.
    fn judge(&self, number: Option<f64>) -> Finding {
        let within = |high: Option<f64>, low: Option<f64>, x: f64| {
            high.is_none_or(|high| x <= high) && low.is_none_or(|low| x >= low)
        };
        let verdict = match number {
            None => Verdict::Fails,
            Some(x) if within(self.max, self.min, x) => Verdict::Pass,
            Some(x) => match (self.degraded, self.max) {
                (Some(bound), Some(_)) if x <= bound => Verdict::Degraded,
                (Some(bound), None) if x >= bound => Verdict::Degraded,
                _ => Verdict::Fails,
            },
        };
        let bounds = [
            self.min.map(|min| format!("≥ {}", shown(Some(min)))),
            self.max.map(|max| format!("≤ {}", shown(Some(max)))),
        ];
        let wanted = bounds.into_iter().flatten().collect::<Vec<_>>().join(", ");
        Finding { verdict, what: self.what().into(), number, wanted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_kernel::parameters::Document;
    use std::path::Path;

    fn read(text: &str) -> Result<Criterion, InputErrors> {
        Criterion::read(&Parameters::root(Document::parse(Path::new("c.json"), text.into()).unwrap()))
    }

    fn outcome(summary: Value, end: &str) -> Outcome {
        Outcome::new(vec![json!({"end": end, "reason": "no longer Hyperbolic", "summary": summary})])
    }

    #[test]
    fn bounds_are_kept_degraded_or_broken() {
        let criterion = read(r#"{"quantity": "/a", "minus": "/b", "over": 2, "max": 1, "degraded": 3}"#).unwrap();
        let verdict = |a: Value| criterion.look(&outcome(json!({"a": a, "b": 1.0}), "done")).verdict;
        assert_eq!(verdict(json!(3.0)), Verdict::Pass);
        assert_eq!(verdict(json!(-5.0)), Verdict::Degraded, "|−5 − 1|/2 = 3");
        assert_eq!(verdict(json!(7.1)), Verdict::Fails);
        assert_eq!(verdict(Value::Null), Verdict::Fails, "what is not finite is no pass");
        let least = read(r#"{"quantity": "/a", "min": 2, "degraded": 1}"#).unwrap();
        let verdict = |a: f64| least.look(&outcome(json!({"a": a}), "done")).verdict;
        assert_eq!([2.0, 1.5, 0.5].map(verdict), [Verdict::Pass, Verdict::Degraded, Verdict::Fails]);
    }

    #[test]
    fn ends_are_compared_with_their_reasons() {
        let criterion = read(r#"{"expect": "failed", "reason_contains": "hyperbolic"}"#).unwrap();
        assert!(criterion.expects_trouble());
        assert_eq!(criterion.look(&outcome(Value::Null, "failed")).verdict, Verdict::Pass);
        assert_eq!(criterion.look(&outcome(Value::Null, "done")).verdict, Verdict::Fails);
    }

    /// Another program stops in its own words, and what was not measured decides nothing.
    #[test]
    fn other_programs_are_judged_by_the_same_bounds() {
        let criterion = read(r#"{"quantity": "/a", "max": 1, "degraded": 3}"#).unwrap();
        let verdict = |number: Option<Option<f64>>| criterion.look_beside("done", number).verdict;
        assert_eq!(verdict(Some(Some(-0.5))), Verdict::Pass);
        assert_eq!(verdict(Some(Some(-2.0))), Verdict::Degraded);
        assert_eq!(verdict(Some(Some(4.0))), Verdict::Fails);
        assert_eq!(verdict(Some(None)), Verdict::Fails, "what is not finite is no pass");
        assert_eq!(verdict(None), Verdict::Unmeasured);
        assert!(Verdict::Unmeasured < Verdict::Pass, "a measured criterion decides");
        let stop = read(r#"{"expect": "failed", "reason_contains": "hyperbolic"}"#).unwrap();
        assert_eq!(stop.look_beside("failed", None).verdict, Verdict::Pass);
        assert_eq!(stop.look_beside("done", None).verdict, Verdict::Fails);
    }

    #[test]
    fn criteria_of_nothing_are_refused() {
        for wrong in [r#"{"max": 1}"#, r#"{"quantity": "/a"}"#, r#"{"quantity": "/a", "max": 1, "over": "b"}"#] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
