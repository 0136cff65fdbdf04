//! Nodal forces of grid loads and of loads on material-point conditions (spec 07 §1-2).

use crate::points::conditions::PointConditions;
use crate::space::Space;
use bia_kernel::geometry::Shape;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::loads::{is_loaded, linear_rule, visit_loads};
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
            self.add_condition(condition as usize, dofs, increments, forces);
        }
        let mut functions = Vec::new();
        for i in 0..self.conditions.len() {
            let cell = self.conditions.cell[i] as usize;
            self.space.evaluate(cell, self.conditions.local[i], &mut functions);
            for (&node, &share) in self.space.nodes_of(cell).iter().zip(&functions) {
                dofs.add_force(node, share, self.conditions.load[i], forces);
            }
        }
    }

    /// A place that is loaded through a function without dofs: no material point reaches it, so its
    /// share of the load is lost.
    fn idle_place(&self, dofs: &ActiveDofs) -> Option<String> {
        let loaded = self.conditions.grid.iter().filter(|&&condition| is_loaded(self.grid, condition as usize));
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

    /// Warns, once, of a load that acts where no material point is.
    pub fn tell_idle(&self, dofs: &ActiveDofs, told: &mut bool) {
        if *told {
            return;
        }
        if let Some(place) = self.idle_place(dofs) {
            *told = true;
            tracing::warn!(
                "a load acts on {place}, which no material point reaches: \
                 that share of it has no effect, as in Kratos"
            );
        }
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

    /// Faces of a basis of higher order take more integration points; the grid does not move, so the
    /// traction is that of the undeformed face.
    fn add_condition(&self, condition: usize, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let along = self.space.degree() + 1;
        let count = |shape: Shape| match shape {
            _ if self.space.is_mesh() => linear_rule(shape),
            Shape::Point1 => 1,
            Shape::Line2 => along,
            Shape::Triangle3 => 12,
            _ => along * along,
        };
        let mut of_space = Vec::new();
        visit_loads(self.grid, condition, count, &mut |at| {
            let (targets, functions) = self.targets(at.position, at.nodes, at.functions, &mut of_space);
            let ring = self.ring(targets, functions, dofs, increments);
            for (&target, n) in targets.iter().zip(functions) {
                dofs.add_force(target, n * at.weight * ring, at.load, forces);
            }
        });
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

/// Whether any condition carries a load now.
pub fn are_any(grid: &ModelPart, conditions: &PointConditions) -> bool {
    conditions.grid.iter().any(|&condition| is_loaded(grid, condition as usize))
        || conditions.load.iter().any(|load| *load != [0.0; 3])
}

/// The first of these functions that counts but has no dofs.
fn idle(targets: &[u32], functions: &[f64], dofs: &ActiveDofs) -> Option<u32> {
    let counts = |(target, n): &(&u32, &f64)| n.abs() > NEGLIGIBLE && dofs.number(**target).is_none();
    targets.iter().zip(functions).find(counts).map(|(target, _)| *target)
}
