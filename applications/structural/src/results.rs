//! What a run shows: values of elements, energies, the account of a run, the state after a failure.

use crate::problem::Step;
use crate::solver::State;
use crate::variables::{
    ACCELERATION, CAUCHY_STRESS_VECTOR, DISPLACEMENT, GREEN_LAGRANGE_STRAIN_VECTOR, PK2_STRESS_VECTOR, REACTION,
    VELOCITY, VOLUME_ACCELERATION,
};
use bia_constitutive::tensor::{green_lagrange_strain, strain_to_voigt, stress_to_voigt};
use bia_constitutive::{Deformation, Response, Voigt, Want};
use bia_kernel::analysis::number;
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::dataset::{Field, FieldData};
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::processes::vtk::{CellKind, mesh_dataset};
use bia_kernel::solving::loads::{LINE_LOAD, NEGATIVE_FACE_PRESSURE, POINT_LOAD, POSITIVE_FACE_PRESSURE, SURFACE_LOAD};
use bia_kernel::solving::ordered::in_order;
use bia_kernel::solving::solver::write_failed_state;
use bia_kernel::variables::Variable;
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
pub const ELEMENTAL: &[Variable] = &[CAUCHY_STRESS_VECTOR, PK2_STRESS_VECTOR, GREEN_LAGRANGE_STRAIN_VECTOR];

/// What the elements hold at the end of a step.
#[derive(Default)]
pub struct ElementResults {
    /// History of the law, as in [`crate::body::Body::states`].
    pub states: Vec<f64>,
    /// Means of [`ELEMENTAL`], element after element.
    pub means: Vec<[Voigt; 3]>,
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
        let compute = |element: usize, buffer: &mut (Vec<f64>, [Voigt; 3], f64)| {
            let nodes = step.part.elements.nodes_of(element);
            let law = step.body.material(element).built.law.as_ref();
            (buffer.1, buffer.2) = ([[0.0; 6]; 3], 0.0);
            with_shape!(step.part.elements.shapes[element], |S, D, N| {
                let both = [step.start, displacements].map(|values| step.dofs.gather::<D, N>(nodes, values));
                let (time_step, states) = (step.time_step, &mut buffer.0);
                let answers = step.body.answers::<S, D, N>(
                    step.part, element, [&both[0], &both[1]], time_step, Want::Stress, states,
                )?;
                let volume: f64 = answers.points.iter().map(|point| point.volume).sum();
                for k in 0..N {
                    let (deformation, share) = (&answers.deformations[k], answers.points[k].volume / volume);
                    for (mean, value) in buffer.1.iter_mut().zip(measures(deformation, &answers.responses[k])) {
                        mean.iter_mut().zip(value).for_each(|(mean, value)| *mean += share * value);
                    }
                    buffer.2 += answers.points[k].volume * law.energy(deformation).unwrap_or(f64::NAN);
                }
                Ok(())
            }, else Ok(()))
        };
        let add = |_: usize, (states, means, energy): &(Vec<f64>, [Voigt; 3], f64)| {
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
            let column = part.element_fields.rows_mut(variable, components.len(), self.means.len());
            for (element, means) in self.means.iter().enumerate() {
                let row = column.row_mut(element).iter_mut();
                row.zip(components).for_each(|(entry, &component)| *entry = means[index][component]);
            }
        }
    }
}

/// Cauchy and second Piola-Kirchhoff stress S = J F⁻¹ σ F⁻ᵀ, and Green-Lagrange strain. In plane
/// stress the first is per undeformed thickness.
fn measures(deformation: &Deformation, response: &Response) -> [Voigt; 3] {
    let gradient = &deformation.gradient;
    let [xx, yy, zz, xy, yz, xz] = response.stress;
    let cauchy = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let inverse = gradient.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
    let second = gradient.determinant() * inverse * cauchy * inverse.transpose();
    [response.stress, stress_to_voigt(&second), strain_to_voigt(&green_lagrange_strain(gradient))]
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
