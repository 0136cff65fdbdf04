//! Errors against reference solutions, studies and surveys: whole runs of the built program.

#[path = "../common/mod.rs"]
mod common;

mod references;
mod studies;
mod surveys;
mod trial;
