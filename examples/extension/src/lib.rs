//! An application from outside the framework: a law for material points, a process, an element of its own and the
//! solver that uses it. `CONTRIBUTING.md` explains the parts, whose code stands there word for word.
//!
//! A program with it is `cli/src/main.rs` with one line more: `bia_extension::register(&mut registry);`.

pub mod element;
pub mod law;
pub mod process;
pub mod solver;

use law::ElasticFluid;
use process::SPEED_LIMIT;
use solver::{HEAT, TEMPERATURE};

// [application]
use bia_constitutive::{Catalogue, Kinematics, LawEntry};
use bia_kernel::geometry::Shape;
use bia_kernel::io::mdpa::Category;
use bia_kernel::registry::Registry;

/// Adds the components of this application, after those that it builds on.
pub fn register(registry: &mut Registry) {
    let laws: &mut Catalogue = registry.catalogue_mut();
    if let Err(taken) = laws.register(LawEntry::of::<ElasticFluid>("ElasticFluid2D", &[Kinematics::PlaneStrain])) {
        tracing::error!("{taken}");
    }
    registry.process(SPEED_LIMIT);
    registry.solver(HEAT);
    registry.variable(TEMPERATURE);
    for (name, shape) in [
        ("HeatElement1D2N", Shape::Line2),
        ("HeatElement2D3N", Shape::Triangle3),
        ("HeatElement2D4N", Shape::Quadrilateral4),
        ("HeatElement3D4N", Shape::Tetrahedron4),
        ("HeatElement3D8N", Shape::Hexahedron8),
    ] {
        registry.cell(Category::Element, name, shape);
    }
}
// [/application]
