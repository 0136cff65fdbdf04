//! Nodal forces of grid loads and of loads on material-point conditions (spec 07 §1-2).

use crate::points::conditions::{PointConditions, cross, tangents};
use crate::variables::{LINE_LOAD, NEGATIVE_FACE_PRESSURE, POINT_LOAD, POSITIVE_FACE_PRESSURE, SURFACE_LOAD};
use bia_kernel::geometry::{Shape, rule};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::variables::{Fields, Variable};
use std::f64::consts::TAU;

/// The loads of a scene.
pub struct Loads<'a> {
    /// The grid with its conditions.
    pub grid: &'a ModelPart,
    /// Which grid conditions act, and the material-point conditions.
    pub conditions: &'a PointConditions,
    /// Axisymmetric about the y axis.
    pub axisymmetric: bool,
}

impl Loads<'_> {
    /// Adds all nodal forces to a vector over the active dofs. Under axisymmetry loads act at the
    /// current radius, so the increments matter; an empty slice stands for zeros.
    pub fn add(&self, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        for &condition in &self.conditions.grid {
            let condition = condition as usize;
            match self.grid.conditions.shapes[condition] {
                Shape::Point1 => self.point(condition, dofs, increments, forces),
                shape => self.surface(condition, shape, dofs, increments, forces),
            }
        }
        for i in 0..self.conditions.len() {
            let cell = self.conditions.cell[i] as usize;
            let shape = self.grid.elements.shapes[cell];
            let mut functions = [0.0; 8];
            shape.functions(self.conditions.local[i], &mut functions[..shape.node_count()]);
            for (&node, share) in self.grid.elements.nodes_of(cell).iter().zip(functions) {
                add_force(dofs, node, share, self.conditions.load[i], forces);
            }
        }
    }

    /// A loaded grid node without dofs: no material point reaches it, so its share of the load is lost.
    pub fn idle_node(&self, dofs: &ActiveDofs) -> Option<u32> {
        let loaded = self.conditions.grid.iter().filter(|&&condition| self.is_loaded(condition as usize));
        let of_grid = loaded.flat_map(|&condition| self.grid.conditions.nodes_of(condition as usize));
        let pulled = (0..self.conditions.len()).filter(|&i| self.conditions.load[i] != [0.0; 3]);
        let of_points = pulled.flat_map(|i| self.grid.elements.nodes_of(self.conditions.cell[i] as usize));
        of_grid.chain(of_points).copied().find(|&node| dofs.number(node).is_none())
    }

    /// Whether a grid condition carries a load of its own or of its nodes.
    fn is_loaded(&self, condition: usize) -> bool {
        let any = |fields: &Fields, index: usize| {
            let vectors = [&POINT_LOAD, &LINE_LOAD, &SURFACE_LOAD];
            vectors.iter().any(|variable| vector(fields, variable, index) != [0.0; 3])
                || self.pressure(fields, index) != 0.0
        };
        let mut nodes = self.grid.conditions.nodes_of(condition).iter();
        any(&self.grid.condition_fields, condition) || nodes.any(|&node| any(&self.grid.node_fields, node as usize))
    }

    fn point(&self, condition: usize, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let node = self.grid.conditions.nodes_of(condition)[0];
        let own = vector(&self.grid.condition_fields, &POINT_LOAD, condition);
        let nodal = vector(&self.grid.node_fields, &POINT_LOAD, node as usize);
        let ring = if self.axisymmetric { TAU * self.radius(node, dofs, increments) } else { 1.0 };
        add_force(dofs, node, ring, [own[0] + nodal[0], own[1] + nodal[1], own[2] + nodal[2]], forces);
    }

    /// Two Gauss points a direction on lines and quadrilaterals, three on triangles; the grid does
    /// not move, so the traction is that of the undeformed face.
    fn surface(&self, condition: usize, shape: Shape, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let nodes = self.grid.conditions.nodes_of(condition);
        let corners = self.grid.corners(&self.grid.conditions, condition);
        let (variable, count) = match shape {
            Shape::Line2 => (&LINE_LOAD, 2),
            Shape::Triangle3 => (&SURFACE_LOAD, 3),
            _ => (&SURFACE_LOAD, 4),
        };
        // A positive face pressure pushes along the normal of a line but against that of a face,
        // as in Kratos.
        let sign = if shape == Shape::Line2 { 1.0 } else { -1.0 };
        let load = vector(&self.grid.condition_fields, variable, condition);
        let pressure = self.pressure(&self.grid.condition_fields, condition);
        let mut functions = [0.0; 4];
        for point in rule(shape, count).unwrap_or_default() {
            shape.functions(point.xi, &mut functions[..nodes.len()]);
            let [first, second] = tangents(shape, &corners, point.xi);
            // The normal's length is the measure of the face.
            let normal = if shape == Shape::Line2 { [first[1], -first[0], 0.0] } else { cross(first, second) };
            let measure = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let mut total_load = load;
            let mut total_pressure = pressure;
            let mut ring = 1.0;
            if self.axisymmetric {
                let radii = nodes.iter().zip(functions).map(|(&node, n)| n * self.radius(node, dofs, increments));
                ring = TAU * radii.sum::<f64>();
            }
            for (&node, n) in nodes.iter().zip(functions) {
                let nodal = vector(&self.grid.node_fields, variable, node as usize);
                (0..3).for_each(|i| total_load[i] += n * nodal[i]);
                total_pressure += n * self.pressure(&self.grid.node_fields, node as usize);
            }
            let traction: [f64; 3] =
                std::array::from_fn(|i| measure * total_load[i] + sign * total_pressure * normal[i]);
            for (&node, n) in nodes.iter().zip(functions) {
                add_force(dofs, node, n * point.weight * ring, traction, forces);
            }
        }
    }

    /// Positive minus negative face pressure.
    fn pressure(&self, fields: &Fields, index: usize) -> f64 {
        let value = |variable| fields.scalar(variable).map_or(0.0, |column| column[index]);
        value(&POSITIVE_FACE_PRESSURE) - value(&NEGATIVE_FACE_PRESSURE)
    }

    fn radius(&self, node: u32, dofs: &ActiveDofs, increments: &[f64]) -> f64 {
        let moved = dofs.number(node).and_then(|number| increments.get(number * dofs.block())).copied().unwrap_or(0.0);
        self.grid.nodes.coordinates[node as usize][0] + moved
    }
}

fn vector(fields: &Fields, variable: &Variable, index: usize) -> [f64; 3] {
    fields.vector(variable).map_or([0.0; 3], |column| column[index])
}

/// Nodes without points have no dofs: a load there acts on nothing.
fn add_force(dofs: &ActiveDofs, node: u32, share: f64, force: [f64; 3], forces: &mut [f64]) {
    if let Some(number) = dofs.number(node) {
        for a in 0..dofs.block() {
            forces[number * dofs.block() + a] += share * force[a];
        }
    }
}
