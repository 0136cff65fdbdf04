//! What the repetitions of a case tell: its numbers, the median of its times and their spread.

use super::runner::is_done;
use serde_json::Value;

/// A median with the smallest and largest value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The median; the mean of the middle two of an even number.
    pub median: f64,
    /// The smallest.
    pub smallest: f64,
    /// The largest.
    pub largest: f64,
}

impl Spread {
    /// Of numbers; none without any.
    pub fn of(mut numbers: Vec<f64>) -> Option<Self> {
        numbers.sort_by(f64::total_cmp);
        let (smallest, largest) = (*numbers.first()?, *numbers.last()?);
        let half = numbers.len() / 2;
        let median = if numbers.len() % 2 == 1 { numbers[half] } else { 0.5 * (numbers[half - 1] + numbers[half]) };
        Some(Self { median, smallest, largest })
    }
}

/// What the runs of a case left.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Each repetition.
    repetitions: Vec<Value>,
}

impl Outcome {
    /// Of what [`super::runner::Runner::run`] returned.
    pub fn new(repetitions: Vec<Value>) -> Self {
        Self { repetitions }
    }

    /// True if all runs ended as they should.
    pub fn is_done(&self) -> bool {
        !self.repetitions.is_empty() && self.repetitions.iter().all(is_done)
    }

    /// How the last run ended.
    pub fn end(&self) -> &str {
        self.repetitions.last().and_then(|last| last["end"].as_str()).unwrap_or("not run")
    }

    /// Why it did not end well.
    pub fn reason(&self) -> &str {
        self.repetitions.last().and_then(|last| last["reason"].as_str()).unwrap_or("")
    }

    /// What it was warned of.
    pub fn warnings(&self) -> Vec<&str> {
        let list = self.summary()["warnings"].as_array();
        list.into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// The summary of the first run.
    pub fn summary(&self) -> &Value {
        self.repetitions.first().map_or(&Value::Null, |first| &first["summary"])
    }

    /// A number of the summary; none if it is not there or not finite.
    pub fn number(&self, pointer: &str) -> Option<f64> {
        self.summary().pointer(pointer).and_then(Value::as_f64)
    }

    /// A measured quantity of all repetitions.
    pub fn spread(&self, pointer: &str) -> Option<Spread> {
        let numbers = self.repetitions.iter().filter_map(|one| one["summary"].pointer(pointer).and_then(Value::as_f64));
        Spread::of(numbers.collect())
    }

    /// CPU time of the loop over time steps, in seconds.
    pub fn cpu(&self) -> Option<Spread> {
        self.spread("/loop_cpu_s")
    }

    /// Material points, times steps, per second of CPU time.
    pub fn rate(&self) -> Option<f64> {
        let (points, steps) = (self.number("/points")?, self.number("/steps")?);
        self.cpu().map(|cpu| points * steps / cpu.median).filter(|rate| *rate > 0.0 && rate.is_finite())
    }

    /// Whether repetitions told other errors or steps than the first: results that depend on chance.
    pub fn differs(&self) -> bool {
        let of = |one: &Value| [one["summary"]["errors"].clone(), one["summary"]["steps"].clone()];
        self.repetitions.windows(2).any(|pair| of(&pair[0]) != of(&pair[1]))
    }
}

/// An error below this is round-off.
pub const EXACT: f64 = 1e-12;

/// Order of convergence from one entry to the next: by how much the error falls with the size.
pub fn orders(points: &[(Option<f64>, Option<f64>)]) -> Vec<Option<f64>> {
    let order = |pair: &[(Option<f64>, Option<f64>)]| {
        let ((h, e), (next, f)) = (pair[0], pair[1]);
        let order = (e? / f?).ln() / (h? / next?).ln();
        (order.is_finite() && f? >= EXACT).then_some(order)
    };
    std::iter::once(None).chain(points.windows(2).map(order)).take(points.len()).collect()
}

/// Indices of the points (cost, error) that no other point beats in both, by rising cost.
pub fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].1 < best;
        best = best.min(points[index].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn medians_and_spreads() {
        let spread = Spread::of(vec![3.0, 1.0, 2.0]).unwrap();
        assert_eq!((spread.median, spread.smallest, spread.largest), (2.0, 1.0, 3.0));
        assert_eq!(Spread::of(vec![4.0, 1.0]).unwrap().median, 2.5);
        assert!(Spread::of(Vec::new()).is_none());
    }

    #[test]
    fn orders_are_those_of_the_errors() {
        let points = [(Some(0.2), Some(4e-2)), (Some(0.1), Some(1e-2)), (Some(0.05), None), (None, Some(1.0))];
        let found = orders(&points);
        assert_eq!(found[0], None);
        assert!((found[1].unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(&found[2..], [None, None]);
        assert_eq!(orders(&[(Some(0.2), Some(0.0)), (Some(0.1), Some(0.0))]), [None, None], "no order of exactness");
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(1.0, 0.1), (2.0, 0.01), (3.0, 0.05), (4.0, 0.001), (2.0, 0.02), (5.0, 0.001)];
        assert_eq!(pareto(&points), [0, 1, 3]);
    }

    #[test]
    fn chance_is_noticed() {
        let run = |e: f64| json!({"end": "done", "summary": {"steps": 3, "loop_cpu_s": 1.0, "errors": {"u": e}}});
        assert!(!Outcome::new(vec![run(1.0), run(1.0)]).differs());
        assert!(Outcome::new(vec![run(1.0), run(2.0)]).differs());
    }
}
