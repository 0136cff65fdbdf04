//! What finished runs left, kept on the disk: a study that is started again does not run them again.
//!
//! A file for each case, under a name that tells its inputs; it is taken only if the inputs themselves, the
//! sums of the files that they name, and the program are the same. Files are written whole or not at all.

use super::case::Case;
use bia_kernel::io::files::{remove_unfinished, write_atomically};
use serde_json::{Map, Value, json};
use std::io;
use std::path::{Path, PathBuf};

/// Folder of the runs in that of the report.
const RUNS: &str = "runs";
/// Beginning of the names of folders in which runs work.
pub const WORK: &str = "unfinished_";

/// The results folder of a study.
pub struct Store {
    folder: PathBuf,
    /// Tells this program from others.
    program: Value,
}

impl Store {
    /// Opens or makes the folder, and takes away what a study that was killed left unfinished.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn open(results: &Path, program: &Path) -> io::Result<Self> {
        let folder = results.join(RUNS);
        std::fs::create_dir_all(&folder)?;
        remove_unfinished(&folder, |name| name.ends_with(".json"));
        for entry in std::fs::read_dir(&folder)?.flatten() {
            if entry.file_name().to_string_lossy().starts_with(WORK) {
                // A folder that stays is no fault of the study.
                let _ = std::fs::remove_dir_all(entry.path());
            }
        }
        let bytes = std::fs::read(program)?;
        let sum = format!("CRC-32 {:08x}, {} bytes", crc32fast::hash(&bytes), bytes.len());
        Ok(Self { folder, program: json!({"version": env!("CARGO_PKG_VERSION"), "file": sum}) })
    }

    /// Where runs work.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn identity(&self, case: &Case) -> Value {
        json!({"program": self.program, "inputs": case.inputs})
    }

    fn path(&self, case: &Case) -> PathBuf {
        let mut slug: String = case.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        slug.truncate(60);
        let sum = crc32fast::hash(self.identity(case).to_string().as_bytes());
        self.folder.join(format!("{slug}-{sum:08x}.json"))
    }

    /// What the repetitions of a case left, as far as they were run.
    pub fn read(&self, case: &Case) -> Vec<Value> {
        let text = std::fs::read_to_string(self.path(case)).unwrap_or_default();
        let Ok(Value::Object(mut stored)) = serde_json::from_str::<Value>(&text) else { return Vec::new() };
        match (stored.get("identity") == Some(&self.identity(case)), stored.remove("repetitions")) {
            (true, Some(Value::Array(list))) => list,
            _ => Vec::new(),
        }
    }

    /// Keeps what the repetitions so far left.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, case: &Case, repetitions: &[Value]) -> io::Result<()> {
        let mut stored = Map::new();
        stored.insert("name".into(), case.name.clone().into());
        stored.insert("command".into(), case.command().into());
        stored.insert("identity".into(), self.identity(case));
        stored.insert("repetitions".into(), repetitions.into());
        let text = format!("{:#}\n", Value::Object(stored));
        write_atomically(&self.path(case), |out| out.write_all(text.as_bytes())).map(|_| ())
    }
}
