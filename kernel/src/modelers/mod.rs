//! Modelers: make model parts from files, from geometries, or from nothing.

mod body;
mod fitted;
mod gmsh;
mod kratos;
mod mapping;
mod mesh;
mod parts;
mod placement;
mod primitive;
mod reading;
mod regular_grid;
mod surface;

#[cfg(test)]
mod tests;

use crate::registry::Registry;
pub(crate) use parts::{BOX, corners};

/// Registers the kernel's modelers.
pub fn register(registry: &mut Registry) {
    kratos::register(registry);
    regular_grid::register(registry);
    body::register(registry);
    gmsh::register(registry);
}
