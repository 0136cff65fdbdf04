//! Meshes of one cell shape: made from lattices or keys, turned to simplices, asked for their faces.

use crate::geometry::Shape;
use std::collections::HashMap;

/// Name of a node before it has a number: cells that share a node give the same key.
pub(super) type Key = [i32; 4];

/// Most cells of one mesh; beyond it a wrong input is likelier than a wish.
pub(super) const MOST_CELLS: usize = 100_000_000;

/// How squares become triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Diagonal {
    /// From the first to the third node of each square.
    Fixed,
    /// Turned in every other square.
    Alternating,
    /// The shorter one; from the first node when both are equal.
    Shorter,
}

/// How cubes become tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cubes {
    /// Five, turned in every other cube; needs a mesh with parities.
    Five,
    /// Six, diagonals through the smallest node of each face, which fits any mesh together.
    Six,
}

/// Nodes and cells of one shape.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    /// Coordinates in m.
    pub nodes: Vec<[f64; 3]>,
    /// Shape of all cells.
    pub shape: Shape,
    /// Node indices, cell after cell.
    pub cells: Vec<u32>,
    /// Parity of each cell's place in its lattice; empty for meshes without a lattice.
    odd: Vec<bool>,
}

impl Mesh {
    /// The grid of these lines along x, y and z: lines, quadrilaterals or hexahedra for 1, 2 or 3
    /// axes. Nodes and cells are numbered with x fastest.
    pub fn lattice(lines: &[Vec<f64>]) -> Self {
        let line = |axis: usize| lines.get(axis).map_or(&[0.0][..], Vec::as_slice);
        let counts: [usize; 3] = std::array::from_fn(|axis| line(axis).len());
        let mut nodes = Vec::with_capacity(counts.iter().product());
        for &z in line(2) {
            for &y in line(1) {
                nodes.extend(line(0).iter().map(|&x| [x, y, z]));
            }
        }
        let shape = lattice_shape(lines.len());
        let spans: [usize; 3] = std::array::from_fn(|axis| (counts[axis] - 1).max(1));
        let (mut cells, mut odd) = (Vec::new(), Vec::new());
        for k in 0..spans[2] {
            for j in 0..spans[1] {
                for i in 0..spans[0] {
                    for corner in corners_of(lines.len()) {
                        let [a, b, c] = [i + corner[0], j + corner[1], k + corner[2]];
                        cells.push((a + counts[0] * (b + counts[1] * c)) as u32);
                    }
                    odd.push((i + j + k) % 2 == 1);
                }
            }
        }
        Self { nodes, shape, cells, odd }
    }

    /// Cells given by the keys of their nodes, numbered in the order of their first mention.
    pub fn from_keys(shape: Shape, keys: &[Key], position: impl Fn(Key) -> [f64; 3]) -> Self {
        let mut numbers: HashMap<Key, u32> = HashMap::new();
        let mut mesh = Self { nodes: Vec::new(), shape, cells: Vec::with_capacity(keys.len()), odd: Vec::new() };
        for key in keys {
            let number = *numbers.entry(*key).or_insert_with(|| {
                mesh.nodes.push(position(*key));
                mesh.nodes.len() as u32 - 1
            });
            mesh.cells.push(number);
        }
        mesh.orient();
        mesh
    }

    /// The cells of a lattice through the origin at these places, whose nodes are at multiples of
    /// `size`.
    pub fn of_places(dimension: usize, places: &[[i32; 3]], size: f64) -> Self {
        let corner = |place: &[i32; 3], corner: &[usize; 3]| {
            let [i, j, k]: [i32; 3] = std::array::from_fn(|axis| place[axis] + corner[axis] as i32);
            [i, j, k, 0]
        };
        let keys: Vec<Key> =
            places.iter().flat_map(|place| corners_of(dimension).iter().map(|c| corner(place, c))).collect();
        let position = |[i, j, k, _]: Key| [i, j, k].map(|index| f64::from(index) * size);
        let mut mesh = Self::from_keys(lattice_shape(dimension), &keys, position);
        mesh.odd = places.iter().map(|place| place.iter().sum::<i32>().rem_euclid(2) == 1).collect();
        mesh
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.len() / self.shape.node_count()
    }

    /// Node indices of a cell.
    pub fn cell(&self, index: usize) -> &[u32] {
        let count = self.shape.node_count();
        &self.cells[index * count..(index + 1) * count]
    }

    /// Coordinates of a cell's nodes.
    pub fn corners(&self, index: usize) -> Vec<[f64; 3]> {
        self.cell(index).iter().map(|&node| self.nodes[node as usize]).collect()
    }

    /// Length, area or volume of a cell; areas and volumes have the sign of their orientation.
    pub fn cell_measure(&self, index: usize) -> f64 {
        let corners = self.corners(index);
        if self.shape.dimension() == 2 { self.shape.plane_area(&corners) } else { self.shape.measure(&corners) }
    }

    /// Length (m), area (m²) or volume (m³) of all cells.
    pub fn measure(&self) -> f64 {
        (0..self.len()).map(|cell| self.cell_measure(cell)).sum()
    }

    /// Lowest and highest coordinates.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        bounds(&self.nodes)
    }

    /// Writes cells that are inside out in the order of their mirror image.
    fn orient(&mut self) {
        let mirror: &[usize] = match self.shape {
            Shape::Quadrilateral4 => &[0, 3, 2, 1],
            Shape::Hexahedron8 => &[4, 5, 6, 7, 0, 1, 2, 3],
            _ => return,
        };
        for index in 0..self.len() {
            if self.cell_measure(index) < 0.0 {
                let old = self.cell(index).to_vec();
                let start = index * mirror.len();
                for (place, &from) in mirror.iter().enumerate() {
                    self.cells[start + place] = old[from];
                }
            }
        }
    }

    /// The same mesh in cells of `shape`: itself, or quadrilaterals cut into triangles, or
    /// hexahedra into tetrahedra; none for any other pair.
    pub fn into_shape(self, shape: Shape, diagonal: Diagonal, cubes: Cubes) -> Option<Self> {
        match (self.shape, shape) {
            (from, to) if from == to => Some(self),
            (Shape::Quadrilateral4, Shape::Triangle3) => Some(self.triangles(diagonal)),
            (Shape::Hexahedron8, Shape::Tetrahedron4) => Some(self.tetrahedra(cubes)),
            _ => None,
        }
    }

    fn is_odd(&self, cell: usize) -> bool {
        self.odd.get(cell).copied().unwrap_or(false)
    }

    fn triangles(self, diagonal: Diagonal) -> Self {
        let mut cells = Vec::with_capacity(self.cells.len() / 4 * 6);
        for index in 0..self.len() {
            let [a, b, c, d]: [u32; 4] = std::array::from_fn(|i| self.cell(index)[i]);
            let turned = match diagonal {
                Diagonal::Fixed => false,
                Diagonal::Alternating => self.is_odd(index),
                // The margin lets equal diagonals be equal in spite of round-off.
                Diagonal::Shorter => self.distance(b, d) < self.distance(a, c) * (1.0 - 1e-9),
            };
            cells.extend(if turned { [a, b, d, b, c, d] } else { [a, b, c, a, c, d] });
        }
        Self { shape: Shape::Triangle3, cells, odd: Vec::new(), ..self }
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|node| self.nodes[node as usize]);
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    fn tetrahedra(self, cubes: Cubes) -> Self {
        let mut cells = Vec::with_capacity(self.len() * 24);
        for index in 0..self.len() {
            match cubes {
                Cubes::Five => five_tetrahedra(self.cell(index), self.is_odd(index), &mut cells),
                Cubes::Six => six_tetrahedra(self.cell(index), &mut cells),
            }
        }
        Self { shape: Shape::Tetrahedron4, cells, odd: Vec::new(), ..self }
    }

    /// Faces that belong to one cell only, in the order of the cells, seen counter-clockwise from
    /// outside (a line has the body on its left); of those alone whose nodes satisfy `wanted`.
    pub fn boundary(&self, wanted: impl Fn(&[u32]) -> bool) -> Vec<Vec<u32>> {
        let (mut faces, seen) = self.faces(wanted);
        faces.retain(|face| seen[&sorted(face)] == 1);
        faces
    }

    /// Faces whose nodes satisfy `wanted`, each once and as the first of its cells sees them.
    pub fn faces_once(&self, wanted: impl Fn(&[u32]) -> bool) -> Vec<Vec<u32>> {
        let (mut faces, mut seen) = self.faces(wanted);
        faces.retain(|face| seen.remove(&sorted(face)).is_some());
        faces
    }

    /// Faces of all cells whose nodes satisfy `wanted`, and how often each occurs.
    fn faces(&self, wanted: impl Fn(&[u32]) -> bool) -> (Vec<Vec<u32>>, HashMap<[u32; 4], usize>) {
        let mut found: Vec<Vec<u32>> = Vec::new();
        let mut owners: HashMap<[u32; 4], usize> = HashMap::new();
        for index in 0..self.len() {
            let cell = self.cell(index);
            for face in faces(self.shape) {
                let face: Vec<u32> = face.iter().map(|&corner| cell[corner]).collect();
                if wanted(&face) {
                    *owners.entry(sorted(&face)).or_insert(0) += 1;
                    found.push(face);
                }
            }
        }
        (found, owners)
    }
}

/// The nodes of a face in ascending order, the same from both of its sides.
fn sorted(face: &[u32]) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    key[..face.len()].copy_from_slice(face);
    key.sort_unstable();
    key
}

/// Lowest and highest coordinates of points.
pub(super) fn bounds(points: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    (low, high)
}

/// Shape of a lattice's cells.
pub(super) fn lattice_shape(dimension: usize) -> Shape {
    match dimension {
        1 => Shape::Line2,
        2 => Shape::Quadrilateral4,
        _ => Shape::Hexahedron8,
    }
}

/// Offsets of a lattice cell's nodes, in the order of the shape.
pub(super) fn corners_of(dimension: usize) -> &'static [[usize; 3]] {
    const CORNERS: [[usize; 3]; 8] =
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    &CORNERS[..1 << dimension]
}

/// Local nodes of a shape's faces, counter-clockwise from outside.
pub(super) fn faces(shape: Shape) -> &'static [&'static [usize]] {
    match shape {
        Shape::Point1 => &[],
        Shape::Line2 => &[&[0], &[1]],
        Shape::Triangle3 => &[&[0, 1], &[1, 2], &[2, 0]],
        Shape::Quadrilateral4 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        Shape::Tetrahedron4 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
        Shape::Hexahedron8 => {
            &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
        }
    }
}

/// Shape of a shape's faces.
pub(super) fn face_shape(shape: Shape) -> Shape {
    match shape {
        Shape::Point1 | Shape::Line2 => Shape::Point1,
        Shape::Triangle3 | Shape::Quadrilateral4 => Shape::Line2,
        Shape::Tetrahedron4 => Shape::Triangle3,
        Shape::Hexahedron8 => Shape::Quadrilateral4,
    }
}

/// One tetrahedron in the middle and one at every other corner; the odd cube is the mirror image
/// of the even one, so that the diagonals of a common face agree.
fn five_tetrahedra(cube: &[u32], odd: bool, out: &mut Vec<u32>) {
    const EVEN: [[usize; 4]; 5] = [[0, 1, 2, 5], [0, 2, 3, 7], [0, 5, 7, 4], [2, 7, 5, 6], [0, 2, 7, 5]];
    const MIRROR: [usize; 8] = [1, 0, 3, 2, 5, 4, 7, 6];
    for [a, b, c, d] in EVEN {
        let corners = if odd { [a, b, d, c].map(|corner| MIRROR[corner]) } else { [a, b, c, d] };
        out.extend(corners.map(|corner| cube[corner]));
    }
}

/// Joins the smallest node to the faces that do not hold it, each cut through its own smallest
/// node. The diagonal of a face then depends on its nodes alone and two cubes agree on it.
///
/// Source: Dompierre, Labbé, Vallet, Camarero, How to subdivide pyramids, prisms and hexahedra
/// into tetrahedra, 8th International Meshing Roundtable (1999).
fn six_tetrahedra(cube: &[u32], out: &mut Vec<u32>) {
    let apex = cube.iter().fold(u32::MAX, |least, &node| least.min(node));
    for face in faces(Shape::Hexahedron8) {
        let nodes: [u32; 4] = std::array::from_fn(|i| cube[face[i]]);
        if nodes.contains(&apex) {
            continue;
        }
        let least = (1..4).fold(0, |least, i| if nodes[i] < nodes[least] { i } else { least });
        let [a, b, c, d]: [u32; 4] = std::array::from_fn(|i| nodes[(least + i) % 4]);
        out.extend([a, c, b, apex, a, d, c, apex]);
    }
}
