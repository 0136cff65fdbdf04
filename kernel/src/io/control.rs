//! When an output process prints.

use crate::io::checkpoint::{Archive, CheckpointError};
use crate::parameters::Settings;
use crate::processes::Clock;
use std::time::Instant;

/// Counts steps or time, as Kratos's output controller does: output `k` is due once the step (or
/// time) has reached `k` intervals. The time may be that of the clock on the wall, since the start of the
/// program or since it went on.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputControl {
    by_time: bool,
    /// When the run began, for outputs by the time on the wall.
    wall: Option<Instant>,
    interval: f64,
    next: f64,
}

impl OutputControl {
    /// From `output_control_type` ("step", "time" or "wall_time") and `output_interval`.
    pub fn read(settings: &Settings) -> Self {
        let kind = settings.text("output_control_type");
        let is_wall = kind == "wall_time";
        let control = Self::new(kind == "time" || is_wall, settings.number("output_interval"));
        Self { by_time: kind == "time", wall: is_wall.then(Instant::now), ..control }
    }

    /// Every `interval` steps or seconds; a part of a step is left out, as in Kratos.
    pub fn new(by_time: bool, interval: f64) -> Self {
        let interval = if by_time { interval } else { interval.trunc() };
        Self { by_time, wall: None, interval, next: interval }
    }

    /// True when the label of files counts time.
    pub fn by_time(&self) -> bool {
        self.by_time
    }

    fn now(&self, clock: &Clock) -> f64 {
        match &self.wall {
            Some(begin) => begin.elapsed().as_secs_f64(),
            None if self.by_time => clock.time,
            None => clock.step as f64,
        }
    }

    /// Whether output is due.
    pub fn is_due(&self, clock: &Clock) -> bool {
        // Times are accumulated sums: a part in 1e12 of slack keeps 10 steps of 0.1 from missing 1.0.
        self.now(clock) >= self.next - 1e-12 * self.next.abs()
    }

    /// Saves or loads when output is due next.
    ///
    /// # Errors
    /// The checkpoint does not hold it.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut next = self.next;
        archive.number("next output", &mut next)?;
        // The clock on the wall begins again.
        if self.wall.is_none() {
            self.next = next;
        }
        Ok(())
    }

    /// Tells that output was printed now.
    pub fn printed(&mut self, clock: &Clock) {
        if self.interval > 0.0 {
            let now = self.now(clock);
            let passed = ((now - self.next) / self.interval + 1e-9).floor().max(0.0) + 1.0;
            self.next += passed * self.interval;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(by_time: bool, interval: f64, time_step: f64) -> Vec<usize> {
        let mut control = OutputControl::new(by_time, interval);
        let mut clock = Clock::default();
        let mut steps = Vec::new();
        for step in 1..=10 {
            clock.step = step;
            clock.time += time_step;
            if control.is_due(&clock) {
                control.printed(&clock);
                steps.push(step);
            }
        }
        steps
    }

    /// An hour does not pass in this test, no time at all always has.
    #[test]
    fn outputs_by_the_time_on_the_wall() {
        for (interval, expected) in [(3600.0, 0), (0.0, 10)] {
            let mut control = OutputControl { wall: Some(Instant::now()), ..OutputControl::new(true, interval) };
            let clock = Clock { step: 1, time: 1e9, ..Clock::default() };
            let due = (0..10).filter(|_| {
                let due = control.is_due(&clock);
                control.printed(&clock);
                due
            });
            assert_eq!(due.count(), expected);
        }
        let earlier = Instant::now().checked_sub(std::time::Duration::from_secs(90));
        let mut control = OutputControl { wall: earlier, ..OutputControl::new(true, 60.0) };
        assert!(control.is_due(&Clock::default()));
        control.printed(&Clock::default());
        assert!(!control.is_due(&Clock::default()), "the second one comes after 120 s");
    }

    #[test]
    fn outputs_come_at_whole_intervals() {
        assert_eq!(printed(false, 4.0, 0.1), [4, 8]);
        assert_eq!(printed(false, 2.5, 0.1), [2, 4, 6, 8, 10], "as Kratos 10.4.4");
        assert_eq!(printed(true, 0.2, 0.1), [2, 4, 6, 8, 10]);
        assert_eq!(printed(true, 0.25, 0.1), [3, 5, 8, 10]);
        assert_eq!(printed(true, 0.05, 0.1), (1..=10).collect::<Vec<_>>(), "never more than once a step");
        assert_eq!(printed(true, 0.0, 0.1).len(), 10);
    }
}
