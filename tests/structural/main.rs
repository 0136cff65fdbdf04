//! Whole runs of the finite elements of bia-structural against analytic values and independent
//! references.
#![cfg(feature = "structural")]

#[path = "../common/mod.rs"]
mod common;

mod bar;
mod body;
mod column;
mod cook;
mod failures;
mod loads;
mod manufactured;
mod patch;
mod plate;
