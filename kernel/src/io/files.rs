//! Whole files or none: what stands under a result's name is always complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};

/// Bytes gathered before the operating system is called.
const BUFFER: usize = 1 << 17;

/// Writes a file through `content`, beside its place and under another name, and moves it there at the end.
///
/// A reader sees the old file or the new one, never a part. Returns the number of bytes. The data are
/// not forced to the disk (`fsync`): a program that dies leaves whole files, a power cut may not.
///
/// # Errors
/// Those of `content` and of the file system, with the path; the temporary file is removed and an
/// older file under this name stays as it was.
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<u64> {
    let with_path = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    write_and_rename(path, content).map_err(with_path)
}

fn write_and_rename(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<u64> {
    let mut temporary = Temporary { path: temporary_path(path)?, moved: false };
    let mut out = Counting { inner: BufWriter::with_capacity(BUFFER, File::create(&temporary.path)?), bytes: 0 };
    content(&mut out)?;
    out.flush()?;
    let bytes = out.bytes;
    drop(out); // Windows does not move open files
    fs::rename(&temporary.path, path)?;
    temporary.moved = true;
    Ok(bytes)
}

/// Where a path leads, whether there is anything or not: links are followed as far as there are any.
pub fn resolve(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut real = PathBuf::new();
    for component in absolute.components() {
        match component {
            Component::ParentDir => drop(real.pop()),
            Component::CurDir => {}
            other => real.push(other),
        }
        if let Ok(found) = real.canonicalize() {
            real = found;
        }
    }
    real
}

/// A hidden name in the same folder, hence on the same file system, that no other process uses.
fn temporary_path(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.tmp", std::process::id()));
    Ok(path.with_file_name(hidden))
}

/// Removes from a folder what [`write_atomically`] left when its program was killed, of the files whose
/// names are chosen.
pub fn remove_unfinished(folder: &Path, chosen: impl Fn(&str) -> bool) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let hidden = entry.file_name();
        let parts = hidden.to_str().and_then(|name| name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.'));
        let Some((name, process)) = parts else { continue };
        if process.bytes().all(|byte| byte.is_ascii_digit()) && chosen(name) {
            // A file that stays is no fault of the run.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Removes the temporary file unless it has been moved, also when `content` panics.
struct Temporary {
    path: PathBuf,
    moved: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.moved {
            // The first error is on its way to the caller; a second one could not help.
            let _ = fs::remove_file(&self.path);
        }
    }
}

struct Counting<W> {
    inner: W,
    bytes: u64,
}

impl<W: Write> Write for Counting<W> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(data)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<OsString> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    }

    #[test]
    fn the_file_appears_whole_and_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.txt");
        fs::write(&path, "old").unwrap();
        let bytes = write_atomically(&path, |out| {
            out.write_all(b"new ")?;
            out.flush()?;
            assert_eq!(fs::read(&path)?, b"old", "a reader still sees the old file");
            out.write_all(&[b'x'; 3 * BUFFER])
        });
        assert_eq!(bytes.unwrap(), 4 + 3 * BUFFER as u64);
        assert_eq!(fs::metadata(&path).unwrap().len(), 4 + 3 * BUFFER as u64);
        assert_eq!(names(folder.path()), ["result.txt"]);
    }

    #[test]
    fn only_the_chosen_unfinished_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        for name in [".a.json.17.tmp", ".b.json.17.tmp", ".a.json.x7.tmp", "a.json.17.tmp", "a.json"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        remove_unfinished(folder.path(), |name| name == "a.json");
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, [".a.json.x7.tmp", ".b.json.17.tmp", "a.json", "a.json.17.tmp"]);
    }

    #[test]
    fn a_failure_keeps_the_old_file_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.txt");
        fs::write(&path, "old").unwrap();
        let error = write_atomically(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("no more numbers"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("result.txt: no more numbers"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["result.txt"]);
        let missing = folder.path().join("no such folder").join("result.txt");
        assert_eq!(write_atomically(&missing, |_| Ok(())).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
