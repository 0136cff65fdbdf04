//! Runs cases one after the other, each in a process of its own.

use super::case::Case;
use super::store::{Store, WORK};
use crate::report::complain;
use crate::signal::Signal;
use serde_json::{Value, json};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How often a run is looked at.
const GLANCE: Duration = Duration::from_millis(5);
/// Characters of a run's messages that are kept.
const KEPT: usize = 4000;

/// Why a study stopped before its end.
pub enum Stop {
    /// A signal; finished runs are kept.
    Signal,
    /// The file system, or the program could not be started.
    System(io::Error),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Stop::System(error)
    }
}

/// Runs cases and keeps what they leave.
pub struct Runner<'a> {
    /// Where results are kept.
    pub store: &'a Store,
    /// This program.
    pub program: PathBuf,
    /// Asks to stop.
    pub signal: Signal,
    /// Says nothing while it runs.
    pub quiet: bool,
}

impl Runner<'_> {
    /// Runs all cases so often; what was run before is taken from the store. Returns what each repetition of
    /// each case left. A case that does not end well is not repeated.
    ///
    /// # Errors
    /// A signal, or the file system; never the failure of a run.
    pub fn run(&self, cases: &[&Case], repetitions: usize) -> Result<Vec<Vec<Value>>, Stop> {
        let mut progress = Progress::new(cases.len() * repetitions, self.quiet);
        let mut all = Vec::new();
        for case in cases {
            let mut left = self.store.read(case);
            left.retain(|repetition| !would_go_on(repetition, case.time_limit));
            left.truncate(repetitions);
            progress.found(left.len());
            while left.len() < repetitions && left.iter().all(is_done) {
                let repetition = self.run_once(case)?;
                progress.ran(case, &repetition, left.len());
                left.push(repetition);
                self.store.write(case, &left)?;
            }
            progress.found(repetitions - left.len());
            all.push(left);
        }
        Ok(all)
    }

    fn run_once(&self, case: &Case) -> Result<Value, Stop> {
        if self.signal.has_come() {
            return Err(Stop::Signal);
        }
        let work = tempfile::Builder::new().prefix(WORK).tempdir_in(self.store.folder())?;
        let summary = work.path().join("summary.json");
        let begin = Instant::now();
        let mut command = Command::new(&self.program);
        command.arg("run").arg(&case.project).arg("--quiet").arg("--threads").arg(case.threads.to_string());
        command.args(case.assignments().into_iter().flat_map(|set| ["--set".to_string(), set]));
        command.arg("--output").arg(work.path().join("output")).arg("--summary").arg(&summary);
        let messages = std::fs::File::create(work.path().join("messages"))?;
        // The end of this program, by whatever signal, closes the pipe, and so ends the run.
        let command = command.arg("--end-with-input").stdin(Stdio::piped());
        let mut child = command.stdout(Stdio::null()).stderr(messages).spawn()?;
        let ended = self.wait(&mut child, begin, case.time_limit)?;
        let wall = begin.elapsed().as_secs_f64();
        let messages = read_end(&work.path().join("messages"));
        Ok(describe(ended, case.time_limit, read_summary(&summary), &messages, wall))
    }

    /// Waits for the end of a run; none if its time is over, and it was ended.
    fn wait(&self, child: &mut Child, begin: Instant, limit: f64) -> Result<Option<ExitStatus>, Stop> {
        // `Child::try_wait` leaves the pipe open, `Child::wait` closes it.
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            let (over, stopped) = (begin.elapsed().as_secs_f64() > limit, self.signal.has_come());
            if over || stopped {
                // Its end may have come just now: then there is nothing to kill.
                let _ = child.kill();
                child.wait()?;
                return if stopped { Err(Stop::Signal) } else { Ok(None) };
            }
            std::thread::sleep(GLANCE);
        }
    }
}

/// Whether a run ended as it should.
pub fn is_done(repetition: &Value) -> bool {
    repetition["end"] == "done"
}

/// A run that was ended for its time may end well if it now has more.
fn would_go_on(repetition: &Value, limit: f64) -> bool {
    repetition["end"] == "timed_out" && repetition["limit_s"].as_f64().is_none_or(|before| before < limit)
}

fn read_summary(path: &Path) -> Option<Value> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

/// The end of a text file.
fn read_end(path: &Path) -> String {
    let mut text = Vec::new();
    // Messages that cannot be read are not there.
    let _ = std::fs::File::open(path).and_then(|mut file| file.read_to_end(&mut text));
    let text = String::from_utf8_lossy(&text);
    let skipped = text.chars().count().saturating_sub(KEPT);
    text.chars().skip(skipped).collect()
}

/// What is kept of a run: how it ended (`done`, `failed`, `input`, `stopped`, `timed_out`, `crashed`), why, its
/// summary.
fn describe(ended: Option<ExitStatus>, limit: f64, summary: Option<Value>, messages: &str, wall: f64) -> Value {
    let told = |key: &str| summary.as_ref().and_then(|summary| summary[key].as_str()).map(str::to_owned);
    let (end, reason) = match (ended, told("status")) {
        (None, _) => ("timed_out".to_string(), Some(format!("not done within {limit} s"))),
        (Some(_), Some(status)) => (status, told("reason")),
        (Some(status), None) => {
            let last = messages.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or_default();
            ("crashed".to_string(), Some(format!("{status}: {}", last.trim())))
        }
    };
    let mut left = json!({"end": end, "wall_s": wall, "summary": summary});
    if end != "done" {
        left["reason"] = reason.into();
        left["messages"] = messages.into();
        left["limit_s"] = limit.into();
    }
    left
}

/// Tells how far a study is, and how much time it still takes.
struct Progress {
    all: usize,
    gone: usize,
    ran: usize,
    begin: Instant,
    quiet: bool,
}

impl Progress {
    fn new(all: usize, quiet: bool) -> Self {
        Self { all, gone: 0, ran: 0, begin: Instant::now(), quiet }
    }

    /// Runs that need not be made.
    fn found(&mut self, count: usize) {
        self.gone += count;
    }

    fn ran(&mut self, case: &Case, repetition: &Value, earlier: usize) {
        self.gone += 1;
        self.ran += 1;
        if self.quiet {
            return;
        }
        let left = self.begin.elapsed().as_secs_f64() / self.ran as f64 * (self.all - self.gone.min(self.all)) as f64;
        let wall = repetition["wall_s"].as_f64().unwrap_or(0.0);
        let told = match repetition["reason"].as_str() {
            Some(reason) => format!("{}: {reason}", repetition["end"].as_str().unwrap_or_default()),
            None => format!("{wall:.2} s"),
        };
        let again = if earlier > 0 { format!(" ({})", earlier + 1) } else { String::new() };
        complain!("[{}/{}] {}{again}: {told}; about {left:.0} s left", self.gone, self.all, case.name);
    }
}
