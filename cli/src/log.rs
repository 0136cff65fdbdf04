//! The log of a run: to standard error as it comes, and its warnings kept for the summary.

use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// Warnings that are kept; a run says most of them once.
const MOST: usize = 100;

/// The warnings of a run so far, also of a quiet one.
#[derive(Clone, Default)]
pub struct Warnings(Arc<Mutex<Vec<String>>>);

impl Warnings {
    /// The first hundred.
    pub fn told(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl<S: Subscriber> Layer<S> for Warnings {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() != Level::WARN {
            return;
        }
        let mut message = Message::default();
        event.record(&mut message);
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if told.len() < MOST {
            told.push(message.0);
        }
    }
}

#[derive(Default)]
struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}

/// Sends the log to standard error; gives the warnings in it.
pub fn start(quiet: bool) -> Warnings {
    let warnings = Warnings::default();
    let shown = if quiet { LevelFilter::ERROR } else { LevelFilter::INFO };
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_target(false)
        .without_time()
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal())
        .with_filter(shown);
    let kept = warnings.clone().with_filter(LevelFilter::WARN);
    let _ = tracing_subscriber::registry().with(lines).with(kept).try_init();
    warnings
}
