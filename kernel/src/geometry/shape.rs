//! The shapes of cells.

/// Shape of a cell, with Kratos's order of local nodes.
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
