//! Measurements of material points as tables in time: values of single points and conditions, fronts and heights,
//! totals.

mod condition;
mod front;
mod overfill;
mod probe;
mod totals;

use bia_kernel::registry::Registry;

/// Registers them.
pub fn register(registry: &mut Registry) {
    probe::register(registry);
    condition::register(registry);
    front::register(registry);
    totals::register(registry);
}
