//! Properties of a group of cells: a material's constants, as read, before a law takes them.

use std::collections::BTreeMap;

/// A value of an input file.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A real number (integers too).
    Number(f64),
    /// A text.
    Text(String),
    /// A vector of any length.
    Vector(Vec<f64>),
    /// A matrix, row by row.
    Matrix(Vec<Vec<f64>>),
}

/// Constants, tables and the law's name of one material.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Properties {
    /// Id in the mesh file or the materials file.
    pub id: u32,
    /// Name of the constitutive law, if one was given.
    pub law: Option<String>,
    /// Values by variable name.
    pub values: BTreeMap<String, Value>,
    /// Tables by their (input variable, output variable).
    pub tables: BTreeMap<(String, String), Table>,
}

impl Properties {
    /// The number stored for `variable`, if there is one.
    pub fn number(&self, variable: &str) -> Option<f64> {
        match self.values.get(variable) {
            Some(Value::Number(number)) => Some(*number),
            _ => None,
        }
    }
}

/// A piecewise linear function; beyond its ends the first or last slope goes on, as in Kratos.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    points: Vec<(f64, f64)>,
}

impl Table {
    /// From (argument, value) pairs; sorted by argument here.
    ///
    /// # Errors
    /// No pair, a number that is not finite, or two equal arguments.
    pub fn new(mut points: Vec<(f64, f64)>) -> Result<Self, String> {
        if points.is_empty() {
            return Err("a table needs at least one pair of numbers".into());
        }
        if let Some(pair) = points.iter().find(|(x, y)| !x.is_finite() || !y.is_finite()) {
            return Err(format!("the pair ({}, {}) is not finite", pair.0, pair.1));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(format!("the argument {} stands twice", pair[0].0));
        }
        Ok(Self { points })
    }

    /// The value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        let points = &self.points;
        if points.len() == 1 {
            return points[0].1;
        }
        let after = points.partition_point(|(argument, _)| *argument <= x).clamp(1, points.len() - 1);
        let ((x0, y0), (x1, y1)) = (points[after - 1], points[after]);
        y0 + (x - x0) / (x1 - x0) * (y1 - y0)
    }

    /// The pairs, ascending.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_interpolate_and_go_on_with_the_end_slopes() {
        let table = Table::new(vec![(1.0, 10.0), (0.0, 0.0), (3.0, 0.0)]).unwrap();
        for (x, y) in [(0.5, 5.0), (1.0, 10.0), (2.0, 5.0), (-1.0, -10.0), (4.0, -5.0)] {
            assert!((table.value(x) - y).abs() < 1e-14, "{x}");
        }
        assert_eq!(Table::new(vec![(2.0, 7.0)]).unwrap().value(-3.0), 7.0);
        assert!(Table::new(vec![(1.0, 0.0), (1.0, 2.0)]).is_err());
    }
}
