//! Tables that measurements write.

use std::path::Path;

/// A table of numbers with its headings, `NAME [unit]`.
pub struct Table {
    pub headings: Vec<String>,
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = text.lines();
        let headings: Vec<String> = lines.next().unwrap().split(',').map(str::to_string).collect();
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
        let rows: Vec<Vec<f64>> = lines.map(row).collect();
        assert!(rows.iter().all(|row| row.len() == headings.len()), "{headings:?}: rows of another length");
        Self { headings, rows }
    }

    /// The column whose heading is `NAME [unit]`.
    pub fn column(&self, heading: &str) -> Vec<f64> {
        let found = self.headings.iter().position(|other| other == heading);
        let column = found.unwrap_or_else(|| panic!("no {heading:?} among {:?}", self.headings));
        self.rows.iter().map(|row| row[column]).collect()
    }
}
