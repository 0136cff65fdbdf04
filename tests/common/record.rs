//! The account of a run that `--record` writes.

use serde_json::Value;
use std::path::Path;

/// The account.
pub struct Record {
    pub json: Value,
}

/// One recorded state.
#[derive(Clone, Copy)]
pub struct State<'a> {
    pub json: &'a Value,
}

impl Record {
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("the run has written its record");
        Self { json: serde_json::from_str(&text).expect("the record is JSON") }
    }

    /// All states, the first at step 0.
    pub fn states(&self) -> Vec<State<'_>> {
        let snapshots = self.json["snapshots"].as_array().expect("a record has states");
        snapshots.iter().map(|json| State { json }).collect()
    }

    pub fn first(&self) -> State<'_> {
        self.states()[0]
    }

    pub fn last(&self) -> State<'_> {
        *self.states().last().expect("a record has states")
    }
}

impl State<'_> {
    pub fn time(&self) -> f64 {
        number(&self.json["time"])
    }

    pub fn step(&self) -> u64 {
        self.json["step"].as_u64().unwrap()
    }

    /// A field of the points (`mp`), conditions (`mpc`) or grid nodes (`nodes`), a row each.
    pub fn field(&self, kind: &str, name: &str) -> Vec<Vec<f64>> {
        let values = self.json[kind][name].as_array().unwrap_or_else(|| panic!("{kind}.{name} is not recorded"));
        let row = |value: &Value| match value.as_array() {
            Some(row) => row.iter().map(number).collect(),
            None => vec![number(value)],
        };
        values.iter().map(row).collect()
    }

    /// A field of the points.
    pub fn points(&self, name: &str) -> Vec<Vec<f64>> {
        self.field("mp", name)
    }

    /// A scalar field of the points.
    pub fn scalars(&self, name: &str) -> Vec<f64> {
        self.points(name).concat()
    }

    /// A field of the grid nodes.
    pub fn nodes(&self, name: &str) -> Vec<Vec<f64>> {
        self.field("nodes", name)
    }

    pub fn energy(&self, name: &str) -> f64 {
        number(&self.json["energies"][name])
    }

    /// `momentum` or `com`.
    pub fn total(&self, name: &str) -> [f64; 3] {
        std::array::from_fn(|a| number(&self.json["sums"][name][a]))
    }

    pub fn mass(&self) -> f64 {
        number(&self.json["sums"]["mass"])
    }
}

/// Null stands for what is not finite.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
