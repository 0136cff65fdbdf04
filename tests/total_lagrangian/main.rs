//! The implicit total-Lagrangian material point method with all functions of the grid, against exact
//! solutions and conservation laws. Problems A, B and C are those of Nuttall (2025).

mod bar;
#[path = "../common/mod.rs"]
mod common;
mod conservation;
mod functions;
mod static_column;
mod step_load;
