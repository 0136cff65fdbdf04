//! The kinds of cells of Gmsh.

use super::source::Source;
use crate::diagnostic::InputErrors;
use crate::geometry::Shape;

/// Kinds that Bia has, by Gmsh's number; nodes stand in Bia's order.
pub(super) const KNOWN: [(i32, Shape); 6] = [
    (1, Shape::Line2),
    (2, Shape::Triangle3),
    (3, Shape::Quadrilateral4),
    (4, Shape::Tetrahedron4),
    (5, Shape::Hexahedron8),
    (15, Shape::Point1),
];

/// The others by name.
const OTHERS: [(i32, &str); 14] = [
    (6, "prisms"),
    (7, "pyramids"),
    (8, "lines of second order"),
    (9, "triangles of second order"),
    (10, "quadrilaterals of second order with 9 nodes"),
    (11, "tetrahedra of second order"),
    (12, "hexahedra of second order with 27 nodes"),
    (13, "prisms of second order"),
    (14, "pyramids of second order"),
    (16, "quadrilaterals of second order with 8 nodes"),
    (17, "hexahedra of second order with 20 nodes"),
    (18, "prisms of second order with 15 nodes"),
    (19, "pyramids of second order with 13 nodes"),
    (21, "triangles of third order"),
];

/// A kind of cell that Bia has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellType(pub Shape);

impl CellType {
    /// The kind with Gmsh's number.
    pub fn read(source: &Source, number: i32) -> Result<Self, InputErrors> {
        if let Some((_, shape)) = KNOWN.iter().find(|(known, _)| *known == number) {
            return Ok(Self(*shape));
        }
        let name = OTHERS.iter().find(|(known, _)| *known == number).map(|(_, name)| *name);
        let message = match name {
            Some(name) => format!("the mesh holds {name} (type {number} of Gmsh)"),
            None => format!("the mesh holds cells of type {number} of Gmsh"),
        };
        let help = "Bia reads points, lines, triangles, quadrilaterals, tetrahedra and hexahedra of first order: \
                    set Mesh.ElementOrder to 1, and recombine or split prisms and pyramids";
        Err(source.fault(message).help(help).into())
    }
}
