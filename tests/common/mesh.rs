//! Structured meshes of blocks.

use std::fmt::Write;

/// Kinds of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    Line,
    Triangle,
    Quadrilateral,
    Tetrahedron,
    Hexahedron,
}

impl Cell {
    pub fn dimension(self) -> usize {
        match self {
            Cell::Line => 1,
            Cell::Triangle | Cell::Quadrilateral => 2,
            Cell::Tetrahedron | Cell::Hexahedron => 3,
        }
    }

    fn suffix(self) -> &'static str {
        match self {
            Cell::Line => "1D2N",
            Cell::Triangle => "2D3N",
            Cell::Quadrilateral => "2D4N",
            Cell::Tetrahedron => "3D4N",
            Cell::Hexahedron => "3D8N",
        }
    }
}

/// Nodes and cells.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub cell: Cell,
    pub nodes: Vec<[f64; 3]>,
    pub cells: Vec<Vec<usize>>,
}

impl Mesh {
    /// A block from `low` to `high` with so many boxes along each axis; those beyond the cell's
    /// dimension are ignored. Each box is one quadrilateral or hexahedron, two triangles, or six tetrahedra.
    pub fn block(cell: Cell, counts: [usize; 3], low: [f64; 3], high: [f64; 3]) -> Self {
        let [nx, ny, nz] = std::array::from_fn(|a| if a < cell.dimension() { counts[a] } else { 0 });
        let mut nodes = Vec::new();
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    let at = |a: usize, index: usize, count: usize| {
                        if count == 0 { 0.0 } else { low[a] + (high[a] - low[a]) * index as f64 / count as f64 }
                    };
                    nodes.push([at(0, i, nx), at(1, j, ny), at(2, k, nz)]);
                }
            }
        }
        let node = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
        let mut cells = Vec::new();
        for k in 0..nz.max(1) {
            for j in 0..ny.max(1) {
                for i in 0..nx {
                    let floor = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
                    let [a, b, c, d] = floor(k);
                    match cell {
                        Cell::Line => cells.push(vec![a, b]),
                        Cell::Quadrilateral => cells.push(vec![a, b, c, d]),
                        Cell::Triangle => cells.extend([vec![a, b, c], vec![a, c, d]]),
                        Cell::Hexahedron => cells.push([floor(k), floor(k + 1)].concat()),
                        Cell::Tetrahedron => cells.extend(six_tetrahedra([floor(k), floor(k + 1)].concat())),
                    }
                }
            }
        }
        Self { cell, nodes, cells }
    }

    /// Moves the nodes.
    #[must_use]
    pub fn map(mut self, to: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.nodes.iter_mut().for_each(|x| *x = to(*x));
        self
    }

    /// Indices of nodes.
    pub fn find(&self, wanted: impl Fn([f64; 3]) -> bool) -> Vec<usize> {
        (0..self.nodes.len()).filter(|&i| wanted(self.nodes[i])).collect()
    }

    /// The file, with nodes and cells numbered from `first + 1`.
    pub fn mdpa(&self, element: &str, first: usize, conditions: &str, parts: &str) -> String {
        let mut text = String::from("Begin Properties 0\nEnd Properties\nBegin Nodes\n");
        for (i, [x, y, z]) in self.nodes.iter().enumerate() {
            writeln!(text, "{} {x:?} {y:?} {z:?}", first + i + 1).unwrap();
        }
        writeln!(text, "End Nodes\nBegin Elements {element}{}", self.cell.suffix()).unwrap();
        for (i, cell) in self.cells.iter().enumerate() {
            write!(text, "{} 0", first + i + 1).unwrap();
            cell.iter().for_each(|node| write!(text, " {}", first + node + 1).unwrap());
            text.push('\n');
        }
        text + "End Elements\n" + conditions + parts
    }
}

/// The six tetrahedra along the diagonal from corner 0 to corner 6, all with positive volume.
fn six_tetrahedra(c: Vec<usize>) -> impl Iterator<Item = Vec<usize>> {
    [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]].into_iter().map(move |[a, b]| vec![c[0], c[a], c[b], c[6]])
}
