//! The material point method: points carry mass, velocity, deformation and history; a background
//! grid solves each step and is reset.
//!
//! Sulsky, Chen & Schreyer 1994; implicit form after Iaconeta, Larese, Rossi & Oñate 2017.

mod implicit;
mod materials;
mod names;
pub mod points;
mod processes;
mod record;
mod settings;
pub mod variables;

use bia_kernel::registry::Registry;

/// Registers the application's components: one line each.
pub fn register(registry: &mut Registry) {
    variables::register(registry);
    names::register(registry);
    *registry.catalogue_mut() = bia_constitutive::catalogue();
    implicit::register(registry);
    processes::register(registry);
}
