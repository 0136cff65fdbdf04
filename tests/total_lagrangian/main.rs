//! The implicit and the explicit total-Lagrangian material point method with all functions of the grid, against exact
//! solutions and conservation laws. Problems A, B and C are those of Nuttall (2025).

mod bar;
#[path = "../common/mod.rs"]
mod common;
mod conservation;
mod explicit_column;
mod explicit_energy;
mod explicit_step_load;
mod functions;
mod stable_steps;
mod static_column;
mod step_load;
