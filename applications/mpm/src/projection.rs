//! The velocity of the grid that is nearest to that of the points: M v = Σ N m v_p with the
//! consistent mass, the least squares of Σ m |v_p − Σ N v|².

use crate::active::ActiveCells;
use crate::grid::nodal_vectors;
use crate::points::Block;
use crate::space::{Space, with_basis};
use bia_kernel::error::{Error, Failure};
use bia_kernel::geometry::CellBasis;
use bia_kernel::linalg::{IterativeSettings, LinearError, Method, solver};
use bia_kernel::solving::{ActiveDofs, CellBuffer, NodalFrames, System};

/// Residual, relative to the right-hand side, to which the projection is solved.
const PRECISION: f64 = 1e-14;
/// What is taken where round-off leaves no more: masses of functions of high degree in space are badly
/// conditioned.
const ENOUGH: f64 = 1e-12;
/// Iterations after which round-off is at work.
const ITERATIONS: usize = 500;

/// What the consistent mass is integrated over.
pub struct ConsistentMass<'a> {
    /// Points.
    pub blocks: &'a [Block],
    /// Cells with points.
    pub active: &'a ActiveCells,
    /// The grid's functions.
    pub space: &'a Space,
    /// Dofs.
    pub dofs: &'a ActiveDofs,
    /// Frames of nodes that slide along walls.
    pub frames: &'a NodalFrames,
}

impl ConsistentMass<'_> {
    /// A system with the pattern of the mass.
    pub fn system(&self) -> System {
        let (mut numbers, mut starts) = (Vec::new(), vec![0]);
        for &cell in &self.active.cells {
            let of_cell = self.space.nodes_of(cell as usize).iter().filter_map(|&node| self.dofs.number(node));
            numbers.extend(of_cell.map(|number| number as u32));
            starts.push(numbers.len() as u32);
        }
        System::new(self.dofs.block(), self.dofs.nodes().len(), numbers, starts)
    }

    /// Completes `velocity`, in which the fixed dofs stand and which slides along walls, by the nearest velocity of the others.
    ///
    /// # Errors
    /// The solver does not converge.
    pub fn project(&self, system: &mut System, velocity: &mut [f64]) -> Result<(), Error> {
        self.assemble(system, velocity)?;
        let missing = self.solve(system)?;
        velocity.iter_mut().zip(missing).for_each(|(v, m)| *v += m);
        Ok(())
    }

    /// The accelerations by the forces on the free dofs.
    ///
    /// # Errors
    /// The solver does not converge.
    pub fn accelerations(&self, system: &mut System, forces: &[f64]) -> Result<Vec<f64>, Error> {
        self.assemble(system, &vec![0.0; forces.len()])?;
        system.rhs.copy_from_slice(forces);
        self.solve(system)
    }

    /// M, and Σ N m (v_p − Σ N v) on the right.
    fn assemble(&self, system: &mut System, velocity: &[f64]) -> Result<(), Error> {
        system.clear(true);
        system.add_cells(true, |index, buffer| {
            let cell = self.active.cells[index] as usize;
            with_basis!(self.space, cell, |basis, D, N| {
                let known = nodal_vectors::<D, N>(self.dofs, self.space.nodes_of(cell), velocity);
                for (block, point) in self.active.points(index) {
                    add_point::<_, D, N>(&basis, &self.blocks[block as usize], point as usize, &known, buffer);
                }
            }, else ());
            Ok(())
        })
    }

    /// Conjugate gradients, which serve where the points leave part of the functions undetermined, too:
    /// that part stays zero.
    fn solve(&self, system: &mut System) -> Result<Vec<f64>, Error> {
        self.frames.turn_system(system, true);
        system.matrix.constrain(self.frames.fixed(self.dofs), &mut system.rhs);
        let settings = IterativeSettings { maximum_iterations: ITERATIONS, ..IterativeSettings::new(PRECISION) };
        let mut solution = vec![0.0; system.rhs.len()];
        let solved = solver(Method::ConjugateGradient(settings)).solve(&system.matrix, &system.rhs, &mut solution);
        self.frames.turn_back(&mut solution);
        match solved {
            Ok(_) => Ok(solution),
            Err(LinearError::NotConverged { residual, .. }) if residual <= ENOUGH => Ok(solution),
            Err(error) => {
                let what = format!("the motion of the points cannot be projected to the grid: {error}");
                Err(Failure::new(what, "more material points in each cell, or functions of a lower order").into())
            }
        }
    }
}

/// The velocity of the grid that is nearest to that of the points, whatever is held: that with which a body starts
/// at its supports. None if it cannot be found to round-off.
pub fn nearest_velocity(blocks: &[Block], active: &ActiveCells, space: &Space, dofs: &ActiveDofs) -> Option<Vec<f64>> {
    let (mut free, frames) = (dofs.clone(), NodalFrames::default());
    free.fixed_mut().fill(false);
    let mass = ConsistentMass { blocks, active, space, dofs: &free, frames: &frames };
    let mut velocity = vec![0.0; free.order()];
    let moves = blocks.iter().flat_map(|block| block.velocity.values()).any(|v| *v != 0.0);
    if moves {
        mass.project(&mut mass.system(), &mut velocity).ok()?;
    }
    Some(velocity)
}

/// M += m N_i N_j and R += m N_i (v_p − Σ N v).
fn add_point<B: CellBasis<D, N>, const D: usize, const N: usize>(
    basis: &B,
    block: &Block,
    point: usize,
    known: &[[f64; D]; N],
    buffer: &mut CellBuffer,
) {
    let functions = basis.functions(&block.local.get::<D>(point));
    let mass = block.mass.get::<1>(point)[0];
    let mut missing = block.velocity.get::<D>(point);
    for (n, known) in functions.iter().zip(known) {
        (0..D).for_each(|a| missing[a] -= n * known[a]);
    }
    for i in 0..N {
        for a in 0..D {
            buffer.vector[i * D + a] += mass * functions[i] * missing[a];
            let row = &mut buffer.matrix[((i * D + a) * D + a) * N..][..N];
            row.iter_mut().zip(&functions).for_each(|(entry, n)| *entry += mass * functions[i] * n);
        }
    }
}
