//! Tables of numbers as text, written a whole line at a time: what a stopped run leaves can be read.

use super::checkpoint::{Archive, CheckpointError};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A column's name and unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Heading {
    /// Name, such as `MP_VELOCITY_X`.
    pub name: String,
    /// SI unit.
    pub unit: String,
}

impl Heading {
    /// A column of this name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

/// How a number is printed: Python's `.8f` or `.12e`, or the shortest text that is read back as the
/// same number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberFormat {
    /// The shortest text.
    Shortest,
    /// So many digits after the point.
    Fixed(usize),
    /// So many digits after the point, and an exponent of at least two.
    Scientific(usize),
}

impl NumberFormat {
    /// From Python's notation; empty means the shortest text. None for other notations.
    pub fn parse(text: &str) -> Option<Self> {
        if text.is_empty() {
            return Some(Self::Shortest);
        }
        let (digits, kind) = text.strip_prefix('.')?.split_at_checked(text.len().checked_sub(2)?)?;
        let digits = digits.parse().ok().filter(|digits| *digits <= 30)?;
        match kind {
            "f" => Some(Self::Fixed(digits)),
            "e" | "E" => Some(Self::Scientific(digits)),
            _ => None,
        }
    }

    /// The number as text; `nan` for none.
    pub fn show(self, x: f64) -> String {
        if x.is_nan() {
            return "nan".into();
        }
        match self {
            Self::Shortest => format!("{x:?}"),
            Self::Fixed(digits) => format!("{x:.digits$}"),
            Self::Scientific(digits) => {
                let text = format!("{x:.digits$e}");
                let Some((mantissa, exponent)) = text.split_once('e') else { return text };
                let exponent: i32 = exponent.parse().unwrap_or(0);
                format!("{mantissa}e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs())
            }
        }
    }
}

/// A table of comma-separated values. The first line holds the headings, `NAME [unit]`.
#[derive(Debug)]
pub struct TableWriter {
    path: PathBuf,
    format: NumberFormat,
    file: Option<File>,
}

impl TableWriter {
    /// A table that is not on the disk yet.
    pub fn new(path: PathBuf, format: NumberFormat) -> Self {
        Self { path, format, file: None }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True once the file is there.
    pub fn is_begun(&self) -> bool {
        self.file.is_some()
    }

    /// Makes the file, and its folder, with the line of headings.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn begin(&mut self, headings: &[Heading]) -> io::Result<()> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let titles: Vec<String> = headings.iter().map(|column| format!("{} [{}]", column.name, column.unit)).collect();
        let mut file = File::create(&self.path)?;
        file.write_all((titles.join(",") + "\n").as_bytes())?;
        self.file = Some(file);
        Ok(())
    }

    /// Saves or loads how far the table goes; rows that came after a checkpoint are cut off.
    ///
    /// # Errors
    /// The file is gone or shorter than it was.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.growing_file("table", &self.path, &mut self.file)
    }

    /// Writes a line. The first number, which is a time, has all its digits whatever the format.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn row(&mut self, numbers: &[f64]) -> io::Result<()> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let show = |(i, x): (usize, &f64)| if i == 0 { NumberFormat::Shortest } else { self.format }.show(*x);
        let cells: Vec<String> = numbers.iter().enumerate().map(show).collect();
        file.write_all((cells.join(",") + "\n").as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_printed_as_python_prints_them() {
        assert_eq!(NumberFormat::parse(".8f").unwrap().show(1.5), "1.50000000");
        assert_eq!(NumberFormat::parse(".3e").unwrap().show(-12345.0), "-1.234e+04");
        assert_eq!(NumberFormat::parse("").unwrap().show(0.1 + 0.2), "0.30000000000000004");
        assert_eq!(NumberFormat::Fixed(2).show(f64::NAN), "nan");
        for wrong in ["8f", ".f", ".8x", ".é"] {
            assert!(NumberFormat::parse(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn every_line_is_on_the_disk_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below/table.csv");
        let mut table = TableWriter::new(path.clone(), NumberFormat::Fixed(1));
        assert!(!table.is_begun());
        table.begin(&[Heading::new("TIME", "s"), Heading::new("X", "m")]).unwrap();
        table.row(&[0.125, 2.0]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "TIME [s],X [m]\n0.125,2.0\n");
        table.row(&[0.25, f64::NAN]).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().ends_with("\n0.25,nan\n"));
    }
}
