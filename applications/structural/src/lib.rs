//! Finite elements of solids at large deformation on the mesh of the body itself: total Lagrangian,
//! static or dynamic, implicit or explicit, with the laws of `bia-constitutive`.
//!
//! Source of the formulation: Belytschko, Liu, Moran & Elkhodary, Nonlinear Finite Elements for
//! Continua and Structures, chapters 4 and 6.

mod advance;
mod body;
mod element;
mod exchange;
mod names;
mod problem;
mod results;
mod settings;
mod solver;
mod stability;
pub mod variables;

use bia_kernel::processes::Location;
use bia_kernel::registry::{Provider, Registry, SolverEntry};
use bia_kernel::variables::names_of;

/// Registers the application's components: one line each.
pub fn register(registry: &mut Registry) {
    variables::register(registry);
    names::register(registry);
    bia_constitutive::register(registry);
    const WHO: &str = "structural solvers";
    for (location, variables) in [
        (Location::Nodes, (|| names_of(results::NODAL)) as fn() -> Vec<&'static str>),
        (Location::Elements, || names_of(results::ELEMENTAL)),
    ] {
        registry.provider(Provider { who: WHO, location, variables });
    }
    registry.solver(SolverEntry {
        types: &["structural_static", "structural_dynamic"],
        keys: settings::KEYS,
        help: "total-Lagrangian finite elements; dynamic: implicit or explicit",
        build: |parameters, _, options| {
            let settings = settings::SolverSettings::read(parameters, options)?;
            Ok(Box::new(solver::Structural::new(settings)))
        },
    });
}
