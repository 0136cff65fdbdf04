//! An elastic bar whose end s = 0 is loaded or moved at once at t = 0, with reflections at both ends.
//!
//! d'Alembert: u = v₀ t + g(c t − s) + h(c t + s), c = √(M/ρ). The far end s = L sends waves back,
//! h'(z) = r g'(z − 2L) with r = 1 at a free end, −1 at a held one and 0 in an endless bar. At s = 0 a
//! stress T asks for −g' + h' = T/M, hence g'(z) = −(T/M) Σ rᵏ, and a velocity V for c(g' + h') = V − v₀,
//! hence g'(z) = (V − v₀)/c Σ (−r)ᵏ; k counts the reflections so far, those with z ≥ 2kL.
//! Source: Graff, Wave Motion in Elastic Solids, §2.2.

use super::{Field, LINE, Line, LineSolution};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::reference::{Compared, ReferenceEntry, ReferenceSolution};
use bia_kernel::registry::Building;

const KEYS: &[Key] = &Key::join::<3, 7, 10>(
    LINE,
    [
        Key::required("modulus", Kind::Number(Range::POSITIVE), "stress over strain along the axis [Pa]"),
        Key::required("density", Kind::Number(Range::POSITIVE), "density [kg/m³]"),
        Key::optional("length", Kind::Number(Range::POSITIVE), "length of the bar [m]; endless without it"),
        Key::new("far_end", Kind::Choice(&["free", "held"]), "\"free\"", "how the end s = length is kept"),
        Key::optional("stress", Kind::Number(Range::ANY), "stress at s = 0 from t = 0 on, positive in tension [Pa]"),
        Key::optional("velocity", Kind::Number(Range::ANY), "velocity along s of the end s = 0 from t = 0 on [m/s]"),
        Key::new(
            "initial_velocity",
            Kind::Number(Range::ANY),
            "0.0",
            "velocity along s of the whole bar at t = 0 [m/s]",
        ),
    ],
);

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "elastic_bar",
    keys: KEYS,
    help: "elastic bar, loaded, moved or stopped at its end s = 0 at once, with reflections (d'Alembert)",
    build,
};

/// The solution.
pub(super) struct Bar {
    pub modulus: f64,
    pub speed: f64,
    pub length: f64,
    /// Factor of each reflection at the far end, and of a way to and fro.
    pub far: f64,
    pub each: f64,
    /// g' of the first wave.
    pub first: f64,
    pub initial_velocity: f64,
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    let bar = Bar::read(settings)?;
    Line::build(settings, compared, bar, None)
}

impl Bar {
    fn read(settings: &Settings) -> Result<Self, InputErrors> {
        let modulus = settings.number("modulus");
        let speed = (modulus / settings.number("density")).sqrt();
        let far = match (settings.given("length"), settings.text("far_end")) {
            (false, _) => 0.0,
            (true, "held") => -1.0,
            (true, _) => 1.0,
        };
        let length = if settings.given("length") { settings.number("length") } else { f64::INFINITY };
        let initial_velocity = settings.number("initial_velocity");
        if initial_velocity != 0.0 && far < 0.0 {
            let message = "a bar that is held at its end cannot fly";
            return Err(settings.error("initial_velocity", message).into());
        }
        let (each, first) = match (settings.given("stress"), settings.given("velocity")) {
            (true, false) => (far, -settings.number("stress") / modulus),
            (false, true) => (-far, (settings.number("velocity") - initial_velocity) / speed),
            _ => {
                let message = "needs either \"stress\" or \"velocity\" at s = 0";
                return Err(settings.parameters().error(message).into());
            }
        };
        Ok(Self { modulus, speed, length, far, each, first, initial_velocity })
    }

    /// g'(z), without unit.
    fn slope(&self, z: f64) -> f64 {
        // A wave front is where it is but for round-off, so that points on it see what lies behind it.
        let slack = 1e-12 * z.abs();
        let mut sum = 0.0;
        self.reflections(z + slack, |factor, _| sum += factor);
        self.first * sum
    }

    /// g(z) = ∫₀ᶻ g'.
    fn integral(&self, z: f64) -> f64 {
        let mut sum = 0.0;
        self.reflections(z, |factor, way| sum += factor * way);
        self.first * sum
    }

    /// The factor of each wave so far, and how far beyond its front z is.
    fn reflections(&self, z: f64, mut visit: impl FnMut(f64, f64)) {
        let (mut factor, mut way) = (1.0, z);
        while way >= 0.0 && factor != 0.0 {
            visit(factor, way);
            factor *= self.each;
            way -= 2.0 * self.length;
        }
    }
}

impl LineSolution for Bar {
    fn value(&self, field: Field, s: f64, t: f64) -> f64 {
        let (right, left) = (self.speed * t - s, self.speed * t + s - 2.0 * self.length);
        match field {
            Field::Displacement => self.initial_velocity * t + self.integral(right) + self.far * self.integral(left),
            Field::Velocity => self.initial_velocity + self.speed * (self.slope(right) + self.far * self.slope(left)),
            Field::Stress => self.modulus * (self.far * self.slope(left) - self.slope(right)),
        }
    }
}
