//! Modelers: make model parts from files, from geometries, or from nothing.

mod kratos;

use crate::registry::Registry;

/// Registers the kernel's modelers.
pub fn register(registry: &mut Registry) {
    kratos::register(registry);
}
