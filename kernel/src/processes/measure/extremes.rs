//! First, last, smallest and largest value of each column of a table, for the summary of a run.

use crate::analysis::number;
use crate::io::checkpoint::{Archive, CheckpointError};
use serde_json::{Map, Value};

/// What the summary tells of each column, in this order.
const NAMES: [&str; 4] = ["first", "last", "smallest", "largest"];

/// The four numbers of each column; all are not a number once a value was.
#[derive(Debug, Clone, Default)]
pub struct Extremes {
    names: Vec<String>,
    numbers: Vec<f64>,
}

impl Extremes {
    /// Those of columns with these names, before the first row.
    pub fn of(names: Vec<String>) -> Self {
        Self { names, numbers: Vec::new() }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.names.len()
    }

    /// Takes a row into account.
    pub fn add(&mut self, row: &[f64]) {
        if self.numbers.is_empty() {
            self.numbers = row.iter().flat_map(|&x| [x; 4]).collect();
        }
        for (numbers, &x) in self.numbers.chunks_exact_mut(4).zip(row) {
            let [_, last, smallest, largest] = numbers else { continue };
            *last = x;
            // What was once not finite stays so: `f64::min` alone would forget it.
            if x.is_nan() || smallest.is_nan() {
                (*smallest, *largest) = (f64::NAN, f64::NAN);
            } else {
                (*smallest, *largest) = (smallest.min(x), largest.max(x));
            }
        }
    }

    /// The numbers by column; none before the first row.
    pub fn values(&self) -> Map<String, Value> {
        let of = |numbers: &[f64]| -> Map<String, Value> {
            NAMES.iter().zip(numbers).map(|(name, x)| ((*name).into(), number(*x))).collect()
        };
        let columns = self.names.iter().zip(self.numbers.chunks_exact(4));
        columns.map(|(name, numbers)| (name.clone(), of(numbers).into())).collect()
    }

    /// Saves or loads all of it.
    ///
    /// # Errors
    /// The checkpoint does not fit.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.texts("columns", &mut self.names)?;
        archive.column("extremes", &mut self.numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_four_numbers_are_told_and_nothing_that_is_no_number_is_forgotten() {
        let mut extremes = Extremes::of(vec!["A".into(), "B".into()]);
        assert!(extremes.values().is_empty());
        for row in [[2.0, 1.0], [-1.0, f64::NAN], [5.0, 3.0], [0.5, 2.0]] {
            extremes.add(&row);
        }
        let values = extremes.values();
        assert_eq!(values["A"], json!({"first": 2.0, "last": 0.5, "smallest": -1.0, "largest": 5.0}));
        assert_eq!(values["B"], json!({"first": 1.0, "last": 2.0, "smallest": null, "largest": null}));
    }
}
