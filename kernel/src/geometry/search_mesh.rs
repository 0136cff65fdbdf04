//! The locator's copy of a mesh, and the test whether one cell holds a point.

use super::{CellShape, Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3, inverse_map};
use crate::model::{Cells, ModelPart};

/// Largest deviation from a box, in units of the box, at which the closed inverse map is used: its
/// error in the local coordinates, hence next to rounding.
const BOX: f64 = 1e-13;

/// Largest deviation at which a cell still counts as one of a regular grid. There it only selects
/// candidates, so it may be generous to files with few digits.
pub(super) const LATTICE: f64 = 1e-8;

/// How local coordinates are computed in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Map {
    /// Not searched: of lower dimension than the mesh.
    None,
    Line,
    Triangle,
    Quadrilateral,
    Tetrahedron,
    Hexahedron,
    /// Axis-aligned quadrilateral: the global axis of each local one.
    Rectangle([u8; 2]),
    /// Axis-aligned hexahedron: the global axis of each local one.
    Box([u8; 3]),
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    start: u32,
    map: Map,
}

/// Nodes and cells, packed for the search.
#[derive(Debug, Clone)]
pub(super) struct SearchMesh {
    coordinates: Vec<[f64; 3]>,
    cells: Vec<Entry>,
    nodes: Vec<u32>,
    /// Tolerance in local coordinates.
    pub tolerance: f64,
    /// Number of coordinates that matter: the largest dimension of a cell.
    pub dimension: usize,
    /// The first cell that is no axis-aligned box to within [`LATTICE`].
    pub skew: Option<u32>,
}

impl SearchMesh {
    pub fn new(part: &ModelPart, cells: &Cells, tolerance: f64) -> Self {
        let dimension = cells.shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
        let mut mesh = Self {
            coordinates: part.nodes.coordinates.clone(),
            cells: Vec::with_capacity(cells.len()),
            nodes: cells.nodes.clone(),
            tolerance,
            dimension,
            skew: None,
        };
        for (cell, &shape) in cells.shapes.iter().enumerate() {
            let (start, nodes) = (cells.starts[cell], cells.nodes_of(cell));
            let complete = nodes.len() == shape.node_count();
            let searched = complete && shape.dimension() == dimension;
            let aligned = if searched { alignment(shape, &mesh.gather_all(nodes)) } else { None };
            if aligned.is_none() {
                mesh.skew.get_or_insert(cell as u32);
            }
            let map = match (shape, aligned) {
                _ if !searched => Map::None,
                (Shape::Quadrilateral4, Some(([i, j, _], deviation))) if deviation <= BOX => Map::Rectangle([i, j]),
                (Shape::Hexahedron8, Some((axes, deviation))) if deviation <= BOX => Map::Box(axes),
                (Shape::Point1, _) => Map::None,
                (Shape::Line2, _) => Map::Line,
                (Shape::Triangle3, _) => Map::Triangle,
                (Shape::Quadrilateral4, _) => Map::Quadrilateral,
                (Shape::Tetrahedron4, _) => Map::Tetrahedron,
                (Shape::Hexahedron8, _) => Map::Hexahedron,
            };
            mesh.cells.push(Entry { start, map });
        }
        mesh
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.coordinates.len()
    }

    /// False for cells of lower dimension than the mesh.
    pub fn is_searched(&self, cell: usize) -> bool {
        self.cells[cell].map != Map::None
    }

    /// Node indices of a cell.
    pub fn nodes_of(&self, cell: usize) -> &[u32] {
        let start = self.cells[cell].start as usize;
        let end = self.cells.get(cell + 1).map_or(self.nodes.len(), |next| next.start as usize);
        &self.nodes[start..end]
    }

    /// Coordinates of a node.
    pub fn coordinates(&self, node: u32) -> [f64; 3] {
        self.coordinates[node as usize]
    }

    /// True when two cells have a node in common.
    pub fn share_node(&self, a: usize, b: usize) -> bool {
        let b = self.nodes_of(b);
        self.nodes_of(a).iter().any(|node| b.contains(node))
    }

    /// Smallest box around a cell.
    pub fn bounds(&self, cell: usize) -> ([f64; 3], [f64; 3]) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &node in self.nodes_of(cell) {
            let x = self.coordinates[node as usize];
            for i in 0..3 {
                low[i] = low[i].min(x[i]);
                high[i] = high[i].max(x[i]);
            }
        }
        (low, high)
    }

    /// Lowest and highest coordinates of all cells.
    pub fn all_bounds(&self) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &node in &self.nodes {
            let x = self.coordinates[node as usize];
            for i in 0..3 {
                low[i] = low[i].min(x[i]);
                high[i] = high[i].max(x[i]);
            }
        }
        [low, high]
    }

    /// Share of a cell's box by which the box must grow to hold all points that are inside within
    /// the tolerance. With ξ outside by t, the negative shape functions sum to at most
    /// ((1 + t)^D − 1)/2 in quadrilaterals and hexahedra and D t in simplices; rounding on top.
    pub fn margin(&self) -> f64 {
        let t = self.tolerance;
        3.0 * t * (1.0 + t) * (1.0 + t) + 1e-9
    }

    /// Local coordinates of `x` if `cell` holds it within the tolerance.
    #[inline]
    pub fn local_coordinates(&self, cell: usize, x: [f64; 3]) -> Option<[f64; 3]> {
        let Entry { start, map } = self.cells[cell];
        let start = start as usize;
        match map {
            Map::Box(axes) => self.aligned(Shape::Hexahedron8, start, axes, 6, x),
            Map::Rectangle(axes) => self.aligned(Shape::Quadrilateral4, start, axes, 2, x),
            Map::Tetrahedron => self.general::<Tetrahedron4, 3, 4>(start, x),
            Map::Triangle => self.general::<Triangle3, 2, 3>(start, x),
            Map::Quadrilateral => self.general::<Quadrilateral4, 2, 4>(start, x),
            Map::Hexahedron => self.general::<Hexahedron8, 3, 8>(start, x),
            Map::Line => self.general::<Line2, 1, 2>(start, x),
            Map::None => None,
        }
    }

    /// Whether local coordinates lie in the cell itself, without tolerance.
    pub fn holds(&self, cell: usize, xi: [f64; 3]) -> bool {
        let shape = match self.cells[cell].map {
            Map::Box(_) | Map::Hexahedron => Shape::Hexahedron8,
            Map::Rectangle(_) | Map::Quadrilateral => Shape::Quadrilateral4,
            Map::Tetrahedron => Shape::Tetrahedron4,
            Map::Triangle => Shape::Triangle3,
            Map::Line => Shape::Line2,
            Map::None => return false,
        };
        shape.contains(xi, 0.0)
    }

    /// The closed form: node 0 and the node opposite to it carry all local axes with their signs.
    #[inline]
    fn aligned<const D: usize>(
        &self,
        shape: Shape,
        start: usize,
        axes: [u8; D],
        opposite: usize,
        x: [f64; 3],
    ) -> Option<[f64; 3]> {
        let first = self.coordinates[self.nodes[start] as usize];
        let last = self.coordinates[self.nodes[start + opposite] as usize];
        let mut xi = [0.0; 3];
        for d in 0..D {
            let axis = usize::from(axes[d]).min(2);
            xi[d] = ((x[axis] - first[axis]) + (x[axis] - last[axis])) / (last[axis] - first[axis]);
        }
        shape.contains(xi, self.tolerance).then_some(xi)
    }

    #[inline]
    fn general<S: CellShape<D, N>, const D: usize, const N: usize>(
        &self,
        start: usize,
        x: [f64; 3],
    ) -> Option<[f64; 3]> {
        let nodes = &self.nodes[start..start + N];
        let mut corners = [[0.0; D]; N];
        for a in 0..N {
            let corner = self.coordinates[nodes[a] as usize];
            corners[a].copy_from_slice(&corner[..D]);
        }
        let mut point = [0.0; D];
        point.copy_from_slice(&x[..D]);
        // Newton's method is for points that may be inside; a simplex is as quick as its box.
        if !S::SHAPE.is_affine() && !in_box(&corners, &point, self.margin()) {
            return None;
        }
        let mut xi = [0.0; 3];
        xi[..D].copy_from_slice(&inverse_map::<S, D, N>(&corners, &point)?);
        S::SHAPE.contains(xi, self.tolerance).then_some(xi)
    }

    fn gather_all(&self, nodes: &[u32]) -> [[f64; 3]; 8] {
        let mut corners = [[0.0; 3]; 8];
        for (corner, &node) in corners.iter_mut().zip(nodes) {
            *corner = self.coordinates[node as usize];
        }
        corners
    }
}

/// True when x is in the corners' box, grown by `margin` times its size.
#[inline]
fn in_box<const D: usize, const N: usize>(corners: &[[f64; D]; N], x: &[f64; D], margin: f64) -> bool {
    for i in 0..D {
        let (mut low, mut high) = (corners[0][i], corners[0][i]);
        for corner in corners {
            low = low.min(corner[i]);
            high = high.max(corner[i]);
        }
        let grow = margin * (high - low);
        if x[i] < low - grow || x[i] > high + grow {
            return false;
        }
    }
    true
}

/// The global axis of each local one and the largest deviation of a corner from the box, in units
/// of the box, if the cell is a box to within [`LATTICE`].
fn alignment(shape: Shape, corners: &[[f64; 3]; 8]) -> Option<([u8; 3], f64)> {
    let opposite = match shape {
        Shape::Line2 => 1,
        Shape::Quadrilateral4 => 2,
        Shape::Hexahedron8 => 6,
        _ => return None,
    };
    let dimension = shape.dimension();
    let mut axes = [0u8; 3];
    for (local, &neighbour) in [1, 3, 4][..dimension].iter().enumerate() {
        let along = |axis: usize| (corners[neighbour][axis] - corners[0][axis]).abs();
        let longest = (0..dimension).max_by(|&a, &b| along(a).total_cmp(&along(b)))?;
        axes[local] = longest as u8;
    }
    let mut seen = [false; 3];
    axes[..dimension].iter().for_each(|&axis| seen[usize::from(axis)] = true);
    if !seen[..dimension].iter().all(|&s| s) {
        return None;
    }
    let mut deviation = 0f64;
    for (corner, reference) in corners.iter().zip(shape.reference_corners()) {
        for local in 0..dimension {
            let axis = usize::from(axes[local]);
            let expected = if reference[local] < 0.0 { corners[0] } else { corners[opposite] };
            let size = (corners[opposite][axis] - corners[0][axis]).abs();
            let distance = ((corner[axis] - expected[axis]) / size).abs();
            if distance.is_nan() || distance > LATTICE {
                return None;
            }
            deviation = deviation.max(distance);
        }
    }
    Some((axes, deviation))
}
