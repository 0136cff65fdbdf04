//! Nodal forces of grid loads and of loads on material-point conditions (spec 07 §1-2).

use crate::points::conditions::{PointConditions, cross, tangents};
use crate::space::Space;
use crate::variables::{LINE_LOAD, NEGATIVE_FACE_PRESSURE, POINT_LOAD, POSITIVE_FACE_PRESSURE, SURFACE_LOAD};
use bia_kernel::geometry::{Shape, rule};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::variables::{Fields, Variable};
use std::f64::consts::TAU;

/// Functions up to this size vanish but for rounding.
const NEGLIGIBLE: f64 = 1e-9;

/// The loads of a scene.
pub struct Loads<'a> {
    /// The grid with its conditions.
    pub grid: &'a ModelPart,
    /// The grid's functions, through which loads act.
    pub space: &'a Space,
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
        let mut functions = Vec::new();
        for i in 0..self.conditions.len() {
            let cell = self.conditions.cell[i] as usize;
            self.space.evaluate(cell, self.conditions.local[i], &mut functions);
            for (&node, &share) in self.space.nodes_of(cell).iter().zip(&functions) {
                add_force(dofs, node, share, self.conditions.load[i], forces);
            }
        }
    }

    /// A place that is loaded through a function without dofs: no material point reaches it, so its
    /// share of the load is lost.
    pub fn idle_place(&self, dofs: &ActiveDofs) -> Option<String> {
        let loaded = self.conditions.grid.iter().filter(|&&condition| self.is_loaded(condition as usize));
        let mut functions = Vec::new();
        for node in loaded.flat_map(|&condition| self.grid.conditions.nodes_of(condition as usize)) {
            let x = self.grid.nodes.coordinates[*node as usize];
            let (targets, functions) = self.targets(x, std::slice::from_ref(node), &[1.0], &mut functions);
            if let Some(idle) = idle(targets, functions, dofs) {
                return Some(self.describe(idle));
            }
        }
        for i in (0..self.conditions.len()).filter(|&i| self.conditions.load[i] != [0.0; 3]) {
            let cell = self.conditions.cell[i] as usize;
            self.space.evaluate(cell, self.conditions.local[i], &mut functions);
            if let Some(idle) = idle(self.space.nodes_of(cell), &functions, dofs) {
                return Some(self.describe(idle));
            }
        }
        None
    }

    fn describe(&self, function: u32) -> String {
        let [x, y, z] = self.space.position(function as usize);
        format!("{} at ({x}, {y}, {z})", self.space.describe(self.grid, function))
    }

    /// The functions through which a load at `x` acts: those of the face's own nodes, as given, or
    /// those that a basis of higher order has there.
    fn targets<'b>(
        &'b self,
        x: [f64; 3],
        nodes: &'b [u32],
        of_nodes: &'b [f64],
        functions: &'b mut Vec<f64>,
    ) -> (&'b [u32], &'b [f64]) {
        if self.space.is_mesh() {
            return (nodes, of_nodes);
        }
        match self.space.evaluate_at(x, functions) {
            Some(cell) => (self.space.nodes_of(cell), functions),
            None => (&[], &[]),
        }
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
        let node = &self.grid.conditions.nodes_of(condition)[0];
        let own = vector(&self.grid.condition_fields, &POINT_LOAD, condition);
        let nodal = vector(&self.grid.node_fields, &POINT_LOAD, *node as usize);
        let load = [own[0] + nodal[0], own[1] + nodal[1], own[2] + nodal[2]];
        let mut functions = Vec::new();
        let x = self.grid.nodes.coordinates[*node as usize];
        let (targets, functions) = self.targets(x, std::slice::from_ref(node), &[1.0], &mut functions);
        let ring = self.ring(targets, functions, dofs, increments);
        for (&target, &share) in targets.iter().zip(functions) {
            add_force(dofs, target, share * ring, load, forces);
        }
    }

    /// Two Gauss points a direction on lines and quadrilaterals, three on triangles, more for functions
    /// of higher order; the grid does not move, so the traction is that of the undeformed face.
    fn surface(&self, condition: usize, shape: Shape, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let nodes = self.grid.conditions.nodes_of(condition);
        let corners = self.grid.corners(&self.grid.conditions, condition);
        let along = self.space.degree() + 1;
        let (variable, count) = match shape {
            Shape::Line2 => (&LINE_LOAD, along),
            Shape::Triangle3 if self.space.is_mesh() => (&SURFACE_LOAD, 3),
            Shape::Triangle3 => (&SURFACE_LOAD, 12),
            _ => (&SURFACE_LOAD, along * along),
        };
        // A positive face pressure pushes along the normal of a line but against that of a face,
        // as in Kratos.
        let sign = if shape == Shape::Line2 { 1.0 } else { -1.0 };
        let load = vector(&self.grid.condition_fields, variable, condition);
        let pressure = self.pressure(&self.grid.condition_fields, condition);
        let (mut functions, mut of_space) = ([0.0; 4], Vec::new());
        for point in rule(shape, count).unwrap_or_default() {
            shape.functions(point.xi, &mut functions[..nodes.len()]);
            let of_face = &functions[..nodes.len()];
            let x = std::array::from_fn(|i| of_face.iter().zip(&corners).map(|(n, corner)| n * corner[i]).sum());
            let (targets, of_targets) = self.targets(x, nodes, of_face, &mut of_space);
            let [first, second] = tangents(shape, &corners, point.xi);
            // The normal's length is the measure of the face.
            let normal = if shape == Shape::Line2 { [first[1], -first[0], 0.0] } else { cross(first, second) };
            let measure = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let mut total_load = load;
            let mut total_pressure = pressure;
            let ring = self.ring(targets, of_targets, dofs, increments);
            for (&node, n) in nodes.iter().zip(functions) {
                let nodal = vector(&self.grid.node_fields, variable, node as usize);
                (0..3).for_each(|i| total_load[i] += n * nodal[i]);
                total_pressure += n * self.pressure(&self.grid.node_fields, node as usize);
            }
            let traction: [f64; 3] =
                std::array::from_fn(|i| measure * total_load[i] + sign * total_pressure * normal[i]);
            for (&target, n) in targets.iter().zip(of_targets) {
                add_force(dofs, target, n * point.weight * ring, traction, forces);
            }
        }
    }

    /// Positive minus negative face pressure.
    fn pressure(&self, fields: &Fields, index: usize) -> f64 {
        let value = |variable| fields.scalar(variable).map_or(0.0, |column| column[index]);
        value(&POSITIVE_FACE_PRESSURE) - value(&NEGATIVE_FACE_PRESSURE)
    }

    /// Circumference on which a load acts, 1 unless axisymmetric.
    fn ring(&self, targets: &[u32], functions: &[f64], dofs: &ActiveDofs, increments: &[f64]) -> f64 {
        if !self.axisymmetric {
            return 1.0;
        }
        let radius = |&function: &u32| {
            let number = dofs.number(function);
            let moved = number.and_then(|number| increments.get(number * dofs.block())).copied().unwrap_or(0.0);
            self.space.position(function as usize)[0] + moved
        };
        TAU * targets.iter().zip(functions).map(|(target, n)| n * radius(target)).sum::<f64>()
    }
}

/// The first of these functions that counts but has no dofs.
fn idle(targets: &[u32], functions: &[f64], dofs: &ActiveDofs) -> Option<u32> {
    let counts = |(target, n): &(&u32, &f64)| n.abs() > NEGLIGIBLE && dofs.number(**target).is_none();
    targets.iter().zip(functions).find(counts).map(|(target, _)| *target)
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
