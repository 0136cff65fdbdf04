//! Where the cells of a body hold their points.

use super::generate::{Plan, material_of};
use crate::settings::Placement;
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::geometry::{Shape, ShapeTable, allowed_counts, even_choices, even_rule, rule};

/// The most points of one cell; beyond it a wrong input is likelier than a wish.
const MOST_POINTS: usize = 1_000_000;

/// A material point in a cell of a body, before the cell is known.
pub struct Place {
    /// Functions of the cell at the point.
    pub table: ShapeTable,
    /// Local volume that the point stands for.
    pub weight: f64,
}

/// The points of all cells of one shape and one material.
pub struct Layout {
    /// Id of the properties.
    pub material: u32,
    /// Shape of the cells.
    pub shape: Shape,
    /// The points, in their order.
    pub places: Vec<Place>,
}

impl Layout {
    /// The layout for a body element and those like it.
    ///
    /// # Errors
    /// A shape that does not fit the kinematics, a number of points that the shape does not have.
    pub fn new(plan: &Plan, id: u32, element: usize) -> Result<Self, InputErrors> {
        let elements = &plan.bodies.elements;
        let material = material_of(plan, id, element as u32)?;
        let shape = elements.shapes[element];
        if shape.dimension() != plan.kinematics.dimension() {
            let message = format!(
                "body element {} is a {}, which does not fit {}",
                elements.ids[element],
                shape.name(),
                plan.kinematics
            );
            let diagnostic = Diagnostic::error(plan.place(element), message);
            return Err(diagnostic.help("check domain_size and the element names").into());
        }
        let wanted = material.properties.number("MATERIAL_POINTS_PER_ELEMENT").unwrap_or(0.0);
        let count = if wanted.fract() == 0.0 { wanted as usize } else { 0 };
        let (points, choices) = match plan.placement {
            Placement::Gauss => {
                let counts: Vec<String> = allowed_counts(shape).iter().map(ToString::to_string).collect();
                (rule(shape, count).ok(), counts.join(", "))
            }
            Placement::Even => (even_rule(shape, count).ok(), even_choices(shape).to_string()),
        };
        let Some(points) = points.filter(|points| points.len() <= MOST_POINTS) else {
            let place = material.place_of(Some("MATERIAL_POINTS_PER_ELEMENT"));
            let evenly = if plan.placement == Placement::Even { " with \"point_placement\": \"even\"" } else { "" };
            let message =
                format!("MATERIAL_POINTS_PER_ELEMENT is {wanted}, which a {} does not have{evenly}", shape.name());
            return Err(place.error(message).help(format!("allowed: {choices}")).into());
        };
        let place = |point: &bia_kernel::geometry::QuadraturePoint| Place {
            table: ShapeTable::new(shape, point.xi),
            weight: point.weight,
        };
        Ok(Self { material: id, shape, places: points.iter().map(place).collect() })
    }
}
