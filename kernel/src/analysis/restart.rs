//! Checkpoints of a run: when they are written, which one is taken up, and whether it fits.

use super::account::number;
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::error::{Error, Failure};
use crate::io::checkpoint::{Archive, CheckpointError, Contents, file};
use crate::io::files::remove_unfinished;
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use crate::processes::Clock;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Member of the project with the settings, and folder of the checkpoints in that of the results.
pub(super) const NAME: &str = "restart";

/// Keys of `restart`.
pub(super) const RESTART: &[Key] = &[
    Key::new("every_steps", Kind::Integer { min: 0 }, "0", "steps between checkpoints; 0: steps do not count"),
    Key::optional("every_seconds", Kind::Number(Range::POSITIVE), "wall time between checkpoints [s]"),
    Key::new("keep", Kind::Integer { min: 1 }, "2", "checkpoints that are kept, the newest ones"),
];

/// Member of the header that says how the run failed before which the state was saved.
const FAILURE: &str = "failure";

/// Beginning and end of the names of checkpoints, around the step.
const STEM: &str = "step_";
const EXTENSION: &str = "checkpoint";

/// Members of the project that say where inputs stand whose content matters.
const INPUT_KEYS: &[&str] = &["materials_filename", "filename", "input_filename", "input_file_name"];

/// The state in memory costs at most one part in so many of the run's time.
const SHARE: u32 = 50;

/// A state in memory.
struct Kept {
    clock: Clock,
    contents: Contents,
    since: Instant,
    cost: Duration,
}

/// Writes checkpoints.
pub(super) struct Restart {
    folder: PathBuf,
    every_steps: usize,
    every: Option<Duration>,
    keep: usize,
    last: Instant,
    /// The state that is saved if the run fails: not older than the newest checkpoint.
    kept: Option<Kept>,
    /// Checkpoints of this run, the oldest first.
    pub files: Vec<PathBuf>,
    /// Time that writing took.
    pub cost: Duration,
}

impl Restart {
    /// As the settings demand.
    pub fn new(settings: &Settings, output: &Path) -> Self {
        Self {
            folder: output.join(NAME),
            every_steps: settings.integer("every_steps") as usize,
            every: settings.given("every_seconds").then(|| Duration::from_secs_f64(settings.number("every_seconds"))),
            keep: settings.integer("keep") as usize,
            last: Instant::now(),
            kept: None,
            files: Vec::new(),
            cost: Duration::ZERO,
        }
    }

    /// Removes checkpoints of earlier runs, which must not be taken for this one's.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn clear(&mut self) -> Result<(), CheckpointError> {
        for path in checkpoints(&self.folder) {
            std::fs::remove_file(&path).map_err(|source| CheckpointError::File { path, source })?;
        }
        self.files.clear();
        remove_unfinished(&self.folder, is_checkpoint);
        // Fails, as it should, where it holds what others put there.
        let _ = std::fs::remove_dir(&self.folder);
        Ok(())
    }

    /// Takes over what an interrupted run left.
    pub fn adopt(&mut self) {
        self.files = checkpoints(&self.folder);
        self.files.reverse();
        remove_unfinished(&self.folder, is_checkpoint);
        self.last = Instant::now();
    }

    /// Whether a checkpoint is due after this step.
    pub fn is_due(&self, clock: &Clock) -> bool {
        let by_steps = self.every_steps > 0 && clock.step.is_multiple_of(self.every_steps);
        by_steps || self.every.is_some_and(|every| self.last.elapsed() >= every)
    }

    /// Writes a checkpoint and removes those that are too many.
    ///
    /// # Errors
    /// Those of the file system, and of components that cannot be saved.
    pub fn save(
        &mut self,
        clock: &Clock,
        identity: &Value,
        exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let begin = Instant::now();
        let path = self.place(clock)?;
        file::write(&path, head(clock, identity), exchange)?;
        self.add(path);
        self.last = Instant::now();
        self.cost += begin.elapsed();
        Ok(())
    }

    /// Whether the state in memory is so old that another one costs next to nothing.
    pub fn is_stale(&self) -> bool {
        self.kept.as_ref().is_none_or(|kept| kept.since.elapsed() >= kept.cost * SHARE)
    }

    /// Keeps the state in memory, in place of the one before.
    ///
    /// # Errors
    /// Those of components that cannot be saved.
    pub fn keep(
        &mut self,
        clock: &Clock,
        exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let begin = Instant::now();
        let spare = self.kept.take().map_or_else(Contents::default, |kept| kept.contents);
        let contents = file::keep(spare, exchange)?;
        let cost = begin.elapsed();
        self.kept = Some(Kept { clock: *clock, contents, since: Instant::now(), cost });
        self.cost += cost;
        Ok(())
    }

    /// Writes the state in memory as a checkpoint of a failed run; none if there is no such state.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn save_kept(
        &mut self,
        identity: &Value,
        failure: &Failure,
    ) -> Result<Option<(PathBuf, Clock)>, CheckpointError> {
        let Some(kept) = self.kept.take() else { return Ok(None) };
        let path = self.place(&kept.clock)?;
        let mut head = head(&kept.clock, identity);
        let report = failure.report();
        head.insert(FAILURE.into(), json!({"step": report.step, "time": number(report.time), "what": report.what}));
        file::write_kept(&path, head, &kept.contents)?;
        self.add(path.clone());
        Ok(Some((path, kept.clock)))
    }

    /// The file of a checkpoint, in a folder that is there.
    fn place(&self, clock: &Clock) -> Result<PathBuf, CheckpointError> {
        let failed = |source| CheckpointError::File { path: self.folder.clone(), source };
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        Ok(self.folder.join(format!("{STEM}{:010}.{EXTENSION}", clock.step)))
    }

    /// Takes note of a new checkpoint and removes those that are too many.
    fn add(&mut self, path: PathBuf) {
        self.files.retain(|other| *other != path);
        self.files.push(path);
        while self.files.len() > self.keep {
            // A file that stays is no fault of the run.
            let _ = std::fs::remove_file(self.files.remove(0));
        }
    }
}

/// What the header of a checkpoint says of it.
fn head(clock: &Clock, identity: &Value) -> Map<String, Value> {
    let mut head = Map::new();
    head.insert("bia_version".into(), env!("CARGO_PKG_VERSION").into());
    head.insert("step".into(), clock.step.into());
    head.insert("time".into(), clock.time.into());
    head.insert("identity".into(), identity.clone());
    head
}

/// Whether a file of this name is a checkpoint.
fn is_checkpoint(name: &str) -> bool {
    name.starts_with(STEM) && name.rsplit_once('.').is_some_and(|(_, extension)| extension == EXTENSION)
}

/// The checkpoints of a folder, the newest first.
fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_ours = |path: &PathBuf| path.file_name().and_then(|name| name.to_str()).is_some_and(is_checkpoint);
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_ours).collect();
    found.sort();
    found.reverse();
    found
}

/// The newest whole checkpoint of the results' folder.
///
/// # Errors
/// There is none, or it is of another project.
pub(super) fn newest(
    output: &Path,
    identity: &Value,
    adjustable: &[&'static str],
) -> Result<(PathBuf, Contents), Error> {
    let folder = output.join(NAME);
    let found = checkpoints(&folder);
    for path in &found {
        match file::read(path) {
            Ok(contents) => {
                check_identity(path, &contents, identity, adjustable)?;
                return Ok((path.clone(), contents));
            }
            Err(error) => tracing::warn!("{error}; an older one is looked for"),
        }
    }
    let message = match found.len() {
        0 => "there is no checkpoint to resume from".to_string(),
        count => format!("none of the {count} checkpoints is whole"),
    };
    let help = "start anew, without --resume; \"restart\": {\"every_seconds\": 600} in the project writes checkpoints";
    Err(Diagnostic::error(Place::file(&folder), message).help(help).into())
}

/// Refuses the checkpoint of another project; of a run that has failed, `adjustable` settings may differ.
fn check_identity(
    path: &Path,
    contents: &Contents,
    identity: &Value,
    adjustable: &[&'static str],
) -> Result<(), InputErrors> {
    let stored = contents.head.get("identity").unwrap_or(&Value::Null);
    let version = contents.head.get("bia_version").and_then(Value::as_str).unwrap_or("unknown");
    if version != env!("CARGO_PKG_VERSION") {
        let own = env!("CARGO_PKG_VERSION");
        tracing::warn!("{} was written by Bia {version}, this is {own}: bits may differ", path.display());
    }
    let (mut stored, mut now) = (stored.clone(), identity.clone());
    if contents.head.contains_key(FAILURE) {
        let (before, after) = (split(&mut stored, adjustable), split(&mut now, adjustable));
        for name in adjustable {
            if let Some((pointer, before, after)) = difference(name, &before[*name], &after[*name]) {
                tracing::warn!("resumed with another setting: {pointer} was {before}, and is now {after}");
            }
        }
    }
    let Some((pointer, before, now)) = difference("", &stored, &now) else { return Ok(()) };
    let message = format!("was written by another project: {pointer} was {before}, and is now {now}");
    let help = "restore what was changed, or start anew, without --resume";
    Err(Diagnostic::error(Place::file(path), message).help(help).into())
}

/// Takes these settings out of an identity.
fn split(identity: &mut Value, adjustable: &[&'static str]) -> Value {
    let mut taken = Map::new();
    if let Some(settings) = identity.pointer_mut("/project/solver_settings").and_then(Value::as_object_mut) {
        let found = adjustable.iter().filter_map(|name| Some(((*name).to_string(), settings.remove(*name)?)));
        taken.extend(found);
    }
    taken.into()
}

/// The first place at which two values differ, with what stands there.
fn difference(pointer: &str, before: &Value, now: &Value) -> Option<(String, String, String)> {
    if before == now {
        return None;
    }
    let inner = match (before, now) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let at = |map: &Map<String, Value>, key: &String| map.get(key).cloned().unwrap_or(Value::Null);
            keys.into_iter().find_map(|key| difference(&format!("{pointer}/{key}"), &at(a, key), &at(b, key)))
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            pairs.into_iter().find_map(|(i, (a, b))| difference(&format!("{pointer}/{i}"), a, b))
        }
        _ => None,
    };
    let shown = |value: &Value| {
        let text = value.to_string();
        if text.chars().count() > 60 { format!("{}…", text.chars().take(60).collect::<String>()) } else { text }
    };
    Some(inner.unwrap_or_else(|| (pointer.to_string(), shown(before), shown(now))))
}

/// What a run must have in common with the one that it goes on with.
pub(super) fn identity(project: &Parameters, mesh_sum: u32, kratos_exact: bool, record: Value) -> Value {
    let mut root = project.value().clone();
    if let Some(members) = root.as_object_mut() {
        // How often checkpoints are written changes nothing.
        members.retain(|key, _| key != NAME && key != "$schema");
    }
    let folder = project.document().path().parent().unwrap_or_else(|| Path::new(""));
    let mut files = Map::new();
    add_inputs(folder, &root, &mut files);
    json!({
        "project": root, "files": files, "check sum of the meshes": mesh_sum, "kratos_exact": kratos_exact,
        "record": record,
    })
}

/// Check sums of the files that the project names as inputs.
fn add_inputs(folder: &Path, value: &Value, files: &mut Map<String, Value>) {
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                match value {
                    Value::String(name) if INPUT_KEYS.contains(&key.as_str()) => {
                        let names = [name.clone(), format!("{name}.mdpa")];
                        let read = |name: String| Some((std::fs::read(folder.join(&name)).ok()?, name));
                        if let Some((bytes, name)) = names.into_iter().find_map(read) {
                            let sum = format!("CRC-32 {:08x}, {} bytes", crc32fast::hash(&bytes), bytes.len());
                            files.insert(name, sum.into());
                        }
                    }
                    _ => add_inputs(folder, value, files),
                }
            }
        }
        Value::Array(list) => list.iter().for_each(|value| add_inputs(folder, value, files)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_named_with_both_values() {
        let (a, b) = (json!({"x": {"y": [1, {"z": 2}]}}), json!({"x": {"y": [1, {"z": 3}]}}));
        assert_eq!(difference("", &a, &a), None);
        assert_eq!(difference("", &a, &b), Some(("/x/y/1/z".into(), "2".into(), "3".into())));
        let more = difference("", &json!({"a": 1}), &json!({"a": 1, "b": "new"}));
        assert_eq!(more, Some(("/b".into(), "null".into(), "\"new\"".into())));
    }
}
