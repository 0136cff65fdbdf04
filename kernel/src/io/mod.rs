//! Files: mesh input, results for ParaView and for machines.

pub mod mdpa;
