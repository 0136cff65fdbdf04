//! Mixed displacement-pressure elements: Kratos's subscales to the last digits, patch tests, Newton's
//! method, and what does not depend on Poisson's ratio. Each file names its sources.

#[path = "../common/mod.rs"]
mod common;

mod columns;
mod cook;
mod membrane;
mod memory;
mod newton;
mod patch;
mod settings;
mod study;
mod water;
mod wave;
