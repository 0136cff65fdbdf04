//! One step as a nonlinear system: residual and tangent over the active nodes.

use super::element::{CellState, CellTask, Integrator, Rule};
use super::kratos_faults::KratosFaults;
use super::transfer::NodalSums;
use crate::active::ActiveCells;
use crate::grid::nodal_vectors;
use crate::loads::Loads;
use crate::points::MaterialPoints;
use crate::settings::Frame;
use crate::space::{Space, with_basis};
use bia_kernel::error::{Error, Failure};
use bia_kernel::lanes::dispatch;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::scheme::Coefficients;
use bia_kernel::solving::{ActiveDofs, CellBuffer, NonlinearSystem, System};

/// Inertia of a dynamic step.
pub struct Inertia {
    /// Newmark's coefficients.
    pub coefficients: Coefficients,
    /// Bossak's alpha.
    pub alpha: f64,
    /// Consistent instead of lumped mass.
    pub consistent: bool,
    /// Velocity at the start of the step, entry `number * D + component`.
    pub velocity: Vec<f64>,
    /// Acceleration at the start of the step.
    pub acceleration: Vec<f64>,
}

impl Inertia {
    /// The acceleration that the scheme weighs with the mass: (1 - alpha) a + alpha a0.
    fn weighted(&self, increments: &[f64]) -> Vec<f64> {
        let both = self.velocity.iter().zip(&self.acceleration);
        let at = |(u, (v0, a0)): (&f64, (&f64, &f64))| {
            (1.0 - self.alpha) * self.coefficients.acceleration(*u, *v0, *a0) + self.alpha * a0
        };
        increments.iter().zip(both).map(at).collect()
    }

    /// The acceleration at the end of the step.
    pub fn final_acceleration(&self, increments: &[f64]) -> Vec<f64> {
        let both = self.velocity.iter().zip(&self.acceleration);
        increments.iter().zip(both).map(|(u, (v, a))| self.coefficients.acceleration(*u, *v, *a)).collect()
    }

    /// The velocity at the end of the step.
    pub fn final_velocity(&self, increments: &[f64]) -> Vec<f64> {
        let both = self.velocity.iter().zip(&self.acceleration);
        increments.iter().zip(both).map(|(u, (v, a))| self.coefficients.velocity(*u, *v, *a)).collect()
    }
}

/// The step.
pub struct Problem<'a> {
    /// The grid.
    pub grid: &'a ModelPart,
    /// Its functions.
    pub space: &'a Space,
    /// Where they are evaluated.
    pub frame: Frame,
    /// Where in the step the internal forces are taken.
    pub rule: Rule,
    /// The points.
    pub points: &'a MaterialPoints,
    /// Cells with points.
    pub active: &'a ActiveCells,
    /// Dofs.
    pub dofs: &'a ActiveDofs,
    /// Nodal mass.
    pub sums: &'a NodalSums,
    /// Inertia, in dynamics.
    pub inertia: Option<&'a Inertia>,
    /// Time step in seconds.
    pub time_step: f64,
    /// Which of Kratos's faults act.
    pub faults: KratosFaults,
    /// Instruction set.
    pub arch: pulp::Arch,
    /// The unknowns.
    pub increments: Vec<f64>,
    /// The unknowns at the last assembly.
    pub assembled: Vec<f64>,
}

impl Problem<'_> {
    fn compute(
        &self,
        integrator: &Integrator,
        weighted: &[f64],
        index: usize,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let cell = self.active.cells[index] as usize;
        let nodes = self.space.nodes_of(cell);
        with_basis!(self.space, cell, |basis, D, N| {
            let state = CellState::<D, N> {
                increments: nodal_vectors(self.dofs, nodes, &self.increments),
                inertia: nodal_vectors(self.dofs, nodes, weighted),
            };
            let points: Vec<(u32, u32)> = self.active.points(index).collect();
            let task = CellTask::<_, D, N> { integrator, state: &state, points: &points, buffer, with_matrix, basis };
            dispatch(self.arch, task)
        }, else Ok(()))
    }
}

impl NonlinearSystem for Problem<'_> {
    fn dofs(&self) -> &ActiveDofs {
        self.dofs
    }

    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
        self.assembled.clone_from(&self.increments);
        system.clear(with_matrix);
        let weighted = self.inertia.map_or(Vec::new(), |inertia| inertia.weighted(&self.increments));
        let factor = |inertia: &Inertia| (1.0 - inertia.alpha) * inertia.coefficients.c0;
        let consistent = self.inertia.filter(|inertia| inertia.consistent);
        let integrator = Integrator {
            blocks: &self.points.blocks,
            kinematics: self.points.kinematics,
            frame: self.frame,
            rule: self.rule,
            time_step: self.time_step,
            faults: self.faults,
            consistent_mass: consistent.map(factor),
        };
        let this = &*self;
        system.add_cells(with_matrix, |index, buffer| {
            this.compute(&integrator, if consistent.is_some() { &weighted } else { &[] }, index, buffer, with_matrix)
        })?;
        if let Some(inertia) = self.inertia.filter(|inertia| !inertia.consistent) {
            let block = self.dofs.block();
            for (dof, acceleration) in weighted.iter().enumerate() {
                let mass = self.sums.mass[dof / block];
                system.rhs[dof] -= mass * acceleration;
                if with_matrix {
                    system.add_diagonal(dof, factor(inertia) * mass);
                }
            }
        }
        let axisymmetric = self.points.kinematics == bia_constitutive::Kinematics::Axisymmetric;
        let loads = Loads { grid: self.grid, space: self.space, conditions: &self.points.conditions, axisymmetric };
        loads.add(self.dofs, &self.increments, &mut system.rhs);
        Ok(())
    }

    fn correct(&mut self, correction: &[f64]) {
        self.increments.iter_mut().zip(correction).for_each(|(u, d)| *u += d);
    }

    fn unknowns(&self) -> &[f64] {
        &self.increments
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        let (node, component) = self.dofs.node_of(dof);
        let axis = ["X", "Y", "Z"][component];
        let name = format!("DISPLACEMENT_{axis} of {}", self.space.describe(self.grid, node));
        (name, self.space.position(node as usize))
    }
}
