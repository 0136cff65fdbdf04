//! A field as a table of comma-separated values: over the time, over one coordinate, or over both.
//!
//! The first line holds the names of the columns; units in brackets are ignored, so that the tables that
//! Bia's own measurements write (of a finer run, say) are read as they are. Between the entries the table is
//! linear: first along the coordinate, at the times before and after, then in time. Beyond its ends it is
//! not a number, which the error shows.

use super::{Compared, Place, ReferenceEntry, ReferenceSolution};
use crate::diagnostic::{Diagnostic, InputErrors, Place as Source};
use crate::parameters::{Key, Kind, Parameters, Settings};
use crate::registry::Building;
use std::path::Path;

const COLUMNS: &[Key] = &[
    Key::optional("time", Kind::Text, "column of the time [s]; without it the table holds at all times"),
    Key::optional("x", Kind::Text, "column of the position x [m]"),
    Key::optional("y", Kind::Text, "column of the position y [m]"),
    Key::optional("z", Kind::Text, "column of the position z [m]"),
    Key::optional("X", Kind::Text, "column of the initial position X [m]"),
    Key::optional("Y", Kind::Text, "column of the initial position Y [m]"),
    Key::optional("Z", Kind::Text, "column of the initial position Z [m]"),
    Key::required("value", Kind::Any, "column of the field, or a list of its components' columns"),
];

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "table",
    keys: &[
        Key::required("file", Kind::Text, "csv file beside the project, its first line the names of the columns"),
        Key::required("columns", Kind::Object(COLUMNS), "names of the columns"),
        Key::new("delimiter", Kind::Text, "\",\"", "between the columns"),
    ],
    help: "a csv table over time, over one coordinate or over both: measured, tabulated, or of a finer run",
    build,
};

/// Positions by which a table may go, with the index into position (0..3) and initial position (3..6).
const COORDINATES: [&str; 6] = ["x", "y", "z", "X", "Y", "Z"];

/// Slack of times and coordinates at the ends of the table, as a share of the largest.
const SLACK: f64 = 1e-9;

/// Rows of one time, ordered by the coordinate.
struct Profile {
    time: f64,
    coordinates: Vec<f64>,
    /// `width` numbers a coordinate.
    values: Vec<f64>,
}

struct Table {
    /// Of the profiles.
    times: Vec<f64>,
    /// In ascending order of time; one profile if the table has no time.
    profiles: Vec<Profile>,
    /// Index into [`COORDINATES`].
    coordinate: Option<usize>,
    has_time: bool,
    width: usize,
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    let Some(columns) = settings.nested("columns") else { return Err(InputErrors::default()) };
    let file = settings.text("file");
    let path = building.options.folder.join(file);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| settings.error("file", format!("{} cannot be read: {error}", path.display())))?;
    let given: Vec<usize> = (0..6).filter(|index| columns.given(COORDINATES[*index])).collect();
    if given.len() > 1 {
        let message = "names several coordinates, a table goes along one";
        return Err(settings.error("columns", message).into());
    }
    let (coordinate, has_time) = (given.first().copied(), columns.given("time"));
    if coordinate.is_none() && !has_time {
        return Err(settings.error("columns", "names neither the time nor a coordinate").into());
    }
    let values = value_names(columns)?;
    if let Some(width) = compared.width().filter(|width| *width != values.len()) {
        let message = format!("has {} columns, {compared} has {width} components", values.len());
        return Err(columns.error("value", message).into());
    }
    let mut wanted: Vec<(Parameters, String)> = Vec::new();
    let place_of = |key: &str| columns.get(key).cloned().unwrap_or_else(|| columns.parameters().clone());
    if has_time {
        wanted.push((place_of("time"), columns.text("time").into()));
    }
    if let Some(index) = coordinate {
        wanted.push((place_of(COORDINATES[index]), columns.text(COORDINATES[index]).into()));
    }
    wanted.extend(values.iter().map(|name| (place_of("value"), name.clone())));
    let rows = read_rows(&text, settings.text("delimiter"), &path, &wanted)?;
    if rows.is_empty() {
        return Err(settings.error("file", format!("{} holds no numbers", path.display())).into());
    }
    let width = values.len();
    let profiles = profiles(&rows, has_time, coordinate.is_some());
    let times = profiles.iter().map(|profile| profile.time).collect();
    Ok(Box::new(Table { times, profiles, coordinate, has_time, width }))
}

/// Names of the columns with the field's components.
fn value_names(columns: &Settings) -> Result<Vec<String>, InputErrors> {
    let Some(value) = columns.get("value") else { return Err(InputErrors::default()) };
    let entries = if value.value().is_array() { value.entries() } else { vec![value.clone()] };
    let name = |entry: &Parameters| entry.value().as_str().map(str::to_owned);
    let names: Option<Vec<String>> = entries.iter().map(name).collect();
    let wrong = || value.error("must be the name of a column, or a list of names").into();
    names.filter(|names| !names.is_empty()).ok_or_else(wrong)
}

/// The numbers of the wanted columns, row by row.
fn read_rows(
    text: &str,
    delimiter: &str,
    path: &Path,
    wanted: &[(Parameters, String)],
) -> Result<Vec<Vec<f64>>, InputErrors> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let plain = |cell: &str| cell.split('[').next().unwrap_or_default().trim().to_owned();
    let names: Vec<String> = lines.next().map_or(Vec::new(), |(_, line)| line.split(delimiter).map(plain).collect());
    let mut errors = InputErrors::default();
    let mut indices = Vec::new();
    for (place, name) in wanted {
        match names.iter().position(|known| known == name) {
            Some(index) => indices.push(index),
            None => {
                let message = format!("{} has no column {name:?}", path.display());
                errors.push(place.error(message).allowed(name, names.iter().map(String::as_str)));
            }
        }
    }
    errors.or(())?;
    let (mut rows, mut errors) = (Vec::new(), InputErrors::default());
    for (number, line) in lines {
        let cells: Vec<&str> = line.split(delimiter).map(str::trim).collect();
        let value = |index: &usize| cells.get(*index)?.parse::<f64>().ok().filter(|value| value.is_finite());
        match indices.iter().map(value).collect::<Option<Vec<f64>>>() {
            Some(row) => rows.push(row),
            None => errors.push(Diagnostic::error(Source::line(path, number + 1), "lacks a number")),
        }
    }
    errors.or(rows)
}

fn profiles(rows: &[Vec<f64>], has_time: bool, has_coordinate: bool) -> Vec<Profile> {
    let skipped = usize::from(has_time) + usize::from(has_coordinate);
    let time = |row: &[f64]| if has_time { row[0] } else { 0.0 };
    let coordinate = |row: &[f64]| if has_coordinate { row[usize::from(has_time)] } else { 0.0 };
    let mut ordered: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    ordered.sort_by(|a, b| time(a).total_cmp(&time(b)).then(coordinate(a).total_cmp(&coordinate(b))));
    let of_time = |group: &[&[f64]]| Profile {
        time: time(group[0]),
        coordinates: group.iter().map(|row| coordinate(row)).collect(),
        values: group.iter().flat_map(|row| row[skipped..].iter().copied()).collect(),
    };
    ordered.chunk_by(|a, b| time(a) == time(b)).map(of_time).collect()
}

/// Between which two of ascending numbers one lies, and at which share of the way; none beyond their ends.
fn between(numbers: &[f64], at: f64) -> Option<(usize, f64)> {
    let (first, last) = (*numbers.first()?, *numbers.last()?);
    let slack = SLACK * first.abs().max(last.abs());
    let inside = at >= first - slack && at <= last + slack;
    let next = numbers.partition_point(|number| *number <= at).clamp(1, numbers.len().max(2) - 1);
    match (inside, numbers.get(next)) {
        (false, _) => None,
        (true, None) => Some((0, 0.0)),
        (true, Some(high)) => {
            let low = numbers[next - 1];
            Some((next - 1, if *high > low { ((at - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }))
        }
    }
}

impl Profile {
    fn value(&self, at: f64, component: usize, width: usize, has_coordinate: bool) -> f64 {
        let of_row = |row: usize| self.values[row * width + component];
        if !has_coordinate {
            return of_row(0);
        }
        match between(&self.coordinates, at) {
            Some((row, share)) if share > 0.0 => (1.0 - share) * of_row(row) + share * of_row(row + 1),
            Some((row, _)) => of_row(row),
            None => f64::NAN,
        }
    }
}

impl ReferenceSolution for Table {
    fn append(&self, place: &Place, out: &mut Vec<f64>) {
        let at = self.coordinate.map_or(0.0, |index| match index {
            0..3 => place.position[index],
            _ => place.initial[index - 3],
        });
        let found = if self.has_time { between(&self.times, place.time) } else { Some((0, 0.0)) };
        let has_coordinate = self.coordinate.is_some();
        out.extend((0..self.width).map(|component| {
            let of = |profile: usize| self.profiles[profile].value(at, component, self.width, has_coordinate);
            match found {
                Some((profile, share)) if share > 0.0 => (1.0 - share) * of(profile) + share * of(profile + 1),
                Some((profile, _)) => of(profile),
                None => f64::NAN,
            }
        }));
    }
}
