//! Functions of a shape at one local place, tabulated to be used in many cells.

use super::Shape;
use super::shape::{cross, dot};
use std::sync::LazyLock;

/// Tables at the two Gauss points a direction of quadrilaterals and hexahedra.
static GAUSS_POINTS: LazyLock<[Vec<ShapeTable>; 2]> = LazyLock::new(|| {
    [Shape::Quadrilateral4, Shape::Hexahedron8].map(|shape| {
        let places = shape.reference_corners().iter().map(|corner| corner.map(|v| v / 3f64.sqrt()));
        places.map(|xi| ShapeTable::new(shape, xi)).collect()
    })
});

/// Tables at the corners of quadrilaterals and hexahedra.
static CORNERS: LazyLock<[Vec<ShapeTable>; 2]> = LazyLock::new(|| {
    [Shape::Quadrilateral4, Shape::Hexahedron8]
        .map(|shape| shape.reference_corners().iter().map(|&xi| ShapeTable::new(shape, xi)).collect())
});

/// Functions and local gradients at one ξ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeTable {
    shape: Shape,
    functions: [f64; 8],
    gradients: [[f64; 3]; 8],
}

impl ShapeTable {
    /// The table of a shape at ξ.
    pub fn new(shape: Shape, xi: [f64; 3]) -> Self {
        let mut table = Self { shape, functions: [0.0; 8], gradients: [[0.0; 3]; 8] };
        shape.functions(xi, &mut table.functions);
        shape.gradients(xi, &mut table.gradients);
        table
    }

    /// Tables at two Gauss points a direction, each of weight 1; none for affine shapes, whose
    /// Jacobian is constant.
    pub(super) fn gauss_points(shape: Shape) -> &'static [Self] {
        Self::of(&GAUSS_POINTS, shape)
    }

    /// Tables at the corners; none for affine shapes.
    pub(super) fn corners(shape: Shape) -> &'static [Self] {
        Self::of(&CORNERS, shape)
    }

    fn of(tables: &'static LazyLock<[Vec<Self>; 2]>, shape: Shape) -> &'static [Self] {
        match shape {
            Shape::Quadrilateral4 => &tables[0],
            Shape::Hexahedron8 => &tables[1],
            _ => &[],
        }
    }

    /// Position at ξ in a cell with these corners, one for each node.
    #[inline]
    pub fn position(&self, corners: &[[f64; 3]]) -> [f64; 3] {
        let mut x = [0.0; 3];
        for (n, corner) in self.functions.iter().zip(corners) {
            for i in 0..3 {
                x[i] += n * corner[i];
            }
        }
        x
    }

    /// As [`Shape::jacobian`] at ξ.
    #[inline]
    pub fn jacobian(&self, corners: &[[f64; 3]]) -> [[f64; 3]; 3] {
        let mut jacobian = [[0.0; 3]; 3];
        for (corner, gradient) in corners.iter().zip(&self.gradients) {
            for i in 0..3 {
                for j in 0..3 {
                    jacobian[i][j] += corner[i] * gradient[j];
                }
            }
        }
        jacobian
    }

    /// As [`Shape::jacobian_determinant`] at ξ.
    #[inline]
    pub fn jacobian_determinant(&self, corners: &[[f64; 3]]) -> f64 {
        let jacobian = self.jacobian(corners);
        let column = |j: usize| [jacobian[0][j], jacobian[1][j], jacobian[2][j]];
        match self.shape.dimension() {
            0 => 1.0,
            1 => dot(column(0), column(0)).sqrt(),
            2 => {
                let normal = cross(column(0), column(1));
                dot(normal, normal).sqrt()
            }
            _ => dot(cross(column(0), column(1)), column(2)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A warped cell: corners of the reference cell moved by numbers without a pattern.
    fn warped(shape: Shape) -> Vec<[f64; 3]> {
        let moved = |(i, x): (usize, &[f64; 3])| std::array::from_fn(|a| x[a] + 0.2 * ((7 * i + 3 * a) as f64).sin());
        shape.reference_corners().iter().enumerate().map(moved).collect()
    }

    /// The derivative of the position by differences is the Jacobian, and the measure of a small
    /// local box around ξ follows its determinant.
    #[test]
    fn the_jacobian_is_the_slope_of_the_position() {
        for shape in Shape::ALL {
            let corners = warped(shape);
            let xi = shape.center().map(|c| c + 0.1);
            let table = ShapeTable::new(shape, xi);
            let jacobian = table.jacobian(&corners);
            for j in 0..shape.dimension() {
                let at = |step: f64| {
                    let mut moved = xi;
                    moved[j] += step;
                    ShapeTable::new(shape, moved).position(&corners)
                };
                let (ahead, behind) = (at(1e-5), at(-1e-5));
                for i in 0..3 {
                    let slope = (ahead[i] - behind[i]) / 2e-5;
                    assert!((slope - jacobian[i][j]).abs() < 1e-9, "{shape:?} {i}{j}: {slope}");
                }
            }
        }
    }

    #[test]
    fn determinants_of_stretched_cells() {
        for shape in Shape::ALL {
            let stretched: Vec<[f64; 3]> =
                shape.reference_corners().iter().map(|x| [2.0 * x[0] + 5.0, 3.0 * x[1], 4.0 * x[2]]).collect();
            let expected = [1.0, 2.0, 6.0, 24.0][shape.dimension()];
            let found = ShapeTable::new(shape, shape.center()).jacobian_determinant(&stretched);
            assert!((found - expected).abs() < 1e-14 * expected, "{shape:?}: {found}");
        }
    }
}
