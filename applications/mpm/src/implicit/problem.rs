//! One step as a nonlinear system: residual and tangent over the active nodes.

use super::element::{CellState, CellTask, Integrator, Rule};
use super::kratos_faults::KratosFaults;
use super::midpoint::SAME;
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
use bia_kernel::solving::newton::ROUND_OFF;
use bia_kernel::solving::scheme::Coefficients;
use bia_kernel::solving::{ActiveDofs, CellBuffer, NonlinearSystem, System, imposed};

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
    /// (1 - alpha) c0, what the mass is multiplied by in the tangent.
    pub fn stiffness(&self) -> f64 {
        (1.0 - self.alpha) * self.coefficients.c0
    }

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
    /// The acceleration that the scheme weighs with the mass; empty without inertia.
    pub fn weighted(&self) -> Vec<f64> {
        self.inertia.map_or(Vec::new(), |inertia| inertia.weighted(&self.increments))
    }

    /// The part of it that cells integrate: all with a consistent mass, else nothing.
    pub fn of_cells<'b>(&self, weighted: &'b [f64]) -> &'b [f64] {
        if self.inertia.is_some_and(|inertia| inertia.consistent) { weighted } else { &[] }
    }

    /// What all cells share.
    pub fn integrator(&self) -> Integrator<'_> {
        let consistent = self.inertia.filter(|inertia| inertia.consistent);
        Integrator {
            blocks: &self.points.blocks,
            kinematics: self.points.kinematics,
            frame: self.frame,
            rule: self.rule,
            time_step: self.time_step,
            faults: self.faults,
            consistent_mass: consistent.map(Inertia::stiffness),
        }
    }

    /// Adds what stands on nodes: lumped inertia and loads. The nodes of the system may have more dofs,
    /// after those of displacement.
    pub fn add_nodal(&self, system: &mut System, weighted: &[f64], with_matrix: bool) {
        let (block, stride) = (self.dofs.block(), system.matrix.pattern.block());
        if let Some(inertia) = self.inertia.filter(|inertia| !inertia.consistent) {
            for (dof, acceleration) in weighted.iter().enumerate() {
                let mass = self.sums.mass[dof / block];
                let place = dof / block * stride + dof % block;
                system.rhs[place] -= mass * acceleration;
                if with_matrix {
                    system.add_diagonal(place, inertia.stiffness() * mass);
                }
            }
        }
        let axisymmetric = self.points.kinematics == bia_constitutive::Kinematics::Axisymmetric;
        let loads = Loads { grid: self.grid, space: self.space, conditions: &self.points.conditions, axisymmetric };
        if stride == block {
            return loads.add(self.dofs, &self.increments, &mut system.rhs);
        }
        let mut forces = vec![0.0; self.dofs.order()];
        loads.add(self.dofs, &self.increments, &mut forces);
        for (node, forces) in system.rhs.chunks_exact_mut(stride).zip(forces.chunks_exact(block)) {
            node.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        }
    }

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
        let weighted = self.weighted();
        let integrator = self.integrator();
        let of_cells = self.of_cells(&weighted);
        let this = &*self;
        system
            .add_cells(with_matrix, |index, buffer| this.compute(&integrator, of_cells, index, buffer, with_matrix))?;
        self.add_nodal(system, &weighted, with_matrix);
        Ok(())
    }

    fn set_back(&mut self) -> Option<Vec<f64>> {
        let imposed = imposed(self.increments.iter().copied(), self.dofs.fixed())?;
        self.increments.fill(0.0);
        Some(imposed)
    }

    fn correct(&mut self, correction: &[f64]) {
        self.increments.iter_mut().zip(correction).for_each(|(u, d)| *u += d);
    }

    fn unknowns(&self) -> &[f64] {
        &self.increments
    }

    fn round_off(&self) -> f64 {
        match self.rule {
            Rule::EndPoint => ROUND_OFF,
            // That of the energy over the least strain that it is divided by.
            Rule::MidPoint => 1.0 / SAME,
        }
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        let (node, component) = self.dofs.node_of(dof);
        let axis = ["X", "Y", "Z"][component];
        let name = format!("DISPLACEMENT_{axis} of {}", self.space.describe(self.grid, node));
        (name, self.space.position(node as usize))
    }
}
