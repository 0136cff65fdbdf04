//! Cell shapes, their functions and rules, and the search for the cell that holds a point.

mod shape;

pub use shape::Shape;
