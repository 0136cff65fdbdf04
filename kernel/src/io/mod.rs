//! Files: mesh input, results for ParaView and for machines.

mod base64;
pub mod dataset;
pub mod files;
mod number;
pub mod pvd;
pub mod vtk_legacy;
pub mod vtu;
