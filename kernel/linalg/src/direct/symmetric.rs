//! Factorisations of symmetric matrices: `L L^T` and `L D L^T`.

use super::factors::{COLUMNS, Factorisation, ScalarColumns, allocate, check_size, out_of_memory, zeros};
use super::multifrontal::minimum_degree;
use crate::{BlockMatrix, BlockPattern, LinearError};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use std::marker::PhantomData;

/// One triangle of the matrix, the structure of its factor, and memory for both.
pub struct Analysis {
    columns: ScalarColumns,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Analysis {
    fn new(pattern: &BlockPattern, scratch: impl Fn(&SymbolicCholesky<u32>) -> StackReq) -> Result<Self, LinearError> {
        let columns = lower_structure(pattern)?;
        let order = pattern.order();
        let (forward, inverse) = minimum_degree(pattern)?;
        let (forward, inverse) = (expanded(&forward, pattern.block()), expanded(&inverse, pattern.block()));
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(order, order, &columns.start, None, &columns.rows),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, order)),
            CholeskySymbolicParams::default(),
        )
        .map_err(out_of_memory)?;
        let solve = symbolic.solve_in_place_scratch::<f64>(COLUMNS, Par::Seq);
        let memory = allocate(scratch(&symbolic).or(solve))?;
        let factor = zeros(symbolic.len_val())?;
        Ok(Self { columns, symbolic, factor, memory })
    }

    /// Row of the matrix that is eliminated at `step`.
    fn dof(&self, step: usize) -> usize {
        self.symbolic.perm().map_or(step, |perm| perm.arrays().0[step] as usize)
    }

    /// Converts the number of a failed pivot: faer counts from 1 in simplicial factors, from 0 in supernodal ones.
    fn dof_of_pivot(&self, index: usize) -> usize {
        let step = match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => index.saturating_sub(1),
            SymbolicCholeskyRaw::Supernodal(_) => index,
        };
        self.dof(step.min(self.symbolic.nrows().saturating_sub(1)))
    }
}

/// The scalar columns of the lower triangle, values still to be filled in.
fn lower_structure(pattern: &BlockPattern) -> Result<ScalarColumns, LinearError> {
    let block = pattern.block();
    check_size(pattern.entries() * block * block)?;
    let mut columns = ScalarColumns { start: vec![0], ..ScalarColumns::default() };
    for row in 0..pattern.rows() {
        let diagonal = pattern.diagonal()[row] as usize;
        for component in 0..block {
            columns.rows.extend((component..block).map(|i| (row * block + i) as u32));
            for &other in &pattern.columns()[diagonal + 1..pattern.row(row).end] {
                columns.rows.extend((0..block).map(|i| (other as usize * block + i) as u32));
            }
            columns.start.push(columns.rows.len() as u32);
        }
    }
    columns.values.resize(columns.rows.len(), 0.0);
    Ok(columns)
}

/// Column `j` of the lower triangle is row `j` of the upper one, which is contiguous in `a`.
fn fill_lower(a: &BlockMatrix, values: &mut [f64]) {
    let (pattern, block) = (&*a.pattern, a.pattern.block());
    let mut target = values.iter_mut();
    for row in 0..pattern.rows() {
        let diagonal = pattern.diagonal()[row] as usize;
        for component in 0..block {
            for entry in diagonal..pattern.row(row).end {
                let begin = (entry * block + component) * block;
                let skipped = if entry == diagonal { component } else { 0 };
                // The slice comes first: it ends the loop before another target is taken.
                for (value, target) in a.values[begin + skipped..begin + block].iter().zip(target.by_ref()) {
                    *target = *value;
                }
            }
        }
    }
}

/// An order of nodes, expanded to their unknowns.
fn expanded(order: &[u32], block: usize) -> Vec<u32> {
    order.iter().flat_map(|&node| (0..block).map(move |i| node * block as u32 + i as u32)).collect()
}

fn lower_view(columns: &ScalarColumns) -> SparseColMatRef<'_, u32, f64> {
    let order = columns.start.len() - 1;
    let structure = SymbolicSparseColMatRef::new_checked(order, order, &columns.start, None, &columns.rows);
    SparseColMatRef::new(structure, &columns.values)
}

/// A factorisation of one triangle.
#[derive(Default)]
pub struct Symmetric<K> {
    analysis: Option<Analysis>,
    kind: PhantomData<K>,
}

/// What distinguishes the factorisations of one triangle.
pub trait Kind: Default + Send {
    /// The method in words, for the log.
    const NAME: &'static str;

    /// Memory for [`Self::factorise`].
    fn scratch(symbolic: &SymbolicCholesky<u32>) -> StackReq;

    /// Computes the factor; on failure returns faer's number of the pivot.
    fn factorise(analysis: &mut Analysis) -> Result<(), usize>;

    /// What a failed pivot means.
    fn error(dof: usize) -> LinearError;

    /// Solves in place.
    fn solve(analysis: &mut Analysis, rhs: MatMut<'_, f64>);

    /// Number of negative pivots, where it says something.
    fn negative_pivots(analysis: &Analysis) -> Option<usize>;
}

impl<K: Kind> Factorisation for Symmetric<K> {
    const NAME: &'static str = K::NAME;

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        self.analysis = Some(Analysis::new(pattern, K::scratch)?);
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(analysis) = &mut self.analysis else { return Ok(()) };
        fill_lower(a, &mut analysis.columns.values);
        K::factorise(analysis).map_err(|pivot| K::error(analysis.dof_of_pivot(pivot)))
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        if let Some(analysis) = &mut self.analysis {
            let order = analysis.symbolic.nrows();
            K::solve(analysis, MatMut::from_column_major_slice_mut(rhs, order, columns));
        }
        Ok(())
    }

    fn negative_pivots(&self) -> Option<usize> {
        K::negative_pivots(self.analysis.as_ref()?)
    }
}

/// `A = L L^T`.
#[derive(Default)]
pub struct Cholesky;

impl Kind for Cholesky {
    const NAME: &'static str = "sparse Cholesky factorisation";

    fn scratch(symbolic: &SymbolicCholesky<u32>) -> StackReq {
        symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
    }

    fn factorise(analysis: &mut Analysis) -> Result<(), usize> {
        let Analysis { columns, symbolic, factor, memory } = analysis;
        let (a, stack) = (lower_view(columns), MemStack::new(memory));
        match symbolic.factorize_numeric_llt(
            factor,
            a,
            Side::Lower,
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        ) {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => Err(index),
        }
    }

    fn error(dof: usize) -> LinearError {
        LinearError::NotPositiveDefinite { dof }
    }

    fn solve(analysis: &mut Analysis, rhs: MatMut<'_, f64>) {
        let Analysis { symbolic, factor, memory, .. } = analysis;
        LltRef::new(symbolic, factor).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
    }

    fn negative_pivots(_: &Analysis) -> Option<usize> {
        None
    }
}

/// `A = L D L^T` without pivoting.
#[derive(Default)]
pub struct Ldlt;

impl Kind for Ldlt {
    const NAME: &'static str = "sparse L D L^T factorisation";

    fn scratch(symbolic: &SymbolicCholesky<u32>) -> StackReq {
        symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
    }

    fn factorise(analysis: &mut Analysis) -> Result<(), usize> {
        let Analysis { columns, symbolic, factor, memory } = analysis;
        let (a, stack) = (lower_view(columns), MemStack::new(memory));
        match symbolic.factorize_numeric_ldlt(
            factor,
            a,
            Side::Lower,
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        ) {
            Ok(_) => Ok(()),
            Err(LdltError::ZeroPivot { index }) => Err(index),
        }
    }

    fn error(dof: usize) -> LinearError {
        LinearError::Singular { dof }
    }

    fn solve(analysis: &mut Analysis, rhs: MatMut<'_, f64>) {
        let Analysis { symbolic, factor, memory, .. } = analysis;
        LdltRef::new(symbolic, factor).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
    }

    fn negative_pivots(analysis: &Analysis) -> Option<usize> {
        let Analysis { symbolic, factor, .. } = analysis;
        Some(match symbolic.raw() {
            // D stands in the place of the unit diagonal of L, first in each column.
            SymbolicCholeskyRaw::Simplicial(raw) => {
                raw.col_ptr()[..raw.ncols()].iter().filter(|&&start| factor[start as usize] < 0.0).count()
            }
            SymbolicCholeskyRaw::Supernodal(raw) => {
                let factors = SupernodalLdltRef::new(raw, factor);
                let negative = |supernode: usize| {
                    let values = factors.supernode(supernode).val();
                    (0..values.ncols()).filter(|&j| values[(j, j)] < 0.0).count()
                };
                (0..raw.n_supernodes()).map(negative).sum()
            }
        })
    }
}
