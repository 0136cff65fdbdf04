//! Names of elements and conditions in mesh files. The body's element name gives the shape only:
//! the formulation is chosen by the solver settings, as in Kratos.

use bia_kernel::geometry::Shape;
use bia_kernel::io::mdpa::Category;
use bia_kernel::registry::Registry;

const ELEMENTS: &[(&str, Shape)] = &[
    ("Element1D2N", Shape::Line2),
    ("Element2D3N", Shape::Triangle3),
    ("Element2D4N", Shape::Quadrilateral4),
    ("Element3D4N", Shape::Tetrahedron4),
    ("Element3D8N", Shape::Hexahedron8),
    ("MPMUpdatedLagrangian1D2N", Shape::Line2),
    ("MPMUpdatedLagrangian2D3N", Shape::Triangle3),
    ("MPMUpdatedLagrangian2D4N", Shape::Quadrilateral4),
    ("MPMUpdatedLagrangian3D4N", Shape::Tetrahedron4),
    ("MPMUpdatedLagrangian3D8N", Shape::Hexahedron8),
    ("MPMUpdatedLagrangianUP2D3N", Shape::Triangle3),
    ("MPMUpdatedLagrangianUP2D4N", Shape::Quadrilateral4),
    ("MPMUpdatedLagrangianUP3D4N", Shape::Tetrahedron4),
    ("MPMUpdatedLagrangianUP3D8N", Shape::Hexahedron8),
    ("MPMUpdatedLagrangianAxisymmetry2D3N", Shape::Triangle3),
    ("MPMUpdatedLagrangianAxisymmetry2D4N", Shape::Quadrilateral4),
    ("MPMUpdatedLagrangianPQ2D3N", Shape::Triangle3),
    ("MPMUpdatedLagrangianPQ2D4N", Shape::Quadrilateral4),
    ("MPMUpdatedLagrangianPQ3D4N", Shape::Tetrahedron4),
    ("MPMUpdatedLagrangianPQ3D8N", Shape::Hexahedron8),
    // Names of projects before Kratos 9.
    ("UpdatedLagrangian2D3N", Shape::Triangle3),
    ("UpdatedLagrangian2D4N", Shape::Quadrilateral4),
    ("UpdatedLagrangian3D4N", Shape::Tetrahedron4),
    ("UpdatedLagrangian3D8N", Shape::Hexahedron8),
    ("UpdatedLagrangianUP2D3N", Shape::Triangle3),
    ("UpdatedLagrangianUP2D4N", Shape::Quadrilateral4),
    ("UpdatedLagrangianAxisymmetry2D3N", Shape::Triangle3),
    ("UpdatedLagrangianAxisymmetry2D4N", Shape::Quadrilateral4),
    ("UpdatedLagrangianPQ2D3N", Shape::Triangle3),
    ("UpdatedLagrangianPQ2D4N", Shape::Quadrilateral4),
];

const CONDITIONS: &[(&str, Shape)] = &[
    ("PointCondition1D1N", Shape::Point1),
    ("MPMGridPointLoadCondition1D1N", Shape::Point1),
    ("PointCondition2D1N", Shape::Point1),
    ("PointCondition3D1N", Shape::Point1),
    ("LineCondition2D2N", Shape::Line2),
    ("SurfaceCondition3D3N", Shape::Triangle3),
    ("SurfaceCondition3D4N", Shape::Quadrilateral4),
    ("MPMGridPointLoadCondition2D1N", Shape::Point1),
    ("MPMGridPointLoadCondition3D1N", Shape::Point1),
    ("MPMGridAxisymPointLoadCondition2D1N", Shape::Point1),
    ("MPMGridLineLoadCondition2D2N", Shape::Line2),
    ("MPMGridAxisymLineLoadCondition2D2N", Shape::Line2),
    ("MPMGridSurfaceLoadCondition3D3N", Shape::Triangle3),
    ("MPMGridSurfaceLoadCondition3D4N", Shape::Quadrilateral4),
];

/// Registers them.
pub fn register(registry: &mut Registry) {
    for (name, shape) in ELEMENTS {
        registry.cell(Category::Element, name, *shape);
    }
    for (name, shape) in CONDITIONS {
        registry.cell(Category::Condition, name, *shape);
    }
}
