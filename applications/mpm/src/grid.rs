//! The background grid as loops over its cells see it.

use bia_kernel::geometry::{CellBasis, Hexahedron8, Line2, Quadrilateral4, Tetrahedron4, Triangle3};
use bia_kernel::lanes::Lanes;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::variables::Variable;

/// Name of the root part of the grid.
pub const GRID: &str = "Background_Grid";

/// Calls a function with the type of a cell's shape: `with_shape!(shape, S, D, N => expression)`.
/// Shapes that are no solid cells yield the last expression.
macro_rules! with_shape {
    ($shape:expr, |$S:ident, $D:ident, $N:ident| $body:expr, else $other:expr) => {
        match $shape {
            Shape::Line2 => {
                type $S = Line2;
                const $D: usize = 1;
                const $N: usize = 2;
                $body
            }
            Shape::Triangle3 => {
                type $S = Triangle3;
                const $D: usize = 2;
                const $N: usize = 3;
                $body
            }
            Shape::Quadrilateral4 => {
                type $S = Quadrilateral4;
                const $D: usize = 2;
                const $N: usize = 4;
                $body
            }
            Shape::Tetrahedron4 => {
                type $S = Tetrahedron4;
                const $D: usize = 3;
                const $N: usize = 4;
                $body
            }
            Shape::Hexahedron8 => {
                type $S = Hexahedron8;
                const $D: usize = 3;
                const $N: usize = 8;
                $body
            }
            _ => $other,
        }
    };
}
pub(crate) use with_shape;

/// The functions of a grid's cell.
pub trait GridCell<const D: usize, const N: usize>: CellBasis<D, N> {
    /// Those of a cell of the grid.
    fn of(grid: &ModelPart, cell: usize) -> Self;

    /// Which local coordinates lie in the cell; those that are no numbers do not.
    fn holds<const W: usize>(xi: &[Lanes<W>; D], inside: &mut [bool; W]);
}

macro_rules! grid_cell {
    ($shape:ident, $d:literal, $n:literal, $holds:ident) => {
        impl GridCell<$d, $n> for $shape {
            #[inline(always)]
            fn of(_: &ModelPart, _: usize) -> Self {
                $shape
            }

            #[inline(always)]
            fn holds<const W: usize>(xi: &[Lanes<W>; $d], inside: &mut [bool; W]) {
                $holds(xi, inside);
            }
        }
    };
}

grid_cell!(Line2, 1, 2, cube_holds);
grid_cell!(Triangle3, 2, 3, simplex_holds);
grid_cell!(Quadrilateral4, 2, 4, cube_holds);
grid_cell!(Tetrahedron4, 3, 4, simplex_holds);
grid_cell!(Hexahedron8, 3, 8, cube_holds);

#[inline(always)]
fn cube_holds<const D: usize, const W: usize>(xi: &[Lanes<W>; D], inside: &mut [bool; W]) {
    for l in 0..W {
        inside[l] = xi.iter().all(|x| x.0[l].abs() <= 1.0);
    }
}

#[inline(always)]
fn simplex_holds<const D: usize, const W: usize>(xi: &[Lanes<W>; D], inside: &mut [bool; W]) {
    for l in 0..W {
        let sum: f64 = xi.iter().map(|x| x.0[l]).sum();
        inside[l] = xi.iter().all(|x| x.0[l] >= 0.0) && sum <= 1.0;
    }
}

/// Coordinates of a cell's nodes.
#[inline]
pub fn corners<const D: usize, const N: usize>(grid: &ModelPart, nodes: &[u32]) -> [[f64; D]; N] {
    grid.nodes.gather(nodes)
}

/// Values of a cell's nodes out of a vector over the active dofs; zeros if it is empty.
#[inline]
pub fn nodal_vectors<const D: usize, const N: usize>(
    dofs: &ActiveDofs,
    nodes: &[u32],
    values: &[f64],
) -> [[f64; D]; N] {
    dofs.gather(nodes, values)
}

/// Writes a vector over the active dofs to a column of the grid; other nodes keep their values.
pub fn write_nodal(grid: &mut ModelPart, dofs: &ActiveDofs, variable: &Variable, values: &[f64]) {
    let count = grid.nodes.len();
    dofs.scatter(values, grid.node_fields.vector_mut(variable, count));
}
