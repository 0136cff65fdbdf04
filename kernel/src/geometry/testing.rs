//! What the tests of this module share: a pseudo-random generator and meshes.

use super::Shape;
use crate::model::ModelPart;

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// A point of the reference cell.
    pub fn inside(&mut self, shape: Shape) -> [f64; 3] {
        loop {
            let mut xi = [0.0; 3];
            xi[..shape.dimension()].iter_mut().for_each(|v| *v = self.within(-1.0, 1.0));
            if shape.contains(xi, 0.0) {
                return xi;
            }
        }
    }

    /// The reference cell's corners, moved by at most `amount` in each of its own directions.
    pub fn distorted(&mut self, shape: Shape, amount: f64) -> Vec<[f64; 3]> {
        let move_corner = |corner: &[f64; 3]| {
            let mut corner = *corner;
            corner[..shape.dimension()].iter_mut().for_each(|v| *v += self.within(-amount, amount));
            corner
        };
        shape.reference_corners().iter().map(move_corner).collect()
    }
}

/// Position of ξ in a cell.
pub fn position(shape: Shape, corners: &[[f64; 3]], xi: [f64; 3]) -> [f64; 3] {
    let mut n = [0.0; 8];
    shape.functions(xi, &mut n);
    let mut x = [0.0; 3];
    for (corner, n) in corners.iter().zip(n) {
        (0..3).for_each(|i| x[i] += n * corner[i]);
    }
    x
}

/// Coordinates of the nodes, and the cells with their node indices.
pub type Mesh = (Vec<[f64; 3]>, Vec<(Shape, Vec<u32>)>);

/// A model part with ids from 1 on.
pub fn part(coordinates: Vec<[f64; 3]>, cells: &[(Shape, Vec<u32>)]) -> ModelPart {
    let mut part = ModelPart::new("Background_Grid");
    part.nodes.ids = (1..=coordinates.len() as u32).collect();
    part.nodes.coordinates = coordinates;
    for (id, (shape, nodes)) in (1..).zip(cells) {
        part.elements.push(id, &format!("Element{}", shape.name()), *shape, 0, nodes);
    }
    part
}

/// The tensor product of `axes` (two: quadrilaterals, three: hexahedra), in lexical order.
pub fn tensor(axes: &[Vec<f64>]) -> Mesh {
    let line = |i: usize| axes.get(i).map_or(vec![0.0], Clone::clone);
    let (xs, ys, zs) = (line(0), line(1), line(2));
    let mut coordinates = Vec::new();
    for &z in &zs {
        for &y in &ys {
            coordinates.extend(xs.iter().map(|&x| [x, y, z]));
        }
    }
    let node = |i: usize, j: usize, k: usize| ((k * ys.len() + j) * xs.len() + i) as u32;
    let around = |i, j, k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
    let mut cells = Vec::new();
    for k in 0..(zs.len() - 1).max(1) {
        for j in 0..ys.len() - 1 {
            for i in 0..xs.len() - 1 {
                cells.push(if axes.len() == 2 {
                    (Shape::Quadrilateral4, around(i, j, 0).to_vec())
                } else {
                    (Shape::Hexahedron8, [around(i, j, k), around(i, j, k + 1)].concat())
                });
            }
        }
    }
    (coordinates, cells)
}

/// Splits quadrilaterals into triangles and hexahedra into six tetrahedra each (Kuhn).
pub fn simplices(cells: &[(Shape, Vec<u32>)]) -> Vec<(Shape, Vec<u32>)> {
    const TETRAHEDRA: [[usize; 4]; 6] =
        [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let mut split = Vec::new();
    for (shape, nodes) in cells {
        let mut add = |shape, local: &[usize]| split.push((shape, local.iter().map(|&a| nodes[a]).collect()));
        if *shape == Shape::Quadrilateral4 {
            add(Shape::Triangle3, &[0, 1, 2]);
            add(Shape::Triangle3, &[0, 2, 3]);
        } else {
            TETRAHEDRA.iter().for_each(|local| add(Shape::Tetrahedron4, local));
        }
    }
    split
}

/// Another numbering of the same mesh: nodes and cells in random order, cells turned at random.
pub fn renumbered(random: &mut Random, coordinates: &[[f64; 3]], cells: &[(Shape, Vec<u32>)]) -> Mesh {
    let mut new_index: Vec<u32> = (0..coordinates.len() as u32).collect();
    random.shuffle(&mut new_index);
    let mut moved = vec![[0.0; 3]; coordinates.len()];
    for (&new, &x) in new_index.iter().zip(coordinates) {
        moved[new as usize] = x;
    }
    let mut turned: Vec<(Shape, Vec<u32>)> = Vec::new();
    for (shape, nodes) in cells {
        let mut nodes: Vec<u32> = nodes.iter().map(|&node| new_index[node as usize]).collect();
        for _ in 0..random.below(6) {
            let turn: &[usize] = match (shape, random.below(2)) {
                (Shape::Quadrilateral4, _) => &[1, 2, 3, 0],
                (Shape::Hexahedron8, 0) => &[1, 2, 3, 0, 5, 6, 7, 4],
                (Shape::Hexahedron8, _) => &[1, 5, 6, 2, 0, 4, 7, 3],
                (Shape::Triangle3, _) => &[1, 2, 0],
                _ => &[1, 2, 0, 3],
            };
            nodes = turn.iter().map(|&a| nodes[a]).collect();
        }
        turned.push((*shape, nodes));
    }
    random.shuffle(&mut turned);
    (moved, turned)
}
