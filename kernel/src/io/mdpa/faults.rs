//! The faults of a mesh file: the first ones in full, the rest as a number.

use super::words::Word;
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use std::path::Path;

/// How many faults are shown.
const SHOWN: usize = 20;

/// Collects faults; a description is only made when it will be shown.
#[derive(Debug)]
pub(super) struct Faults<'a> {
    path: &'a Path,
    text: &'a str,
    shown: Vec<Diagnostic>,
    more: usize,
}

impl<'a> Faults<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, text, shown: Vec::new(), more: 0 }
    }

    /// A fault at a word.
    pub fn word(&mut self, word: Word<'_>, describe: impl FnOnce(Diagnostic) -> Diagnostic) {
        let before = self.text.get(..word.start).unwrap_or_default();
        let column = before.chars().rev().take_while(|&letter| letter != '\n').count() + 1;
        self.add(word.line, Some(column), describe);
    }

    /// A fault of a whole line.
    pub fn line(&mut self, line: u32, describe: impl FnOnce(Diagnostic) -> Diagnostic) {
        self.add(line, None, describe);
    }

    fn add(&mut self, line: u32, column: Option<usize>, describe: impl FnOnce(Diagnostic) -> Diagnostic) {
        if self.shown.len() == SHOWN {
            self.more += 1;
            return;
        }
        let place = Place { column, ..Place::line(self.path, line as usize) };
        self.shown.push(describe(Diagnostic::error(place, "")));
    }

    /// All faults, by line.
    pub fn into_errors(mut self) -> InputErrors {
        self.shown.sort_by_key(|diagnostic| (diagnostic.place.line, diagnostic.place.column));
        if self.more > 0 {
            let message = format!("and {} more errors", self.more);
            self.shown.push(Diagnostic::error(Place::file(self.path), message));
        }
        InputErrors(self.shown)
    }
}

/// Fills in the message of a diagnostic that already has its place.
pub(super) trait Says {
    fn says(self, message: impl Into<String>) -> Self;
}

impl Says for Diagnostic {
    fn says(mut self, message: impl Into<String>) -> Self {
        self.message = message.into();
        self
    }
}
