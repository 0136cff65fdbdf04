//! What a run shows: values of elements, energies, the account of a run, the state after a failure.

use crate::body::Body;
use crate::problem::Step;
use crate::solver::State;
use crate::variables::{
    ACCELERATION, CAUCHY_STRESS_VECTOR, DETERMINANT_F, DISPLACEMENT, GREEN_LAGRANGE_STRAIN_VECTOR, MEAN_STRESS,
    PK2_STRESS_VECTOR, REACTION, STRAIN_ENERGY_DENSITY, VELOCITY, VOLUME_ACCELERATION, VON_MISES_STRESS,
};
use bia_constitutive::tensor::{green_lagrange_strain, strain_to_voigt, stress_to_voigt};
use bia_constitutive::{Deformation, Response, Voigt, Want};
use bia_kernel::analysis::number;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::dataset::{Field, FieldData};
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::processes::Requirements;
use bia_kernel::processes::vtk::{CellKind, mesh_dataset};
use bia_kernel::solving::loads::{LINE_LOAD, NEGATIVE_FACE_PRESSURE, POINT_LOAD, POSITIVE_FACE_PRESSURE, SURFACE_LOAD};
use bia_kernel::solving::ordered::in_order;
use bia_kernel::solving::solver::write_failed_state;
use bia_kernel::variables::{Rank, Variable};
use bia_kernel::with_shape;
use nalgebra::Matrix3;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Variables of nodes that can be shown: those of the solver and those that it reads.
pub const NODAL: &[Variable] = &[
    DISPLACEMENT,
    VELOCITY,
    ACCELERATION,
    REACTION,
    VOLUME_ACCELERATION,
    POINT_LOAD,
    LINE_LOAD,
    SURFACE_LOAD,
    POSITIVE_FACE_PRESSURE,
    NEGATIVE_FACE_PRESSURE,
];
/// Variables of elements that the solver can show.
pub const ELEMENTAL: &[Variable] = &[
    CAUCHY_STRESS_VECTOR,
    PK2_STRESS_VECTOR,
    GREEN_LAGRANGE_STRAIN_VECTOR,
    VON_MISES_STRESS,
    MEAN_STRESS,
    DETERMINANT_F,
    STRAIN_ENERGY_DENSITY,
];
/// Those that the account of a run holds.
pub const RECORDED: &[Variable] = &[CAUCHY_STRESS_VECTOR, PK2_STRESS_VECTOR, GREEN_LAGRANGE_STRAIN_VECTOR];

/// The tensors of [`ELEMENTAL`], then its scalars.
#[derive(Debug, Clone, Copy, Default)]
pub struct Means {
    tensors: [Voigt; 3],
    scalars: [f64; 4],
}

/// What the elements hold at the end of a step.
#[derive(Default)]
pub struct ElementResults {
    /// History of the law, as in [`crate::body::Body::states`].
    pub states: Vec<f64>,
    /// Means of [`ELEMENTAL`], element after element.
    pub means: Vec<Means>,
    /// Strain energy in joules; not a number where a law has none.
    pub energy: f64,
}

impl ElementResults {
    /// Evaluates all elements.
    ///
    /// # Errors
    /// An element turned inside out, or a law without an answer.
    pub fn new(step: &Step, displacements: &[f64]) -> Result<Self, Failure> {
        let mut results = Self::default();
        let compute = |element: usize, buffer: &mut (Vec<f64>, Means, f64)| {
            let nodes = step.part.elements.nodes_of(element);
            let law = step.body.material(element).built.law.as_ref();
            (buffer.1, buffer.2) = (Means::default(), 0.0);
            with_shape!(step.part.elements.shapes[element], |S, D, N| {
                let both = [step.start, displacements].map(|values| step.dofs.gather::<D, N>(nodes, values));
                let (time_step, states) = (step.time_step, &mut buffer.0);
                let answers = step.body.answers::<S, D, N>(
                    step.part, element, [&both[0], &both[1]], time_step, Want::Stress, states,
                )?;
                let volume: f64 = answers.points.iter().map(|point| point.volume).sum();
                for k in 0..N {
                    let (deformation, share) = (&answers.deformations[k], answers.points[k].volume / volume);
                    let energy = law.energy(deformation).unwrap_or(f64::NAN);
                    buffer.1.add(share, &measures(deformation, &answers.responses[k], energy));
                    buffer.2 += answers.points[k].volume * energy;
                }
                Ok(())
            }, else Ok(()))
        };
        let add = |_: usize, (states, means, energy): &(Vec<f64>, Means, f64)| {
            results.states.extend_from_slice(states);
            results.means.push(*means);
            results.energy += energy;
        };
        in_order(step.part.elements.len(), &mut Vec::new(), compute, add)?;
        Ok(results)
    }

    /// Writes the means to the columns of elements.
    pub fn write(&self, part: &mut ModelPart, variables: &[Variable], components: &[usize]) {
        for variable in variables {
            let Some(index) = ELEMENTAL.iter().position(|other| other.name == variable.name) else { continue };
            if variable.rank == Rank::Scalar {
                let column = part.element_fields.scalar_mut(variable, self.means.len());
                column.iter_mut().zip(&self.means).for_each(|(entry, means)| *entry = means.scalars[index - 3]);
                continue;
            }
            let column = part.element_fields.rows_mut(variable, components.len(), self.means.len());
            for (element, means) in self.means.iter().enumerate() {
                let row = column.row_mut(element).iter_mut();
                row.zip(components).for_each(|(entry, &component)| *entry = means.tensors[index][component]);
            }
        }
    }
}

/// Refuses to show the energy of laws that have none.
///
/// # Errors
/// One for each place that asks for it.
pub fn check_energies(body: &Body, requirements: &Requirements) -> Result<(), InputErrors> {
    let rest = Deformation::from_gradient(Matrix3::identity());
    let lacking = body.materials.iter().find(|material| material.built.law.energy(&rest).is_none());
    let Some(law) = lacking.map(|material| material.built.law.name()) else { return Ok(()) };
    let mut errors = InputErrors::default();
    for wanted in requirements.variables.iter().filter(|wanted| wanted.variable == STRAIN_ENERGY_DENSITY.name) {
        let message = format!("the law {law} has no strain energy");
        errors.push(wanted.place.error(message).help("hyperelastic laws have one"));
    }
    errors.or(())
}

impl Means {
    fn add(&mut self, share: f64, other: &Self) {
        let (mine, theirs) = (self.tensors.as_flattened_mut(), other.tensors.as_flattened());
        mine.iter_mut().zip(theirs).for_each(|(mean, value)| *mean += share * value);
        self.scalars.iter_mut().zip(other.scalars).for_each(|(mean, value)| *mean += share * value);
    }
}

/// √(3/2 s : s) of the deviator s.
fn von_mises([xx, yy, zz, xy, yz, xz]: Voigt) -> f64 {
    let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt()
}

/// Cauchy and second Piola-Kirchhoff stress S = J F⁻¹ σ F⁻ᵀ, Green-Lagrange strain, and the scalars. In plane
/// stress the first is per undeformed thickness.
fn measures(deformation: &Deformation, response: &Response, energy: f64) -> Means {
    let gradient = &deformation.gradient;
    let [xx, yy, zz, xy, yz, xz] = response.stress;
    let cauchy = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let inverse = gradient.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
    let second = gradient.determinant() * inverse * cauchy * inverse.transpose();
    let tensors = [response.stress, stress_to_voigt(&second), strain_to_voigt(&green_lagrange_strain(gradient))];
    Means { tensors, scalars: [von_mises(response.stress), (xx + yy + zz) / 3.0, gradient.determinant(), energy] }
}

impl State {
    /// Potential energy of the (dead) external forces, kinetic and strain energy in joules; the latter
    /// two as far as there is inertia and the laws know an energy.
    pub fn energies(&self, step: &Step, consistent: bool) -> Vec<(&'static str, f64)> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut list = vec![("potential", -dot(&self.external, &self.displacement))];
        if !self.velocity.is_empty() {
            list.push(("kinetic", 0.5 * dot(&self.velocity, &self.momentum(step, consistent))));
        }
        if let Some(results) = ElementResults::new(step, &self.displacement).ok().filter(|r| r.energy.is_finite()) {
            list.push(("strain", results.energy));
        }
        list
    }

    /// Mass times velocity of each dof.
    fn momentum(&self, step: &Step, consistent: bool) -> Vec<f64> {
        if !consistent {
            return self.mass.iter().zip(&self.velocity).map(|(m, v)| m * v).collect();
        }
        let mut product = vec![0.0; self.velocity.len()];
        let block = step.dofs.block();
        let velocity = |node: u32| {
            let first = step.dofs.number(node).map_or(0, |number| number * block);
            std::array::from_fn(|a| if a < block { self.velocity[first + a] } else { 0.0 })
        };
        // The sum of elements without a law's answer cannot fail.
        let _ = step.add_mass_times(velocity, &mut product);
        product
    }

    /// Writes energies, sums and fields of all nodes and elements.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn snapshot(&self, step: &Step, consistent: bool, out: &mut JsonObject) -> std::io::Result<()> {
        let energies = self.energies(step, consistent);
        let total: f64 = energies.iter().map(|(_, energy)| energy).sum();
        let all = energies.into_iter().chain([("total", total)]);
        let named = all.map(|(name, energy)| (name.to_string(), number(energy)));
        out.value("energies", &serde_json::Value::Object(named.collect()))?;
        let block = step.dofs.block();
        let mut momentum = [0.0; 3];
        if !self.velocity.is_empty() {
            let all = self.momentum(step, consistent);
            all.iter().enumerate().for_each(|(dof, p)| momentum[dof % block] += p);
        }
        let mass: f64 = self.mass.iter().step_by(block).sum();
        out.value("sums", &json!({"mass": number(mass), "momentum": momentum.map(number)}))?;
        let part = step.part;
        out.object("nodes", |out| {
            out.integers("ids", part.nodes.ids.iter().copied())?;
            part.node_fields.record(out)
        })?;
        out.object("elements", |out| {
            out.integers("ids", part.elements.ids.iter().copied())?;
            part.element_fields.record(out)
        })
    }
}

/// Writes the mesh with the displacements that a failed step has reached.
///
/// # Errors
/// The folder cannot be written.
pub fn save_state(model: &Model, step: &Step, state: &State, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let Some(members) = model.members(&step.part.name) else { return Ok(Vec::new()) };
    let mut data = mesh_dataset(step.part, &members, CellKind::Elements, true, [&[], &[], &[]]);
    for (variable, values) in [(DISPLACEMENT, &state.displacement), (VELOCITY, &state.velocity)] {
        let mut column = vec![[0.0; 3]; step.part.nodes.len()];
        if !values.is_empty() {
            step.dofs.scatter(values, &mut column);
            let values = FieldData::F64(column.concat());
            data.point_fields.push(Field { name: variable.name.into(), components: 3, values });
        }
    }
    write_failed_state(&data, folder)
}
