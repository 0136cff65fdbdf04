//! One step of the mixed formulation as a nonlinear system: displacement increments and a pressure on
//! each active node.

use super::constants::{Constants, element_size};
use super::element::{MixedIntegrator, MixedState, MixedTask, Terms};
use super::osgs::{GatherTask, Projection};
use super::{Unknowns, with_cell};
use crate::grid::{numbers, vectors_of};
use crate::implicit::element::CellState;
use crate::implicit::problem::Problem;
use crate::settings::ElementSize;
use bia_kernel::error::{Error, Failure};
use bia_kernel::lanes::dispatch;
use bia_kernel::solving::{ActiveDofs, CellBuffer, Field, NonlinearSystem, System};

/// Share of its own that the diagonal of the tangent gets on top in dynamics.
///
/// Points that reach a layer of cells by a part ε of its thickness resist patterns of its nodes by ε² only,
/// and at ε = 1e-7 the matrix passes for singular though nothing is loose. Inertia leaves no other singular
/// matrices to be found. Residuals, and with them the solution, stay as they are.
const HOLD: f64 = 1e-11;

/// The step.
pub struct MixedProblem<'a> {
    /// Its part in displacements alone.
    pub base: Problem<'a>,
    /// Dofs: those of displacement, then pressure, node by node.
    pub dofs: &'a ActiveDofs,
    /// Constants of each block.
    pub constants: Vec<Constants>,
    /// Stabilisation.
    pub terms: Terms,
    /// Kind of element size.
    pub size: ElementSize,
    /// Sums and couplings of the projection, with orthogonal subscales.
    pub couplings: Option<&'a mut System>,
    /// The projection.
    pub projection: Projection,
    /// What is judged apart.
    pub fields: Vec<Field>,
    /// The unknowns.
    pub unknowns: Unknowns,
}

impl MixedProblem<'_> {
    fn integrator(&self) -> MixedIntegrator<'_> {
        MixedIntegrator { base: self.base.integrator(), constants: &self.constants, terms: self.terms }
    }

    /// The nodal values of a cell.
    fn state<const D: usize, const N: usize>(
        &self,
        nodes: &[u32],
        weighted: &[f64],
        corners: &[[f64; D]; N],
    ) -> MixedState<D, N> {
        let numbers = numbers::<N>(self.base.dofs, nodes);
        MixedState {
            motion: CellState {
                increments: vectors_of(&numbers, &self.base.increments),
                inertia: vectors_of(&numbers, self.base.of_cells(weighted)),
            },
            acceleration: vectors_of(&numbers, weighted),
            pressures: numbers.map(|number| self.unknowns.pressures[number]),
            projection: vectors_of(&numbers, &self.projection.residual),
            size: element_size(self.size, corners),
        }
    }

    fn compute(
        &self,
        integrator: &MixedIntegrator,
        weighted: &[f64],
        index: usize,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let (base, cell) = (&self.base, self.base.active.cells[index] as usize);
        with_cell!(base.space, cell, |basis, D, N, DOFS| {
            let state = self.state::<D, N>(base.space.nodes_of(cell), weighted, &basis.corners);
            let points: Vec<(u32, u32)> = base.active.points(index).collect();
            let (state, points) = (&state, points.as_slice());
            let task = MixedTask::<_, D, N, DOFS> { integrator, state, points, buffer, with_matrix, basis };
            dispatch(base.arch, task)
        }, else Ok(()))
    }

    fn gather(
        &self,
        integrator: &MixedIntegrator,
        index: usize,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) -> Result<(), Failure> {
        let (base, cell) = (&self.base, self.base.active.cells[index] as usize);
        with_cell!(base.space, cell, |basis, D, N, DOFS| {
            let state = self.state::<D, N>(base.space.nodes_of(cell), &[], &basis.corners);
            let points: Vec<(u32, u32)> = base.active.points(index).collect();
            let (state, points) = (&state, points.as_slice());
            let task = GatherTask::<_, D, N, DOFS> { integrator, state, points, buffer, with_matrix, basis };
            dispatch(base.arch, task)
        }, else Ok(()))
    }

    /// Projects the residual, and gathers the couplings of the projection if the matrix is wanted.
    fn project(&mut self, with_matrix: bool) -> Result<(), Error> {
        let Some(couplings) = self.couplings.take() else { return Ok(()) };
        let result = self.project_into(couplings, with_matrix);
        self.couplings = Some(couplings);
        result
    }

    fn project_into(&mut self, couplings: &mut System, with_matrix: bool) -> Result<(), Error> {
        for matrix in [false, true] {
            if matrix && !with_matrix {
                break;
            }
            couplings.clear(matrix);
            let (this, integrator) = (&*self, self.integrator());
            couplings.add_cells(matrix, |index, buffer| this.gather(&integrator, index, buffer, matrix))?;
            if !matrix {
                self.projection.divide(couplings);
            }
        }
        Ok(())
    }
}

impl NonlinearSystem for MixedProblem<'_> {
    fn dofs(&self) -> &ActiveDofs {
        self.dofs
    }

    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
        self.unknowns.split(self.base.dofs.block(), &mut self.base.increments);
        self.base.assembled.clone_from(&self.base.increments);
        self.project(with_matrix)?;
        system.clear(with_matrix);
        let weighted = self.base.weighted();
        let (this, integrator) = (&*self, self.integrator());
        system
            .add_cells(with_matrix, |index, buffer| this.compute(&integrator, &weighted, index, buffer, with_matrix))?;
        if let (Some(couplings), true) = (&self.couplings, with_matrix) {
            match self.base.dofs.block() {
                3 => self.projection.condense::<3>(couplings, system),
                _ => self.projection.condense::<2>(couplings, system),
            }
        }
        self.base.add_nodal(system, &weighted, with_matrix);
        if with_matrix && self.base.inertia.is_some() && !self.fields.is_empty() {
            system.matrix.scale_diagonal(1.0 + HOLD);
        }
        Ok(())
    }

    fn set_back(&mut self) -> Option<Vec<f64>> {
        let (block, imposed) = (self.base.dofs.block(), self.base.set_back()?);
        for (node, values) in self.unknowns.values.chunks_exact_mut(block + 1).enumerate() {
            values[..block].copy_from_slice(&self.base.increments[node * block..][..block]);
        }
        // Pressures stay.
        Some(imposed.chunks_exact(block).flat_map(|imposed| imposed.iter().copied().chain([0.0])).collect())
    }

    fn correct(&mut self, correction: &[f64]) {
        self.unknowns.values.iter_mut().zip(correction).for_each(|(u, d)| *u += d);
        self.unknowns.split(self.base.dofs.block(), &mut self.base.increments);
    }

    fn unknowns(&self) -> &[f64] {
        &self.unknowns.values
    }

    fn fields(&self) -> &[Field] {
        &self.fields
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        let (node, component) = self.dofs.node_of(dof);
        let block = self.base.dofs.block();
        if component < block {
            let number = dof / self.dofs.block();
            return self.base.describe_dof(number * block + component);
        }
        let name = format!("PRESSURE of {}", self.base.space.describe(self.base.grid, node));
        (name, self.base.space.position(node as usize))
    }
}
