//! The folder, names and formats of a process's VTK files.

use super::super::{Clock, Requirements, RunOptions};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::dataset::Dataset;
use crate::io::files::{remove_unfinished, resolve};
use crate::io::pvd::PvdSeries;
use crate::io::vtk_legacy::{Encoding, write_legacy};
use crate::io::vtu::{VtuOptions, write_vtu};
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Keys that all processes that write VTK files share; each adds its own `output_path`.
pub const FILES: [Key; 14] = [
    Key::new(
        "file_format",
        Kind::Choice(&["ascii", "binary", "vtu"]),
        "\"binary\"",
        "legacy VTK as text or binary, or compressed .vtu files with a .pvd series",
    ),
    Key::new("output_precision", Kind::Integer { min: 0 }, "7", "digits after the point in text files and labels"),
    Key::new(
        "precision",
        Kind::Choice(&["float64", "float32"]),
        "\"float64\"",
        "numbers of .vtu files; float32 halves their size and keeps 7 digits",
    ),
    Key::new(
        "output_control_type",
        Kind::Choice(&["step", "time", "wall_time"]),
        "\"step\"",
        "what output_interval counts: steps, simulated time, or time on the wall",
    ),
    Key::new(
        "output_interval",
        Kind::Number(Range::NOT_NEGATIVE),
        "1.0",
        "between outputs [steps or s]; 0: every step",
    )
    .or(&["output_frequency"]),
    Key::new("output_sub_model_parts", Kind::Bool, "false", "write the parts directly below as files of their own too"),
    Key::new("save_output_files_in_folder", Kind::Bool, "true", "false: the files go where the results go"),
    Key::new("custom_name_prefix", Kind::Text, "\"\"", "put before the names of files"),
    Key::new("custom_name_postfix", Kind::Text, "\"\"", "put after the names of files, before the label"),
    Key::new("write_ids", Kind::Bool, "false", "write ids of nodes, cells and properties").or(&["write_properties_id"]),
    Key::new(
        "entity_type",
        Kind::Choice(&["automatic", "element", "condition"]),
        "\"automatic\"",
        "cells that are shown: elements, conditions, or whichever there are",
    ),
    Key::new("condition_flags", Kind::List, "[]", "must be empty: conditions have no flags"),
    Key::new("element_flags", Kind::List, "[]", "must be empty: elements have no flags"),
    Key::optional("help", Kind::Any, "ignored"),
];

/// More digits are neither needed nor printed.
const MOST_DIGITS: i64 = 30;

/// Digits after the point with which every double is exact.
const ALL_DIGITS: usize = 1074;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Legacy(Encoding),
    Vtu { single_precision: bool },
}

/// Writes files named `<name>_0_<step or time>` as a process's settings demand. (The 0 is the rank
/// that Kratos puts there.)
#[derive(Debug)]
pub struct VtkFiles {
    folder: PathBuf,
    /// The folder belongs to the process, which empties it at the start.
    own_folder: bool,
    /// Folders that must not be emptied.
    project: [PathBuf; 2],
    format: Format,
    prefix: String,
    postfix: String,
    by_time: bool,
    precision: usize,
    kratos_exact: bool,
    series: BTreeMap<String, PvdSeries>,
    /// Time of the last file of each name, in seconds.
    last: BTreeMap<String, f64>,
    written: Vec<PathBuf>,
}

impl VtkFiles {
    /// From settings with the keys [`FILES`] and `output_path`.
    ///
    /// # Errors
    /// Flags; more digits than any number has.
    pub fn read(settings: &Settings, options: &RunOptions) -> Result<Self, InputErrors> {
        super::refuse_lists(settings, &["condition_flags", "element_flags"])?;
        let digits = settings.integer("output_precision");
        if digits > MOST_DIGITS {
            return Err(settings.error("output_precision", format!("must be at most {MOST_DIGITS}")).into());
        }
        if settings.text("precision") == "float32" && settings.text("file_format") != "vtu" {
            let fault = settings.error("precision", "float32 is for files of the format vtu");
            return Err(fault
                .help("set \"file_format\": \"vtu\"; legacy files are written as Kratos writes them")
                .into());
        }
        let precision = digits as usize;
        let own_folder = settings.flag("save_output_files_in_folder");
        let below = if own_folder { settings.text("output_path") } else { "" };
        Ok(Self {
            folder: options.output.join(below),
            own_folder,
            project: [options.folder.clone(), options.output.clone()],
            format: match settings.text("file_format") {
                "ascii" => Format::Legacy(Encoding::Ascii { precision }),
                "vtu" => Format::Vtu { single_precision: settings.text("precision") == "float32" },
                _ => Format::Legacy(Encoding::Binary),
            },
            prefix: settings.text("custom_name_prefix").into(),
            postfix: settings.text("custom_name_postfix").into(),
            by_time: settings.text("output_control_type") == "time",
            precision,
            kratos_exact: options.kratos_exact,
            series: BTreeMap::new(),
            last: BTreeMap::new(),
            written: Vec::new(),
        })
    }

    /// Whether the files are of the XML format, in which ParaView expects points' values on points.
    pub fn is_vtu(&self) -> bool {
        matches!(self.format, Format::Vtu { .. })
    }

    /// A name with the prefix and postfix of the settings.
    pub fn name(&self, part: &str) -> String {
        format!("{}{part}{}", self.prefix, self.postfix)
    }

    /// Files written so far.
    pub fn written(&self) -> &[PathBuf] {
        &self.written
    }

    /// Says that the files of this name are written here, so that no other process takes their place.
    pub fn claim(&self, name: &str, requirements: &mut Requirements, place: &Parameters) {
        let extension = if self.is_vtu() { "vtu" } else { "vtk" };
        requirements.write(&self.folder.join(format!("{name}_0_*.{extension}")), place);
    }

    /// Checks that the folder may be emptied at the start; changes nothing.
    ///
    /// # Errors
    /// It is the project's own folder or the root, is no folder, or holds what no VTK output wrote.
    pub fn check_folder(&self, settings: &Settings) -> Result<(), InputErrors> {
        if !self.own_folder {
            return Ok(());
        }
        let refuse = |why: String| {
            let diagnostic = settings.error("output_path", why);
            let help = "the folder is emptied when the run starts: name a new one, or one with VTK files only";
            Err(diagnostic.help(help).into())
        };
        let shown = self.folder.display();
        if self.project.iter().any(|project| resolve(project) == resolve(&self.folder)) {
            return refuse(format!("{shown:?} is the folder of the project or of all results"));
        }
        if !self.folder.exists() {
            return Ok(());
        }
        match foreign_entries(&self.folder) {
            Ok(names) if names.is_empty() => Ok(()),
            Ok(names) => {
                let more = if names.len() > 5 { ", …" } else { "" };
                let listed = names.iter().take(5).map(String::as_str).collect::<Vec<_>>().join(", ");
                refuse(format!("{shown:?} holds other things than VTK files: {listed}{more}"))
            }
            Err(error) => refuse(format!("{shown:?} cannot be listed: {error}")),
        }
    }

    /// Makes the folder, without VTK files of earlier runs.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn prepare(&self) -> Result<(), Error> {
        let work = || -> io::Result<()> {
            fs::create_dir_all(&self.folder)?;
            if self.own_folder {
                for entry in fs::read_dir(&self.folder)? {
                    let entry = entry?;
                    if is_ours(&entry) {
                        fs::remove_file(entry.path())?;
                    }
                }
            }
            Ok(())
        };
        work().map_err(|source| Error::Write { path: self.folder.clone(), source })
    }

    /// Saves or loads which files there are. Series go on after the files of the checkpoint; those that
    /// came later are written again under the same names.
    ///
    /// # Errors
    /// The file of a series is gone or not whole.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut series: Vec<String> = self.series.keys().cloned().collect();
        let mut names: Vec<String> = self.last.keys().cloned().collect();
        let mut times: Vec<f64> = self.last.values().copied().collect();
        let mut written: Vec<String> = self.written.iter().map(|path| path.to_string_lossy().into_owned()).collect();
        archive.texts("series", &mut series)?;
        archive.texts("names", &mut names)?;
        archive.column("times", &mut times)?;
        archive.texts("written", &mut written)?;
        if archive.is_loading() {
            self.last = names.into_iter().zip(times).collect();
            self.written = written.into_iter().map(PathBuf::from).collect();
            for name in series {
                let path = self.folder.join(format!("{name}.pvd"));
                let until = self.last.get(&name).copied().unwrap_or(f64::NEG_INFINITY);
                let resumed = PvdSeries::resume(&path, until);
                let resumed = resumed.map_err(|source| CheckpointError::File { path, source })?;
                self.series.insert(name, resumed);
            }
            self.remove_unfinished();
        }
        Ok(())
    }

    /// Removes what a killed run did not finish, of these files alone where the folder holds others.
    fn remove_unfinished(&self) {
        let begins = |file: &str| self.last.keys().any(|name| file.starts_with(name.as_str()));
        remove_unfinished(&self.folder, |file| self.own_folder || begins(file));
    }

    /// Step or time as it stands in the names of files. A time has as many digits more than the
    /// settings ask for as tell it from the last time: no file takes the place of another one.
    fn label(&self, name: &str, clock: &Clock) -> String {
        if !self.by_time {
            return clock.step.to_string();
        }
        let with = |digits: usize, time: f64| format!("{time:.digits$}");
        let last = self.last.get(name).copied().filter(|last| *last != clock.time);
        let differs = |digits: &usize| last.is_none_or(|last| with(*digits, last) != with(*digits, clock.time));
        with((self.precision..=ALL_DIGITS).find(differs).unwrap_or(self.precision), clock.time)
    }

    /// Writes a file, and adds it to the series of this name if it is one of a series.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&mut self, name: &str, clock: &Clock, data: &Dataset, of_series: bool) -> Result<(), Error> {
        let extension = if self.is_vtu() { "vtu" } else { "vtk" };
        let file = format!("{name}_0_{}.{extension}", self.label(name, clock));
        self.write_as(name, &file, clock, data, of_series)?;
        self.last.insert(name.into(), clock.time);
        Ok(())
    }

    /// Writes what does not change, such as the mesh under the points, labelled as step 0.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write_once(&mut self, name: &str, clock: &Clock, data: &Dataset) -> Result<(), Error> {
        let extension = if self.is_vtu() { "vtu" } else { "vtk" };
        self.write_as(name, &format!("{name}_0_{}.{extension}", clock.step), clock, data, false)
    }

    fn write_as(
        &mut self,
        name: &str,
        file: &str,
        clock: &Clock,
        data: &Dataset,
        of_series: bool,
    ) -> Result<(), Error> {
        let path = self.folder.join(file);
        let result = match self.format {
            // Kratos rounds to single precision before it prints digits.
            Format::Legacy(encoding) if self.kratos_exact => {
                write_legacy(&path, &data.clone().in_single_precision(), encoding)
            }
            Format::Legacy(encoding) => write_legacy(&path, data, encoding),
            Format::Vtu { single_precision } => {
                write_vtu(&path, data, Some(clock.time), &VtuOptions { single_precision, ..VtuOptions::default() })
            }
        };
        result.map_err(|source| Error::Write { path: path.clone(), source })?;
        self.written.push(path);
        if of_series && self.is_vtu() {
            let path = self.folder.join(format!("{name}.pvd"));
            self.append(name, &path, clock.time, file).map_err(|source| Error::Write { path, source })?;
        }
        Ok(())
    }

    fn append(&mut self, name: &str, path: &Path, time: f64, file: &str) -> io::Result<()> {
        if !self.series.contains_key(name) {
            self.series.insert(name.into(), PvdSeries::create(path)?);
            self.written.push(path.into());
        }
        match self.series.get_mut(name) {
            Some(series) => series.append(time, Path::new(file), None),
            None => Ok(()),
        }
    }
}

/// Names of what the folder holds beside VTK files.
fn foreign_entries(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if !is_ours(&entry) {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
}

/// VTK files, and the hidden unfinished ones that a killed run leaves.
fn is_ours(entry: &fs::DirEntry) -> bool {
    let name = entry.file_name().to_string_lossy().into_owned();
    let unfinished = name.starts_with('.') && name.ends_with(".tmp");
    let extension = Path::new(&name).extension().and_then(|extension| extension.to_str());
    let known = matches!(extension, Some("vtk" | "vtu" | "pvd" | "series"));
    (known || unfinished) && entry.file_type().is_ok_and(|kind| kind.is_file())
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
