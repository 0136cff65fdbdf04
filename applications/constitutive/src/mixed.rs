//! What a mixed displacement-pressure element asks of a law beside stress and tangent.
//!
//! The nodal pressure p is the mean Cauchy stress, tension positive. The law answers
//! σ = σ_dev + p I for the pressure that the element hands over; the element itself holds p to the
//! change of volume by one of two volumetric laws with the bulk modulus κ, both of which admit
//! 1/κ = 0, J = 1.

/// How pressure and change of volume go together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum VolumetricLaw {
    /// p = κ (J − 1), integrated over the reference volume, as in Kratos.
    #[default]
    Linear,
    /// p = κ (1 − 1/J), integrated over the current volume (Miehe 1994).
    Miehe,
}

impl VolumetricLaw {
    /// U in p/κ = U, given J − 1.
    #[inline(always)]
    pub fn change(self, change: f64) -> f64 {
        match self {
            Self::Linear => change,
            Self::Miehe => change / (1.0 + change),
        }
    }

    /// dU by the divergence of the displacement: J dU/dJ.
    #[inline(always)]
    pub fn slope(self, jacobian: f64) -> f64 {
        match self {
            Self::Linear => jacobian,
            Self::Miehe => 1.0 / jacobian,
        }
    }

    /// Volume over which the law is integrated, by the reference volume: 1 or J. Its product with U is
    /// J − 1 for both.
    #[inline(always)]
    pub fn weight(self, jacobian: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Miehe => jacobian,
        }
    }

    /// d(weight p/κ) by the divergence of the displacement, over the weight times J: what couples
    /// pressures with displacements is V (1 − this) N_i ∂N_j.
    #[inline(always)]
    pub fn coupling(self, relative_pressure: f64) -> f64 {
        match self {
            Self::Linear => 0.0,
            Self::Miehe => relative_pressure,
        }
    }

    /// J at p/κ.
    pub fn jacobian(self, relative_pressure: f64) -> f64 {
        match self {
            Self::Linear => 1.0 + relative_pressure,
            Self::Miehe => 1.0 / (1.0 - relative_pressure),
        }
    }

    /// Complementary energy of the change of volume per reference volume (J/m³) at pressure `p` (Pa)
    /// and compressibility `c` = 1/κ (1/Pa): Ψ* in the energy Ψ_dev + p (J − 1) − Ψ*(p).
    pub fn complementary_energy(self, p: f64, c: f64) -> f64 {
        let x = c * p;
        match self {
            // −p − κ ln(1 − x), by its series where the two cancel.
            Self::Miehe if x.abs() > 1e-3 => -p - (-x).ln_1p() / c,
            Self::Miehe => p * x * (0.5 + x * (1.0 / 3.0 + x * (0.25 + x * 0.2))),
            Self::Linear => 0.5 * p * x,
        }
    }
}

/// Resistance to a change of shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shear {
    /// Shear modulus of a solid at small strain (Pa).
    Elastic(f64),
    /// Dynamic viscosity of a fluid (Pa s).
    Viscous(f64),
}

/// Moduli of a law with nodal pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixedModuli {
    /// 1/κ (1/Pa); 0 is incompressible.
    pub compressibility: f64,
    /// Resistance to shearing.
    pub shear: Shear,
    /// Volumetric law.
    pub volumetric: VolumetricLaw,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J(p) inverts U, the slope is J dU/dJ, and dΨ*/dp = J(p) − 1.
    #[test]
    fn volumetric_laws_are_consistent() {
        let c = 0.25;
        for law in [VolumetricLaw::Linear, VolumetricLaw::Miehe] {
            for p in [-1.5, -0.2, -1e-3, 1e-4, 0.7, 2.0] {
                let j = law.jacobian(c * p);
                assert!((law.change(j - 1.0) - c * p).abs() < 1e-15);
                assert!((law.weight(j) * law.change(j - 1.0) - (j - 1.0)).abs() < 1e-15);
                let h = 1e-6;
                let slope = j * (law.change(j - 1.0 + h) - law.change(j - 1.0 - h)) / (2.0 * h);
                assert!((slope - law.slope(j)).abs() < 1e-8);
                let energy = |p| law.complementary_energy(p, c);
                let change = (energy(p + h) - energy(p - h)) / (2.0 * h);
                assert!((change - (j - 1.0)).abs() < 1e-8, "{law:?} {p}: {change}");
            }
            assert_eq!((law.jacobian(0.0), law.complementary_energy(3.0, 0.0)), (1.0, 0.0));
        }
    }
}
