//! Where the cells of a material hold their points.

use crate::kind::Place;
use crate::settings::Placement;
use bia_constitutive::BodyMaterial;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::geometry::{QuadraturePoint, Shape, allowed_counts, even_choices, even_rule, rule};

/// The most points of one cell; beyond it a wrong input is likelier than a wish.
const MOST_POINTS: usize = 1000;

/// The points of cells of one shape and material.
///
/// # Errors
/// A number of points that the shape does not have.
pub fn places(placement: &Placement, shape: Shape, material: &BodyMaterial) -> Result<Vec<Place>, InputErrors> {
    let variable = "MATERIAL_POINTS_PER_ELEMENT";
    let wanted = material.properties.number(variable).unwrap_or(1.0);
    let count = if wanted.fract() == 0.0 && wanted > 0.0 { wanted as usize } else { 0 };
    let (points, choices) = match placement {
        Placement::At(positions) => {
            let weight = shape.reference_measure() / positions.len() as f64;
            let place = |position: &[f64; 3]| {
                let local = std::array::from_fn(|a| if a < shape.dimension() { 2.0 * position[a] - 1.0 } else { 0.0 });
                Place { local, weight }
            };
            return Ok(positions.iter().map(place).collect());
        }
        Placement::Gauss => {
            let counts: Vec<String> = allowed_counts(shape).iter().map(ToString::to_string).collect();
            (rule(shape, count).ok(), counts.join(", "))
        }
        Placement::Even => (even_rule(shape, count).ok(), even_choices(shape).to_string()),
    };
    match points.filter(|points| points.len() <= MOST_POINTS) {
        Some(points) => Ok(points.iter().map(|&QuadraturePoint { xi, weight }| Place { local: xi, weight }).collect()),
        None => {
            let message = format!("{variable} is {wanted}, which a {} does not have", shape.name());
            Err(material.place_of(Some(variable)).error(message).help(format!("allowed: {choices}")).into())
        }
    }
}
