//! Nodal forces of grid loads and of loads on material-point conditions (spec 07 §1-2).

use crate::points::conditions::PointConditions;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::loads::ConditionLoads;

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
    fn of_grid(&self) -> ConditionLoads<'_> {
        ConditionLoads { part: self.grid, axisymmetric: self.axisymmetric }
    }

    /// Adds all nodal forces to a vector over the active dofs. Under axisymmetry loads act at the
    /// current radius, so the increments matter; an empty slice stands for zeros.
    pub fn add(&self, dofs: &ActiveDofs, increments: &[f64], forces: &mut [f64]) {
        let of_grid = self.of_grid();
        for &condition in &self.conditions.grid {
            of_grid.add(condition as usize, dofs, increments, forces);
        }
        for i in 0..self.conditions.len() {
            let cell = self.conditions.cell[i] as usize;
            let shape = self.grid.elements.shapes[cell];
            let mut functions = [0.0; 8];
            shape.functions(self.conditions.local[i], &mut functions[..shape.node_count()]);
            for (&node, share) in self.grid.elements.nodes_of(cell).iter().zip(functions) {
                dofs.add_force(node, share, self.conditions.load[i], forces);
            }
        }
    }

    /// A loaded grid node without dofs: no material point reaches it, so its share of the load is lost.
    pub fn idle_node(&self, dofs: &ActiveDofs) -> Option<u32> {
        let loads = self.of_grid();
        let loaded = self.conditions.grid.iter().filter(|&&condition| loads.is_loaded(condition as usize));
        let of_grid = loaded.flat_map(|&condition| self.grid.conditions.nodes_of(condition as usize));
        let pulled = (0..self.conditions.len()).filter(|&i| self.conditions.load[i] != [0.0; 3]);
        let of_points = pulled.flat_map(|i| self.grid.elements.nodes_of(self.conditions.cell[i] as usize));
        of_grid.chain(of_points).copied().find(|&node| dofs.number(node).is_none())
    }
}
