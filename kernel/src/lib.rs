//! The kernel of Bia: what every application needs and no application owns.
//!
//! Data flows one way: JSON → [`parameters`] → [`model`] → an application's solver → [`io`].
//! The kernel knows no physics and names no application; applications hand it components
//! (modelers, processes, solvers) through the [`registry`].

pub mod diagnostic;
pub mod expression;
pub mod geometry;
pub mod io;
pub mod model;
