//! How the state advances: from the start, by central differences, or by Newton's method.

use crate::problem::{Motion, Problem, Tangent, describe_dof};
use crate::solver::{Structural, uninitialised};
use crate::variables::{DISPLACEMENT, VELOCITY};
use bia_kernel::error::{Error, Failure};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::solving::{NonlinearSystem, StepReport};

impl Structural {
    /// The velocity that holds a dof whose displacement nothing holds.
    fn held_velocity(&self, part: &ModelPart, dof: usize) -> Option<f64> {
        let (node, a) = self.dofs.node_of(dof);
        let fixed = |variable| part.node_fields.fixed(variable).is_some_and(|fixed| fixed[node as usize][a]);
        let column = part.node_fields.vector(&VELOCITY)?;
        (self.dynamic() && fixed(&VELOCITY) && !fixed(&DISPLACEMENT)).then(|| column[node as usize][a])
    }

    /// Fixes dofs whose displacement or velocity a process holds, and moves them.
    pub(crate) fn prescribe(&mut self, part: &ModelPart, time_step: f64) {
        let fixed = part.node_fields.fixed(&DISPLACEMENT);
        let values = part.node_fields.vector(&DISPLACEMENT);
        for dof in 0..self.dofs.order() {
            let (node, a) = self.dofs.node_of(dof);
            let held = fixed.is_some_and(|fixed| fixed[node as usize][a]);
            let displacement = values.filter(|_| held).map(|values| values[node as usize][a]);
            let moved = || {
                let velocity = self.held_velocity(part, dof)?;
                Some(self.state.start[dof] + 0.5 * time_step * (self.state.velocity[dof] + velocity))
            };
            let target = displacement.or_else(moved);
            self.dofs.fixed_mut()[dof] = target.is_some();
            if let Some(target) = target {
                self.state.displacement[dof] = target;
            }
        }
    }

    /// Velocities that processes hold, as they are and not as the scheme finds them.
    pub(crate) fn keep_held_velocities(&mut self, part: &ModelPart) {
        for dof in 0..self.state.velocity.len() {
            if let Some(velocity) = self.held_velocity(part, dof) {
                self.state.velocity[dof] = velocity;
            }
        }
    }

    /// Displacements, velocities and, from the equation of motion, accelerations at the start.
    pub(crate) fn start(&mut self, model: &Model) -> Result<(), Error> {
        let Some(part) = model.part(&self.settings.part) else { return Ok(()) };
        let displacement = self.dofs.collect(part.node_fields.vector(&DISPLACEMENT));
        let velocity = self.dofs.collect(part.node_fields.vector(&VELOCITY));
        self.state.start.clone_from(&displacement);
        self.state.displacement = displacement;
        if self.dynamic() {
            self.state.velocity = velocity;
        }
        self.prescribe(part, 0.0);
        let step = self.step(model, 0.0)?;
        let mut mass = vec![0.0; self.dofs.order()];
        step.add_mass_times(|_| [1.0; 3], &mut mass)?;
        let external = step.external()?;
        let mut residual = external.clone();
        if self.dynamic() {
            step.subtract_internal(&self.state.displacement, &mut residual)?;
        }
        (self.state.mass, self.state.external) = (mass, external);
        if self.dynamic() {
            self.state.acceleration = self.accelerations(model, residual)?;
        }
        Ok(())
    }

    /// Accelerations under these forces with the mass of the scheme; 0 on held dofs.
    fn accelerations(&mut self, model: &Model, mut forces: Vec<f64>) -> Result<Vec<f64>, Error> {
        let Some((mut system, mut linear)) = self.linear.take_if(|_| self.settings.is_consistent()) else {
            let both = self.state.mass.iter().zip(self.dofs.fixed());
            let each = forces.iter().zip(both);
            return Ok(each.map(|(force, (mass, fixed))| if *fixed { 0.0 } else { force / mass }).collect());
        };
        let step = self.step(model, 0.0)?;
        system.clear(true);
        let tangent = Tangent { stiffness: false, mass: Some(1.0) };
        let zeros = vec![0.0; forces.len()];
        system.add_cells(true, |element, buffer| {
            step.element(element, &self.state.displacement, &zeros, tangent, buffer)
        })?;
        system.matrix.constrain(self.dofs.fixed(), &mut forces);
        let mut accelerations = vec![0.0; forces.len()];
        linear.solve(&system.matrix, &forces, &mut accelerations).map_err(|error| {
            let advice = "consistent_mass_matrix false, or another linear solver";
            Failure::new(format!("the accelerations at the start cannot be solved for: {error}"), advice)
        })?;
        self.linear = Some((system, linear));
        Ok(accelerations)
    }

    /// First half of a step of central differences: v ← v + dt/2 a, u ← u + dt v; held dofs move as
    /// they must.
    pub(crate) fn drift(&mut self, part: &ModelPart, time_step: f64) {
        self.prescribe(part, time_step);
        let state = &mut self.state;
        for (dof, fixed) in self.dofs.fixed().iter().enumerate() {
            if *fixed {
                let velocity = (state.displacement[dof] - state.start[dof]) / time_step;
                state.acceleration[dof] = (velocity - state.velocity[dof]) / time_step;
                state.velocity[dof] = velocity;
            } else {
                state.velocity[dof] += 0.5 * time_step * state.acceleration[dof];
                state.displacement[dof] += time_step * state.velocity[dof];
            }
        }
    }

    /// Second half: a ← f/m, v ← v + dt/2 a. Held dofs keep what [`Self::drift`] gave them.
    pub(crate) fn kick(&mut self, model: &Model, time_step: f64) -> Result<StepReport, Error> {
        let step = self.step(model, time_step)?;
        let mut forces = self.state.external.clone();
        step.subtract_internal(&self.state.displacement, &mut forces)?;
        if let Some(dof) = forces.iter().position(|force| !force.is_finite()) {
            let (name, position) = describe_dof(step.part, &self.dofs, dof);
            let advice = "a smaller time step, or look at the loads near this place";
            return Err(Failure::new("the forces are not finite", advice).at(name, position).into());
        }
        let state = &mut self.state;
        for (dof, fixed) in self.dofs.fixed().iter().enumerate() {
            if *fixed {
                state.reaction[dof] = state.mass[dof] * state.acceleration[dof] - forces[dof];
            } else {
                state.acceleration[dof] = forces[dof] / state.mass[dof];
                state.velocity[dof] += 0.5 * time_step * state.acceleration[dof];
                state.reaction[dof] = 0.0;
            }
        }
        Ok(StepReport { converged: true, ..StepReport::default() })
    }

    /// Newton's method for statics and implicit dynamics.
    pub(crate) fn solve(&mut self, model: &Model, time_step: f64) -> Result<StepReport, Error> {
        let Some((mut system, mut linear)) = self.linear.take() else { return Err(uninitialised().into()) };
        let state = &self.state;
        let motion = Motion::new(self.settings.regime, time_step, [&state.velocity, &state.acceleration, &state.mass]);
        let (step, displacements) = (self.step(model, time_step)?, state.displacement.clone());
        let mut problem = Problem { step, external: &state.external, motion, displacements };
        let mut result = self.settings.newton.solve(&mut problem, &mut system, linear.as_mut());
        if result.is_ok() && self.reactions {
            result = result.and_then(|report| problem.assemble(&mut system, false).map(|()| report));
        }
        let (displacement, motion) = (problem.displacements, problem.motion.take());
        let increments: Vec<f64> = displacement.iter().zip(&state.start).map(|(u, u0)| u - u0).collect();
        let moved = motion.map(|m| m.coefficients.motion(&increments, m.velocity, m.acceleration));
        self.state.displacement = displacement;
        let report = match result {
            Ok(report) => report,
            Err(error) => {
                // The step may be taken again in pieces.
                self.linear = Some((system, linear));
                return Err(error);
            }
        };
        let held = system.rhs.iter().zip(self.dofs.fixed());
        self.state.reaction = held.map(|(rest, fixed)| if *fixed { -rest } else { 0.0 }).collect();
        if let Some((velocity, acceleration)) = moved {
            (self.state.velocity, self.state.acceleration) = (velocity, acceleration);
        }
        self.linear = Some((system, linear));
        Ok(report)
    }
}
