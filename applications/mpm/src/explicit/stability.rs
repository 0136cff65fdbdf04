//! The stable step of explicit schemes: waves and points must not cross a cell in one step.

use crate::points::{Block, MaterialPoints};
use bia_kernel::geometry::Shape;
use bia_kernel::model::ModelPart;
use rayon::prelude::*;

/// Faces of a solid cell as local nodes; edges in the plane.
fn faces(shape: Shape) -> &'static [&'static [usize]] {
    match shape {
        Shape::Triangle3 => &[&[0, 1], &[1, 2], &[2, 0]],
        Shape::Quadrilateral4 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        Shape::Tetrahedron4 => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        Shape::Hexahedron8 => {
            &[&[0, 1, 2, 3], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
        }
        _ => &[],
    }
}

fn face_shape(nodes: usize) -> Shape {
    match nodes {
        2 => Shape::Line2,
        3 => Shape::Triangle3,
        _ => Shape::Quadrilateral4,
    }
}

/// Smallest height of each cell in metres: its measure over that of its largest face, times the
/// dimension for simplices, the length of lines; infinite for cells that are no solids.
pub fn cell_sizes(grid: &ModelPart) -> Vec<f64> {
    let cells = &grid.elements;
    let size = |cell: usize| {
        let (shape, corners) = (cells.shapes[cell], grid.corners(cells, cell));
        let area = |face: &&[usize]| {
            let corners: Vec<[f64; 3]> = face.iter().map(|&node| corners[node]).collect();
            face_shape(face.len()).measure(&corners).abs()
        };
        let largest = faces(shape).iter().map(area).fold(0.0, f64::max);
        let heights = if shape.is_affine() { shape.dimension() as f64 } else { 1.0 };
        if shape == Shape::Line2 {
            return shape.measure(&corners);
        }
        if largest > 0.0 { heights * shape.measure(&corners).abs() / largest } else { f64::INFINITY }
    };
    (0..cells.len()).map(size).collect()
}

/// Fastest wave of all materials in m/s.
pub fn wave_speed(points: &MaterialPoints) -> f64 {
    points.blocks.iter().map(|block| block.law.wave_speed(block.density)).fold(0.0, f64::max)
}

/// Largest ‖F⁻¹‖ of all points, 1 at least: a wave that runs through compressed material crosses the
/// undeformed cells so many times faster. That the material also stiffens or softens is left out: 7 % at
/// F = 0.41 for the neo-Hookean law in uniaxial strain.
///
/// The largest eigenvalue of C⁻¹ is bounded by its trace and norm (Wolkowicz & Styan 1980, exact if the
/// two others are equal).
pub fn shortening(points: &MaterialPoints) -> f64 {
    let of_block = |block: &Block| {
        let of_point = |point: usize| {
            let gradient = block.deformation_gradient(point);
            let Some(inverse) = (gradient.transpose() * gradient).try_inverse() else { return 1.0 };
            let mean = inverse.trace() / 3.0;
            let spread = (inverse.norm_squared() / 3.0 - mean * mean).max(0.0).sqrt();
            (mean + std::f64::consts::SQRT_2 * spread).sqrt()
        };
        (0..block.len()).into_par_iter().map(of_point).reduce(|| 1.0, f64::max)
    };
    points.blocks.iter().map(of_block).fold(1.0, f64::max)
}

/// Fastest point in m/s.
pub fn point_speed(points: &MaterialPoints) -> f64 {
    let squares = |block: &Block| {
        let width = block.velocity.width().max(1);
        let rows = block.velocity.values().chunks_exact(width);
        rows.map(|v| v.iter().map(|v| v * v).sum::<f64>()).fold(0.0, f64::max)
    };
    points.blocks.iter().map(squares).fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_the_smallest_heights() {
        let mut grid = ModelPart::new("grid");
        grid.nodes.coordinates = vec![
            [0.0, 0.0, 0.0],
            [3.0, 0.0, 0.0],
            [3.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 4.0],
            [3.0, 0.0, 4.0],
            [3.0, 2.0, 4.0],
            [0.0, 2.0, 4.0],
        ];
        grid.nodes.ids = (1..=8).collect();
        let all: Vec<u32> = (0..8).collect();
        for (id, shape, nodes) in [
            (1, Shape::Hexahedron8, &all[..]),
            (2, Shape::Quadrilateral4, &all[..4]),
            (3, Shape::Triangle3, &[0, 1, 3]),
            (4, Shape::Tetrahedron4, &[0, 1, 3, 4]),
        ] {
            grid.elements.push(id, "cell", shape, 0, nodes);
        }
        let sizes = cell_sizes(&grid);
        // Triangle: 2 A over the hypotenuse. Tetrahedron: 1/h² = 1/3² + 1/2² + 1/4².
        let expected = [2.0, 2.0, 6.0 / 13f64.sqrt(), (1.0f64 / 9.0 + 0.25 + 0.0625).powf(-0.5)];
        for (size, expected) in sizes.iter().zip(expected) {
            assert!((size - expected).abs() < 1e-14, "{sizes:?}");
        }
    }
}
