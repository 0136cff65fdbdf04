//! The elimination tree of the nodes, cut into supernodes.

use crate::direct::factors::{allocate, out_of_memory};
use crate::{BlockPattern, LinearError};
use faer::Side;
use faer::dyn_stack::MemStack;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams, amd};
use std::ops::Range;

/// Neighbouring supernodes of at most so many nodes are merged where less than that part of the result is zero.
const MERGE: &[(usize, f64)] = &[(4, 1.0), (12, 0.6), (32, 0.2), (usize::MAX, 0.05)];
/// Subtrees that one thread works through hold at most this part of all work.
const TASK_SHARE: f64 = 1.0 / 16.0;

/// Consecutive steps of the elimination whose columns of `L` share their structure.
#[derive(Debug)]
pub struct Supernode {
    /// Steps at which its nodes are eliminated.
    pub steps: Range<usize>,
    /// Later steps that its nodes are coupled with, ascending; an index range of [`Tree::rows`].
    pub rows: Range<usize>,
    /// Supernodes whose first row is one of `steps`, ascending.
    pub children: Vec<u32>,
}

/// Supernodes in postorder: the descendants of one stand right before it.
#[derive(Debug)]
pub struct Tree {
    pub supernodes: Vec<Supernode>,
    pub rows: Vec<u32>,
    /// Node eliminated at each step.
    pub nodes: Vec<u32>,
    /// Step at which each node is eliminated.
    pub steps: Vec<u32>,
    /// Disjoint subtrees of little work, ascending.
    pub tasks: Vec<Range<usize>>,
    /// The supernodes in none of the tasks: those near the roots, ascending.
    pub top: Vec<usize>,
}

/// Approximate minimum degree order of the nodes (Amestoy, Davis and Duff 1996) and its inverse: the unknowns of a node
/// have the same neighbours, so ordering nodes is as good as ordering unknowns and much cheaper.
pub fn minimum_degree(pattern: &BlockPattern) -> Result<(Vec<u32>, Vec<u32>), LinearError> {
    let rows = pattern.rows();
    let (mut forward, mut inverse) = (vec![0u32; rows], vec![0u32; rows]);
    let mut memory = allocate(amd::order_scratch::<u32>(rows, pattern.entries()))?;
    amd::order(&mut forward, &mut inverse, graph(pattern), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(out_of_memory)?;
    Ok((forward, inverse))
}

/// The pattern of blocks as one of scalars.
fn graph(pattern: &BlockPattern) -> SymbolicSparseColMatRef<'_, u32> {
    let rows = pattern.rows();
    SymbolicSparseColMatRef::new_checked(rows, rows, pattern.row_start(), None, pattern.columns())
}

impl Tree {
    pub fn new(pattern: &BlockPattern) -> Result<Self, LinearError> {
        let (forward, inverse) = minimum_degree(pattern)?;
        let symbolic = factorize_symbolic_cholesky(
            graph(pattern),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, pattern.rows())),
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                supernodal_params: SymbolicSupernodalParams { relax: Some(MERGE) },
                ..Default::default()
            },
        )
        .map_err(out_of_memory)?;
        let SymbolicCholeskyRaw::Supernodal(raw) = symbolic.raw() else { return Err(LinearError::OutOfMemory) };
        let (nodes, steps) = symbolic.perm().map_or((forward.clone(), inverse.clone()), |perm| {
            let (forward, inverse) = perm.arrays();
            (forward.to_vec(), inverse.to_vec())
        });
        let supernodes = (0..raw.n_supernodes()).map(|index| Supernode {
            steps: raw.supernode_begin()[index] as usize..raw.supernode_end()[index] as usize,
            rows: raw.col_ptr_for_row_idx()[index] as usize..raw.col_ptr_for_row_idx()[index + 1] as usize,
            children: Vec::new(),
        });
        let (supernodes, roots) = postordered(supernodes.collect(), raw.row_idx());
        let mut tree =
            Self { supernodes, rows: raw.row_idx().to_vec(), nodes, steps, tasks: Vec::new(), top: Vec::new() };
        tree.cut(&roots);
        Ok(tree)
    }

    /// Steps of the rows below the pivots of a supernode.
    pub fn rows_of(&self, supernode: &Supernode) -> &[u32] {
        &self.rows[supernode.rows.clone()]
    }

    /// Cuts subtrees of little work off the tree.
    fn cut(&mut self, roots: &[usize]) {
        let mut work = vec![0.0; self.supernodes.len()];
        let mut first = vec![0; self.supernodes.len()];
        for (index, supernode) in self.supernodes.iter().enumerate() {
            let (pivots, rows) = (supernode.steps.len() as f64, supernode.rows.len() as f64);
            let children = || supernode.children.iter().map(|&child| child as usize);
            work[index] = pivots * (pivots + rows) * (pivots + rows) + children().map(|c| work[c]).sum::<f64>();
            first[index] = children().map(|c| first[c]).min().unwrap_or(index);
        }
        let limit = TASK_SHARE * roots.iter().map(|&root| work[root]).sum::<f64>();
        let mut waiting = roots.to_vec();
        while let Some(index) = waiting.pop() {
            if work[index] <= limit {
                self.tasks.push(first[index]..index + 1);
            } else {
                self.top.push(index);
                waiting.extend(self.supernodes[index].children.iter().map(|&child| child as usize));
            }
        }
        self.tasks.sort_by_key(|task| task.start);
        self.top.sort_unstable();
    }
}

/// Renumbers supernodes so that descendants stand right before their ancestor, and fills in the children; returns the
/// roots as well.
fn postordered(supernodes: Vec<Supernode>, rows: &[u32]) -> (Vec<Supernode>, Vec<usize>) {
    let count = supernodes.len();
    let holding = |step: u32| supernodes.partition_point(|supernode| supernode.steps.end <= step as usize);
    let mut children = vec![Vec::new(); count];
    let mut roots = Vec::new();
    for (index, supernode) in supernodes.iter().enumerate() {
        match rows.get(supernode.rows.clone()).and_then(|rows| rows.first()) {
            Some(&first) => children[holding(first)].push(index),
            None => roots.push(index),
        }
    }
    // Backwards: ancestors first, the last child first.
    let mut order = Vec::with_capacity(count);
    let mut waiting = roots.clone();
    while let Some(index) = waiting.pop() {
        order.push(index);
        waiting.extend(&children[index]);
    }
    order.reverse();
    let mut place = vec![0; count];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new;
    }
    let renumbered = |old: usize| {
        let mut own: Vec<u32> = children[old].iter().map(|&child| place[child] as u32).collect();
        own.sort_unstable();
        let Supernode { steps, rows, .. } = &supernodes[old];
        Supernode { steps: steps.clone(), rows: rows.clone(), children: own }
    };
    (order.iter().map(|&old| renumbered(old)).collect(), roots.iter().map(|&root| place[root]).collect())
}
