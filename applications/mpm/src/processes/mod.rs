//! Processes of the material point method.

mod acceleration;
mod body_acceleration;
mod energy;
mod extrapolate;
mod initial_deformation;
mod json;
mod measure;
mod neumann;
mod slip;
mod vtk;

use bia_kernel::registry::Registry;

/// Registers them.
pub fn register(registry: &mut Registry) {
    acceleration::register(registry);
    body_acceleration::register(registry);
    initial_deformation::register(registry);
    neumann::register(registry);
    slip::register(registry);
    energy::register(registry);
    extrapolate::register(registry);
    json::register(registry);
    measure::register(registry);
    vtk::register(registry);
}
