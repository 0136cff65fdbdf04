//! Cell shapes, their functions and rules, and the search for the cell that holds a point.
//!
//! [`Shape`] answers by value, for set-up and output; [`CellShape`] answers by type, for hot
//! loops. Both have the same nodes, functions and reference cells. On a regular grid a
//! [`TensorBasis`] has functions of higher order; [`PlacedBasis`] is what loops over either see.

mod bins;
mod cell;
mod check;
mod inverse;
mod locate;
mod placed;
mod polynomials;
mod quadrature;
mod regular;
mod search_mesh;
mod shape;
mod table;
mod tensor;

pub use cell::{CellBasis, CellShape, Hexahedron8, Line2, Quadrilateral4, Tetrahedron4, Triangle3, adjugate, jacobian, physical_gradients};
pub use check::{CellFault, check_cells};
pub use inverse::{inverse_map, local_coordinates};
pub use locate::CellLocator;
pub use placed::{MeshCell, PlacedBasis};
pub use quadrature::{QuadraturePoint, UnevenCount, UnsupportedCount, allowed_counts, even_choices, even_rule, rule};
pub use regular::{Irregular, RegularGrid};
pub use shape::Shape;
pub use table::ShapeTable;
pub use tensor::{Family, TensorBasis, TensorCell};

#[cfg(test)]
mod testing;
