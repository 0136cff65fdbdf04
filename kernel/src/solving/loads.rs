//! Nodal forces of loads on conditions: forces on points, forces per length and area, pressures.
//!
//! Values stand on the conditions, on their nodes, or on both, and add up. Faces are taken as they
//! lie in the mesh, so that loads on a moving body are dead loads.

use crate::geometry::{Shape, rule};
use crate::model::ModelPart;
use crate::registry::Registry;
use crate::variables::{Fields, Variable};

/// Force on a point [N].
pub const POINT_LOAD: Variable = Variable::vector("POINT_LOAD", "N", "force on a point");
/// Force per length of a line [N/m].
pub const LINE_LOAD: Variable = Variable::vector("LINE_LOAD", "N/m", "force per length of a line");
/// Force per area of a surface [N/m²].
pub const SURFACE_LOAD: Variable = Variable::vector("SURFACE_LOAD", "N/m²", "force per area of a surface");
/// Pressure on the positive side of a face [Pa].
pub const POSITIVE_FACE_PRESSURE: Variable =
    Variable::scalar("POSITIVE_FACE_PRESSURE", "Pa", "pressure on the positive side of a face");
/// Pressure on the negative side of a face [Pa].
pub const NEGATIVE_FACE_PRESSURE: Variable =
    Variable::scalar("NEGATIVE_FACE_PRESSURE", "Pa", "pressure on the negative side of a face");

/// Registers the variables of loads.
pub fn register(registry: &mut Registry) {
    for variable in [POINT_LOAD, LINE_LOAD, SURFACE_LOAD, POSITIVE_FACE_PRESSURE, NEGATIVE_FACE_PRESSURE] {
        registry.variable(variable);
    }
}

/// A share of a condition's load, which acts at one place.
pub struct LoadPoint<'a> {
    /// The place in metres.
    pub position: [f64; 3],
    /// Nodes of the condition.
    pub nodes: &'a [u32],
    /// Their shape functions at the place.
    pub functions: &'a [f64],
    /// Weight of the place.
    pub weight: f64,
    /// The force is the weight times this (N); under axisymmetry it is per length of the ring (N/m).
    pub load: [f64; 3],
}

/// Visits the places at which a condition's loads act: its node, or `count(shape)` integration points
/// of its face.
pub fn visit_loads(
    part: &ModelPart,
    condition: usize,
    count: impl Fn(Shape) -> usize,
    visit: &mut dyn FnMut(LoadPoint),
) {
    let (shape, nodes) = (part.conditions.shapes[condition], part.conditions.nodes_of(condition));
    let corners = part.corners(&part.conditions, condition);
    let variable = match shape {
        Shape::Point1 => &POINT_LOAD,
        Shape::Line2 => &LINE_LOAD,
        _ => &SURFACE_LOAD,
    };
    // A positive face pressure pushes along the normal of a line but against that of a face,
    // as in Kratos.
    let sign = if shape == Shape::Line2 { 1.0 } else { -1.0 };
    let mut functions = [0.0; 4];
    for point in rule(shape, count(shape)).unwrap_or_default() {
        shape.functions(point.xi, &mut functions);
        // The normal's length is the measure of the face.
        let normal = shape.normal(&corners, point.xi);
        let measure = match shape {
            Shape::Point1 => 1.0,
            _ => normal.iter().map(|n| n * n).sum::<f64>().sqrt(),
        };
        let mut force = vector(&part.condition_fields, variable, condition);
        let mut push = sign * pressure(&part.condition_fields, condition);
        let mut position = [0.0; 3];
        for ((&node, n), corner) in nodes.iter().zip(functions).zip(&corners) {
            let nodal = vector(&part.node_fields, variable, node as usize);
            push += n * sign * pressure(&part.node_fields, node as usize);
            for i in 0..3 {
                force[i] += n * nodal[i];
                position[i] += n * corner[i];
            }
        }
        let load = std::array::from_fn(|i| measure * force[i] + push * normal[i]);
        visit(LoadPoint { position, nodes, functions: &functions[..nodes.len()], weight: point.weight, load });
    }
}

/// Points that integrate linear loads on linear faces: two a direction, three on triangles.
pub fn linear_rule(shape: Shape) -> usize {
    match shape {
        Shape::Line2 => 2,
        other => other.node_count(),
    }
}

/// Whether a condition carries a load of its own or of its nodes.
pub fn is_loaded(part: &ModelPart, condition: usize) -> bool {
    let any = |fields: &Fields, index: usize| {
        let vectors = [&POINT_LOAD, &LINE_LOAD, &SURFACE_LOAD];
        vectors.iter().any(|variable| vector(fields, variable, index) != [0.0; 3]) || pressure(fields, index) != 0.0
    };
    let mut nodes = part.conditions.nodes_of(condition).iter();
    any(&part.condition_fields, condition) || nodes.any(|&node| any(&part.node_fields, node as usize))
}

/// Positive minus negative face pressure.
fn pressure(fields: &Fields, index: usize) -> f64 {
    let value = |variable| fields.scalar(variable).map_or(0.0, |column| column[index]);
    value(&POSITIVE_FACE_PRESSURE) - value(&NEGATIVE_FACE_PRESSURE)
}

fn vector(fields: &Fields, variable: &Variable, index: usize) -> [f64; 3] {
    fields.vector(variable).map_or([0.0; 3], |column| column[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of 2 m with a linear load, and a pressure on a tilted rectangle.
    #[test]
    fn linear_loads_give_consistent_forces_and_pressures_push_along_normals() {
        let mut part = ModelPart::new("Body");
        part.nodes.ids = vec![1, 2, 3, 4];
        part.nodes.coordinates = vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 3.0, 4.0], [0.0, 3.0, 4.0]];
        part.conditions.push(1, "Line", Shape::Line2, 0, &[0, 1]);
        part.conditions.push(2, "Face", Shape::Quadrilateral4, 0, &[0, 1, 2, 3]);
        part.node_fields.vector_mut(&LINE_LOAD, 4)[1] = [0.0, 6.0, 0.0];
        part.condition_fields.scalar_mut(&POSITIVE_FACE_PRESSURE, 2)[1] = 10.0;
        assert!(is_loaded(&part, 0) && is_loaded(&part, 1));
        let forces = |condition: usize| {
            let mut forces = vec![0.0; 12];
            visit_loads(&part, condition, linear_rule, &mut |at| {
                for (&node, n) in at.nodes.iter().zip(at.functions) {
                    (0..3).for_each(|i| forces[3 * node as usize + i] += n * at.weight * at.load[i]);
                }
            });
            forces
        };
        let of_line = forces(0);
        // 6 N/m · 2 m / 6 and / 3.
        assert!((of_line[1] - 2.0).abs() < 1e-14 && (of_line[4] - 4.0).abs() < 1e-14, "{of_line:?}");
        // Normal of the face: (0, -8, 6) over the area 10; a quarter of 10 Pa times it on each node.
        for node in forces(1).chunks(3) {
            assert!(node[0].abs() < 1e-13 && (node[1] - 20.0).abs() < 1e-13 && (node[2] + 15.0).abs() < 1e-13);
        }
    }
}
