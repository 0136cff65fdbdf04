//! Material points, their blocks, and the conditions that move with them.

mod block;
pub mod carriers;
pub mod conditions;
mod exchange;
pub mod fields;
mod generate;
mod layout;
pub mod lost;
pub mod measures;
mod read;
#[cfg(test)]
mod tests;

pub use block::{
    Block, Columns, MaterialPoints, Scratch, Selection, compress, describe_deformation, expand, gradient_width,
    law_failure,
};
pub use generate::{Plan, across, generate};
