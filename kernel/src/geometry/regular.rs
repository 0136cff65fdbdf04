//! Regular grids: candidates by arithmetic instead of lists.

use super::search_mesh::{LATTICE, SearchMesh};

/// Place in the table without a cell.
const NONE: u32 = u32::MAX;

/// Places at most for each cell: a grid with more holes is searched by bins.
const PLACES_PER_CELL: usize = 8;

/// Deviation from constant spacing, in units of the spacing, at which an axis is divided instead
/// of searched. The quotient is only a guess, which the axis corrects.
const UNIFORM: f64 = 1e-3;

/// One coordinate axis of a regular grid.
#[derive(Debug, Clone)]
struct Axis {
    /// Grid lines, ascending.
    lines: Vec<f64>,
    /// 1/spacing where the spacing is constant.
    per_length: Option<f64>,
}

/// A tensor-product grid of axis-aligned cells, perhaps with holes.
#[derive(Debug, Clone)]
pub(super) struct Regular {
    axes: Vec<Axis>,
    /// Cell at each place, first axis fastest.
    table: Vec<u32>,
    /// Share of a cell's size by which a point may lie outside of it.
    margin: f64,
}

impl Regular {
    /// None if the cells are no regular grid. The numbering of nodes and cells and the local
    /// orientation of each cell do not matter.
    pub fn new(mesh: &SearchMesh) -> Option<Self> {
        if !mesh.all_aligned || mesh.len() == 0 {
            return None;
        }
        // Half of the tolerance, as the local cell is 2 wide; and what coordinates deviate.
        let margin = 0.5 * mesh.tolerance + 10.0 * LATTICE;
        let axes: Vec<Axis> = (0..mesh.dimension).map(|i| Axis::new(mesh, i, margin)).collect::<Option<_>>()?;
        let places = axes.iter().fold(1usize, |product, axis| product.saturating_mul(axis.len()));
        if places > PLACES_PER_CELL.saturating_mul(mesh.len()).saturating_add(4096) {
            return None;
        }
        let mut regular = Self { axes, table: vec![NONE; places], margin };
        for cell in 0..mesh.len() {
            let place = regular.place_of(mesh, cell)?;
            if regular.table[place] != NONE {
                return None;
            }
            regular.table[place] = cell as u32;
        }
        Some(regular)
    }

    /// Place of a cell in the table, if it spans one interval of each axis.
    fn place_of(&self, mesh: &SearchMesh, cell: usize) -> Option<usize> {
        let (low, high) = mesh.bounds(cell);
        let (mut place, mut stride) = (0, 1);
        for (i, axis) in self.axes.iter().enumerate() {
            let tolerance = 2.0 * LATTICE * (high[i] - low[i]);
            let interval = axis.interval(0.5 * (low[i] + high[i]));
            let near = |a: f64, b: f64| (a - b).abs() <= tolerance;
            if !(near(axis.lines[interval], low[i]) && near(axis.lines[interval + 1], high[i])) {
                return None;
            }
            place += stride * interval;
            stride *= axis.len();
        }
        Some(place)
    }

    /// Cells that may hold `x`, ascending: at most two along each axis.
    #[inline]
    pub fn candidates(&self, x: [f64; 3]) -> Candidates {
        let mut found = Candidates { cells: [NONE; 8], count: 0 };
        let (mut first, mut last, mut strides) = ([0; 3], [0; 3], [0; 3]);
        let mut stride = 1;
        for (i, axis) in self.axes.iter().enumerate() {
            let Some((from, to)) = axis.candidates(x[i], self.margin) else { return found };
            (first[i], last[i], strides[i]) = (from, to, stride);
            stride *= axis.len();
        }
        for k in first[2]..=last[2] {
            for j in first[1]..=last[1] {
                for i in first[0]..=last[0] {
                    found.insert(self.table[i * strides[0] + j * strides[1] + k * strides[2]]);
                }
            }
        }
        found
    }

    /// Such as `20 x 10`, and which axes have constant spacing.
    pub fn describe(&self) -> String {
        let sizes: Vec<String> = self.axes.iter().map(|axis| axis.len().to_string()).collect();
        let uniform = self.axes.iter().all(|axis| axis.per_length.is_some());
        let holes = self.table.iter().filter(|&&cell| cell == NONE).count();
        let spacing = if uniform { "constant" } else { "varying" };
        format!("regular grid of {} cells with {spacing} spacing and {holes} holes", sizes.join(" x "))
    }
}

/// A short ascending list of cells.
#[derive(Debug)]
pub(super) struct Candidates {
    cells: [u32; 8],
    count: usize,
}

impl Candidates {
    #[inline]
    fn insert(&mut self, cell: u32) {
        if cell == NONE {
            return;
        }
        let mut at = self.count;
        while at > 0 && self.cells[at - 1] > cell {
            self.cells[at] = self.cells[at - 1];
            at -= 1;
        }
        self.cells[at] = cell;
        self.count += 1;
    }

    #[inline]
    pub fn as_slice(&self) -> &[u32] {
        &self.cells[..self.count]
    }
}

impl Axis {
    /// The grid lines along one axis. None if a point could be within the margin of three
    /// intervals, which grids of very different spacings and large tolerances allow.
    fn new(mesh: &SearchMesh, axis: usize, margin: f64) -> Option<Self> {
        let mut used = vec![false; mesh.node_count()];
        let mut smallest = f64::INFINITY;
        for cell in 0..mesh.len() {
            let (low, high) = mesh.bounds(cell);
            smallest = smallest.min(high[axis] - low[axis]);
            mesh.nodes_of(cell).iter().for_each(|&node| used[node as usize] = true);
        }
        let of_used = (0..used.len()).filter(|&node| used[node]);
        let mut lines: Vec<f64> = of_used.map(|node| mesh.coordinates(node as u32)[axis]).collect();
        lines.sort_unstable_by(f64::total_cmp);
        lines.dedup_by(|next, kept| *next - *kept <= LATTICE * smallest);
        lines.shrink_to_fit();
        let largest = lines.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        let at_most_two = 4.0 * margin * largest < smallest;
        if lines.len() < 2 || !at_most_two {
            return None;
        }
        let (first, spacing) = (lines[0], (lines[lines.len() - 1] - lines[0]) / (lines.len() - 1) as f64);
        let is_uniform = (0..).zip(&lines).all(|(i, line)| {
            let expected = first + f64::from(i) * spacing;
            (line - expected).abs() <= UNIFORM * spacing
        });
        Some(Self { lines, per_length: is_uniform.then_some(1.0 / spacing) })
    }

    /// Number of intervals.
    fn len(&self) -> usize {
        self.lines.len() - 1
    }

    /// The interval that holds `x`, or the first or last one.
    #[inline]
    fn interval(&self, x: f64) -> usize {
        let last = self.len() - 1;
        let Some(per_length) = self.per_length else {
            return self.lines.partition_point(|line| *line <= x).clamp(1, last + 1) - 1;
        };
        let guess = (((x - self.lines[0]) * per_length) as usize).min(last);
        if x < self.lines[guess] {
            guess.saturating_sub(1)
        } else if x >= self.lines[guess + 1] {
            (guess + 1).min(last)
        } else {
            guess
        }
    }

    /// First and last interval that hold `x` to within the margin.
    #[inline]
    fn candidates(&self, x: f64, margin: f64) -> Option<(usize, usize)> {
        let within = |interval: usize| {
            let (low, high) = (self.lines[interval], self.lines[interval + 1]);
            let grow = margin * (high - low);
            x >= low - grow && x <= high + grow
        };
        let middle = self.interval(x);
        if !within(middle) {
            return None;
        }
        let first = if middle > 0 && within(middle - 1) { middle - 1 } else { middle };
        let last = if middle + 1 < self.len() && within(middle + 1) { middle + 1 } else { middle };
        Some((first, last))
    }
}
