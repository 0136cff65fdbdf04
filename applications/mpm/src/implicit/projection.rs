//! The velocity of the grid that is nearest to that of the points: M v = Σ N m v_p with the
//! consistent mass, the least squares of Σ m |v_p − Σ N v|².

use crate::active::ActiveCells;
use crate::grid::nodal_vectors;
use crate::points::Block;
use crate::space::{Space, with_basis};
use bia_kernel::error::{Error, Failure};
use bia_kernel::geometry::CellBasis;
use bia_kernel::linalg::{IterativeSettings, Method, solver};
use bia_kernel::solving::{ActiveDofs, CellBuffer, System};

/// Residual, relative to the right-hand side, to which the projection is solved.
const PRECISION: f64 = 1e-14;

/// Completes `velocity`, in which the fixed dofs stand, by the nearest velocity of the others.
///
/// Conjugate gradients, which serve where the points leave part of the functions undetermined, too:
/// that part stays zero.
///
/// # Errors
/// The solver does not converge.
pub fn project(
    blocks: &[Block],
    active: &ActiveCells,
    space: &Space,
    dofs: &ActiveDofs,
    system: &mut System,
    velocity: &mut [f64],
) -> Result<(), Error> {
    system.clear(true);
    let given = &*velocity;
    system.add_cells(true, |index, buffer| {
        let cell = active.cells[index] as usize;
        with_basis!(space, cell, |basis, D, N| {
            let held = nodal_vectors::<D, N>(dofs, space.nodes_of(cell), given);
            for &(block, point) in active.points(index) {
                add_point::<_, D, N>(&basis, &blocks[block as usize], point as usize, &held, buffer);
            }
        }, else ());
        Ok::<(), Error>(())
    })?;
    system.matrix.constrain(dofs.fixed(), &mut system.rhs);
    let settings = IterativeSettings { maximum_iterations: 10_000, ..IterativeSettings::new(PRECISION) };
    let mut missing = vec![0.0; velocity.len()];
    let solved = solver(Method::ConjugateGradient(settings)).solve(&system.matrix, &system.rhs, &mut missing);
    solved.map_err(|error| {
        let what = format!("the velocity of the points cannot be projected to the grid: {error}");
        Failure::new(what, "more material points in each cell, or functions of a lower order")
    })?;
    velocity.iter_mut().zip(missing).for_each(|(v, m)| *v += m);
    Ok(())
}

/// M += m N_i N_j and R += m N_i (v_p − Σ N v).
fn add_point<B: CellBasis<D, N>, const D: usize, const N: usize>(
    basis: &B,
    block: &Block,
    point: usize,
    held: &[[f64; D]; N],
    buffer: &mut CellBuffer,
) {
    let functions = basis.functions(&block.local.get::<D>(point));
    let mass = block.mass.get::<1>(point)[0];
    let mut missing = block.velocity.get::<D>(point);
    for (n, held) in functions.iter().zip(held) {
        (0..D).for_each(|a| missing[a] -= n * held[a]);
    }
    for i in 0..N {
        for a in 0..D {
            buffer.vector[i * D + a] += mass * functions[i] * missing[a];
            let row = &mut buffer.matrix[((i * D + a) * D + a) * N..][..N];
            row.iter_mut().zip(&functions).for_each(|(entry, n)| *entry += mass * functions[i] * n);
        }
    }
}
