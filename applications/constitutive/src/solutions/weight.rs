//! A column at rest under its own weight and a pressure on top, at small strain.
//!
//! s is the height above the base, H that of the top: σ = −p − ρ g (H − s), and with the base held
//! u = −(p s + ρ g (H s − s²/2))/M. A fluid at rest has the same σ as its mean stress; its column does not
//! move with `modulus` left out.

use super::{Field, LINE, Line, LineSolution};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range};
use bia_kernel::reference::{Compared, ReferenceEntry, ReferenceSolution};
use bia_kernel::registry::Building;

const KEYS: &[Key] = &Key::join::<3, 5, 8>(
    LINE,
    [
        Key::required("height", Kind::Number(Range::POSITIVE), "coordinate s of the top [m]"),
        Key::required("density", Kind::Number(Range::POSITIVE), "density [kg/m³]"),
        Key::required("gravity", Kind::Number(Range::ANY), "acceleration towards the base [m/s²]"),
        Key::new("pressure", Kind::Number(Range::ANY), "0.0", "on top, positive in compression [Pa]"),
        Key::optional(
            "modulus",
            Kind::Number(Range::POSITIVE),
            "stress over strain along the axis [Pa]; rigid without",
        ),
    ],
);

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "hydrostatic_column",
    keys: KEYS,
    help: "column of a solid or fluid at rest under its own weight, at small strain",
    build,
};

struct Column {
    height: f64,
    weight: f64,
    pressure: f64,
    modulus: f64,
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    let column = Column {
        height: settings.number("height"),
        weight: settings.number("density") * settings.number("gravity"),
        pressure: settings.number("pressure"),
        modulus: if settings.given("modulus") { settings.number("modulus") } else { f64::INFINITY },
    };
    Line::build(settings, compared, column, None)
}

impl LineSolution for Column {
    fn value(&self, field: Field, s: f64, _: f64) -> f64 {
        match field {
            Field::Displacement => -(self.pressure * s + self.weight * (self.height * s - 0.5 * s * s)) / self.modulus,
            Field::Velocity => 0.0,
            Field::Stress => -self.pressure - self.weight * (self.height - s),
        }
    }
}
