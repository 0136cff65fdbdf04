//! Signals that ask a run to stop: it finishes its step first, and leaves a checkpoint.

use crate::report;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown, register_usize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The signal that came, if any.
#[derive(Clone, Default)]
pub struct Signal(Arc<AtomicUsize>);

impl Signal {
    /// Waits for SIGINT (Ctrl-C) and SIGTERM; a second one ends the program at once.
    pub fn wait() -> Self {
        let (signal, is_second) = (Self::default(), Arc::new(AtomicBool::new(false)));
        for number in [SIGINT, SIGTERM] {
            // The order counts: the shutdown must not see what the same signal sets.
            let registered = register_conditional_shutdown(number, 128 + number, Arc::clone(&is_second))
                .and_then(|_| register(number, Arc::clone(&is_second)))
                .and_then(|_| register_usize(number, Arc::clone(&signal.0), number as usize));
            if let Err(error) = registered {
                report::complain!("warning: signal {number} cannot be waited for and ends the run at once: {error}");
            }
        }
        signal
    }

    /// Whether one has come.
    pub fn has_come(&self) -> bool {
        self.0.load(Ordering::Relaxed) != 0
    }

    /// The exit code of a program that a signal has stopped: 130 or 143.
    pub fn exit_code(&self) -> u8 {
        u8::try_from(128 + self.0.load(Ordering::Relaxed)).unwrap_or(u8::MAX)
    }
}
