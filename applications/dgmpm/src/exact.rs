//! The exact Riemann problem of a bar with a nonlinear law P(F) that is convex or concave between the
//! states.
//!
//! A wave that takes a side from its stretch F_k to F changes the velocity by ±G(F; F_k), where
//!
//! G = ∫ c dF, c = √(P'(F)/ρ₀), in a fan and
//! G = sgn(F − F_k) √((P(F) − P(F_k))(F − F_k)/ρ₀) in a shock, which is what forms where the chord of P is
//! steeper than its tangent at F_k (Lax's condition).
//! Weak waves are neither: G = c (F − F_k) with c in their middle.
//!
//! With τ on the outward normal, v* = v_k + G for the waves that leave a face into the side of which it
//! is the upper end. Both sides have the same P*; one unknown stretch is found by Newton's method.
//!
//! Source: Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, ch. 4.

use crate::material::Material;
use crate::matrix::Matrix;
use crate::riemann::Trace;
use crate::scheme::Scheme;

/// Abscissae and weights of Gauss and Legendre on [−1, 1], half of eight.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Change of the stretch below which a wave is neither fan nor shock.
const WEAK: f64 = 1e-6;
const ITERATIONS: usize = 40;
const TOLERANCE: f64 = 1e-15;

/// A side of a face, seen from the face: the face is its upper end.
#[derive(Clone, Copy)]
struct Side<'a> {
    material: &'a Material,
    /// F − 1.
    strain: f64,
    velocity: f64,
    stress: f64,
    /// +1 if the outward normal is the positive direction.
    sign: f64,
}

/// P and ρ₀ c² = P' at a strain; not a number where the law has no answer or waves no speed.
fn law(material: &Material, strain: f64) -> (f64, f64) {
    let (gradient, mut stress) = ([[strain]], [[[0.0]]]);
    let (mut impedance, mut speed) = ([[[0.0]]], [0.0]);
    let answered = material.stresses(&[gradient], &mut stress).is_ok()
        && material.impedances(&gradient, &[[1.0]], &mut impedance, &mut speed).is_ok();
    if !answered {
        return (f64::NAN, f64::NAN);
    }
    let speed = if material.law.is_some() { speed[0] } else { material.wave_speed() };
    (stress[0][0][0], material.density * speed * speed)
}

impl Side<'_> {
    /// G(F; F_k), its slope, P and P' at the end of the wave.
    fn wave(&self, strain: f64) -> [f64; 4] {
        let density = self.material.density;
        let change = strain - self.strain;
        let (stress, slope) = law(self.material, strain);
        if change.abs() < WEAK {
            let speed = (law(self.material, self.strain + 0.5 * change).1 / density).sqrt();
            return [speed * change, speed, stress, slope];
        }
        let chord = (stress - self.stress) / change;
        if chord > law(self.material, self.strain).1 {
            let jump = (chord / density).sqrt() * change;
            return [jump, (slope * change + stress - self.stress) / (2.0 * density * jump), stress, slope];
        }
        let middle = self.strain + 0.5 * change;
        let speed = |at: f64| (law(self.material, middle + 0.5 * change * at).1 / density).sqrt();
        let sum: f64 = GAUSS.iter().map(|(x, weight)| weight * (speed(*x) + speed(-x))).sum();
        [0.5 * change * sum, (slope / density).sqrt(), stress, slope]
    }

    /// The strain at which the stress is that, beginning at a guess.
    fn strain_of(&self, wanted: f64, guess: f64) -> f64 {
        let mut strain = guess;
        for _ in 0..ITERATIONS {
            let (stress, slope) = law(self.material, strain);
            let correction = (wanted - stress) / slope;
            strain += correction;
            if correction.abs() <= TOLERANCE * (1.0 + strain).abs() {
                break;
            }
        }
        strain
    }

    /// What the face sees after the wave to a strain.
    fn star<const D: usize>(&self, strain: f64) -> Trace<D> {
        let [jump, _, stress, _] = self.wave(strain);
        Trace { velocity: [self.velocity + self.sign * jump; D], traction: [self.sign * stress; D] }
    }

    /// Newton's method for `residual(strain) = 0`, which rises with the strain, from this side's own.
    fn solve(&self, start: f64, residual: impl Fn(f64) -> (f64, f64)) -> f64 {
        let mut strain = start;
        for _ in 0..ITERATIONS {
            let (value, slope) = residual(strain);
            let mut correction = -value / slope;
            // Never beyond nothing.
            correction = correction.max(-0.5 * (1.0 + strain));
            strain += correction;
            if correction.is_nan() || correction.abs() <= TOLERANCE * (1.0 + strain).abs() {
                break;
            }
        }
        strain
    }
}

fn side<const D: usize>(scheme: &Scheme<D>, slot: u32) -> Side<'_> {
    let (trace, gradient) = scheme.traced(slot);
    let (material, strain) = (scheme.material_of_slot(slot), first(gradient));
    let sign = scheme.kind(slot as usize / (2 * D)).normals[slot as usize % (2 * D)][0];
    Side { material, strain, velocity: trace.velocity[0], stress: law(material, strain).0, sign }
}

fn first<const D: usize>(m: &Matrix<D>) -> f64 {
    m[0][0]
}

/// v*, and τ* on the outward normal of the left side, of a face in one dimension.
pub fn solve<const D: usize>(scheme: &Scheme<D>, face: usize) -> Trace<D> {
    let left = side(scheme, scheme.faces.left[face]);
    let Some(&slot) = scheme.faces.right.get(face) else {
        let condition = &scheme.conditions[face - scheme.faces.inner()];
        return match (condition.transmitting, condition.held[0]) {
            (true, _) => *scheme.traced(scheme.faces.left[face]).0,
            (false, true) => {
                let wanted = left.sign * (condition.velocity[0] - left.velocity);
                let strain = left.solve(left.strain, |strain| {
                    let [jump, slope, ..] = left.wave(strain);
                    (jump - wanted, slope)
                });
                Trace { velocity: condition.velocity, ..left.star(strain) }
            }
            (false, false) => {
                let strain = left.strain_of(left.sign * condition.traction[0], left.strain);
                Trace { traction: condition.traction, ..left.star(strain) }
            }
        };
    };
    let right = side(scheme, slot);
    let apart = left.sign * (right.velocity - left.velocity);
    if apart == 0.0 && left.stress == right.stress {
        return *scheme.traced(scheme.faces.left[face]).0;
    }
    // v_L + G(F; F_L) = v_R − G(F_R; F_R) with P_R(F_R) = P_L(F).
    let same = std::ptr::eq(left.material, right.material);
    let strain = left.solve(0.5 * (left.strain + right.strain), |strain| {
        let [jump, slope, stress, stiffness] = left.wave(strain);
        let other = if same { strain } else { right.strain_of(stress, right.strain) };
        let [other_jump, other_slope, _, other_stiffness] = right.wave(other);
        (jump + other_jump - apart, slope + other_slope * stiffness / other_stiffness)
    });
    left.star(strain)
}
