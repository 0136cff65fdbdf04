//! Solving: time schemes, the dofs of active nodes, assembly, Newton's method and its criteria.
//!
//! Applications describe a nonlinear system ([`newton::NonlinearSystem`]); everything here is
//! free of physics.

pub mod assembly;
pub mod criteria;
pub mod dofs;
pub mod frames;
mod lead;
pub mod linear;
pub mod loads;
pub mod mesh;
pub mod newton;
pub mod ordered;
pub mod scheme;
pub mod solver;
pub mod stepping;

pub use assembly::{CellBuffer, System};
pub use criteria::{Criterion, Field, Reference, References, Tolerances};
pub use dofs::ActiveDofs;
pub use frames::NodalFrames;
pub use lead::imposed;
pub use mesh::MeshSource;
pub use newton::{Newton, NonlinearSystem, StepReport};
pub use scheme::Newmark;
pub use stepping::Stepping;
