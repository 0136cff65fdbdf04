//! The application's solvers, and which settings choose which.

use crate::explicit::Explicit;
use crate::implicit::Implicit;
use crate::settings::SolverSettings;
use bia_kernel::registry::{Registry, SolverEntry};

/// Registers them.
pub fn register(registry: &mut Registry) {
    registry.solver(SolverEntry {
        types: &["static", "quasi_static", "dynamic"],
        keys: crate::settings::KEYS,
        help: "material point method, updated Lagrangian; dynamic: implicit or explicit",
        build: |parameters, _, options| {
            let settings = SolverSettings::read(parameters, &options.folder)?;
            match settings.explicit {
                Some(scheme) => Ok(Box::new(Explicit::new(settings, scheme, options.clone()))),
                None => Ok(Box::new(Implicit::new(settings, options.clone()))),
            }
        },
    });
}
