//! LU factorisation of structurally symmetric matrices by the multifrontal method.
//!
//! (Duff and Reid 1983; threshold pivoting with delayed pivots as in Amestoy, Duff, L'Excellent and Koster 2001.)
//! Nodes are eliminated in an order of low fill-in of the symmetric pattern, which makes the factors of finite element
//! matrices several times smaller than those of an order for the worst row exchanges (COLAMD) would be. Where a pivot
//! is too small, its elimination waits until the parent in the tree has more rows to choose from, so that saddle points
//! with a vanishing block need no special order.

mod front;
mod tree;

pub use tree::minimum_degree;

use super::factors::{Factorisation, zeros};
use crate::equilibration::Equilibration;
use crate::{BlockMatrix, BlockPattern, LinearError};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use front::Front;
use rayon::prelude::*;
use std::ops::Range;
use tree::{Supernode, Tree};

/// `P R A C Q = L U` with diagonal scalings `R` and `C`.
#[derive(Default)]
pub struct Lu(Option<Analysis>);

struct Analysis {
    block: usize,
    tree: Tree,
    /// For each block (i, j) of the pattern the index of block (j, i).
    transposed: Vec<u32>,
    scaling: Equilibration,
    factors: Vec<Eliminated>,
}

/// What the elimination of a supernode leaves. Variables are unknowns in the order of the steps.
#[derive(Default)]
struct Eliminated {
    pivots: usize,
    /// Variables that were fully summed; those beyond the pivots are left to the parent.
    summed: usize,
    rows: Vec<u32>,
    columns: Vec<u32>,
    /// `L`, and `U` on and above the diagonal, of the pivots' columns; all rows.
    lower: Vec<f64>,
    /// `U` of the pivots' rows; the other columns.
    upper: Vec<f64>,
    /// Schur complement, waiting for the parent; all but the pivots.
    rest: Vec<f64>,
}

/// Memory of one thread.
struct Workspace {
    front: Front,
    row_place: Vec<u32>,
    column_place: Vec<u32>,
    /// Where the rows of a contribution go.
    targets: Vec<u32>,
}

impl Factorisation for Lu {
    const NAME: &'static str = "sparse LU factorisation (multifrontal)";

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        let tree = Tree::new(pattern)?;
        let factors = tree.supernodes.iter().map(|_| Eliminated::default()).collect();
        let transposed = pattern.transposed_positions();
        let scaling = Equilibration::default();
        self.0 = Some(Analysis { block: pattern.block(), tree, transposed, scaling, factors });
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(Analysis { tree, transposed, scaling, factors, .. }) = &mut self.0 else { return Ok(()) };
        scaling.set_up(a);
        let assembly = Assembly { a, tree, transposed, scaling };
        let order = a.pattern.order();
        let (mut tasks, mut rest, mut cut) = (Vec::with_capacity(tree.tasks.len()), &mut factors[..], 0);
        for task in &tree.tasks {
            let (slots, after) = rest.split_at_mut(task.start - cut).1.split_at_mut(task.len());
            (rest, cut) = (after, task.end);
            tasks.push((task.clone(), slots));
        }
        tasks
            .into_par_iter()
            .try_for_each_init(|| Workspace::new(order), |work, (task, slots)| assembly.eliminate(task, slots, work))?;
        let mut work = Workspace::new(order);
        for &index in &tree.top {
            assembly.eliminate_one(index, &mut factors[..=index], 0, &mut work)?;
        }
        Ok(())
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        let Some(Analysis { block, tree, scaling, factors, .. }) = &self.0 else { return Ok(()) };
        let order = tree.nodes.len() * block;
        let dof = |variable: usize| tree.nodes[variable / block] as usize * block + variable % block;
        let mut forward = zeros(order * columns)?;
        for (work, rhs) in forward.chunks_exact_mut(order).zip(rhs.chunks_exact(order)) {
            work.iter_mut().enumerate().for_each(|(i, work)| *work = rhs[dof(i)] * scaling.rows[dof(i)]);
        }
        let mut local = Vec::new();
        factors.iter().for_each(|factor| factor.forward(&mut forward, order, &mut local));
        let mut solution = zeros(order * columns)?;
        factors.iter().rev().for_each(|factor| factor.backward(&forward, &mut solution, order, &mut local));
        for (solution, rhs) in solution.chunks_exact(order).zip(rhs.chunks_exact_mut(order)) {
            solution.iter().enumerate().for_each(|(i, value)| rhs[dof(i)] = value * scaling.columns[dof(i)]);
        }
        Ok(())
    }
}

impl Workspace {
    fn new(order: usize) -> Self {
        Self { front: Front::default(), row_place: vec![0; order], column_place: vec![0; order], targets: Vec::new() }
    }
}

/// What fronts are assembled from.
struct Assembly<'a> {
    a: &'a BlockMatrix,
    tree: &'a Tree,
    transposed: &'a [u32],
    scaling: &'a Equilibration,
}

impl Assembly<'_> {
    /// Works through a whole subtree, whose results go to `slots`.
    fn eliminate(&self, task: Range<usize>, slots: &mut [Eliminated], work: &mut Workspace) -> Result<(), LinearError> {
        task.clone()
            .try_for_each(|index| self.eliminate_one(index, &mut slots[..=index - task.start], task.start, work))
    }

    /// Eliminates supernode `index`, whose slot is the last of `slots`; the first belongs to supernode `first`.
    fn eliminate_one(
        &self,
        index: usize,
        slots: &mut [Eliminated],
        first: usize,
        work: &mut Workspace,
    ) -> Result<(), LinearError> {
        let supernode = &self.tree.supernodes[index];
        let Some((slot, before)) = slots.split_last_mut() else { return Ok(()) };
        self.prepare(supernode, before, first, work)?;
        self.add_matrix(supernode, work);
        for &child in &supernode.children {
            before[child as usize - first].contribute(work);
        }
        let pivots = work.front.eliminate();
        slot.take(&work.front, pivots)
    }

    /// Lists the variables of a front and sets it to zero.
    fn prepare(
        &self,
        supernode: &Supernode,
        before: &[Eliminated],
        first: usize,
        work: &mut Workspace,
    ) -> Result<(), LinearError> {
        let Workspace { front, row_place, column_place, .. } = work;
        let block = self.a.pattern.block() as u32;
        let children = || supernode.children.iter().map(|&child| &before[child as usize - first]);
        let below = || self.tree.rows_of(supernode).iter().flat_map(|&step| step * block..(step + 1) * block);
        let own = supernode.steps.start as u32 * block..supernode.steps.end as u32 * block;
        for (variables, place, of_rows) in
            [(&mut front.rows, row_place, true), (&mut front.columns, column_place, false)]
        {
            variables.clear();
            variables.extend(own.clone());
            children().for_each(|child| variables.extend(child.delayed(of_rows)));
            front.summed = variables.len();
            variables.extend(below());
            for (index, &variable) in variables.iter().enumerate() {
                place[variable as usize] = index as u32;
            }
        }
        let entries = front.rows.len() * front.rows.len();
        front.values.clear();
        front.values.try_reserve(entries).map_err(|_| LinearError::OutOfMemory)?;
        front.values.resize(entries, 0.0);
        Ok(())
    }

    /// Adds the rows and columns of the matrix that belong to the pivots.
    fn add_matrix(&self, supernode: &Supernode, work: &mut Workspace) {
        let (pattern, block) = (&*self.a.pattern, self.a.pattern.block());
        let Workspace { front, row_place, column_place, .. } = work;
        let size = front.size();
        let mut add = |entry: usize, row: usize, column: usize| {
            let (i, j) = (self.tree.steps[row] as usize * block, self.tree.steps[column] as usize * block);
            let values = self.a.values[entry * block * block..(entry + 1) * block * block].chunks_exact(block);
            let (rows, columns) = (row_place[i] as usize, column_place[j] as usize);
            for (k, values) in values.enumerate() {
                let scale = self.scaling.rows[row * block + k];
                for (l, value) in values.iter().enumerate() {
                    front.values[(columns + l) * size + rows + k] +=
                        scale * value * self.scaling.columns[column * block + l];
                }
            }
        };
        for &node in &self.tree.nodes[supernode.steps.clone()] {
            for entry in pattern.row(node as usize) {
                let other = pattern.columns()[entry] as usize;
                let step = self.tree.steps[other] as usize;
                if step >= supernode.steps.start {
                    add(entry, node as usize, other);
                }
                if step >= supernode.steps.end {
                    add(self.transposed[entry] as usize, other, node as usize);
                }
            }
        }
    }
}

impl Eliminated {
    /// Fully summed variables of rows or columns that found no pivot.
    fn delayed(&self, of_rows: bool) -> &[u32] {
        let variables = if of_rows { &self.rows } else { &self.columns };
        &variables[self.pivots..self.summed]
    }

    /// `L y = b` for the pivots of the front.
    fn forward(&self, work: &mut [f64], order: usize, local: &mut Vec<f64>) {
        let (size, pivots) = (self.rows.len(), self.pivots);
        local.clear();
        for work in work.chunks_exact(order) {
            local.extend(self.rows.iter().map(|&row| work[row as usize]));
        }
        let lower = MatRef::from_column_major_slice(&self.lower, size, pivots);
        let count = work.len() / order;
        let (mut above, below) = MatMut::from_column_major_slice_mut(local, size, count).split_at_row_mut(pivots);
        solve_unit_lower_triangular_in_place(lower.subrows(0, pivots), above.rb_mut(), Par::Seq);
        matmul(below, Accum::Add, lower.subrows(pivots, size - pivots), above.rb(), -1.0, Par::Seq);
        for (work, local) in work.chunks_exact_mut(order).zip(local.chunks_exact(size)) {
            self.rows.iter().zip(local).for_each(|(&row, &value)| work[row as usize] = value);
        }
    }

    /// `U x = y` for the pivots of the front.
    fn backward(&self, work: &[f64], solution: &mut [f64], order: usize, local: &mut Vec<f64>) {
        let (size, pivots) = (self.rows.len(), self.pivots);
        local.clear();
        for (work, solution) in work.chunks_exact(order).zip(solution.chunks_exact(order)) {
            local.extend(self.rows[..pivots].iter().map(|&row| work[row as usize]));
            local.extend(self.columns[pivots..].iter().map(|&column| solution[column as usize]));
        }
        let square = MatRef::from_column_major_slice(&self.lower, size, pivots).subrows(0, pivots);
        let upper = MatRef::from_column_major_slice(&self.upper, pivots, size - pivots);
        let count = work.len() / order;
        let (mut above, below) = MatMut::from_column_major_slice_mut(local, size, count).split_at_row_mut(pivots);
        matmul(above.rb_mut(), Accum::Add, upper, below.rb(), -1.0, Par::Seq);
        solve_upper_triangular_in_place(square, above, Par::Seq);
        for (solution, local) in solution.chunks_exact_mut(order).zip(local.chunks_exact(size)) {
            self.columns[..pivots].iter().zip(local).for_each(|(&column, &value)| solution[column as usize] = value);
        }
    }

    /// Takes over the result of an elimination.
    fn take(&mut self, front: &Front, pivots: usize) -> Result<(), LinearError> {
        self.pivots = pivots;
        self.summed = front.summed;
        let (size, Self { rows, columns, lower, upper, rest, .. }) = (front.size(), self);
        let others = size - pivots;
        rows.clone_from(&front.rows);
        columns.clone_from(&front.columns);
        for (target, length) in
            [(&mut *lower, size * pivots), (&mut *upper, pivots * others), (&mut *rest, others * others)]
        {
            target.clear();
            target.try_reserve_exact(length).map_err(|_| LinearError::OutOfMemory)?;
        }
        lower.extend_from_slice(&front.values[..pivots * size]);
        for column in front.values[pivots * size..].chunks_exact(size) {
            upper.extend_from_slice(&column[..pivots]);
            rest.extend_from_slice(&column[pivots..]);
        }
        Ok(())
    }

    /// Adds the Schur complement to the front of the parent.
    fn contribute(&mut self, work: &mut Workspace) {
        let Workspace { front, row_place, column_place, targets } = work;
        let (size, count) = (front.size(), self.rows.len() - self.pivots);
        if count == 0 {
            return;
        }
        targets.clear();
        targets.extend(self.rows[self.pivots..].iter().map(|&row| row_place[row as usize]));
        for (values, &column) in self.rest.chunks_exact(count).zip(&self.columns[self.pivots..]) {
            let column = &mut front.values[column_place[column as usize] as usize * size..][..size];
            for (value, &target) in values.iter().zip(targets.iter()) {
                column[target as usize] += value;
            }
        }
        self.rest = Vec::new();
    }
}
