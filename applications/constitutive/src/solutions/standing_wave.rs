//! A standing wave u = A sin(k s + φ) cos(ω t) or A sin(k s + φ) sin(ω t), ω = k c.
//!
//! Along the axis it is exact for small strains with c = √(M/ρ). Across the axis it is exact at any
//! amplitude for neo-Hookean bodies with c = √(μ/ρ): simple shear does not change the volume, and its shear
//! stress is μ times the shear (Truesdell and Noll, The Non-Linear Field Theories of Mechanics, §54).

use super::{Field, LINE, Line, LineSolution};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range};
use bia_kernel::reference::{Compared, ReferenceEntry, ReferenceSolution};
use bia_kernel::registry::Building;

const KEYS: &[Key] = &Key::join::<3, 7, 10>(
    LINE,
    [
        Key::optional("direction", Kind::Choice(&["X", "Y", "Z"]), "of the displacement; the axis unless given"),
        Key::required("modulus", Kind::Number(Range::POSITIVE), "M along the axis, μ across it [Pa]"),
        Key::required("density", Kind::Number(Range::POSITIVE), "density [kg/m³]"),
        Key::required("wave_number", Kind::Number(Range::POSITIVE), "k, 2π over the wave length [1/m]"),
        Key::new("phase", Kind::Number(Range::ANY), "0.0", "φ at s = 0; π/2 makes a cosine"),
        Key::optional("displacement", Kind::Number(Range::ANY), "amplitude of the displacement at the start [m]"),
        Key::optional("velocity", Kind::Number(Range::ANY), "amplitude of the velocity at the start [m/s]"),
    ],
);

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "standing_wave",
    keys: KEYS,
    help: "standing wave along the axis (vibrating bar) or, at any amplitude of a neo-Hookean body, across it",
    build,
};

/// The solution.
pub(super) struct StandingWave {
    pub modulus: f64,
    pub wave_number: f64,
    pub frequency: f64,
    pub phase: f64,
    /// Amplitudes of the cosine and the sine of time, in metres.
    pub amplitudes: [f64; 2],
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    if !settings.given("displacement") && !settings.given("velocity") {
        let message = "needs \"displacement\" or \"velocity\" at the start";
        return Err(settings.parameters().error(message).into());
    }
    let (modulus, wave_number) = (settings.number("modulus"), settings.number("wave_number"));
    let frequency = wave_number * (modulus / settings.number("density")).sqrt();
    let number = |key: &str| if settings.given(key) { settings.number(key) } else { 0.0 };
    let amplitudes = [number("displacement"), number("velocity") / frequency];
    let wave = StandingWave { modulus, wave_number, frequency, phase: settings.number("phase"), amplitudes };
    let direction = match settings.given("direction") {
        true => ["X", "Y", "Z"].iter().position(|axis| *axis == settings.text("direction")),
        false => None,
    };
    Line::build(settings, compared, wave, direction)
}

impl LineSolution for StandingWave {
    fn value(&self, field: Field, s: f64, t: f64) -> f64 {
        let (sin, cos) = (self.wave_number * s + self.phase).sin_cos();
        let ([a, b], (sin_t, cos_t)) = (self.amplitudes, (self.frequency * t).sin_cos());
        match field {
            Field::Displacement => sin * (a * cos_t + b * sin_t),
            Field::Velocity => sin * self.frequency * (b * cos_t - a * sin_t),
            Field::Stress => self.modulus * self.wave_number * cos * (a * cos_t + b * sin_t),
        }
    }
}
