//! Files: mesh input, results for ParaView and for machines.

mod base64;
pub mod checkpoint;
pub mod control;
pub mod convert;
pub mod dataset;
pub mod files;
pub mod gmsh;
pub mod history;
pub mod json;
pub mod mdpa;
mod number;
pub mod pvd;
pub mod stl;
pub mod table;
pub mod vtk_legacy;
pub mod vtu;
pub mod vtu_read;
