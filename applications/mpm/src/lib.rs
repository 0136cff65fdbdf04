//! MPM.
