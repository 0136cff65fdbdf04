//! A uniform grid of bins over the boxes of all cells: the search without a hint.

use super::search_mesh::SearchMesh;

/// Bins at most for each cell, so that sparse meshes in large boxes stay small.
const BINS_PER_CELL: usize = 4;

/// List entries at most for each cell, so that long thin cells stay cheap.
const ENTRIES_PER_CELL: usize = 32;

/// For each bin the cells whose box meets it, ascending.
#[derive(Debug, Clone)]
pub(super) struct Bins {
    low: [f64; 3],
    high: [f64; 3],
    per_length: [f64; 3],
    counts: [usize; 3],
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl Bins {
    /// Bins as large as the average cell's box, or larger where the limits above ask for it.
    pub fn new(mesh: &SearchMesh) -> Self {
        let (mut low, mut high, mut size) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], [0.0; 3]);
        let mut searched = 0usize;
        for cell in (0..mesh.len()).filter(|&cell| mesh.is_searched(cell)) {
            let (below, above) = grown_bounds(mesh, cell);
            for i in 0..mesh.dimension {
                low[i] = low[i].min(below[i]);
                high[i] = high[i].max(above[i]);
                size[i] += above[i] - below[i];
            }
            searched += 1;
        }
        let mut bins = Self { low, high, per_length: [0.0; 3], counts: [1; 3], starts: Vec::new(), cells: Vec::new() };
        if searched == 0 {
            bins.starts = vec![0; 2];
            return bins;
        }
        for i in 0..mesh.dimension {
            // Half a bin beyond the mesh, lest the bins' walls be the grid lines of an even mesh.
            let bin = size[i] / searched as f64;
            (bins.low[i], bins.high[i]) = (low[i] - 0.5 * bin, high[i] + 0.5 * bin);
            bins.counts[i] = (((high[i] - low[i]) / bin).round() as usize).clamp(1, 1 << 20) + 1;
        }
        while bins.product() > BINS_PER_CELL * searched + 64 {
            bins.coarsen();
        }
        bins.set_scales(mesh.dimension);
        let limit = ENTRIES_PER_CELL * searched + 64;
        while bins.entries(mesh) > limit && bins.product() > 1 {
            bins.coarsen();
            bins.set_scales(mesh.dimension);
        }
        bins.fill(mesh);
        bins
    }

    /// Cells that may hold `x`, ascending.
    #[inline]
    pub fn candidates(&self, x: [f64; 3]) -> &[u32] {
        for i in 0..3 {
            if self.per_length[i] > 0.0 && !(x[i] >= self.low[i] && x[i] <= self.high[i]) {
                return &[];
            }
        }
        let bin = self.index([0, 1, 2].map(|i| self.place(i, x[i])));
        &self.cells[self.starts[bin] as usize..self.starts[bin + 1] as usize]
    }

    /// Number of bins along each axis, and the average number of entries in one.
    pub fn statistics(&self) -> ([usize; 3], f64) {
        (self.counts, self.cells.len() as f64 / self.product() as f64)
    }

    fn product(&self) -> usize {
        self.counts.iter().fold(1, |product, &n| product.saturating_mul(n))
    }

    fn coarsen(&mut self) {
        self.counts = self.counts.map(|n| n.div_ceil(2));
    }

    fn set_scales(&mut self, dimension: usize) {
        for i in 0..dimension {
            let extent = self.high[i] - self.low[i];
            self.per_length[i] = if extent > 0.0 { self.counts[i] as f64 / extent } else { f64::MIN_POSITIVE };
        }
    }

    /// Monotone in `x`, so that a point in a cell's box falls in a bin of that box.
    #[inline]
    fn place(&self, axis: usize, x: f64) -> usize {
        if self.counts[axis] == 1 {
            return 0;
        }
        (((x - self.low[axis]) * self.per_length[axis]) as usize).min(self.counts[axis] - 1)
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.counts[1] + j) * self.counts[0] + i
    }

    /// First and last bin of a cell along each axis.
    fn span(&self, mesh: &SearchMesh, cell: usize) -> ([usize; 3], [usize; 3]) {
        let (below, above) = grown_bounds(mesh, cell);
        ([0, 1, 2].map(|i| self.place(i, below[i])), [0, 1, 2].map(|i| self.place(i, above[i])))
    }

    fn entries(&self, mesh: &SearchMesh) -> usize {
        let searched = (0..mesh.len()).filter(|&cell| mesh.is_searched(cell));
        searched
            .map(|cell| {
                let (first, last) = self.span(mesh, cell);
                (0..3).map(|i| last[i] - first[i] + 1).product::<usize>()
            })
            .sum()
    }

    fn fill(&mut self, mesh: &SearchMesh) {
        let mut starts = vec![0u32; self.product() + 1];
        self.visit(mesh, |bin, _| starts[bin + 1] += 1);
        for bin in 1..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let mut cells = vec![0u32; starts.last().map_or(0, |&n| n as usize)];
        let mut next = starts.clone();
        self.visit(mesh, |bin, cell| {
            cells[next[bin] as usize] = cell;
            next[bin] += 1;
        });
        (self.starts, self.cells) = (starts, cells);
    }

    fn visit(&self, mesh: &SearchMesh, mut entry: impl FnMut(usize, u32)) {
        for cell in (0..mesh.len()).filter(|&cell| mesh.is_searched(cell)) {
            let (first, last) = self.span(mesh, cell);
            for k in first[2]..=last[2] {
                for j in first[1]..=last[1] {
                    for i in first[0]..=last[0] {
                        entry(self.index([i, j, k]), cell as u32);
                    }
                }
            }
        }
    }
}

/// A cell's box with the margin of the tolerance.
fn grown_bounds(mesh: &SearchMesh, cell: usize) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = mesh.bounds(cell);
    for i in 0..3 {
        let grow = mesh.margin() * (high[i] - low[i]);
        low[i] -= grow;
        high[i] += grow;
    }
    (low, high)
}
