//! The discontinuous-Galerkin material point method for impact: fields of their own in each cell, Riemann
//! problems at the faces between them, total Lagrangian, in one, two and three dimensions.
//!
//! Conserved are the velocity and the displacement gradient of the points, by mass. A step: points →
//! nodes of each cell → stresses and Riemann problems → nodes → points, whose velocity and deformation
//! are those of the nodes (PIC). Steps, operators and layouts: `scheme`, `chunk`, `kind`, `stages`.
//!
//! Source: Renaud and Heuzé, A Discontinuous Galerkin Material Point Method for the simulation of impact
//! problems in solid mechanics, COMPDYN 2017.

mod body;
mod boundary;
mod chunk;
mod engine;
mod exact;
mod exchange;
mod faces;
mod fields;
mod kind;
mod layout;
mod material;
mod matrix;
mod names;
mod processes;
mod results;
mod riemann;
mod scheme;
mod settings;
mod solver;
mod stability;
mod stages;
mod transverse;
pub mod variables;

use bia_kernel::processes::Location;
use bia_kernel::registry::{Provider, Registry, SolverEntry};
use bia_kernel::variables::names_of;

/// Registers the application's components: one line each.
pub fn register(registry: &mut Registry) {
    variables::register(registry);
    names::register(registry);
    bia_constitutive::register(registry);
    processes::register(registry);
    const WHO: &str = "the solver dgmpm";
    for (location, variables) in [
        (Location::Points, (|| names_of(&[fields::OF_POINTS, fields::DERIVED].concat())) as fn() -> Vec<&'static str>),
        (Location::Elements, || names_of(fields::OF_CELLS)),
        (Location::Nodes, || names_of(fields::OF_NODES)),
    ] {
        registry.provider(Provider { who: WHO, location, variables });
    }
    registry.solver(SolverEntry {
        types: &["dgmpm"],
        keys: settings::KEYS,
        help: "discontinuous-Galerkin material point method with Riemann solvers, for impact",
        build: |parameters, _, options| {
            let settings = settings::SolverSettings::read(parameters, &options.folder)?;
            Ok(Box::new(solver::DiscontinuousGalerkin::new(settings)))
        },
    });
}
