//! LU factorisation with partial pivoting.

use super::factors::{COLUMNS, Factorisation, ScalarColumns, allocate, check_size, out_of_memory};
use crate::{BlockMatrix, BlockPattern, LinearError};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// `P A Q = L U`, the columns ordered by COLAMD (Davis, Gilbert, Larimore and Ng 2004).
#[derive(Default)]
pub struct Lu(Option<Analysis>);

struct Analysis {
    columns: ScalarColumns,
    /// For each block (i, j) of the pattern the index of block (j, i).
    transposed: Vec<u32>,
    symbolic: SymbolicLu<u32>,
    numeric: NumericLu<u32, f64>,
    memory: MemBuffer,
}

/// The scalar columns of the whole matrix; its structure is symmetric, so rows serve as columns.
fn structure(pattern: &BlockPattern) -> Result<ScalarColumns, LinearError> {
    let block = pattern.block();
    check_size(pattern.entries() * block * block)?;
    let mut columns = ScalarColumns { start: vec![0], ..ScalarColumns::default() };
    for column in 0..pattern.rows() {
        for _ in 0..block {
            for &row in &pattern.columns()[pattern.row(column)] {
                columns.rows.extend((0..block).map(|i| (row as usize * block + i) as u32));
            }
            columns.start.push(columns.rows.len() as u32);
        }
    }
    columns.values.resize(columns.rows.len(), 0.0);
    Ok(columns)
}

fn fill(a: &BlockMatrix, transposed: &[u32], values: &mut [f64]) {
    let (pattern, block) = (&*a.pattern, a.pattern.block());
    let mut target = values.iter_mut();
    for column in 0..pattern.rows() {
        for component in 0..block {
            for &entry in &transposed[pattern.row(column)] {
                let source = a.values[entry as usize * block * block..].iter().skip(component).step_by(block);
                for (value, target) in source.take(block).zip(target.by_ref()) {
                    *target = *value;
                }
            }
        }
    }
}

impl Factorisation for Lu {
    const NAME: &'static str = "sparse LU factorisation";

    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError> {
        let columns = structure(pattern)?;
        let order = pattern.order();
        let view = SymbolicSparseColMatRef::new_checked(order, order, &columns.start, None, &columns.rows);
        let symbolic = factorize_symbolic_lu(view, Default::default()).map_err(out_of_memory)?;
        let factorise = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(COLUMNS, Par::Seq);
        let memory = allocate(factorise.or(solve))?;
        let transposed = pattern.transposed_positions();
        self.0 = Some(Analysis { columns, transposed, symbolic, numeric: NumericLu::new(), memory });
        Ok(())
    }

    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Some(Analysis { columns, transposed, symbolic, numeric, memory }) = &mut self.0 else { return Ok(()) };
        fill(a, transposed, &mut columns.values);
        let order = symbolic.nrows();
        let view = SymbolicSparseColMatRef::new_checked(order, order, &columns.start, None, &columns.rows);
        let view = SparseColMatRef::new(view, &columns.values);
        let result = symbolic.factorize_numeric_lu(numeric, view, Par::Seq, MemStack::new(memory), Default::default());
        match result {
            Ok(_) => Ok(()),
            Err(LuError::Generic(error)) => Err(out_of_memory(error)),
            Err(LuError::SymbolicSingular { index }) => {
                Err(LinearError::Singular { dof: symbolic.col_perm().arrays().0[index] as usize })
            }
        }
    }

    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError> {
        if let Some(Analysis { symbolic, numeric, memory, .. }) = &mut self.0 {
            let rhs = MatMut::from_column_major_slice_mut(rhs, symbolic.nrows(), columns);
            let factors = LuRef::new_unchecked(symbolic, numeric);
            factors.solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(memory));
        }
        Ok(())
    }
}
