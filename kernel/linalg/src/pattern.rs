//! Which block rows are coupled with which block columns.

/// Block compressed sparse rows without values.
///
/// Structurally symmetric, columns ascending in each row, diagonal always present. The block size `B`
/// (1..=4) is a run-time value here; kernels are instantiated for each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockPattern {
    block: usize,
    row_start: Vec<u32>,
    columns: Vec<u32>,
    diagonal: Vec<u32>,
}

impl BlockPattern {
    /// Couples all nodes of each clique with one another, as the cells of a mesh couple theirs.
    ///
    /// `block` is the number of unknowns of a node, `n` the number of nodes; `cliques` yields node lists.
    /// A node may stand in a list twice, and in no list at all (its row is then the diagonal alone).
    ///
    /// # Panics
    /// If `block` is not in 1..=4, a node is not below `n`, or there are 2^32 blocks or more: mistakes of
    /// the calling code.
    pub fn from_cliques<'a>(block: usize, n: usize, cliques: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        assert!((1..=4).contains(&block), "a block of size {block} is not supported");
        let cliques: Vec<&[u32]> = cliques.collect();
        let (start, cliques_of_node) = cliques_by_node(n, &cliques);
        let mut pattern =
            Self { block, row_start: Vec::with_capacity(n + 1), columns: Vec::new(), diagonal: Vec::with_capacity(n) };
        pattern.row_start.push(0);
        let mut last_row_seen = vec![u32::MAX; n];
        for row in 0..n {
            let begin = pattern.columns.len();
            pattern.columns.push(row as u32);
            last_row_seen[row] = row as u32;
            for &clique in &cliques_of_node[start[row] as usize..start[row + 1] as usize] {
                for &node in cliques[clique as usize] {
                    if last_row_seen[node as usize] != row as u32 {
                        last_row_seen[node as usize] = row as u32;
                        pattern.columns.push(node);
                    }
                }
            }
            let columns = &mut pattern.columns[begin..];
            columns.sort_unstable();
            pattern.diagonal.push((begin + columns.partition_point(|&column| column < row as u32)) as u32);
            assert!(pattern.columns.len() < u32::MAX as usize, "the pattern has 2^32 blocks or more");
            pattern.row_start.push(pattern.columns.len() as u32);
        }
        pattern
    }

    /// Block size `B`: scalar unknowns of a node.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Number of block rows (nodes).
    pub fn rows(&self) -> usize {
        self.diagonal.len()
    }

    /// Scalar size of the matrix, `rows * block`.
    pub fn order(&self) -> usize {
        self.rows() * self.block
    }

    /// Number of stored blocks.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Index of the block at (`row`, `column`), if it is stored. Takes the logarithm of the row length.
    pub fn position(&self, row: usize, column: usize) -> Option<u32> {
        let begin = *self.row_start.get(row)?;
        let end = *self.row_start.get(row + 1)?;
        let columns = &self.columns[begin as usize..end as usize];
        columns.binary_search(&u32::try_from(column).ok()?).ok().map(|offset| begin + offset as u32)
    }

    /// First block of each row and, last, the number of blocks; `rows + 1` values.
    pub fn row_start(&self) -> &[u32] {
        &self.row_start
    }

    /// Block column of each stored block, ascending inside a row.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Index of the diagonal block of each row.
    pub fn diagonal(&self) -> &[u32] {
        &self.diagonal
    }

    /// Indices of the blocks of `row`.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_start[row] as usize..self.row_start[row + 1] as usize
    }

    /// For each stored block (i, j) the index of block (j, i).
    pub(crate) fn transposed_positions(&self) -> Vec<u32> {
        let mut next = self.row_start.clone();
        let mut transposed = vec![0; self.entries()];
        // Rows ascend, hence so do the columns that each transposed row receives.
        for row in 0..self.rows() {
            for entry in self.row(row) {
                let column = self.columns[entry] as usize;
                transposed[next[column] as usize] = entry as u32;
                next[column] += 1;
            }
        }
        transposed
    }
}

/// Inverts the cliques: `list[start[i]..start[i + 1]]` are the cliques that hold node `i`.
fn cliques_by_node(n: usize, cliques: &[&[u32]]) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; n + 1];
    for &node in cliques.iter().copied().flatten() {
        start[node as usize + 1] += 1;
    }
    for node in 0..n {
        start[node + 1] += start[node];
    }
    let mut next = start.clone();
    let mut list = vec![0u32; start[n] as usize];
    for (clique, nodes) in cliques.iter().enumerate() {
        for &node in *nodes {
            list[next[node as usize] as usize] = clique as u32;
            next[node as usize] += 1;
        }
    }
    (start, list)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_systems::Random;
    use std::collections::BTreeSet;

    #[test]
    fn equals_brute_force_on_random_cliques() {
        let mut random = Random::new(7);
        for n in [1, 5, 40] {
            let cliques: Vec<Vec<u32>> =
                (0..n).map(|_| (0..random.below(6)).map(|_| random.below(n) as u32).collect()).collect();
            let pattern = BlockPattern::from_cliques(3, n, cliques.iter().map(Vec::as_slice));
            let mut expected: BTreeSet<(usize, usize)> = (0..n).map(|i| (i, i)).collect();
            for clique in &cliques {
                for &i in clique {
                    expected.extend(clique.iter().map(|&j| (i as usize, j as usize)));
                }
            }
            assert_eq!((pattern.rows(), pattern.order(), pattern.entries()), (n, 3 * n, expected.len()));
            for (index, &(row, column)) in expected.iter().enumerate() {
                assert_eq!(pattern.position(row, column), Some(index as u32));
                let transposed = pattern.transposed_positions()[index];
                assert_eq!(pattern.position(column, row), Some(transposed));
            }
            for row in 0..n {
                assert_eq!(pattern.position(row, row), Some(pattern.diagonal()[row]));
                for column in (0..n + 1).filter(|&column| !expected.contains(&(row, column))) {
                    assert_eq!(pattern.position(row, column), None);
                }
            }
            assert_eq!(pattern.position(n, 0), None);
        }
    }
}
