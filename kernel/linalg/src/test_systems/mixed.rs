//! Displacement-pressure systems of a box of bilinear or trilinear cells: `[A B^T; B -C]`, the pressure last on each
//! node.

use crate::{BlockMatrix, BlockPattern};
use std::sync::Arc;

/// How the pressure is kept stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressure {
    /// Not at all: displacements and pressure on the same nodes.
    Unstable,
    /// `tau grad p . grad q` with `tau = h^2 / (2 G + density h^2)`, like ASGS.
    Stabilised,
    /// On every second node only (Q1-iso-Q2/Q1, which satisfies the inf-sup condition); the other pressures are held.
    /// `cells` must be even.
    Coarse,
}

/// A box `[0, 1]^dimension` of linear isotropic material, held at `x = 0`.
#[derive(Debug, Clone)]
pub struct MixedBox {
    pub dimension: usize,
    /// Cells along an edge.
    pub cells: usize,
    /// Shear modulus.
    pub shear: f64,
    /// Bulk modulus, may be infinite.
    pub bulk: f64,
    /// Density over the square of the time step; 0 for statics.
    pub inertia: f64,
    pub pressure: Pressure,
    /// Part of their volume that the cells at `x > 1 - h` hold, as if a body ended in them.
    pub cut: f64,
    /// Relative size of the unsymmetric terms of a consistent tangent.
    pub skew: f64,
}

impl MixedBox {
    pub fn new(dimension: usize, cells: usize) -> Self {
        Self {
            dimension,
            cells,
            shear: 1.0,
            bulk: f64::INFINITY,
            inertia: 0.0,
            pressure: Pressure::Stabilised,
            cut: 1.0,
            skew: 0.0,
        }
    }

    fn width(&self) -> f64 {
        1.0 / self.cells as f64
    }

    pub fn nodes(&self) -> usize {
        (self.cells + 1).pow(self.dimension as u32)
    }

    /// Place of a node on the lattice, the last axis fastest.
    pub fn lattice(&self, node: usize) -> [usize; 3] {
        let along = self.cells + 1;
        let mut rest = node;
        let mut place = [0; 3];
        for axis in (0..self.dimension).rev() {
            place[axis] = rest % along;
            rest /= along;
        }
        place
    }

    fn node(&self, place: [usize; 3]) -> u32 {
        place[..self.dimension].iter().fold(0, |node, &i| node * (self.cells + 1) + i) as u32
    }

    /// Corners of lattice boxes of `width` cells, one list for each.
    fn boxes(&self, width: usize) -> Vec<Vec<u32>> {
        let (along, corners) = (self.cells / width, (width + 1).pow(self.dimension as u32));
        let digits = |mut index: usize, base: usize| -> [usize; 3] {
            std::array::from_fn(|axis| {
                let digit = if axis < self.dimension { index % base } else { 0 };
                index /= base;
                digit
            })
        };
        let list = |cell: usize| {
            let low = digits(cell, along);
            let corner = |k| self.node(std::array::from_fn(|axis| low[axis] * width + digits(k, width + 1)[axis]));
            (0..corners).map(corner).collect()
        };
        (0..along.pow(self.dimension as u32)).map(list).collect()
    }

    /// Whether the pressure of a node is an unknown.
    fn has_pressure(&self, node: usize) -> bool {
        self.pressure != Pressure::Coarse || self.lattice(node).iter().all(|i| i % 2 == 0)
    }

    /// The unknowns that are held.
    pub fn held(&self) -> Vec<bool> {
        let block = self.dimension + 1;
        let held = |dof: usize| match dof % block == self.dimension {
            true => !self.has_pressure(dof / block),
            false => self.lattice(dof / block)[0] == 0,
        };
        (0..self.nodes() * block).map(held).collect()
    }

    /// Pressures that are unknown: the number of negative eigenvalues where `skew` is 0.
    pub fn pressures(&self) -> usize {
        (0..self.nodes()).filter(|&node| self.has_pressure(node)).count()
    }

    /// The matrix without supports.
    pub fn free(&self) -> BlockMatrix {
        let block = self.dimension + 1;
        let coarse = self.pressure == Pressure::Coarse;
        let cliques = self.boxes(if coarse { 2 } else { 1 });
        let pattern = BlockPattern::from_cliques(block, self.nodes(), cliques.iter().map(Vec::as_slice));
        let mut matrix = BlockMatrix::new(Arc::new(pattern));
        for cell in self.boxes(1) {
            self.add_cell(&cell, &mut matrix);
        }
        matrix
    }

    /// The matrix with `x = 0` held, and a load on the rest in the scale of its rows.
    pub fn system(&self) -> (BlockMatrix, Vec<f64>) {
        let mut matrix = self.free();
        let solution = super::vector(matrix.pattern.order(), 5);
        let mut load = vec![0.0; solution.len()];
        matrix.multiply(&solution, &mut load);
        matrix.constrain(&self.held(), &mut load);
        (matrix, load)
    }

    fn add_cell(&self, cell: &[u32], matrix: &mut BlockMatrix) {
        let (d, block) = (self.dimension, self.dimension + 1);
        let last = self.lattice(cell[0] as usize)[0] == self.cells - 1;
        let (points, volume) = (1usize << d, self.width().powi(d as i32) * if last { self.cut } else { 1.0 });
        let parents = self.interpolation(cell);
        for point in 0..points {
            let shape: Vec<(f64, [f64; 3])> = (0..points).map(|corner| self.shape(corner, point)).collect();
            let pressure: Vec<(u32, f64, [f64; 3])> = self.pressure_shape(cell, &parents, &shape);
            let weight = volume / points as f64;
            let mut add = |i: u32, a: usize, j: u32, b: usize, value: f64| {
                let entry = matrix.pattern.position(i as usize, j as usize).unwrap() as usize;
                matrix.values[(entry * block + a) * block + b] += weight * value;
            };
            for (&i, (n, p)) in cell.iter().zip(&shape) {
                for (&j, (m, q)) in cell.iter().zip(&shape) {
                    let dot: f64 = (0..d).map(|k| p[k] * q[k]).sum();
                    for a in 0..d {
                        for b in 0..d {
                            let deviatoric = p[b] * q[a] - 2.0 / 3.0 * p[a] * q[b];
                            let same = if a == b { self.shear * dot + self.inertia * n * m } else { 0.0 };
                            add(i, a, j, b, self.shear * deviatoric + same);
                        }
                    }
                }
            }
            for &(i, n, p) in &pressure {
                for (&j, (_, q)) in cell.iter().zip(&shape) {
                    // A pressure gradient across the body, as it enters the tangents of ASGS and of Miehe's law.
                    let gradient = [self.skew, -0.5 * self.skew, 0.3 * self.skew];
                    let along: f64 = (0..d).map(|k| p[k] * gradient[k]).sum();
                    let dot: f64 = (0..d).map(|k| p[k] * q[k]).sum();
                    for b in 0..d {
                        let skew = self.width() * (along * q[b] - gradient[b] * dot) + self.skew * n * q[b];
                        add(j, b, i, d, n * q[b]);
                        add(i, d, j, b, n * q[b] + skew);
                    }
                }
                for &(j, m, q) in &pressure {
                    let dot: f64 = (0..d).map(|k| p[k] * q[k]).sum();
                    add(i, d, j, d, -n * m / self.bulk - self.tau() * dot);
                }
            }
        }
    }

    /// What resists a strain of the size of a cell: the scale of pressures.
    pub fn stiffness(&self) -> f64 {
        self.shear + self.inertia * self.width().powi(2)
    }

    fn tau(&self) -> f64 {
        let square = self.width().powi(2);
        if self.pressure == Pressure::Stabilised { square / (2.0 * self.shear + self.inertia * square) } else { 0.0 }
    }

    /// Shape function of `corner` and its gradient at Gauss point `point`.
    fn shape(&self, corner: usize, point: usize) -> (f64, [f64; 3]) {
        let value = |axis: usize| {
            let place = 0.5 + if point >> axis & 1 == 1 { 0.5 } else { -0.5 } / 3f64.sqrt();
            if corner >> axis & 1 == 1 { place } else { 1.0 - place }
        };
        let slope = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 } / self.width();
        let factor = |axis: usize, other: usize| if axis == other { slope(axis) } else { value(other) };
        let along = |axis: usize| (0..self.dimension).map(|other| factor(axis, other)).product();
        let gradient = std::array::from_fn(|axis| if axis < self.dimension { along(axis) } else { 0.0 });
        ((0..self.dimension).map(value).product(), gradient)
    }

    /// For each corner the nodes whose pressures it is the mean of.
    fn interpolation(&self, cell: &[u32]) -> Vec<Vec<u32>> {
        let parents = |&node: &u32| {
            let place = self.lattice(node as usize);
            let odd: Vec<usize> = (0..self.dimension).filter(|&axis| place[axis] % 2 == 1).collect();
            let parent = |choice: usize| {
                let mut parent = place;
                for (bit, &axis) in odd.iter().enumerate() {
                    parent[axis] = if choice >> bit & 1 == 1 { place[axis] + 1 } else { place[axis] - 1 };
                }
                self.node(parent)
            };
            (0..1usize << odd.len()).map(parent).collect()
        };
        match self.pressure {
            Pressure::Coarse => cell.iter().map(parents).collect(),
            _ => cell.iter().map(|&node| vec![node]).collect(),
        }
    }

    /// Pressure nodes with value and gradient of their functions.
    fn pressure_shape(
        &self,
        cell: &[u32],
        parents: &[Vec<u32>],
        shape: &[(f64, [f64; 3])],
    ) -> Vec<(u32, f64, [f64; 3])> {
        debug_assert_eq!(cell.len(), parents.len());
        let mut functions: Vec<(u32, f64, [f64; 3])> = Vec::new();
        for (parents, (value, gradient)) in parents.iter().zip(shape) {
            let share = 1.0 / parents.len() as f64;
            for &parent in parents {
                let known = functions.iter().position(|(node, ..)| *node == parent);
                let index = known.unwrap_or_else(|| {
                    functions.push((parent, 0.0, [0.0; 3]));
                    functions.len() - 1
                });
                functions[index].1 += share * value;
                for axis in 0..3 {
                    functions[index].2[axis] += share * gradient[axis];
                }
            }
        }
        functions
    }
}
