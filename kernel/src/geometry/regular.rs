//! Regular grids: tensor products of intervals, in which cells are found by arithmetic.

use super::search_mesh::{LATTICE, SearchMesh};
use crate::model::ModelPart;
use std::array::from_fn;

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
pub struct RegularGrid {
    axes: Vec<Axis>,
    /// Cell at each place, first axis fastest.
    table: Vec<u32>,
    /// Place of each cell in the table.
    places: Vec<u32>,
    /// Share of a cell's size by which a point may lie outside of it.
    margin: f64,
}

/// Why a mesh is no regular grid. Cells are named by their ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Irregular {
    /// There is no cell.
    #[error("it has no cells")]
    Empty,
    /// A cell that is no axis-aligned box of the mesh's dimension.
    #[error("cell {0} is no line, rectangle or box along the axes")]
    Skew(u32),
    /// A cell whose faces are not on consecutive grid lines.
    #[error("a node of other cells lies inside the extent of cell {0}")]
    Hanging(u32),
    /// Two cells at one place.
    #[error("cells {0} and {1} lie on top of each other")]
    Overlap(u32, u32),
    /// Two nodes at one place, which separate cells that a basis on the grid would join.
    #[error("nodes {0} and {1} are at the same place")]
    Slit(u32, u32),
    /// Spacings that differ too much for the tolerance of the search.
    #[error("its spacings along an axis differ by too much")]
    Graded,
    /// Mostly holes.
    #[error("{places} places of its grid lines hold {cells} cells only")]
    Sparse {
        /// Number of places.
        places: usize,
        /// Number of cells.
        cells: usize,
    },
}

impl RegularGrid {
    /// Recognises the elements of a part as a regular grid. The numbering of nodes and cells and
    /// the local orientation of each cell do not matter, and places may be empty.
    ///
    /// # Errors
    /// It is none.
    pub fn new(part: &ModelPart) -> Result<Self, Irregular> {
        let mesh = SearchMesh::new(part, &part.elements, 0.0);
        let id = |cell: u32| part.elements.ids[cell as usize];
        Self::of(&mesh).map_err(|reason| match reason {
            Irregular::Skew(cell) => Irregular::Skew(id(cell)),
            Irregular::Hanging(cell) => Irregular::Hanging(id(cell)),
            Irregular::Overlap(a, b) => Irregular::Overlap(id(a), id(b)),
            other => other,
        })
    }

    /// As above, with indices of cells instead of their ids in the error.
    pub(super) fn of(mesh: &SearchMesh) -> Result<Self, Irregular> {
        if mesh.len() == 0 || mesh.dimension == 0 {
            return Err(Irregular::Empty);
        }
        if let Some(cell) = mesh.skew {
            return Err(Irregular::Skew(cell));
        }
        // Half of the tolerance, as the local cell is 2 wide; and what coordinates deviate.
        let margin = 0.5 * mesh.tolerance + 10.0 * LATTICE;
        let axes: Option<Vec<Axis>> = (0..mesh.dimension).map(|i| Axis::new(mesh, i, margin)).collect();
        let axes = axes.ok_or(Irregular::Graded)?;
        let places = axes.iter().fold(1usize, |product, axis| product.saturating_mul(axis.len()));
        if places > PLACES_PER_CELL.saturating_mul(mesh.len()).saturating_add(4096) {
            return Err(Irregular::Sparse { places, cells: mesh.len() });
        }
        let mut regular = Self { axes, table: vec![NONE; places], places: Vec::with_capacity(mesh.len()), margin };
        for cell in 0..mesh.len() {
            let place = regular.place_of(mesh, cell).ok_or(Irregular::Hanging(cell as u32))?;
            if regular.table[place] != NONE {
                return Err(Irregular::Overlap(regular.table[place], cell as u32));
            }
            regular.table[place] = cell as u32;
            regular.places.push(place as u32);
        }
        Ok(regular)
    }

    /// Number of axes.
    pub fn dimension(&self) -> usize {
        self.axes.len()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Never: a grid has cells.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Places of the grid lines along an axis in m, ascending.
    pub fn lines(&self, axis: usize) -> &[f64] {
        &self.axes[axis].lines
    }

    /// The interval of each axis in which a cell lies; 0 beyond the dimension.
    pub fn place(&self, cell: usize) -> [usize; 3] {
        let mut rest = self.places[cell] as usize;
        let mut place = [0; 3];
        for (axis, i) in self.axes.iter().zip(&mut place) {
            *i = rest % axis.len();
            rest /= axis.len();
        }
        place
    }

    /// The cell at a place, if it is one without a hole.
    pub fn cell_at(&self, place: [usize; 3]) -> Option<usize> {
        let (mut index, mut stride) = (0, 1);
        for (axis, i) in self.axes.iter().zip(place) {
            if i >= axis.len() {
                return None;
            }
            index += stride * i;
            stride *= axis.len();
        }
        Some(self.table[index]).filter(|&cell| cell != NONE).map(|cell| cell as usize)
    }

    /// Number of grid lines along each axis; 1 beyond the dimension.
    pub fn line_counts(&self) -> [usize; 3] {
        from_fn(|d| self.axes.get(d).map_or(1, |axis| axis.lines.len()))
    }

    /// The node of `part` at each crossing of grid lines, first axis fastest; none in holes.
    ///
    /// # Errors
    /// Two nodes at one place.
    pub fn crossings(&self, part: &ModelPart) -> Result<Vec<Option<u32>>, Irregular> {
        let [nx, ny, nz] = self.line_counts();
        let mut nodes = vec![None; nx * ny * nz];
        for cell in 0..self.len() {
            let place = self.place(cell);
            for &node in part.elements.nodes_of(cell) {
                let x = part.nodes.coordinates[node as usize];
                let [i, j, k] = from_fn(|d| match self.axes.get(d) {
                    Some(Axis { lines, .. }) => {
                        let (low, high) = (lines[place[d]], lines[place[d] + 1]);
                        place[d] + usize::from(x[d] - low > high - x[d])
                    }
                    None => 0,
                });
                match nodes[i + nx * (j + ny * k)].replace(node) {
                    Some(other) if other != node => {
                        return Err(Irregular::Slit(part.nodes.ids[other as usize], part.nodes.ids[node as usize]));
                    }
                    _ => {}
                }
            }
        }
        Ok(nodes)
    }

    /// A cell that holds `x` up to rounding, the lowest of those that share a face there.
    pub fn cell_holding(&self, x: [f64; 3]) -> Option<usize> {
        self.candidates(x).as_slice().first().map(|&cell| cell as usize)
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
    pub(super) fn candidates(&self, x: [f64; 3]) -> Candidates {
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
