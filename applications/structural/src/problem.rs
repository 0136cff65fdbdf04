//! Forces and tangent of the whole body, and an implicit step as a nonlinear system.

use crate::body::Body;
use crate::settings::Regime;
use crate::variables::VOLUME_ACCELERATION;
use bia_constitutive::{Kinematics, Want};
use bia_kernel::error::{Error, Failure};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::loads::{linear_rule, visit_loads};
use bia_kernel::solving::ordered::in_order;
use bia_kernel::solving::scheme::Coefficients;
use bia_kernel::solving::{ActiveDofs, CellBuffer, NonlinearSystem, System, imposed};
use bia_kernel::with_shape;
use std::f64::consts::TAU;

/// The body in a step, all vectors over the dofs.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// The mesh with its conditions.
    pub part: &'a ModelPart,
    /// The elements.
    pub body: &'a Body,
    /// The dofs.
    pub dofs: &'a ActiveDofs,
    /// Displacements at the start of the step.
    pub start: &'a [f64],
    /// Length of the step in seconds.
    pub time_step: f64,
}

/// Which parts of an element's matrix are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// The derivative of the stress.
    pub stiffness: bool,
    /// This many times the consistent mass.
    pub mass: Option<f64>,
}

impl Step<'_> {
    /// Minus the internal forces of an element, minus the inertia of nodal accelerations with the
    /// consistent mass unless they are empty, and the matrix.
    ///
    /// # Errors
    /// An element turned inside out, or a law without an answer.
    pub fn element(
        &self,
        element: usize,
        displacements: &[f64],
        accelerations: &[f64],
        tangent: Tangent,
        buffer: &mut CellBuffer,
    ) -> Result<(), Failure> {
        let nodes = self.part.elements.nodes_of(element);
        with_shape!(self.part.elements.shapes[element], |S, D, N| {
            let gather = |values| self.dofs.gather::<D, N>(nodes, values);
            let material = self.body.material(element);
            let want = if tangent.stiffness { Want::StressAndTangent } else { Want::Stress };
            let mut states = std::mem::take(&mut buffer.scratch);
            let both = [&gather(self.start), &gather(displacements)];
            let answers = self.body.answers::<S, D, N>(self.part, element, both, self.time_step, want, &mut states);
            buffer.scratch = states;
            let answers = answers?;
            let accelerations = (!accelerations.is_empty()).then(|| gather(accelerations));
            for k in 0..N {
                let (point, kinematics) = (&answers.points[k], material.built.kinematics);
                let (deformation, response) = (&answers.deformations[k], &answers.responses[k]);
                point.add_stress(kinematics, deformation, response, buffer, tangent.stiffness);
                if let Some(accelerations) = &accelerations {
                    point.add_inertia(material.density, accelerations, tangent.mass, buffer);
                }
            }
            Ok(())
        }, else Ok(()))
    }

    /// Adds what `compute` makes of each element to a vector, in a fixed order.
    ///
    /// # Errors
    /// That of the first element that fails.
    pub fn sum(
        &self,
        sums: &mut [f64],
        compute: impl Fn(usize, &mut CellBuffer) -> Result<(), Failure> + Sync,
    ) -> Result<(), Failure> {
        let (cells, block) = (&self.part.elements, self.dofs.block());
        let prepare = |element: usize, buffer: &mut CellBuffer| {
            buffer.clear(block * cells.nodes_of(element).len(), false);
            compute(element, buffer)
        };
        let add = |element: usize, buffer: &CellBuffer| {
            for (&node, own) in cells.nodes_of(element).iter().zip(buffer.vector.chunks_exact(block)) {
                let Some(number) = self.dofs.number(node) else { continue };
                sums[number * block..][..block].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
        };
        in_order(cells.len(), &mut Vec::new(), prepare, add)
    }

    /// Adds minus the internal forces to a vector.
    ///
    /// # Errors
    /// An element turned inside out, or a law without an answer.
    pub fn subtract_internal(&self, displacements: &[f64], sums: &mut [f64]) -> Result<(), Failure> {
        let none = Tangent { stiffness: false, mass: None };
        self.sum(sums, |element, buffer| self.element(element, displacements, &[], none, buffer))
    }

    /// Σ ρ V₀ N_i N_j b_j of an element with these values b of its nodes.
    pub fn element_body(&self, element: usize, values: impl Fn(u32) -> [f64; 3], buffer: &mut CellBuffer) {
        let nodes = self.part.elements.nodes_of(element);
        with_shape!(self.part.elements.shapes[element], |S, D, N| {
            let minus = std::array::from_fn::<[f64; D], N, _>(|i| {
                let value = values(nodes[i]);
                std::array::from_fn(|a| -value[a])
            });
            let points = self.body.points::<S, D, N>(self.part, element);
            let density = self.body.material(element).density;
            points.iter().for_each(|point| point.add_inertia(density, &minus, None, buffer));
        }, else ());
    }

    /// Adds the consistent mass times nodal values to a vector; times ones it is the lumped mass.
    ///
    /// # Errors
    /// Never in fact.
    pub fn add_mass_times(&self, values: impl Fn(u32) -> [f64; 3] + Sync, sums: &mut [f64]) -> Result<(), Failure> {
        self.sum(sums, |element, buffer| {
            self.element_body(element, &values, buffer);
            Ok(())
        })
    }

    /// Forces of loads on conditions and of the body acceleration.
    ///
    /// # Errors
    /// Never in fact.
    pub fn external(&self) -> Result<Vec<f64>, Failure> {
        let mut forces = vec![0.0; self.dofs.order()];
        let axisymmetric = self.body.materials.iter().any(|m| m.built.kinematics == Kinematics::Axisymmetric);
        for condition in 0..self.part.conditions.len() {
            visit_loads(self.part, condition, linear_rule, &mut |at| {
                let ring = if axisymmetric { TAU * at.position[0] } else { 1.0 };
                for (&node, n) in at.nodes.iter().zip(at.functions) {
                    self.dofs.add_force(node, n * at.weight * ring, at.load, &mut forces);
                }
            });
        }
        if let Some(acceleration) = self.part.node_fields.vector(&VOLUME_ACCELERATION) {
            self.add_mass_times(|node| acceleration[node as usize], &mut forces)?;
        }
        Ok(forces)
    }
}

/// Motion at the start of an implicit step of dynamics.
pub struct Motion<'a> {
    /// Newmark's coefficients.
    pub coefficients: Coefficients,
    /// Bossak's alpha.
    pub alpha: f64,
    /// Velocities.
    pub velocity: &'a [f64],
    /// Accelerations.
    pub acceleration: &'a [f64],
    /// Lumped mass of each dof; none if it is consistent.
    pub lumped: Option<&'a [f64]>,
}

impl<'a> Motion<'a> {
    /// The motion before a step of this regime, if it has any.
    pub fn new(regime: Regime, time_step: f64, [velocity, acceleration, mass]: [&'a [f64]; 3]) -> Option<Self> {
        let Regime::Implicit { newmark, consistent } = regime else { return None };
        let lumped = (!consistent).then_some(mass);
        let coefficients = newmark.coefficients(time_step);
        Some(Self { coefficients, alpha: newmark.alpha, velocity, acceleration, lumped })
    }

    /// The acceleration that the scheme weighs with the mass: (1 - alpha) a + alpha a0.
    fn weighted(&self, increments: &[f64]) -> Vec<f64> {
        let (_, new) = self.coefficients.motion(increments, self.velocity, self.acceleration);
        let both = new.iter().zip(self.acceleration);
        both.map(|(a, a0)| (1.0 - self.alpha) * a + self.alpha * a0).collect()
    }
}

/// An implicit step; without motion it is one of statics.
pub struct Problem<'a> {
    /// The body.
    pub step: Step<'a>,
    /// External forces at the end of the step.
    pub external: &'a [f64],
    /// Motion at its start.
    pub motion: Option<Motion<'a>>,
    /// The unknowns: displacements at its end.
    pub displacements: Vec<f64>,
}

impl NonlinearSystem for Problem<'_> {
    fn dofs(&self) -> &ActiveDofs {
        self.step.dofs
    }

    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
        system.clear(with_matrix);
        let (step, displacements) = (self.step, &self.displacements);
        let motion = self.motion.as_ref();
        let increments = || displacements.iter().zip(step.start).map(|(u, u0)| u - u0).collect::<Vec<_>>();
        let weighted = motion.map_or(Vec::new(), |motion| motion.weighted(&increments()));
        let factor = motion.map_or(0.0, |motion| (1.0 - motion.alpha) * motion.coefficients.c0);
        let lumped = motion.and_then(|motion| motion.lumped);
        let consistent = if lumped.is_none() { &weighted[..] } else { &[] };
        let tangent = Tangent { stiffness: with_matrix, mass: with_matrix.then_some(factor) };
        system.add_cells(with_matrix, |element, buffer| {
            step.element(element, displacements, consistent, tangent, buffer)
        })?;
        if let Some(mass) = lumped {
            for (dof, (mass, acceleration)) in mass.iter().zip(&weighted).enumerate() {
                system.rhs[dof] -= mass * acceleration;
                if with_matrix {
                    system.add_diagonal(dof, factor * mass);
                }
            }
        }
        system.rhs.iter_mut().zip(self.external).for_each(|(r, f)| *r += f);
        Ok(())
    }

    fn set_back(&mut self) -> Option<Vec<f64>> {
        let motions = self.displacements.iter().zip(self.step.start).map(|(u, start)| u - start);
        let imposed = imposed(motions, self.step.dofs.fixed())?;
        self.displacements.copy_from_slice(self.step.start);
        Some(imposed)
    }

    fn correct(&mut self, correction: &[f64]) {
        self.displacements.iter_mut().zip(correction).for_each(|(u, d)| *u += d);
    }

    fn unknowns(&self) -> &[f64] {
        &self.displacements
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        describe_dof(self.step.part, self.step.dofs, dof)
    }
}

/// Name and place of a dof.
pub fn describe_dof(part: &ModelPart, dofs: &ActiveDofs, dof: usize) -> (String, [f64; 3]) {
    let (node, component) = dofs.node_of(dof);
    let (id, axis) = (part.nodes.ids[node as usize], ["X", "Y", "Z"][component]);
    (format!("DISPLACEMENT_{axis} of node {id}"), part.nodes.coordinates[node as usize])
}
