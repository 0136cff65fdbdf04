//! The implicit material point method against exact solutions, conservation laws and orders of
//! convergence. Each file names its sources.

#[path = "../common/mod.rs"]
mod common;

mod conservation;
mod faces;
mod free_fall;
mod initial_deformation;
mod manufactured;
mod modes;
mod patch;
mod reactions;
mod slip;
mod supports;
mod vibrating_bar;
