//! Block-sparse linear algebra.
