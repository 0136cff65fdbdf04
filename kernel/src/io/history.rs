//! Histories: values of named entities at many times in one JSON file, in the layout of Kratos's
//! JSON output and check processes: `{"TIME": […], "NODE_5": {"DISPLACEMENT_X": […], …}, …}`.
//!
//! The layout groups by entity, so a file cannot grow at its end: it is written again as a whole.

use super::checkpoint::{Archive, CheckpointError};
use super::files::{remove_unfinished, write_atomically};
use crate::diagnostic::{Diagnostic, InputErrors};
use crate::model::Table;
use crate::parameters::Document;
use serde_json::Value;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A quantity of a history: a number, or a list of fixed length, for each entity and time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Series {
    /// Name in the file, such as `DISPLACEMENT_X`.
    pub name: String,
    /// Length of the list; none for a plain number.
    pub list: Option<usize>,
}

/// A history that is being written. The file is complete and valid after every write; it is
/// written so rarely that writing takes at most about a tenth of the run, and at the end.
#[derive(Debug)]
pub struct HistoryWriter {
    path: PathBuf,
    series: Vec<Series>,
    times: Vec<f64>,
    /// Key and values of each entity, time after time.
    entities: Vec<(String, Vec<f64>)>,
    /// Where the next entity is expected: they come in the same order every time.
    cursor: usize,
    unwritten: bool,
    last: Instant,
    cost: Duration,
}

impl HistoryWriter {
    /// A history without entities; [`HistoryWriter::finish`] writes it. What a killed run left
    /// unfinished of this file is removed.
    pub fn new(path: PathBuf, series: Vec<Series>) -> Self {
        if let (Some(folder), Some(name)) = (path.parent(), path.file_name()) {
            remove_unfinished(folder, |unfinished| name == unfinished);
        }
        let (times, entities) = (Vec::new(), Vec::new());
        let (last, cost) = (Instant::now(), Duration::ZERO);
        Self { path, series, times, entities, cursor: 0, unwritten: true, last, cost }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds an entity, so that it stands in the file even without values.
    pub fn declare(&mut self, key: &str) {
        self.entities.push((key.to_string(), Vec::new()));
    }

    /// Begins the values of a time in seconds.
    pub fn begin(&mut self, time: f64) {
        self.times.push(time);
        self.cursor = 0;
        self.unwritten = true;
    }

    /// Adds an entity's values at this time, series after series.
    pub fn add(&mut self, key: &str, values: &[f64]) {
        let count = self.entities.len();
        let found = (self.cursor..count).chain(0..self.cursor.min(count)).find(|&i| self.entities[i].0 == key);
        let entity = found.unwrap_or_else(|| {
            self.declare(key);
            count
        });
        self.entities[entity].1.extend_from_slice(values);
        self.cursor = entity + 1;
    }

    /// Saves or loads all values so far; the file is written again after loading.
    ///
    /// # Errors
    /// The checkpoint does not hold them.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut names: Vec<String> = self.series.iter().map(|series| series.name.clone()).collect();
        // A list of length 0 stands for a plain number: no list is empty.
        let mut lists: Vec<u64> = self.series.iter().map(|series| series.list.unwrap_or(0) as u64).collect();
        let mut keys: Vec<String> = self.entities.iter().map(|(key, _)| key.clone()).collect();
        let mut lengths: Vec<u64> = self.entities.iter().map(|(_, values)| values.len() as u64).collect();
        let mut values: Vec<f64> = self.entities.iter().flat_map(|(_, values)| values).copied().collect();
        archive.texts("series", &mut names)?;
        archive.column("lists", &mut lists)?;
        archive.texts("entities", &mut keys)?;
        archive.column("lengths", &mut lengths)?;
        archive.column("times", &mut self.times)?;
        archive.column("values", &mut values)?;
        if archive.is_loading() {
            let series = names.into_iter().zip(lists);
            self.series =
                series.map(|(name, list)| Series { name, list: (list > 0).then_some(list as usize) }).collect();
            let mut rest = values.into_iter();
            let entities = keys.into_iter().zip(lengths);
            self.entities =
                entities.map(|(key, length)| (key, rest.by_ref().take(length as usize).collect())).collect();
            self.unwritten = true;
        }
        Ok(())
    }

    /// Ends the values of a time; writes the file if the last writing was long enough ago.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn end(&mut self) -> io::Result<()> {
        if self.last.elapsed() >= 9 * self.cost { self.finish() } else { Ok(()) }
    }

    /// Writes what has not been written.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn finish(&mut self) -> io::Result<()> {
        if !self.unwritten {
            return Ok(());
        }
        let begin = Instant::now();
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        write_atomically(&self.path, |out| self.write(out))?;
        self.unwritten = false;
        self.cost = begin.elapsed();
        self.last = Instant::now();
        Ok(())
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let row: usize = self.series.iter().map(|series| series.list.unwrap_or(1)).sum();
        write!(out, "{{\n  \"TIME\": ")?;
        write_list(out, 1, self.times.len(), |out, i| write_number(out, self.times[i]))?;
        for (key, values) in &self.entities {
            write!(out, ",\n  {}: ", Value::from(key.as_str()))?;
            if self.series.is_empty() {
                write!(out, "{{}}")?;
                continue;
            }
            let (mut separator, mut offset) = ("{", 0);
            let count = values.len().checked_div(row).unwrap_or(0);
            for series in &self.series {
                write!(out, "{separator}\n    {}: ", Value::from(series.name.as_str()))?;
                write_list(out, 2, count, |out, i| match series.list {
                    None => write_number(out, values[i * row + offset]),
                    Some(length) => {
                        write_list(out, 3, length, |out, k| write_number(out, values[i * row + offset + k]))
                    }
                })?;
                offset += series.list.unwrap_or(1);
                separator = ",";
            }
            write!(out, "\n  }}")?;
        }
        write!(out, "\n}}")
    }
}

impl Drop for HistoryWriter {
    /// Keeps the values of a run that failed.
    fn drop(&mut self) {
        // The error that ended the run is on its way to the user; a second one could not help.
        let _ = self.finish();
    }
}

/// A JSON list, an entry a line, its bracket standing at `depth` times two blanks.
fn write_list(
    out: &mut dyn Write,
    depth: usize,
    count: usize,
    entry: impl Fn(&mut dyn Write, usize) -> io::Result<()>,
) -> io::Result<()> {
    if count == 0 {
        return write!(out, "[]");
    }
    let indent = 2 * depth;
    for i in 0..count {
        write!(out, "{}\n{:indent$}  ", if i == 0 { "[" } else { "," }, "")?;
        entry(out, i)?;
    }
    write!(out, "\n{:indent$}]", "")
}

/// The shortest text that is read back as the same number; JSON has no name for what is none.
fn write_number(out: &mut dyn Write, x: f64) -> io::Result<()> {
    if x.is_finite() { write!(out, "{x:?}") } else { write!(out, "null") }
}

/// How a value between the stored times is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lookup {
    /// That of the nearest time, the later one of two at equal distance.
    Nearest,
    /// On the line through the two neighbouring times, or the first or last two.
    Linear,
}

/// A history that was read.
#[derive(Debug)]
pub struct History {
    root: Value,
    times: Vec<f64>,
}

impl History {
    /// Reads a file.
    ///
    /// # Errors
    /// No such file, no JSON, no `TIME` with at least one number, times that do not ascend.
    pub fn read(path: &Path) -> Result<Self, InputErrors> {
        let document = Document::read(path)?;
        let error = |message: &str| Err(Diagnostic::error(document.place("/TIME"), message).into());
        let times = document.root().get("TIME").and_then(Value::as_array);
        let times: Option<Vec<f64>> = times.and_then(|list| list.iter().map(Value::as_f64).collect());
        match times {
            None => error("a history needs a list of numbers under \"TIME\""),
            Some(times) if times.is_empty() => error("the history is empty: \"TIME\" holds no number"),
            Some(times) if times.windows(2).any(|pair| pair[1] <= pair[0]) => error("the times must ascend"),
            Some(times) => Ok(Self { root: document.root().clone(), times }),
        }
    }

    /// The times in seconds, ascending.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values of an entity's series, one a time; none if the file does not have all of them.
    pub fn values(&self, key: &str, series: &str) -> Option<&[Value]> {
        let values = self.root.get(key)?.get(series)?.as_array()?;
        (values.len() == self.times.len()).then_some(values)
    }

    /// Index of the time nearest to `time` (s).
    pub fn nearest(&self, time: f64) -> usize {
        let times = &self.times;
        let after = times.partition_point(|t| *t < time);
        match after {
            0 => 0,
            _ if after == times.len() => after - 1,
            _ if time - times[after - 1] < times[after] - time => after - 1,
            _ => after,
        }
    }

    /// The number at `time` (s) among one number a time.
    pub fn at(&self, numbers: &[f64], time: f64, lookup: Lookup) -> Option<f64> {
        match lookup {
            Lookup::Nearest => numbers.get(self.nearest(time)).copied(),
            Lookup::Linear => {
                let pairs = self.times.iter().copied().zip(numbers.iter().copied()).collect();
                Some(Table::new(pairs).ok()?.value(time))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn written(work: impl FnOnce(&mut HistoryWriter)) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new folder/history.json");
        let number = |name: &str| Series { name: name.into(), list: None };
        let series = vec![number("SPEED"), Series { name: "STRESS".into(), list: Some(2) }];
        let mut history = HistoryWriter::new(path.clone(), series);
        work(&mut history);
        history.finish().unwrap();
        std::fs::read_to_string(path).unwrap()
    }

    /// What Python's `json.dump(…, indent=2)` makes of the same values.
    #[test]
    fn the_layout_is_that_of_pythons_json_with_two_blanks() {
        let text = written(|history| {
            history.declare("MP_1");
            history.begin(0.5);
            history.add("MP_1", &[1.0, 2.0, -3.5]);
        });
        let expected = "{\n  \"TIME\": [\n    0.5\n  ],\n  \"MP_1\": {\n    \"SPEED\": [\n      1.0\n    ],\n    \
                        \"STRESS\": [\n      [\n        2.0,\n        -3.5\n      ]\n    ]\n  }\n}";
        assert_eq!(text, expected);
        assert_eq!(
            written(|history| history.declare("MP_1")),
            "{\n  \"TIME\": [],\n  \"MP_1\": {\n    \"SPEED\": [],\n    \"STRESS\": []\n  }\n}"
        );
    }

    #[test]
    fn entities_may_vanish_and_appear() {
        let text = written(|history| {
            for (time, keys) in [(0.1, vec!["A", "B", "C"]), (0.2, vec!["A", "C"]), (0.3, vec!["C", "D"])] {
                history.begin(time);
                keys.iter().for_each(|key| history.add(key, &[time, f64::NAN, 0.0]));
            }
        });
        let read: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(read["TIME"], json!([0.1, 0.2, 0.3]));
        assert_eq!(read["A"]["SPEED"], json!([0.1, 0.2]));
        assert_eq!(read["B"]["SPEED"], json!([0.1]));
        assert_eq!(read["C"]["SPEED"], json!([0.1, 0.2, 0.3]));
        assert_eq!(read["D"]["STRESS"], json!([[null, 0.0]]));
    }

    #[test]
    fn a_history_that_is_dropped_unfinished_is_on_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.json");
        let mut history = HistoryWriter::new(path.clone(), vec![Series { name: "X".into(), list: None }]);
        history.cost = Duration::from_secs(1000);
        for i in 1..=3 {
            history.begin(f64::from(i));
            history.add("E", &[0.0]);
            history.end().unwrap();
        }
        assert!(!path.exists(), "writing would have taken more than a tenth of the run");
        drop(history);
        assert_eq!(History::read(&path).unwrap().times(), [1.0, 2.0, 3.0]);
    }

    fn read(text: &str) -> Result<History, InputErrors> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.json");
        std::fs::write(&path, text).unwrap();
        History::read(&path)
    }

    /// Values that Kratos's `PiecewiseLinearTable.GetNearestValue` and its core check process gave.
    #[test]
    fn values_between_times_are_those_of_kratos() {
        let history = read(r#"{"TIME": [1.0, 2.0, 3.0], "N": {"T": [10.0, 20.0, 40.0]}}"#).unwrap();
        let numbers = [10.0, 20.0, 40.0];
        for (time, nearest, linear) in [
            (0.5, 10.0, 5.0),
            (1.0, 10.0, 10.0),
            (1.25, 10.0, 12.5),
            (1.5, 20.0, 15.0),
            (2.6, 40.0, 32.0),
            (4.0, 40.0, 60.0),
        ] {
            assert_eq!(history.at(&numbers, time, Lookup::Nearest), Some(nearest), "{time}");
            assert_eq!(history.at(&numbers, time, Lookup::Linear), Some(linear), "{time}");
        }
        assert_eq!(history.values("N", "T").map(<[Value]>::len), Some(3));
        assert!(history.values("N", "U").is_none() && history.values("M", "T").is_none());
    }

    #[test]
    fn faults_of_a_history_are_named() {
        for (text, part) in [
            ("{}", "needs a list of numbers"),
            (r#"{"TIME": []}"#, "is empty"),
            (r#"{"TIME": [1, 1]}"#, "ascend"),
            (r#"{"TIME": ["a"]}"#, "list of numbers"),
        ] {
            let errors = read(text).unwrap_err().to_string();
            assert!(errors.contains(part), "{errors}");
        }
        assert!(History::read(Path::new("no such file.json")).is_err());
    }
}
