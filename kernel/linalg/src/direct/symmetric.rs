//! Factorisations of symmetric matrices: `L L^T`, `L D L^T`, and `L B L^T` with pivoting in supernodes.

use super::factors::{COLUMNS, Factorisation, ScalarColumns, allocate, check_size, out_of_memory};
use super::multifrontal::minimum_degree;
use crate::{BlockMatrix, BlockPattern, LinearError};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

/// One triangle of the matrix, the structure of its factor, and memory for both.
struct Analysis {
    columns: ScalarColumns,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Analysis {
    fn new(
        pattern: &BlockPattern,
        threshold: SupernodalThreshold,
        scratch: impl Fn(&SymbolicCholesky<u32>) -> StackReq,
    ) -> Result<Self, LinearError> {
        let columns = lower_structure(pattern)?;
        let order = pattern.order();
        let (forward, inverse) = minimum_degree(pattern)?;
        let (forward, inverse) = (expanded(&forward, pattern.block()), expanded(&inverse, pattern.block()));
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(order, order, &columns.start, None, &columns.rows),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, order)),
            CholeskySymbolicParams { supernodal_flop_ratio_threshold: threshold, ..Default::default() },
        )
        .map_err(out_of_memory)?;
        let solve = symbolic.solve_in_place_scratch::<f64>(COLUMNS, Par::Seq);
        let memory = allocate(scratch(&symbolic).or(solve))?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val()).map_err(|_| LinearError::OutOfMemory)?;
        factor.resize(symbolic.len_val(), 0.0);
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

/// `A = L L^T`.
#[derive(Default)]
pub struct Cholesky(Option<Analysis>);

impl Factorisation for Cholesky {
    const NAME: &'static str = "sparse Cholesky factorisation";

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        let scratch = |symbolic: &SymbolicCholesky<u32>| {
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
        };
        self.0 = Some(Analysis::new(pattern, SupernodalThreshold::AUTO, scratch)?);
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(analysis) = &mut self.0 else { return Ok(()) };
        fill_lower(a, &mut analysis.columns.values);
        let result = analysis.symbolic.factorize_numeric_llt(
            &mut analysis.factor,
            lower_view(&analysis.columns),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut analysis.memory),
            Default::default(),
        );
        let failed = match result {
            Ok(_) => return Ok(()),
            Err(LltError::NonPositivePivot { index }) => index,
        };
        Err(LinearError::NotPositiveDefinite { dof: analysis.dof_of_pivot(failed) })
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        if let Some(Analysis { symbolic, factor, memory, .. }) = &mut self.0 {
            let rhs = MatMut::from_column_major_slice_mut(rhs, symbolic.nrows(), columns);
            LltRef::new(symbolic, factor).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
        }
        Ok(())
    }
}

/// `A = L D L^T` without pivoting.
#[derive(Default)]
pub struct Ldlt(Option<Analysis>);

impl Factorisation for Ldlt {
    const NAME: &'static str = "sparse L D L^T factorisation";

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        let scratch = |symbolic: &SymbolicCholesky<u32>| {
            symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
        };
        self.0 = Some(Analysis::new(pattern, SupernodalThreshold::AUTO, scratch)?);
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(analysis) = &mut self.0 else { return Ok(()) };
        fill_lower(a, &mut analysis.columns.values);
        let result = analysis.symbolic.factorize_numeric_ldlt(
            &mut analysis.factor,
            lower_view(&analysis.columns),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut analysis.memory),
            Default::default(),
        );
        let failed = match result {
            Ok(_) => return Ok(()),
            Err(LdltError::ZeroPivot { index }) => index,
        };
        Err(LinearError::Singular { dof: analysis.dof_of_pivot(failed) })
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        if let Some(Analysis { symbolic, factor, memory, .. }) = &mut self.0 {
            let rhs = MatMut::from_column_major_slice_mut(rhs, symbolic.nrows(), columns);
            LdltRef::new(symbolic, factor).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
        }
        Ok(())
    }

    fn negative_pivots(&self) -> Option<usize> {
        let Analysis { symbolic, factor, .. } = self.0.as_ref()?;
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

/// `A = L B L^T` where `B` has blocks of 1 x 1 and 2 x 2 (Bunch and Kaufman 1977); pivots are exchanged only inside
/// supernodes, so that the structure of the factor is known beforehand.
#[derive(Default)]
pub struct PivotedLdlt(Option<Pivoted>);

struct Pivoted {
    analysis: Analysis,
    subdiagonal: Vec<f64>,
    forward: Vec<u32>,
    inverse: Vec<u32>,
}

impl Factorisation for PivotedLdlt {
    const NAME: &'static str = "sparse L B L^T factorisation with pivoting in supernodes";

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        let scratch = |symbolic: &SymbolicCholesky<u32>| {
            symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default())
        };
        // Without supernodes faer would not pivot at all.
        let analysis = Analysis::new(pattern, SupernodalThreshold::FORCE_SUPERNODAL, scratch)?;
        let order = pattern.order();
        let (forward, inverse) = (vec![0; order], vec![0; order]);
        self.0 = Some(Pivoted { analysis, subdiagonal: vec![0.0; order], forward, inverse });
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(Pivoted { analysis, subdiagonal, forward, inverse }) = &mut self.0 else { return Ok(()) };
        fill_lower(a, &mut analysis.columns.values);
        analysis.symbolic.factorize_numeric_intranode_lblt(
            &mut analysis.factor,
            subdiagonal,
            forward,
            inverse,
            lower_view(&analysis.columns),
            Side::Lower,
            Par::Seq,
            MemStack::new(&mut analysis.memory),
            Default::default(),
        );
        Ok(())
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        if let Some(Pivoted { analysis, subdiagonal, forward, inverse }) = &mut self.0 {
            let Analysis { symbolic, factor, memory, .. } = analysis;
            let order = symbolic.nrows();
            let factors =
                IntranodeLbltRef::new(symbolic, factor, subdiagonal, PermRef::new_checked(forward, inverse, order));
            let rhs = MatMut::from_column_major_slice_mut(rhs, order, columns);
            factors.solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
        }
        Ok(())
    }
}
