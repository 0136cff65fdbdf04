//! Deformation gradient or Cauchy stress of material points at the start. Bia's own: Kratos's material points
//! begin undeformed.
//!
//! The mesh of the body is its present, deformed shape, and DENSITY that of the undeformed material: a point
//! with the volume V and J = det F has the mass ρ₀ V/J.

use super::acceleration::check_part;
use crate::points::measures::stress_of;
use crate::points::{Block, MaterialPoints, compress, expand};
use bia_constitutive::Voigt;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Parameters, Settings};
use bia_kernel::processes::{Context, Process, SpaceTimeValue};
use bia_kernel::registry::{Building, ProcessEntry, Registry};
use nalgebra::{DMatrix, DVector, Matrix3};

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of points, such as MPM_Material or Initial_MPM_Material.Body"),
    Key::optional(
        "deformation_gradient",
        Kind::List,
        "F, nine numbers or functions of x, y, z, row by row: from the undeformed material to the body's mesh",
    ),
    Key::optional(
        "cauchy_stress",
        Kind::List,
        "instead: stress [Pa], numbers or functions of x, y, z: xx, yy, zz, xy, yz, xz, or those of them that the \
         kinematics has; the law's deformation without rotation that gives it",
    ),
];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "assign_initial_deformation_to_material_point_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "deformation gradient or Cauchy stress of material points at the start, as functions of place; the \
               body's mesh is its deformed shape",
        build: |building| Ok(Box::new(InitialDeformation::read(building)?)),
    });
}

struct InitialDeformation {
    settings: Settings,
    is_stress: bool,
    functions: Vec<SpaceTimeValue>,
}

impl InitialDeformation {
    fn read(building: Building) -> Result<Self, InputErrors> {
        let (settings, project) = (building.settings, building.project);
        let list = match (settings.get("deformation_gradient"), settings.get("cauchy_stress")) {
            (Some(list), None) | (None, Some(list)) => list.clone(),
            (Some(_), Some(list)) => {
                return Err(list.error("stands beside \"deformation_gradient\"; one of them gives the state").into());
            }
            (None, None) => {
                let message = "names neither \"deformation_gradient\" nor \"cauchy_stress\"";
                return Err(settings.parameters().error(message).into());
            }
        };
        let mut errors = InputErrors::default();
        let is_stress = settings.given("cauchy_stress");
        if !is_stress && list.entries().len() != 9 {
            errors.push(list.error(format!("has {} members, must have nine, row by row", list.entries().len())));
        }
        refuse_frames(project, &settings, &mut errors);
        let read: Vec<_> =
            list.entries().iter().filter_map(|entry| errors.absorb(SpaceTimeValue::read(entry))).collect();
        errors.or(Self { settings, is_stress, functions: read })
    }

    /// Sets deformation, mass and stress of a point.
    fn set(&self, block: &mut Block, point: usize, time: f64) -> Result<(), Failure> {
        let x = block.coordinates(point);
        let values: Vec<f64> = self.functions.iter().map(|function| function.at(x, x, time)).collect();
        let failed = |what: String, advice: &str| {
            Failure::new(what, advice).at(format!("material point {}", block.ids[point]), x)
        };
        if values.iter().any(|value| !value.is_finite()) {
            return Err(failed(
                format!("the initial state {values:?} is not finite"),
                "functions that are finite here",
            ));
        }
        if self.is_stress {
            let Some(row) = find(block, point, &values) else {
                let what = format!("the law {} has no deformation with the stress {values:?} Pa", block.law.name());
                return Err(failed(what, "a stress that the law can have, or a deformation gradient"));
            };
            match block.law.uses_strain() {
                true => block.strain.row_mut(point).copy_from_slice(&row),
                false => block.gradient.row_mut(point).copy_from_slice(&row),
            }
        } else {
            let gradient = Matrix3::from_row_slice(&values);
            let mut row = block.gradient.row(point).to_vec();
            compress(&gradient, &mut row);
            if expand(&row) != gradient || gradient.determinant() <= 0.0 {
                let what = format!("F = {values:?} is no deformation in {}", block.kinematics);
                return Err(failed(what, "a gradient with a positive determinant and 1 across the plane"));
            }
            block.gradient.row_mut(point).copy_from_slice(&row);
        }
        let jacobian = block.deformation_gradient(point).determinant();
        block.mass.row_mut(point)[0] /= jacobian;
        if block.stress.is_used() {
            let stress = stress_of(block, point, block.gradient.row(point), block.strain.row(point));
            let components = block.kinematics.voigt();
            let row = block.stress.row_mut(point);
            row.iter_mut().zip(components).for_each(|(value, &component)| *value = stress[component]);
        }
        if block.acceleration.is_used() {
            block.acceleration.row_mut(point).fill(0.0);
        }
        Ok(())
    }
}

/// The total frame would have to know where the undeformed material lies.
fn refuse_frames(project: &Parameters, settings: &Settings, errors: &mut InputErrors) {
    let Some(solver) = project.child("solver_settings") else { return };
    let is = |name: &str, value: &str| solver.child(name).is_some_and(|given| given.value() == value);
    if is("frame", "total_lagrangian") || is("grid_reset", "never") {
        let message = "an initial deformation is for the updated frame: points of the total one start undeformed";
        errors.push(settings.parameters().error(message));
    }
}

/// Unknowns of the deformation that gives a stress, as a row of the column that the law answers to: the
/// strain, or a symmetric deformation gradient of these components.
fn row_of(block: &Block, unknowns: &DVector<f64>) -> Vec<f64> {
    if block.law.uses_strain() {
        return unknowns.iter().copied().collect();
    }
    let mut gradient = Matrix3::identity();
    for (&component, value) in block.kinematics.voigt().iter().zip(unknowns.iter()) {
        let (i, j) = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)][component];
        gradient[(i, j)] += value;
        if i != j {
            gradient[(j, i)] += value;
        }
    }
    let mut row = block.gradient.row(0).to_vec();
    compress(&gradient, &mut row);
    row
}

/// Most iterations.
const ITERATIONS: usize = 50;
/// Strain that is round-off of a deformation gradient.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;
/// Difference of strains by which tangents are found.
const DIFFERENCE: f64 = 1e-7;

/// The row of the deformation under which the law answers with this stress, by Newton's method; none if it
/// does not come near.
fn find(block: &Block, point: usize, wanted: &[f64]) -> Option<Vec<f64>> {
    let components = block.kinematics.voigt();
    let wanted = DVector::from_column_slice(wanted);
    let answer = |unknowns: &DVector<f64>| -> DVector<f64> {
        let row = row_of(block, unknowns);
        let stress: Voigt = match block.law.uses_strain() {
            true => stress_of(block, point, block.gradient.row(point), &row),
            false => stress_of(block, point, &row, block.strain.row(point)),
        };
        DVector::from_iterator(components.len(), components.iter().map(|&component| stress[component]))
    };
    let mut unknowns = DVector::zeros(components.len());
    for _ in 0..ITERATIONS {
        let missing = &wanted - answer(&unknowns);
        let column = |k: usize| {
            let mut moved = unknowns.clone();
            moved[k] += DIFFERENCE;
            let mut back = unknowns.clone();
            back[k] -= DIFFERENCE;
            (answer(&moved) - answer(&back)) / (2.0 * DIFFERENCE)
        };
        let columns: Vec<DVector<f64>> = (0..components.len()).map(column).collect();
        let step = DMatrix::from_columns(&columns).lu().solve(&missing)?;
        if step.amax() <= ROUND_OFF {
            return Some(row_of(block, &unknowns));
        }
        // Half of the way, at most, to where the point would be flat.
        let share = (0.5 / step.amax()).min(1.0);
        unknowns += step * share;
    }
    None
}

impl Process for InitialDeformation {
    fn name(&self) -> &str {
        "assign_initial_deformation_to_material_point"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Ok(()) };
        let place = self.settings.parameters();
        if points.blocks.iter().any(|block| block.pressure.is_used()) {
            return Err(place.error("an initial deformation cannot be given with pressure_dofs yet").into());
        }
        let components = points.kinematics.component_names();
        if self.is_stress && self.functions.len() != components.len() {
            let (count, names) = (self.functions.len(), components.join(", "));
            let message = format!("has {count} components, must have {}: {names}", components.len());
            return Err(self.settings.error("cauchy_stress", message).into());
        }
        Ok(())
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let time = context.clock.time;
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return Ok(()) };
        for block in points.blocks.iter_mut().filter(|block| selection.holds(block.body)) {
            block.starts_stressed = true;
            (0..block.len()).try_for_each(|point| self.set(block, point, time))?;
        }
        Ok(())
    }
}
