//! The material point method: points carry mass, velocity, deformation and history; a background
//! grid solves each step and is reset.
//!
//! Sulsky, Chen & Schreyer 1994; implicit form after Iaconeta, Larese, Rossi & Oñate 2017.

mod active;
mod energy;
mod explicit;
mod grid;
mod implicit;
mod inventory;
mod loads;
mod names;
pub mod points;
mod processes;
mod projection;
mod record;
mod room;
mod scene;
mod settings;
mod solvers;
mod space;
pub mod variables;

use bia_kernel::registry::Registry;

/// Registers the application's components: one line each.
pub fn register(registry: &mut Registry) {
    variables::register(registry);
    names::register(registry);
    registry.body_mesh("Initial_MPM_Material", "MPMUpdatedLagrangian");
    bia_constitutive::register(registry);
    solvers::register(registry);
    processes::register(registry);
}
