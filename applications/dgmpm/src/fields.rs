//! Values of points and cells for output.

use crate::engine::{Engine, Point};
use crate::variables::{
    CAUCHY_STRESS_VECTOR, DEFORMATION_GRADIENT, DISPLACEMENT, MP_CAUCHY_STRESS_VECTOR, MP_COORD,
    MP_DEFORMATION_GRADIENT, MP_DETERMINANT_F, MP_DISPLACEMENT, MP_EQUIVALENT_STRESS, MP_MASS, MP_MATERIAL_ID,
    MP_MEAN_STRESS, MP_PK1_STRESS_TENSOR, MP_STRAIN_ENERGY_DENSITY, MP_VELOCITY, MP_VOLUME, VELOCITY,
    VOLUME_ACCELERATION,
};
use bia_constitutive::Voigt;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::model::ModelPart;
use bia_kernel::processes::Requirements;
use bia_kernel::solving::loads::{LINE_LOAD, NEGATIVE_FACE_PRESSURE, POINT_LOAD, POSITIVE_FACE_PRESSURE, SURFACE_LOAD};
use bia_kernel::variables::Variable;
use nalgebra::Matrix3;

/// Variables of points.
pub const OF_POINTS: &[Variable] = &[
    MP_COORD,
    MP_DISPLACEMENT,
    MP_VELOCITY,
    MP_CAUCHY_STRESS_VECTOR,
    MP_PK1_STRESS_TENSOR,
    MP_DEFORMATION_GRADIENT,
    MP_EQUIVALENT_STRESS,
    MP_MASS,
    MP_VOLUME,
    MP_MATERIAL_ID,
];
/// Those that follow from others: shown where they are asked for, not in the account of a run.
pub const DERIVED: &[Variable] = &[MP_MEAN_STRESS, MP_DETERMINANT_F, MP_STRAIN_ENERGY_DENSITY];
/// Variables of cells: means over their points.
pub const OF_CELLS: &[Variable] = &[CAUCHY_STRESS_VECTOR, DEFORMATION_GRADIENT, VELOCITY, DISPLACEMENT];
/// Variables of nodes that can be shown: what is prescribed there.
pub const OF_NODES: &[Variable] = &[
    DISPLACEMENT,
    VELOCITY,
    VOLUME_ACCELERATION,
    POINT_LOAD,
    LINE_LOAD,
    SURFACE_LOAD,
    POSITIVE_FACE_PRESSURE,
    NEGATIVE_FACE_PRESSURE,
];

/// Nine numbers, row by row.
fn rows(m: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|k| m[(k / 3, k % 3)])
}

/// √(3/2 s : s) of the deviator s.
fn von_mises([xx, yy, zz, xy, yz, xz]: Voigt) -> f64 {
    let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt()
}

/// The values of a variable at a point, appended to `out`.
pub fn append(engine: &dyn Engine, index: usize, variable: &str, out: &mut Vec<f64>) {
    let Point { initial, displacement, velocity, gradient, nominal_stress, volume, mass, material, .. } =
        engine.point(index);
    match variable {
        "MP_COORD" => out.extend((0..3).map(|a| initial[a] + displacement[a])),
        "MP_DISPLACEMENT" => out.extend(displacement),
        "MP_VELOCITY" => out.extend(velocity),
        "MP_CAUCHY_STRESS_VECTOR" => {
            let stress = engine.cauchy(index);
            out.extend(engine.kinematics().voigt().iter().map(|&component| stress[component]));
        }
        "MP_PK1_STRESS_TENSOR" => out.extend(rows(&nominal_stress)),
        "MP_DEFORMATION_GRADIENT" => out.extend(rows(&gradient)),
        "MP_EQUIVALENT_STRESS" => out.push(von_mises(engine.cauchy(index))),
        "MP_MEAN_STRESS" => out.push(engine.cauchy(index)[..3].iter().sum::<f64>() / 3.0),
        "MP_DETERMINANT_F" => out.push(gradient.determinant()),
        // A law without an energy is refused before the run ([`check_energies`]).
        "MP_STRAIN_ENERGY_DENSITY" => out.push(engine.strain_energy(index).map_or(f64::NAN, |energy| energy / volume)),
        "MP_MASS" => out.push(mass),
        "MP_VOLUME" => out.push(volume),
        "MP_MATERIAL_ID" => out.push(f64::from(material)),
        _ => {}
    }
}

/// Refuses to show the energy of laws that have none.
///
/// # Errors
/// One for each place that asks for it.
pub fn check_energies(engine: &dyn Engine, requirements: &Requirements) -> Result<(), InputErrors> {
    let lacking = (0..engine.len()).find(|&index| engine.strain_energy(index).is_none());
    let Some(material) = lacking.map(|index| engine.point(index).material) else { return Ok(()) };
    let mut errors = InputErrors::default();
    for wanted in requirements.variables.iter().filter(|wanted| wanted.variable == MP_STRAIN_ENERGY_DENSITY.name) {
        let message = format!("the law of the properties {material} has no strain energy");
        errors.push(wanted.place.error(message).help("hyperelastic laws have one"));
    }
    errors.or(())
}

/// Writes the wanted means by volume over the cells' points to the columns of elements.
pub fn write_cells(engine: &dyn Engine, part: &mut ModelPart, wanted: &[Variable]) {
    let count = part.elements.len();
    let mut values = Vec::new();
    for variable in wanted {
        let of_points = match variable.name {
            "CAUCHY_STRESS_VECTOR" => MP_CAUCHY_STRESS_VECTOR,
            "DEFORMATION_GRADIENT" => MP_DEFORMATION_GRADIENT,
            "VELOCITY" => MP_VELOCITY,
            _ => MP_DISPLACEMENT,
        };
        for element in 0..count {
            let [first, end] = engine.points_of(element);
            values.clear();
            (first..end).for_each(|point| append(engine, point, of_points.name, &mut values));
            let width = values.len() / (end - first);
            let volumes: Vec<f64> = (first..end).map(|point| engine.point(point).volume).collect();
            let weighted = |k: usize| values[k..].iter().step_by(width).zip(&volumes).map(|(value, v)| v * value);
            let mean = |k: usize| weighted(k).sum::<f64>() / volumes.iter().sum::<f64>();
            match variable.name {
                "VELOCITY" | "DISPLACEMENT" => {
                    part.element_fields.vector_mut(variable, count)[element] = std::array::from_fn(mean);
                }
                _ => {
                    let row = part.element_fields.rows_mut(variable, width, count).row_mut(element);
                    row.iter_mut().enumerate().for_each(|(k, entry)| *entry = mean(k));
                }
            }
        }
    }
}

/// Kinetic and strain energy of the points (J), summed in their order; the latter is none where a law has
/// no energy.
pub fn energies(engine: &dyn Engine, points: impl Iterator<Item = usize>) -> (f64, Option<f64>) {
    let (mut kinetic, mut strain) = (0.0, Some(0.0));
    for index in points {
        let point = engine.point(index);
        kinetic += 0.5 * point.mass * point.velocity.iter().map(|v| v * v).sum::<f64>();
        strain = strain.zip(engine.strain_energy(index)).map(|(sum, energy)| sum + energy);
    }
    (kinetic, strain)
}
