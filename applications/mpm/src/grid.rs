//! The background grid as loops over its cells see it.

use bia_kernel::lanes::turns;
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

/// Numbers of a cell's functions among the active ones; all functions of an active cell have one.
#[inline(always)]
pub fn numbers<const N: usize>(dofs: &ActiveDofs, nodes: &[u32]) -> [usize; N] {
    let mut numbers = [0; N];
    for (number, &node) in numbers.iter_mut().zip(nodes) {
        *number = dofs.number(node).unwrap_or(0);
    }
    numbers
}

/// Values of functions by their numbers out of a vector over the active dofs; zeros if it is empty.
#[inline(always)]
pub fn vectors_of<const D: usize, const N: usize>(numbers: &[usize; N], values: &[f64]) -> [[f64; D]; N] {
    let mut vectors = [[0.0; D]; N];
    if !values.is_empty() {
        for i in 0..turns::<N>() {
            vectors[i].copy_from_slice(&values[numbers[i] * D..(numbers[i] + 1) * D]);
        }
    }
    vectors
}

/// Values of a cell's functions out of a vector over the active dofs; zeros if it is empty.
#[inline(always)]
pub fn nodal_vectors<const D: usize, const N: usize>(
    dofs: &ActiveDofs,
    nodes: &[u32],
    values: &[f64],
) -> [[f64; D]; N] {
    vectors_of(&numbers(dofs, nodes), values)
}

/// Writes a vector over the active dofs to a column of the grid; other nodes keep their values.
pub fn write_nodal(grid: &mut ModelPart, dofs: &ActiveDofs, variable: &Variable, values: &[f64]) {
    let count = grid.nodes.len();
    dofs.scatter(values, grid.node_fields.vector_mut(variable, count));
}
