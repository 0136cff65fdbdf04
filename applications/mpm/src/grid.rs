//! The background grid as loops over its cells see it.

use bia_kernel::lanes::turns;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::variables::Variable;

/// Name of the root part of the grid.
pub const GRID: &str = "Background_Grid";

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
