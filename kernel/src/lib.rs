//! The kernel of Bia: what every application needs and no application owns.
//!
//! Data flows one way: JSON → [`parameters`] → [`model`] → an application's solver → [`io`].
//! The kernel knows no physics and names no application; applications hand it components
//! (modelers, processes, solvers) through the [`registry`].

pub mod analysis;
pub mod diagnostic;
pub mod error;
pub mod expression;
pub mod geometry;
pub mod io;
pub mod lanes;
pub mod model;
pub mod modelers;
pub mod parameters;
pub mod processes;
pub mod reference;
pub mod registry;
pub mod solving;
pub mod variables;

pub use bia_linalg as linalg;
pub use error::{Error, Failure};
