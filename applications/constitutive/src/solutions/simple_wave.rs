//! An endless bar of the Saint Venant-Kirchhoff law P = E/2 F (F² − 1) whose end s = 0 is loaded at once.
//!
//! P'' = 3 E F > 0: a pressure runs into the bar as a centred simple wave, in which
//! F = √((2ρξ²/E + 1)/3), ξ = s/t, between c(F₁) and c₀, c = √(P'/ρ); a tension as a shock of the speed
//! √(P₀/(ρ (F₁ − 1))). Behind both the stretch is F₁ with P(F₁) = P₀ and the velocity
//! v₁ = −∫₁^F₁ c dF in the wave, −S (F₁ − 1) behind the shock. Below P = −E/(3√3) there is no solution.
//! Source: Renaud and Heuzé (2017), §5.3; Courant and Friedrichs, Supersonic Flow and Shock Waves, §§40-41.

use super::{Field, LINE, Line, LineSolution};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range};
use bia_kernel::reference::{Compared, ReferenceEntry, ReferenceSolution};
use bia_kernel::registry::Building;

const KEYS: &[Key] = &Key::join::<3, 3, 6>(
    LINE,
    [
        Key::required("modulus", Kind::Number(Range::POSITIVE), "Young's modulus E [Pa]"),
        Key::required("density", Kind::Number(Range::POSITIVE), "density [kg/m³]"),
        Key::required("stress", Kind::Number(Range::ANY), "first Piola-Kirchhoff stress at s = 0 from t = 0 on [Pa]"),
    ],
);

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "kirchhoff_bar",
    keys: KEYS,
    help: "endless bar of the Saint Venant-Kirchhoff law, loaded at once: simple wave or shock; stress is P",
    build,
};

/// The solution.
pub(super) struct SimpleWave {
    modulus: f64,
    density: f64,
    /// Stretch behind the wave.
    pub stretch: f64,
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    if compared.variable.name.contains("CAUCHY") || compared.variable.name.contains("PRESSURE") {
        let message = format!("this solution does not give {compared}, but the stress P");
        return Err(settings.parameters().error(message).help("compare MP_PK1_STRESS_TENSOR").into());
    }
    let wave = SimpleWave::new(settings.number("modulus"), settings.number("density"), settings.number("stress"));
    match wave {
        Some(wave) => Line::build(settings, compared, wave, None),
        None => {
            let message = "is beyond -E/(3√3), where the law bears no more pressure";
            Err(settings.error("stress", message).into())
        }
    }
}

impl SimpleWave {
    /// The bar under this stress; none where the law does not reach it.
    pub fn new(modulus: f64, density: f64, stress: f64) -> Option<Self> {
        let wanted = stress / modulus;
        if wanted <= -1.0 / 27.0_f64.sqrt() {
            return None;
        }
        // Newton's method from 1 or above the root stays on its convex side.
        let mut stretch: f64 = 1.0 + wanted.max(0.0);
        for _ in 0..60 {
            stretch -= (0.5 * stretch * (stretch * stretch - 1.0) - wanted) / (1.5 * stretch * stretch - 0.5);
        }
        Some(Self { modulus, density, stretch })
    }

    fn stress(&self, stretch: f64) -> f64 {
        0.5 * self.modulus * stretch * (stretch * stretch - 1.0)
    }

    /// ∫₁^F c dF.
    fn jump(&self, stretch: f64) -> f64 {
        let root3 = 3.0_f64.sqrt();
        let primitive = |f: f64| {
            let root = (3.0 * f * f - 1.0).sqrt();
            0.5 * f * root - (root3 * f + root).ln() / (2.0 * root3)
        };
        (self.modulus / (2.0 * self.density)).sqrt() * (primitive(stretch) - primitive(1.0))
    }

    /// Stretch at ξ = s/t.
    fn stretch_at(&self, speed: f64) -> f64 {
        if self.stretch > 1.0 {
            let shock = (self.stress(self.stretch) / (self.density * (self.stretch - 1.0))).sqrt();
            return if speed < shock { self.stretch } else { 1.0 };
        }
        let in_fan = ((2.0 * self.density * speed * speed / self.modulus + 1.0) / 3.0).sqrt();
        in_fan.clamp(self.stretch, 1.0)
    }

    fn velocity(&self, stretch: f64) -> f64 {
        if self.stretch > 1.0 {
            return -(self.stress(stretch) * (stretch - 1.0) / self.density).sqrt();
        }
        -self.jump(stretch)
    }
}

impl LineSolution for SimpleWave {
    fn value(&self, field: Field, s: f64, t: f64) -> f64 {
        if t <= 0.0 || s < 0.0 {
            return 0.0;
        }
        let stretch = self.stretch_at(s / t);
        match field {
            // The motion is self-similar, u = t w(ξ): from ∂u/∂t = v and ∂u/∂s = F − 1 follows w = v + ξ (F − 1).
            Field::Displacement => t * self.velocity(stretch) + s * (stretch - 1.0),
            Field::Velocity => self.velocity(stretch),
            Field::Stress => self.stress(stretch),
        }
    }
}
