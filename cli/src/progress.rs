//! Progress: a bar on a terminal, plain lines in a log.

use crate::report;
use crate::signal::Signal;
use bia_kernel::analysis::Observer;
use bia_kernel::processes::Clock;
use bia_kernel::solving::StepReport;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// A log gets a line at most this often.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Shows how a run goes on.
pub struct Progress {
    mode: Mode,
    begin: Instant,
    last: Instant,
    iterations: usize,
    signal: Signal,
}

enum Mode {
    Silent,
    Lines,
    Bar(Option<ProgressBar>),
}

impl Progress {
    /// A bar if standard error is a terminal, else lines; nothing if `quiet`.
    pub fn new(quiet: bool, signal: Signal) -> Self {
        let mode = match (quiet, std::io::stderr().is_terminal()) {
            (true, _) => Mode::Silent,
            (false, true) => Mode::Bar(None),
            (false, false) => Mode::Lines,
        };
        Self { mode, begin: Instant::now(), last: Instant::now(), iterations: 0, signal }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Mode::Bar(Some(bar)) = &self.mode {
            bar.finish_and_clear();
        }
    }
}

fn bar(planned: Option<usize>) -> ProgressBar {
    let (bar, template) = match planned {
        Some(steps) => (ProgressBar::new(steps as u64), "{bar:24} {pos}/{len} {msg} {per_sec} left {eta}"),
        None => (ProgressBar::no_length(), "{spinner} step {pos} {msg} {per_sec}"),
    };
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl Observer for Progress {
    fn wants_to_stop(&self) -> bool {
        self.signal.has_come()
    }

    fn step(&mut self, clock: &Clock, planned: Option<usize>, report: &StepReport) {
        self.iterations += report.iterations;
        let text = format!("t {:.6e} s  dt {:.2e} s  iterations {}", clock.time, clock.time_step, report.iterations);
        match &mut self.mode {
            Mode::Silent => {}
            Mode::Bar(shown) => {
                let bar = shown.get_or_insert_with(|| bar(planned));
                bar.set_position(clock.step as u64);
                bar.set_message(text);
            }
            Mode::Lines => {
                if self.last.elapsed() >= LINE_EVERY {
                    self.last = Instant::now();
                    let rate = clock.step as f64 / self.begin.elapsed().as_secs_f64();
                    let left = planned.map_or(String::new(), |n| {
                        format!("  left {:.0} s", n.saturating_sub(clock.step) as f64 / rate)
                    });
                    let of = planned.map_or(String::new(), |n| format!("/{n}"));
                    report::complain!("step {}{of}  {text}  {rate:.1} steps/s{left}", clock.step);
                }
            }
        }
    }
}
