//! Names of elements and conditions in mesh files. The element's name gives the shape only.

use bia_kernel::geometry::Shape;
use bia_kernel::io::mdpa::Category::{Condition, Element};
use bia_kernel::registry::Registry;

/// Registers them.
pub fn register(registry: &mut Registry) {
    for (name, shape) in
        [("Element1D2N", Shape::Line2), ("Element2D4N", Shape::Quadrilateral4), ("Element3D8N", Shape::Hexahedron8)]
    {
        registry.cell(Element, name, shape);
    }
    for (name, shape) in [
        ("PointLoadCondition1D1N", Shape::Point1),
        ("LineLoadCondition2D2N", Shape::Line2),
        ("SurfaceLoadCondition3D4N", Shape::Quadrilateral4),
    ] {
        registry.cell(Condition, name, shape);
    }
}
