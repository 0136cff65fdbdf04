//! Where a step of Newton's method starts if what is imposed in it turns material inside out as long as the
//! rest stands still: a support that moves by more than the cell beside it.

use super::System;
use super::newton::{NonlinearSystem, describe};
use crate::error::Error;
use bia_linalg::LinearSolver;

/// What of these motions of the dofs since the start of the step is imposed, 0 where they are free; none if that is
/// nothing. For [`NonlinearSystem::set_back`].
pub fn imposed(motions: impl Iterator<Item = f64>, fixed: &[bool]) -> Option<Vec<f64>> {
    let imposed: Vec<f64> = motions.zip(fixed).map(|(u, held)| if *held { u } else { 0.0 }).collect();
    imposed.iter().any(|u| *u != 0.0).then_some(imposed)
}

/// Lets the free dofs follow the held ones, u_f = K_ff⁻¹ (r_f − K_fc u_c) with residual and tangent at the start of
/// the step. Gives false where nothing is imposed, or the system does not tell what.
///
/// # Errors
/// The system has no residual at the start of the step either, or is singular.
pub fn lead(
    problem: &mut dyn NonlinearSystem,
    system: &mut System,
    solver: &mut dyn LinearSolver,
) -> Result<bool, Error> {
    let Some(imposed) = problem.set_back() else { return Ok(false) };
    problem.assemble(system, true)?;
    let mut carried = vec![0.0; imposed.len()];
    system.matrix.multiply(&imposed, &mut carried);
    system.rhs.iter_mut().zip(&carried).for_each(|(residual, carried)| *residual -= carried);
    system.matrix.constrain(problem.dofs().fixed(), &mut system.rhs);
    let mut correction = vec![0.0; imposed.len()];
    let solved = solver.solve(&system.matrix, &system.rhs, &mut correction);
    solved.map_err(|error| describe(problem, &error))?;
    let held = imposed.iter().zip(problem.dofs().fixed()).zip(&mut correction).filter(|((_, fixed), _)| **fixed);
    held.for_each(|((imposed, _), correction)| *correction = *imposed);
    problem.correct(&correction);
    tracing::debug!("supports move by more than the cells beside them bear: the rest follows linearly first");
    Ok(true)
}
