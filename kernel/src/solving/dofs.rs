//! The unknowns: a block of dofs on each active node.

use crate::model::Cells;

/// Marks a node without dofs.
const NONE: u32 = u32::MAX;

/// Numbering of the active nodes, ascending, with `block` dofs each.
#[derive(Debug, Clone, Default)]
pub struct ActiveDofs {
    block: usize,
    nodes: Vec<u32>,
    numbers: Vec<u32>,
    fixed: Vec<bool>,
}

impl ActiveDofs {
    /// Numbers the nodes for which `active` holds; nothing is fixed yet.
    pub fn new(block: usize, active: &[bool]) -> Self {
        let nodes: Vec<u32> = (0..active.len() as u32).filter(|&n| active[n as usize]).collect();
        let mut numbers = vec![NONE; active.len()];
        for (number, &node) in nodes.iter().enumerate() {
            numbers[node as usize] = number as u32;
        }
        Self { block, fixed: vec![false; block * nodes.len()], nodes, numbers }
    }

    /// Numbers the nodes of these cells.
    pub fn of_cells(block: usize, nodes: usize, cells: &Cells, chosen: &[u32]) -> Self {
        let mut active = vec![false; nodes];
        for &cell in chosen {
            cells.nodes_of(cell as usize).iter().for_each(|&node| active[node as usize] = true);
        }
        Self::new(block, &active)
    }

    /// Dofs a node.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Active nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Number of a node among the active ones.
    pub fn number(&self, node: u32) -> Option<usize> {
        match self.numbers.get(node as usize) {
            Some(&number) if number != NONE => Some(number as usize),
            _ => None,
        }
    }

    /// All dofs, fixed ones too.
    pub fn order(&self) -> usize {
        self.fixed.len()
    }

    /// Dofs that are not fixed.
    pub fn free(&self) -> usize {
        self.fixed.iter().filter(|fixed| !**fixed).count()
    }

    /// Which dofs are fixed: entry `number * block + component`.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Which dofs are fixed, to be changed.
    pub fn fixed_mut(&mut self) -> &mut [bool] {
        &mut self.fixed
    }

    /// The active nodes, and which of their dofs are fixed, to be changed.
    pub fn nodes_and_fixed_mut(&mut self) -> (&[u32], &mut [bool]) {
        (&self.nodes, &mut self.fixed)
    }

    /// Values of a cell's nodes out of a vector over the dofs; zeros if it is empty.
    #[inline]
    pub fn gather<const D: usize, const N: usize>(&self, nodes: &[u32], values: &[f64]) -> [[f64; D]; N] {
        std::array::from_fn(|i| match self.number(nodes[i]) {
            Some(number) if !values.is_empty() => std::array::from_fn(|a| values[number * D + a]),
            _ => [0.0; D],
        })
    }

    /// The vector over the dofs of a column of all nodes; zeros if there is none.
    pub fn collect(&self, column: Option<&[[f64; 3]]>) -> Vec<f64> {
        let value = |dof| {
            let (node, a) = self.node_of(dof);
            column.map_or(0.0, |column| column[node as usize][a])
        };
        (0..self.order()).map(value).collect()
    }

    /// Writes a vector over the dofs to a column of all nodes; other nodes keep their values.
    pub fn scatter(&self, values: &[f64], column: &mut [[f64; 3]]) {
        for (&node, values) in self.nodes.iter().zip(values.chunks_exact(self.block.max(1))) {
            column[node as usize][..self.block].copy_from_slice(values);
        }
    }

    /// Adds a share of a force to a node; a node without dofs takes none.
    pub fn add_force(&self, node: u32, share: f64, force: [f64; 3], forces: &mut [f64]) {
        if let Some(number) = self.number(node) {
            for a in 0..self.block {
                forces[number * self.block + a] += share * force[a];
            }
        }
    }

    /// The node index and component of a dof.
    pub fn node_of(&self, dof: usize) -> (u32, usize) {
        (self.nodes[dof / self.block], dof % self.block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_active_nodes_are_numbered() {
        let mut dofs = ActiveDofs::new(2, &[false, true, false, true]);
        assert_eq!(dofs.nodes(), [1, 3]);
        assert_eq!((dofs.number(3), dofs.number(2), dofs.number(9)), (Some(1), None, None));
        dofs.fixed_mut()[2] = true;
        assert_eq!((dofs.order(), dofs.free(), dofs.node_of(3)), (4, 3, (3, 1)));
        let column = [[0.0; 3], [1.0, 2.0, 9.0], [5.0; 3], [3.0, 4.0, 9.0]];
        let values = dofs.collect(Some(&column));
        assert_eq!((values.as_slice(), dofs.collect(None)), (&[1.0, 2.0, 3.0, 4.0][..], vec![0.0; 4]));
        assert_eq!(dofs.gather::<2, 3>(&[3, 0, 1], &values), [[3.0, 4.0], [0.0; 2], [1.0, 2.0]]);
        let mut back = [[7.0; 3]; 4];
        dofs.scatter(&values, &mut back);
        assert_eq!(back, [[7.0; 3], [1.0, 2.0, 7.0], [7.0; 3], [3.0, 4.0, 7.0]]);
    }
}
