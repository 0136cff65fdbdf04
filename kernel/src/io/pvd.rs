//! Series files: which result file belongs to which time, for ParaView's time slider.
//!
//! Two forms, chosen by the extension of the path:
//! - `.pvd`, ParaView's collection of XML files (`.vtu`), with parts for several bodies at one time;
//! - `.series` (`results.vtu.series`, `results.vtk.series`), ParaView's JSON list for any format, without parts.

use super::files::write_atomically;
use super::vtu::escaped;
use serde_json::json;
use std::ffi::OsStr;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// A series file that is complete, and readable while the run goes on, after every call.
#[derive(Debug, Clone, PartialEq)]
pub struct PvdSeries {
    path: PathBuf,
    form: Form,
    /// The entries as they stand in the file, so that a long series costs one copy per output.
    rows: String,
    count: usize,
    /// Names of the parts in the order of their appearance, which numbers them.
    parts: Vec<Option<String>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Pvd,
    Json,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    time: f64,
    file: String,
    part: Option<String>,
}

impl PvdSeries {
    /// Begins a series and writes it without entries, over an older file of this name.
    ///
    /// # Errors
    /// `InvalidInput` if `path` ends neither in `.pvd` nor in `.series`; otherwise those of the file system.
    pub fn create(path: impl Into<PathBuf>) -> io::Result<Self> {
        let series = Self::empty(path.into())?;
        series.write()?;
        Ok(series)
    }

    /// Goes on with a series after a restart at `until_time` (s): entries up to and at that time stay, later ones
    /// are removed from the file.
    ///
    /// # Errors
    /// `NotFound` without the file, `InvalidData` with the place if it was not written by this type,
    /// otherwise those of [`PvdSeries::create`].
    pub fn resume(path: impl Into<PathBuf>, until_time: f64) -> io::Result<Self> {
        let mut series = Self::empty(path.into())?;
        let with_path = |error: &dyn Display| format!("{}: {error}", series.path.display());
        let text =
            std::fs::read_to_string(&series.path).map_err(|error| io::Error::new(error.kind(), with_path(&error)))?;
        let entries = match series.form {
            Form::Pvd => read_pvd(&text),
            Form::Json => read_json(&text),
        }
        .map_err(|fault| io::Error::new(io::ErrorKind::InvalidData, with_path(&fault)))?;
        entries.into_iter().filter(|entry| entry.time <= until_time).for_each(|entry| series.push(entry));
        series.write()?;
        Ok(series)
    }

    /// Adds a file, whole on the disk by now, given relative to the folder of the series. Files of one time are
    /// told apart by their `part`, such as the name of a body.
    ///
    /// # Errors
    /// `InvalidInput` for a time that is not finite, a path that is not UTF-8, or a part in a JSON series;
    /// otherwise those of the file system. After an error the series is as it was.
    pub fn append(&mut self, time: f64, file: &Path, part: Option<&str>) -> io::Result<()> {
        let refuse = |why: &str| {
            let message = format!("{}: {}: {why}", self.path.display(), file.display());
            Err(io::Error::new(io::ErrorKind::InvalidInput, message))
        };
        if !time.is_finite() {
            return refuse("the time is not finite");
        }
        if part.is_some() && self.form == Form::Json {
            return refuse("a .series file has no parts, use .pvd");
        }
        let Some(name) = file.to_str() else { return refuse("the file's name is not UTF-8") };
        // ParaView reads slashes on every system.
        let file = if cfg!(windows) { name.replace('\\', "/") } else { name.to_string() };
        let before = (self.rows.len(), self.count, self.parts.len());
        self.push(Entry { time, file, part: part.map(str::to_string) });
        let written = self.write();
        if written.is_err() {
            self.rows.truncate(before.0);
            self.count = before.1;
            self.parts.truncate(before.2);
        }
        written
    }

    /// Number of files in the series.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True without files.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn empty(path: PathBuf) -> io::Result<Self> {
        let form = Form::of(&path)?;
        Ok(Self { path, form, rows: String::new(), count: 0, parts: Vec::new() })
    }

    fn push(&mut self, entry: Entry) {
        let row = match self.form {
            Form::Pvd => self.pvd_row(&entry),
            Form::Json => {
                let comma = if self.is_empty() { "" } else { ",\n" };
                format!("{comma}    {}", json!({"name": entry.file, "time": entry.time}))
            }
        };
        self.rows.push_str(&row);
        self.count += 1;
    }

    /// ParaView tells parts apart by their number and shows their name, if given.
    fn pvd_row(&mut self, Entry { time, file, part }: &Entry) -> String {
        let number = self.parts.iter().position(|known| known == part).unwrap_or_else(|| {
            self.parts.push(part.clone());
            self.parts.len() - 1
        });
        let name = part.as_ref().map_or(String::new(), |name| format!(" name=\"{}\"", escaped(name)));
        format!("<DataSet timestep=\"{time:?}\" part=\"{number}\"{name} file=\"{}\"/>\n", escaped(file))
    }

    fn write(&self) -> io::Result<()> {
        let (head, foot) = match self.form {
            Form::Pvd => (
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
                "</Collection>\n</VTKFile>\n",
            ),
            Form::Json => ("{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n", "\n  ]\n}\n"),
        };
        let parts = [head, &self.rows, foot];
        write_atomically(&self.path, |out| parts.iter().try_for_each(|part| out.write_all(part.as_bytes())))
            .map(|_bytes| ())
    }
}

impl Form {
    fn of(path: &Path) -> io::Result<Self> {
        match path.extension().and_then(OsStr::to_str) {
            Some("pvd") => Ok(Self::Pvd),
            Some("series") => Ok(Self::Json),
            _ => {
                let message = format!("{}: a series file ends in .pvd or .series", path.display());
                Err(io::Error::new(io::ErrorKind::InvalidInput, message))
            }
        }
    }
}

/// Reads what this module writes: one entry a line.
fn read_pvd(text: &str) -> Result<Vec<Entry>, String> {
    let mut entries = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("<DataSet ")) {
        let fault = |what: &str| format!("line {}: {what}", number + 1);
        let time = attribute(line, "timestep").and_then(|time| time.parse().ok());
        let time = time.ok_or_else(|| fault("no time"))?;
        let file = attribute(line, "file").ok_or_else(|| fault("no file"))?;
        entries.push(Entry { time, file, part: attribute(line, "name") });
    }
    if text.trim_end().ends_with("</VTKFile>") { Ok(entries) } else { Err("not a whole .pvd file".into()) }
}

fn read_json(text: &str) -> Result<Vec<Entry>, String> {
    let series: serde_json::Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let files = series["files"].as_array().ok_or("no list \"files\"")?;
    let entry = |(i, file): (usize, &serde_json::Value)| {
        let (Some(name), Some(time)) = (file["name"].as_str(), file["time"].as_f64()) else {
            return Err(format!("files[{i}]: a \"name\" and a \"time\" are needed"));
        };
        Ok(Entry { time, file: name.to_string(), part: None })
    };
    files.iter().enumerate().map(entry).collect()
}

/// Value of an XML attribute in double quotes.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let (_, after) = tag.split_once(&format!(" {name}=\""))?;
    let (value, _) = after.split_once('"')?;
    // The ampersand last: `&amp;lt;` stands for `&lt;`.
    Some(value.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(folder: &Path, name: &str, part: Option<&str>) -> PvdSeries {
        let mut series = PvdSeries::create(folder.join(name)).unwrap();
        for i in 0..4 {
            series.append(f64::from(i) * 0.1, Path::new(&format!("a & \"b\"/<{i}>.vtu")), part).unwrap();
        }
        series
    }

    #[test]
    fn the_collection_has_paraview_s_form_after_every_append() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.pvd");
        let mut series = PvdSeries::create(&path).unwrap();
        let head = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
        let foot = "</Collection>\n</VTKFile>\n";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{head}{foot}"));
        series.append(0.0, Path::new("body_0.vtu"), Some("Body")).unwrap();
        series.append(0.0, Path::new("soil_0.vtu"), Some("Soil & Co")).unwrap();
        series.append(1e-7, Path::new("body_1.vtu"), Some("Body")).unwrap();
        let lines = [
            "<DataSet timestep=\"0.0\" part=\"0\" name=\"Body\" file=\"body_0.vtu\"/>\n",
            "<DataSet timestep=\"0.0\" part=\"1\" name=\"Soil &amp; Co\" file=\"soil_0.vtu\"/>\n",
            "<DataSet timestep=\"1e-7\" part=\"0\" name=\"Body\" file=\"body_1.vtu\"/>\n",
        ];
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{head}{}{foot}", lines.concat()));
    }

    #[test]
    fn the_json_series_has_paraview_s_form() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.vtk.series");
        PvdSeries::create(&path).unwrap().append(0.25, Path::new("body_0.vtk"), None).unwrap();
        let value: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let files = json!([{"name": "body_0.vtk", "time": 0.25}]);
        assert_eq!(value, json!({"file-series-version": "1.0", "files": files}));
    }

    #[test]
    fn a_restart_keeps_the_past_and_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        for (name, part) in [("run.pvd", Some("x<&lt;\"y\"")), ("one.pvd", None), ("run.vtu.series", None)] {
            let whole = series(folder.path(), name, part);
            let until = 2.0 * 0.1;
            let mut again = PvdSeries::resume(folder.path().join(name), until).unwrap();
            assert_eq!(again.len(), 3, "an entry at the time of the restart stays");
            assert!(whole.rows.starts_with(&again.rows) && again.rows.contains("0.2"));
            let shortened = std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert!(shortened.contains(&again.rows) && !shortened.contains("0.3"));
            again.append(3.0 * 0.1, Path::new("a & \"b\"/<3>.vtu"), part).unwrap();
            assert_eq!(again, whole);
            assert_eq!(again.len(), 4);
        }
    }

    #[test]
    fn what_cannot_be_a_series_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |result: io::Result<PvdSeries>| result.unwrap_err().kind();
        assert_eq!(kind(PvdSeries::create(folder.path().join("run.vtu"))), io::ErrorKind::InvalidInput);
        let path = folder.path().join("run.pvd");
        assert_eq!(kind(PvdSeries::resume(&path, 1.0)), io::ErrorKind::NotFound);
        for broken in ["", "<DataSet timestep=\"x\" file=\"a\"/>\n</VTKFile>", "<DataSet timestep=\"1\"/>\n</VTKFile>"]
        {
            std::fs::write(&path, broken).unwrap();
            assert_eq!(kind(PvdSeries::resume(&path, 1.0)), io::ErrorKind::InvalidData, "{broken}");
        }
        let mut series = series(folder.path(), "run.pvd", None);
        let before = std::fs::read(&path).unwrap();
        assert!(series.append(f64::NAN, Path::new("a.vtu"), None).is_err());
        assert_eq!((series.len(), std::fs::read(&path).unwrap()), (4, before));
        let mut json = PvdSeries::create(folder.path().join("run.vtu.series")).unwrap();
        assert!(json.append(0.0, Path::new("a.vtu"), Some("Body")).is_err());
    }
}
