//! The application's solvers, and which settings choose which.

use crate::explicit::Explicit;
use crate::implicit::Implicit;
use crate::points::fields::{CONDITION_VARIABLES, names_of};
use crate::scene::{NODAL_VARIABLES, PRESSURE_VARIABLES};
use crate::settings::SolverSettings;
use bia_kernel::processes::Location;
use bia_kernel::registry::{Provider, Registry, SolverEntry};

/// Registers them.
pub fn register(registry: &mut Registry) {
    const POINTS: &str = "the material point method";
    const MIXED: &str = "the material point method with \"pressure_dofs\": true";
    for (who, location, variables) in [
        (POINTS, Location::Points, (|| names_of(false)) as fn() -> Vec<&'static str>),
        (MIXED, Location::Points, || names_of(true)),
        (POINTS, Location::PointConditions, || CONDITION_VARIABLES.to_vec()),
        (POINTS, Location::Nodes, || NODAL_VARIABLES.to_vec()),
        (MIXED, Location::Nodes, || PRESSURE_VARIABLES.to_vec()),
    ] {
        registry.provider(Provider { who, location, variables });
    }
    registry.solver(SolverEntry {
        types: &["static", "quasi_static", "dynamic"],
        keys: crate::settings::KEYS,
        help: "material point method, updated Lagrangian; dynamic: implicit or explicit",
        build: |parameters, _, options| {
            let settings = SolverSettings::read(parameters, options)?;
            match settings.explicit {
                Some(scheme) => Ok(Box::new(Explicit::new(settings, scheme, options.clone()))),
                None => Ok(Box::new(Implicit::new(settings, options.clone()))),
            }
        },
    });
}
