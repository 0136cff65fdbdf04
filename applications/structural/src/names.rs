//! Names of elements and conditions in mesh files. The element's name gives the shape only: the
//! kinematics follow from the solver settings and the law.

use bia_kernel::geometry::Shape;
use bia_kernel::io::mdpa::Category::{Condition, Element};
use bia_kernel::registry::Registry;

/// Registers them.
pub fn register(registry: &mut Registry) {
    for (name, shape) in [
        ("Element1D2N", Shape::Line2),
        ("Element2D3N", Shape::Triangle3),
        ("Element2D4N", Shape::Quadrilateral4),
        ("Element3D4N", Shape::Tetrahedron4),
        ("Element3D8N", Shape::Hexahedron8),
        ("TotalLagrangianElement1D2N", Shape::Line2),
        ("TotalLagrangianElement2D3N", Shape::Triangle3),
        ("TotalLagrangianElement2D4N", Shape::Quadrilateral4),
        ("TotalLagrangianElement3D4N", Shape::Tetrahedron4),
        ("TotalLagrangianElement3D8N", Shape::Hexahedron8),
        ("AxisymTotalLagrangianElement2D3N", Shape::Triangle3),
        ("AxisymTotalLagrangianElement2D4N", Shape::Quadrilateral4),
    ] {
        registry.cell(Element, name, shape);
    }
    for (name, shape) in [
        ("PointLoadCondition1D1N", Shape::Point1),
        ("PointLoadCondition2D1N", Shape::Point1),
        ("PointLoadCondition3D1N", Shape::Point1),
        ("AxisymPointLoadCondition2D1N", Shape::Point1),
        ("LineLoadCondition2D2N", Shape::Line2),
        ("AxisymLineLoadCondition2D2N", Shape::Line2),
        ("SurfaceLoadCondition3D3N", Shape::Triangle3),
        ("SurfaceLoadCondition3D4N", Shape::Quadrilateral4),
    ] {
        registry.cell(Condition, name, shape);
    }
}
