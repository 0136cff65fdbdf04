//! The shapes of cells.

use super::ShapeTable;
use super::cell::{CellShape, Hexahedron8, Line2, Quadrilateral4, Tetrahedron4, Triangle3};

/// Shape of a cell, with Kratos's order of local nodes.
///
/// Reference cells: lines, quadrilaterals and hexahedra span [−1, 1] in each local coordinate;
/// triangles and tetrahedra are the unit simplices with their first node at the origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// One node.
    Point1,
    /// Two nodes.
    Line2,
    /// Three nodes, counter-clockwise.
    Triangle3,
    /// Four nodes, counter-clockwise.
    Quadrilateral4,
    /// Four nodes, positive volume.
    Tetrahedron4,
    /// Eight nodes: bottom counter-clockwise, then top.
    Hexahedron8,
}

const POINT: [[f64; 3]; 1] = [[0.0; 3]];
const LINE: [[f64; 3]; 2] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
const SIMPLEX: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const SQUARE: [[f64; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
const CUBE: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 6] =
        [Self::Point1, Self::Line2, Self::Triangle3, Self::Quadrilateral4, Self::Tetrahedron4, Self::Hexahedron8];

    /// Number of nodes.
    pub const fn node_count(self) -> usize {
        self.reference_corners().len()
    }

    /// Number of local coordinates.
    pub const fn dimension(self) -> usize {
        match self {
            Self::Point1 => 0,
            Self::Line2 => 1,
            Self::Triangle3 | Self::Quadrilateral4 => 2,
            Self::Tetrahedron4 | Self::Hexahedron8 => 3,
        }
    }

    /// Name, as the variant is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point1 => "Point1",
            Self::Line2 => "Line2",
            Self::Triangle3 => "Triangle3",
            Self::Quadrilateral4 => "Quadrilateral4",
            Self::Tetrahedron4 => "Tetrahedron4",
            Self::Hexahedron8 => "Hexahedron8",
        }
    }

    /// Type number of the cell in VTK files; VTK's order of nodes is ours.
    pub const fn vtk_type(self) -> u8 {
        match self {
            Self::Point1 => 1,
            Self::Line2 => 3,
            Self::Triangle3 => 5,
            Self::Quadrilateral4 => 9,
            Self::Tetrahedron4 => 10,
            Self::Hexahedron8 => 12,
        }
    }

    /// True where the map from local to physical coordinates is affine for any corners.
    pub const fn is_affine(self) -> bool {
        !matches!(self, Self::Quadrilateral4 | Self::Hexahedron8)
    }

    /// Local coordinates of the nodes; those beyond [`Shape::dimension`] are 0.
    pub const fn reference_corners(self) -> &'static [[f64; 3]] {
        match self {
            Self::Point1 => &POINT,
            Self::Line2 => &LINE,
            Self::Triangle3 => SIMPLEX.split_at(3).0,
            Self::Quadrilateral4 => &SQUARE,
            Self::Tetrahedron4 => &SIMPLEX,
            Self::Hexahedron8 => &CUBE,
        }
    }

    /// Length, area or volume of the reference cell; 1 for a point (it counts).
    pub const fn reference_measure(self) -> f64 {
        match self {
            Self::Point1 => 1.0,
            Self::Line2 => 2.0,
            Self::Triangle3 => 0.5,
            Self::Quadrilateral4 => 4.0,
            Self::Tetrahedron4 => 1.0 / 6.0,
            Self::Hexahedron8 => 8.0,
        }
    }

    /// Local coordinates of the centroid of the reference cell.
    pub const fn center(self) -> [f64; 3] {
        match self {
            Self::Triangle3 => [1.0 / 3.0, 1.0 / 3.0, 0.0],
            Self::Tetrahedron4 => [0.25; 3],
            _ => [0.0; 3],
        }
    }

    /// Shape functions N_a(ξ), one for each node, into the first entries of `n`.
    ///
    /// # Panics
    /// If `n` is shorter than [`Shape::node_count`].
    pub fn functions(self, xi: [f64; 3], n: &mut [f64]) {
        let [x, y, z] = xi;
        match self {
            Self::Point1 => n[0] = 1.0,
            Self::Line2 => n[..2].copy_from_slice(&Line2::functions(&[x])),
            Self::Triangle3 => n[..3].copy_from_slice(&Triangle3::functions(&[x, y])),
            Self::Quadrilateral4 => n[..4].copy_from_slice(&Quadrilateral4::functions(&[x, y])),
            Self::Tetrahedron4 => n[..4].copy_from_slice(&Tetrahedron4::functions(&[x, y, z])),
            Self::Hexahedron8 => n[..8].copy_from_slice(&Hexahedron8::functions(&[x, y, z])),
        }
    }

    /// Local gradients ∂N_a/∂ξ_j as `dn[a][j]`; entries beyond [`Shape::dimension`] are 0.
    ///
    /// # Panics
    /// If `dn` is shorter than [`Shape::node_count`].
    pub fn gradients(self, xi: [f64; 3], dn: &mut [[f64; 3]]) {
        fn widen<const D: usize>(from: &[[f64; D]], to: &mut [[f64; 3]]) {
            for (a, gradient) in from.iter().enumerate() {
                to[a] = [0.0; 3];
                to[a][..D].copy_from_slice(gradient);
            }
        }
        let [x, y, z] = xi;
        match self {
            Self::Point1 => dn[0] = [0.0; 3],
            Self::Line2 => widen(&Line2::gradients(&[x]), dn),
            Self::Triangle3 => widen(&Triangle3::gradients(&[x, y]), dn),
            Self::Quadrilateral4 => widen(&Quadrilateral4::gradients(&[x, y]), dn),
            Self::Tetrahedron4 => widen(&Tetrahedron4::gradients(&[x, y, z]), dn),
            Self::Hexahedron8 => widen(&Hexahedron8::gradients(&[x, y, z]), dn),
        }
    }

    /// True when ξ lies in the reference cell enlarged by `tolerance` (in local coordinates):
    /// ξ_i ≥ −t and Σξ ≤ 1 + t in simplices, |ξ_i| ≤ 1 + t in the others. False for NaN.
    #[inline]
    pub fn contains(self, xi: [f64; 3], tolerance: f64) -> bool {
        match self {
            Self::Point1 => true,
            Self::Triangle3 | Self::Tetrahedron4 => {
                let xi = &xi[..self.dimension()];
                xi.iter().all(|&v| v >= -tolerance) && xi.iter().sum::<f64>() <= 1.0 + tolerance
            }
            _ => xi[..self.dimension()].iter().all(|&v| v.abs() <= 1.0 + tolerance),
        }
    }

    /// Jacobian of the map to physical coordinates, J\[i\]\[j\] = ∂x_i/∂ξ_j; columns beyond
    /// [`Shape::dimension`] are 0. `corners` holds one position for each node.
    pub fn jacobian(self, corners: &[[f64; 3]], xi: [f64; 3]) -> [[f64; 3]; 3] {
        ShapeTable::new(self, xi).jacobian(corners)
    }

    /// Ratio of physical to local measure at ξ, by which weights are multiplied: det J of a solid
    /// (negative where it is inside out), |∂x/∂ξ × ∂x/∂η| of a triangle or quadrilateral,
    /// |∂x/∂ξ| of a line, 1 of a point.
    pub fn jacobian_determinant(self, corners: &[[f64; 3]], xi: [f64; 3]) -> f64 {
        ShapeTable::new(self, xi).jacobian_determinant(corners)
    }

    /// Normal at ξ whose length is the ratio of physical to local measure: of a line in the plane to
    /// its right, of a surface by the right hand; 0 for shapes that have none.
    pub fn normal(self, corners: &[[f64; 3]], xi: [f64; 3]) -> [f64; 3] {
        let jacobian = self.jacobian(corners, xi);
        let column = |j: usize| [jacobian[0][j], jacobian[1][j], jacobian[2][j]];
        match self.dimension() {
            1 => [jacobian[1][0], -jacobian[0][0], 0.0],
            2 => cross(column(0), column(1)),
            _ => [0.0; 3],
        }
    }

    /// Length (m), area (m²) or volume (m³) of the cell with these corners; 1 for a point.
    ///
    /// Volumes have the sign of det J. Lines and surfaces may stand in space, where they have no
    /// sign; the sign of a cell in the plane is that of [`Shape::plane_area`]. Exact but for
    /// warped quadrilaterals, which 2 × 2 Gauss points integrate.
    pub fn measure(self, corners: &[[f64; 3]]) -> f64 {
        if self.is_affine() {
            return self.reference_measure() * self.jacobian_determinant(corners, self.center());
        }
        if let Some((edges, deviation)) = self.edges(corners)
            && deviation <= 4.0 * f64::EPSILON * corners.as_flattened().iter().fold(0.0, |most, x| x.abs().max(most))
        {
            let normal = cross(edges[0], edges[1]);
            let is_solid = self == Self::Hexahedron8;
            return if is_solid { dot(normal, edges[2]) } else { dot(normal, normal).sqrt() };
        }
        ShapeTable::gauss_points(self).iter().map(|table| table.jacobian_determinant(corners)).sum()
    }

    /// The edges that leave the first corner of a quadrilateral or hexahedron (the third is 0 in the
    /// former), and the sum of all differences of coordinates from the parallelogram or
    /// parallelepiped that they span, all in m. None for other shapes.
    pub(super) fn edges(self, corners: &[[f64; 3]]) -> Option<([[f64; 3]; 3], f64)> {
        let edge = |to: usize| std::array::from_fn(|i| corners[to][i] - corners[0][i]);
        let (edges, sums): (_, &[(usize, [f64; 3])]) = match (self, corners.len()) {
            (Self::Quadrilateral4, 4) => ([edge(1), edge(3), [0.0; 3]], &[(2, [1.0, 1.0, 0.0])]),
            (Self::Hexahedron8, 8) => (
                [edge(1), edge(3), edge(4)],
                &[(2, [1.0, 1.0, 0.0]), (5, [1.0, 0.0, 1.0]), (7, [0.0, 1.0, 1.0]), (6, [1.0; 3])],
            ),
            _ => return None,
        };
        let mut deviation = 0.0;
        for &(corner, shares) in sums {
            for i in 0..3 {
                let sum = shares[0] * edges[0][i] + shares[1] * edges[1][i] + shares[2] * edges[2][i];
                deviation += (corners[0][i] + sum - corners[corner][i]).abs();
            }
        }
        Some((edges, deviation))
    }

    /// Signed area (m²) of the projection to the first two coordinates, positive where the nodes
    /// run counter-clockwise; 0 for shapes that are no surfaces.
    pub fn plane_area(self, corners: &[[f64; 3]]) -> f64 {
        let diagonals = match (self, corners) {
            (Self::Triangle3, [a, b, c]) => [[b, a], [c, a]],
            (Self::Quadrilateral4, [a, b, c, d]) => [[c, a], [d, b]],
            _ => return 0.0,
        };
        let [u, v] = diagonals.map(|[to, from]| [to[0] - from[0], to[1] - from[1]]);
        0.5 * (u[0] * v[1] - u[1] * v[0])
    }
}

/// Cross product.
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Scalar product.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
