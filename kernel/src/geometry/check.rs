//! Faults of meshes: cells that are turned inside out, folded, flat or have a node twice.

use super::shape::{cross, dot};
use super::{Shape, ShapeTable};
use crate::model::{Cells, ModelPart};

/// Jacobian determinants below this share of (longest edge)^dimension count as zero.
const FLAT: f64 = 1e-12;

/// A cell that cannot be used. `name` is the registered name, such as `Element2D4N`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CellFault {
    /// det J is negative everywhere: the order of the nodes is that of the mirrored cell.
    #[error(
        "{name} {id} is inside out (signed measure {measure:e}): write its nodes in the order {}",
        mirrored_order(*shape)
    )]
    Inverted {
        /// Id of the cell.
        id: u32,
        /// Registered name.
        name: String,
        /// Shape.
        shape: Shape,
        /// Signed area (m²) or volume (m³).
        measure: f64,
    },
    /// det J has both signs (or vanishes in places): edges cross, or a corner is re-entrant.
    #[error(
        "{name} {id} is folded (signed measure {measure:e}, det J as low as {smallest:e} at a corner or Gauss point): \
         its edges cross or a corner is re-entrant; its nodes must run {}",
        node_order(*shape)
    )]
    Folded {
        /// Id of the cell.
        id: u32,
        /// Registered name.
        name: String,
        /// Shape.
        shape: Shape,
        /// Signed area (m²) or volume (m³).
        measure: f64,
        /// Smallest det J at the corners and Gauss points.
        smallest: f64,
    },
    /// The measure is zero, or a coordinate is not a number.
    #[error("{name} {id} is flat (measure {measure:e}): its nodes must not coincide or lie on one line or plane")]
    Degenerate {
        /// Id of the cell.
        id: u32,
        /// Registered name.
        name: String,
        /// Length (m), area (m²) or volume (m³).
        measure: f64,
    },
    /// A node stands twice in the cell's list.
    #[error("{name} {id} has node {node} twice: a {} has {} different nodes", shape.name(), shape.node_count())]
    RepeatedNode {
        /// Id of the cell.
        id: u32,
        /// Registered name.
        name: String,
        /// Shape.
        shape: Shape,
        /// Id of the node.
        node: u32,
    },
}

fn mirrored_order(shape: Shape) -> &'static str {
    match shape {
        Shape::Triangle3 => "1 3 2",
        Shape::Quadrilateral4 => "1 4 3 2",
        Shape::Tetrahedron4 => "1 3 2 4",
        Shape::Hexahedron8 => "5 6 7 8 1 2 3 4",
        Shape::Point1 | Shape::Line2 => "of the shape",
    }
}

fn node_order(shape: Shape) -> &'static str {
    match shape {
        Shape::Hexahedron8 => "counter-clockwise around the bottom, then around the top, seen from above",
        _ => "counter-clockwise around it",
    }
}

impl CellFault {
    /// Id of the cell.
    pub fn id(&self) -> u32 {
        match self {
            Self::Inverted { id, .. }
            | Self::Folded { id, .. }
            | Self::Degenerate { id, .. }
            | Self::RepeatedNode { id, .. } => *id,
        }
    }
}

/// The faults of `cells`, whose nodes are those of `part`; at most one for each cell.
///
/// Solid cells (with as many dimensions as `space`, 2 or 3) need det J > 0 at their corners and 2-point Gauss points. Lines and surfaces in a space
/// of more dimensions have no sign: they need a measure.
pub fn check_cells(part: &ModelPart, cells: &Cells, space: usize) -> Vec<CellFault> {
    (0..cells.len()).filter_map(|cell| check_cell(part, cells, cell, space)).collect()
}

fn check_cell(part: &ModelPart, cells: &Cells, cell: usize, space: usize) -> Option<CellFault> {
    let (id, shape, nodes) = (cells.ids[cell], cells.shapes[cell], cells.nodes_of(cell));
    let name = || cells.name_of(cell).to_string();
    if shape == Shape::Point1 {
        return None;
    }
    let mut corners = [[0.0; 3]; 8];
    for (corner, &node) in corners.iter_mut().zip(nodes) {
        *corner = part.nodes.coordinates[node as usize];
    }
    let corners = &corners[..shape.node_count()];
    if is_sound_block(shape, corners) {
        return None;
    }
    if let Some(&twice) = (1..nodes.len()).find_map(|i| nodes[..i].iter().find(|&&n| n == nodes[i])) {
        let node = part.nodes.ids[twice as usize];
        return Some(CellFault::RepeatedNode { id, name: name(), shape, node });
    }
    let solid = shape.dimension() == space;
    let scale = longest_edge(corners).powi(shape.dimension() as i32);
    let (smallest, largest) = extreme_determinants(shape, corners, solid);
    let flat = FLAT * scale;
    if smallest > flat {
        return None;
    }
    let measure = match shape.dimension() {
        2 if solid => shape.plane_area(corners),
        _ => shape.measure(corners),
    };
    if largest < -flat {
        Some(CellFault::Inverted { id, name: name(), shape, measure })
    } else if largest > flat || smallest < -flat {
        Some(CellFault::Folded { id, name: name(), shape, measure, smallest })
    } else {
        Some(CellFault::Degenerate { id, name: name(), measure })
    }
}

/// True for hexahedra that are surely sound: parallelepipeds, but for a part in 10⁹, that are far
/// from flat. In them det J is constant to that part. It spares the cells of most grids the tests.
fn is_sound_block(shape: Shape, corners: &[[f64; 3]]) -> bool {
    let Some((edges, deviation)) = shape.edges(corners).filter(|_| shape == Shape::Hexahedron8) else { return false };
    let size: f64 = edges.iter().map(|edge| dot(*edge, *edge).sqrt()).sum();
    deviation <= 1e-9 * size && dot(cross(edges[0], edges[1]), edges[2]) > 1e-6 * size.powi(3)
}

/// Smallest and largest det J over corners and Gauss points; NaN counts as zero.
fn extreme_determinants(shape: Shape, corners: &[[f64; 3]], solid: bool) -> (f64, f64) {
    let determinant = |table: &ShapeTable| {
        let value = if solid && shape.dimension() == 2 {
            let j = table.jacobian(corners);
            j[0][0] * j[1][1] - j[0][1] * j[1][0]
        } else {
            table.jacobian_determinant(corners)
        };
        if value.is_nan() { 0.0 } else { value }
    };
    if shape.is_affine() {
        let value = determinant(&ShapeTable::new(shape, shape.center()));
        return (value, value);
    }
    let tables = ShapeTable::corners(shape).iter().chain(ShapeTable::gauss_points(shape));
    tables.map(determinant).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn longest_edge(corners: &[[f64; 3]]) -> f64 {
    let mut longest = 0f64;
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[..i] {
            let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
            longest = longest.max(square.sqrt());
        }
    }
    longest
}

#[cfg(test)]
mod tests;
