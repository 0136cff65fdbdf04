//! Whole runs of the discontinuous-Galerkin material point method against analytic values and
//! independent references.
#![cfg(feature = "dgmpm")]

#[path = "../common/mod.rs"]
mod common;

mod bar;
mod bodies;
mod conservation;
mod failures;
mod kirchhoff_bar;
mod plate;
mod scene;
