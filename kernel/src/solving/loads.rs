//! Nodal forces of loads on conditions: forces on points, forces per length and area, pressures.
//!
//! Values stand on the conditions, on their nodes, or on both, and add up. Faces are taken as they
//! lie in the mesh, so that loads on a moving body are dead loads.

use super::ActiveDofs;
use crate::geometry::{Shape, rule};
use crate::model::ModelPart;
use crate::registry::Registry;
use crate::variables::{Fields, Variable};
use std::f64::consts::TAU;

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

/// Loads on conditions of a mesh.
pub struct ConditionLoads<'a> {
    /// The mesh with its conditions.
    pub part: &'a ModelPart,
    /// Axisymmetric about the y axis: loads act on whole rings.
    pub axisymmetric: bool,
}

impl ConditionLoads<'_> {
    /// Adds the nodal forces of a condition to a vector over the active dofs. Under axisymmetry
    /// loads act at the radius moved by `increments`; an empty slice stands for zeros.
    pub fn add(&self, condition: usize, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        match self.part.conditions.shapes[condition] {
            Shape::Point1 => self.point(condition, dofs, increments, forces),
            shape => self.surface(condition, shape, dofs, increments, forces),
        }
    }

    /// Whether a condition carries a load of its own or of its nodes.
    pub fn is_loaded(&self, condition: usize) -> bool {
        let any = |fields: &Fields, index: usize| {
            let vectors = [&POINT_LOAD, &LINE_LOAD, &SURFACE_LOAD];
            vectors.iter().any(|variable| vector(fields, variable, index) != [0.0; 3]) || pressure(fields, index) != 0.0
        };
        let mut nodes = self.part.conditions.nodes_of(condition).iter();
        any(&self.part.condition_fields, condition) || nodes.any(|&node| any(&self.part.node_fields, node as usize))
    }

    fn point(&self, condition: usize, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let node = self.part.conditions.nodes_of(condition)[0];
        let own = vector(&self.part.condition_fields, &POINT_LOAD, condition);
        let nodal = vector(&self.part.node_fields, &POINT_LOAD, node as usize);
        let ring = if self.axisymmetric { TAU * self.radius(node, dofs, increments) } else { 1.0 };
        dofs.add_force(node, ring, [own[0] + nodal[0], own[1] + nodal[1], own[2] + nodal[2]], forces);
    }

    /// Two Gauss points a direction on lines and quadrilaterals, three on triangles.
    fn surface(&self, condition: usize, shape: Shape, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let nodes = self.part.conditions.nodes_of(condition);
        let corners = self.part.corners(&self.part.conditions, condition);
        let (variable, count) = match shape {
            Shape::Line2 => (&LINE_LOAD, 2),
            Shape::Triangle3 => (&SURFACE_LOAD, 3),
            _ => (&SURFACE_LOAD, 4),
        };
        // A positive face pressure pushes along the normal of a line but against that of a face,
        // as in Kratos.
        let sign = if shape == Shape::Line2 { 1.0 } else { -1.0 };
        let load = vector(&self.part.condition_fields, variable, condition);
        let own_pressure = pressure(&self.part.condition_fields, condition);
        let mut functions = [0.0; 4];
        for point in rule(shape, count).unwrap_or_default() {
            shape.functions(point.xi, &mut functions[..nodes.len()]);
            // The normal's length is the measure of the face.
            let normal = shape.normal(&corners, point.xi);
            let measure = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let mut total_load = load;
            let mut total_pressure = own_pressure;
            let mut ring = 1.0;
            if self.axisymmetric {
                let radii = nodes.iter().zip(functions).map(|(&node, n)| n * self.radius(node, dofs, increments));
                ring = TAU * radii.sum::<f64>();
            }
            for (&node, n) in nodes.iter().zip(functions) {
                let nodal = vector(&self.part.node_fields, variable, node as usize);
                (0..3).for_each(|i| total_load[i] += n * nodal[i]);
                total_pressure += n * pressure(&self.part.node_fields, node as usize);
            }
            let traction: [f64; 3] =
                std::array::from_fn(|i| measure * total_load[i] + sign * total_pressure * normal[i]);
            for (&node, n) in nodes.iter().zip(functions) {
                dofs.add_force(node, n * point.weight * ring, traction, forces);
            }
        }
    }

    fn radius(&self, node: u32, dofs: &ActiveDofs, increments: &[f64]) -> f64 {
        let moved = dofs.number(node).and_then(|number| increments.get(number * dofs.block())).copied().unwrap_or(0.0);
        self.part.nodes.coordinates[node as usize][0] + moved
    }
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
        let dofs = ActiveDofs::new(3, &[true; 4]);
        let loads = ConditionLoads { part: &part, axisymmetric: false };
        assert!(loads.is_loaded(0) && loads.is_loaded(1));
        let mut forces = vec![0.0; 12];
        loads.add(0, &dofs, &[], &mut forces);
        // 6 N/m · 2 m / 6 and / 3.
        assert!((forces[1] - 2.0).abs() < 1e-14 && (forces[4] - 4.0).abs() < 1e-14, "{forces:?}");
        forces.fill(0.0);
        loads.add(1, &dofs, &[], &mut forces);
        // Normal of the face: (0, -8, 6) over the area 10; a quarter of 10 Pa times it on each node.
        for node in forces.chunks(3) {
            assert!(node[0].abs() < 1e-13 && (node[1] - 20.0).abs() < 1e-13 && (node[2] + 15.0).abs() < 1e-13);
        }
    }
}
