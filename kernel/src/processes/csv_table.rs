//! A function of time as a table in a csv file, with Kratos's keys.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::model::Table;
use crate::parameters::{Key, Kind, Parameters, Range};
use std::path::Path;

const KEYS: &[Key] = &[
    Key::new("name", Kind::Choice(&["csv_table"]), "\"csv_table\"", "kind of the table"),
    Key::required("filename", Kind::Text, "csv file, beside the project"),
    Key::new("delimiter", Kind::Text, "\",\"", "between the columns"),
    Key::new("skiprows", Kind::Integer { min: 0 }, "0", "lines before the data"),
    Key::new("first_column_id", Kind::Integer { min: 0 }, "0", "column of the time, from 0"),
    Key::new("second_column_id", Kind::Integer { min: 0 }, "1", "column of the value, from 0"),
    Key::new("table_id", Kind::Integer { min: -1 }, "-1", "accepted"),
    Key::new("na_replace", Kind::Number(Range::ANY), "0.0", "value of cells that hold N/A"),
];

/// Reads the table that an object like `{"name": "csv_table", "filename": "load.csv"}` names.
///
/// # Errors
/// A file that cannot be read, rows with too few columns, cells that are no numbers.
pub fn read(parameters: &Parameters) -> Result<Table, InputErrors> {
    let settings = parameters.read(KEYS)?;
    let folder = parameters.document().path().parent().unwrap_or_else(|| Path::new(""));
    let path = folder.join(settings.text("filename"));
    let text = std::fs::read_to_string(&path)
        .map_err(|error| settings.error("filename", format!("{} cannot be read: {error}", path.display())))?;
    let columns = [settings.integer("first_column_id") as usize, settings.integer("second_column_id") as usize];
    let delimiter = settings.text("delimiter");
    if delimiter.is_empty() {
        return Err(settings.error("delimiter", "is empty, must be at least one character").into());
    }
    let (mut pairs, mut errors) = (Vec::new(), InputErrors::default());
    for (number, line) in text.lines().enumerate().skip(settings.integer("skiprows") as usize) {
        if line.trim().is_empty() {
            continue;
        }
        let cells: Vec<&str> = line.split(delimiter).map(str::trim).collect();
        let value = |column: usize| match cells.get(column) {
            None => Err(format!("has {} columns, column {column} (from 0) is asked for", cells.len())),
            Some(&"N/A") => Ok(settings.number("na_replace")),
            Some(cell) => match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(format!("holds {cell:?} in column {column}, which is no number")),
            },
        };
        match (value(columns[0]), value(columns[1])) {
            (Ok(time), Ok(value)) => pairs.push((time, value)),
            (Err(message), _) | (_, Err(message)) => {
                errors.push(Diagnostic::error(Place::line(&path, number + 1), message));
            }
        }
    }
    errors.or(())?;
    Table::new(pairs).map_err(|message| settings.error("filename", message).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Document;
    use crate::processes::SpaceTimeValue;

    fn value(folder: &Path, object: &str, csv: &str) -> Result<SpaceTimeValue, InputErrors> {
        std::fs::write(folder.join("load.csv"), csv).unwrap();
        SpaceTimeValue::read(&Parameters::root(Document::parse(&folder.join("P.json"), object.into())?))
    }

    #[test]
    fn tables_are_interpolated_over_the_time() {
        let folder = tempfile::tempdir().unwrap();
        let object = r#"{"name": "csv_table", "filename": "load.csv", "skiprows": 1, "second_column_id": 2}"#;
        let read = value(folder.path(), object, "t, a, b\n0, 9, 1\n\n2, 9, 5\n").unwrap();
        assert_eq!(read.times(2.0).at([7.0; 3], [7.0; 3], 0.5), 4.0);
        assert!(read.depends_on_time() && !read.depends_on_space() && read.as_constant().is_none());
    }

    #[test]
    fn faults_name_file_and_line() {
        let folder = tempfile::tempdir().unwrap();
        let object = r#"{"filename": "load.csv"}"#;
        let all = value(folder.path(), object, "0, 1\n1, x\n2\n").unwrap_err().to_string();
        assert!(all.contains("load.csv:2") && all.contains("load.csv:3"), "{all}");
        let missing = value(folder.path(), r#"{"filename": "lod.csv"}"#, "").unwrap_err().to_string();
        assert!(missing.contains("lod.csv cannot be read"), "{missing}");
    }
}
