//! Balance of momentum and compatibility by differences, conditions at the ends, and published numbers.

use super::bar::Bar;
use super::simple_wave::SimpleWave;
use super::standing_wave::StandingWave;
use super::{Field, LineSolution};

/// ∂u/∂t = v and stiffness ∂u/∂s = stress by central differences, to 1e-6 of the size of velocities and stresses.
fn check_compatible(solution: &dyn LineSolution, modulus: impl Fn(f64) -> f64, places: &[[f64; 2]], scale: [f64; 2]) {
    let u = |s: f64, t: f64| solution.value(Field::Displacement, s, t);
    for &[s, t] in places {
        let (ds, dt) = (1e-6 * s.abs().max(1e-3), 1e-6 * t);
        let velocity = (u(s, t + dt) - u(s, t - dt)) / (2.0 * dt);
        let strain = (u(s + ds, t) - u(s - ds, t)) / (2.0 * ds);
        let (v, stress) = (solution.value(Field::Velocity, s, t), solution.value(Field::Stress, s, t));
        assert!((velocity - v).abs() <= 1e-6 * scale[0], "v at {s}, {t}: {velocity} {v}");
        let expected = modulus(strain);
        assert!((expected - stress).abs() <= 1e-6 * scale[1], "σ at {s}, {t}: {expected} {stress}");
    }
}

fn bar(far: f64, each: f64, first: f64, initial_velocity: f64) -> Bar {
    Bar { modulus: 2e11, speed: 5063.697, length: 6.0, far, each, first, initial_velocity }
}

#[test]
fn the_loaded_bar_keeps_its_ends_and_balances() {
    let stress = -1e9;
    let crossing = 6.0 / 5063.697;
    let inside: Vec<[f64; 2]> =
        [0.3, 0.7, 1.4, 1.9, 2.6, 3.3, 4.7].iter().flat_map(|t| [0.9, 2.3, 4.4].map(|s| [s, t * crossing])).collect();
    for far in [1.0, -1.0] {
        let bar = bar(far, far, -stress / 2e11, 0.0);
        check_compatible(&bar, |strain| 2e11 * strain, &inside, [25.0, 1e9]);
        for t in [0.5, 1.5, 2.5, 7.5].map(|t| t * crossing) {
            assert!((bar.value(Field::Stress, 0.0, t) / stress - 1.0).abs() < 1e-12);
            let (field, name) = if far > 0.0 { (Field::Stress, "stress") } else { (Field::Velocity, "velocity") };
            assert!(bar.value(field, 6.0, t).abs() < 1e-6, "{name} at the far end");
        }
    }
    // Renaud and Heuzé 2017, §5.1: behind the front v = 25.3185 m/s, twice that behind the reflection.
    let free = bar(1.0, 1.0, -stress / 2e11, 0.0);
    assert!((free.value(Field::Velocity, 1.0, 0.5 * crossing) - 25.3185).abs() < 1e-4);
    assert!((free.value(Field::Velocity, 5.0, 1.5 * crossing) - 50.637).abs() < 1e-3);
    assert_eq!(free.value(Field::Velocity, 5.0, 0.5 * crossing), 0.0, "ahead of the front");
}

/// Nuttall 2025, eq. 71: the free end goes to 2 τ L/E = −0.0508 mm and back within 4L/c = 0.0556489 ms.
#[test]
fn a_bar_held_at_its_end_swings_as_published() {
    let speed = (250.0_f64 / 1.9355e-3).sqrt();
    let bar =
        Bar { modulus: 250.0, speed, length: 5.0, far: -1.0, each: -1.0, first: 1.27 / 250.0, initial_velocity: 0.0 };
    let end = |t: f64| -bar.value(Field::Displacement, 0.0, t);
    let period = 20.0 / speed;
    assert!((period - 0.0556489).abs() < 1e-7);
    assert!((end(0.5 * period) + 0.0508).abs() < 1e-12 && end(period).abs() < 1e-12);
    assert!((end(0.25 * period) + 0.0254).abs() < 1e-12 && (end(2.5 * period) + 0.0508).abs() < 1e-12);
}

#[test]
fn a_bar_that_hits_a_wall_leaves_it_with_its_speed() {
    let crossing = 6.0 / 5063.697;
    let bar = bar(1.0, -1.0, 8.0 / 5063.697, -8.0);
    let v = |s: f64, t: f64| bar.value(Field::Velocity, s, t * crossing);
    assert!((v(5.0, 0.5) + 8.0).abs() < 1e-12 && v(1.0, 0.5).abs() < 1e-12);
    assert!((v(5.0, 1.5) - 8.0).abs() < 1e-12, "the free end flies back");
    // σ = −ρ c v = −M v/c.
    let stress = bar.value(Field::Stress, 1.0, 0.5 * crossing);
    assert!((stress + 2e11 * 8.0 / 5063.697).abs() < 1e-3, "{stress}");
}

#[test]
fn standing_waves_swing() {
    let wave = StandingWave { modulus: 3e6, wave_number: 2.0, frequency: 7.0, phase: 0.4, amplitudes: [0.01, -0.02] };
    let places: Vec<[f64; 2]> = [0.2, 1.1, 2.7].iter().flat_map(|t| [0.3, 1.2].map(|s| [s, *t])).collect();
    check_compatible(&wave, |strain| 3e6 * strain, &places, [0.1, 1e5]);
}

/// Renaud and Heuzé 2017, §5.3, by an independent evaluation: stretches, speeds and velocities.
#[test]
fn the_nonlinear_bar_has_the_published_waves() {
    let (modulus, density) = (2e11, 7800.0);
    let law = |strain: f64| 0.5 * modulus * (1.0 + strain) * ((1.0 + strain).powi(2) - 1.0);
    let wave = SimpleWave::new(modulus, density, -8e8).unwrap();
    assert!((wave.stretch - 0.99597574).abs() < 1e-8);
    assert!((wave.value(Field::Velocity, 1.0, 1e-3) - 20.3161).abs() < 1e-4);
    assert_eq!(wave.value(Field::Velocity, 5063.8e-3, 1e-3), 0.0, "ahead of the fan");
    let shock = SimpleWave::new(modulus, density, 8e8).unwrap();
    assert!((shock.stretch - 1.00397625).abs() < 1e-8);
    assert!((shock.value(Field::Velocity, 1.0, 1e-3) + 20.1946).abs() < 1e-4);
    assert_ne!(shock.value(Field::Velocity, 5.0787, 1e-3), 0.0);
    assert_eq!(shock.value(Field::Velocity, 5.0789, 1e-3), 0.0, "the shock runs at 5078.80 m/s");
    // A wide fan.
    let strong = SimpleWave::new(modulus, density, -3e10).unwrap();
    let inside = [0.3, 0.8, 0.9, 0.97].map(|share: f64| [share * 5.0637, 1e-3]);
    check_compatible(&strong, law, &inside, [1e3, 3e10]);
    assert!(SimpleWave::new(modulus, density, -3.9e10).is_none(), "0.19245 E is the most");
}
