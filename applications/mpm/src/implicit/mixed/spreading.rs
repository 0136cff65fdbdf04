//! Where points of a fluid have gathered they are moved apart.
//!
//! Rows of pressure keep the volume of points as it is and do not see how much of it lies where: over many
//! steps points gather where the pressure is high, the denser fluid sinks, and its surface falls. With the
//! room of a node R_i = ∫ N_i dx over the grid and the volume there V_i = Σ N_i V_p, the excess
//! e_i = V_i − (1 + slack) R_i, where it is positive, is spread in steps: positions, but not velocities,
//! take the displacement δ of K (δ, q) = (0, c e), K the tangent of the step (compare Kugelstadt et al.
//! 2019, "Implicit density projection for volume conserving liquids"). A node that is full has no excess,
//! nor has one near a surface. Lifting what has sunk takes work: the energy may rise by it.

use super::MixedProblem;
use super::gather::PressureSums;
use bia_kernel::error::Error;
use bia_kernel::solving::{ActiveDofs, NonlinearSystem, System};

/// Share of its room by which a node may be overfull: points leave as much to chance in full cells.
const SLACK: f64 = 0.05;

/// What is too much at each active node (m³).
pub fn excess(room: &[f64], sums: &PressureSums, dofs: &ActiveDofs) -> Vec<f64> {
    let of_node = |(number, &node): (usize, &u32)| {
        let (area, volume) = (sums.area[number], sums.volume[number]);
        let excess = area - (1.0 + SLACK) * room[node as usize];
        if excess > 0.0 { excess * (volume / area) } else { 0.0 }
    };
    dofs.nodes().iter().enumerate().map(of_node).collect()
}

/// The displacement that takes the excess out, as one linear solve.
pub struct Spreading<'a, 'b> {
    /// The step, solved.
    pub problem: &'a mut MixedProblem<'b>,
    /// Volume to make at each node.
    pub excess: Vec<f64>,
    /// Displacement and pressure, node by node.
    pub solution: Vec<f64>,
}

impl NonlinearSystem for Spreading<'_, '_> {
    fn dofs(&self) -> &ActiveDofs {
        self.problem.dofs
    }

    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
        self.problem.assemble(system, with_matrix)?;
        let block = self.problem.dofs.block();
        system.rhs.fill(0.0);
        for (rhs, excess) in system.rhs.chunks_exact_mut(block).zip(&self.excess) {
            rhs[block - 1] = *excess;
        }
        Ok(())
    }

    fn correct(&mut self, correction: &[f64]) {
        self.solution = correction.to_vec();
    }

    fn unknowns(&self) -> &[f64] {
        &self.solution
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        self.problem.describe_dof(dof)
    }
}
