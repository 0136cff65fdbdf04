//! Constants of the stabilisation: element size, the weights τ₁ and τ₂ of the subscales, and that of
//! the projected pressure.

use crate::implicit::problem::Inertia;
use crate::points::Block;
use crate::settings::{ElementSize, MixedSettings, Stabilization, Variant};
use bia_constitutive::{MixedModuli, Shear};
use bia_kernel::geometry::Shape;

/// Diameter of the circle of unit area.
const CIRCLE: f64 = std::f64::consts::FRAC_2_SQRT_PI;
/// The like in space, as in Kratos before version 10.
const BALL: f64 = 0.60046878;

/// Share of the inertia ρ h²/(β Δt²) in τ₂ of a fluid.
///
/// τ₂ = c₂ h²/τ₁ would have all of it (Codina 2002), which locks coarse quadrilaterals; without it points
/// gather where the pressure is high, since rows of pressure see averages over nodes only. Measured on
/// the dam break and the sloshing tank (docs/studies/fluids.md).
const DYNAMIC_SHARE: f64 = 0.1;

/// Constants of one block of points in one step.
#[derive(Debug, Clone, Copy)]
pub struct Constants {
    /// Moduli of the law.
    pub moduli: MixedModuli,
    /// Constant of τ₁.
    c1: f64,
    /// Resistance to shearing (Pa): the shear modulus, or μ/Δt.
    shear: f64,
    /// c_t ρ/(β Δt²).
    dynamic: f64,
    /// Constant of τ₂.
    c2: f64,
    /// Share of `dynamic` in τ₂.
    dynamic_share: f64,
    /// (1 − alpha)/(β Δt²) where inertia is in the residual, else zero.
    pub inertia: f64,
}

impl Constants {
    /// Of a block with these moduli, in dynamics with its inertia.
    pub fn new(
        block: &Block,
        moduli: MixedModuli,
        settings: &MixedSettings,
        variant: Variant,
        inertia: Option<&Inertia>,
        time_step: f64,
    ) -> Self {
        let (shear, is_fluid) = match moduli.shear {
            Shear::Elastic(modulus) => (modulus, false),
            // Kratos takes the viscosity for a modulus.
            Shear::Viscous(viscosity) if variant == Variant::Kratos => (viscosity, true),
            Shear::Viscous(viscosity) => (viscosity / time_step, true),
        };
        let c_t = settings.c_t.unwrap_or(if is_fluid { 1.0 } else { 0.0 });
        let c0 = inertia.map_or(0.0, |inertia| inertia.coefficients.c0);
        let of_residual = settings.inertia.unwrap_or(is_fluid) && settings.stabilization == Stabilization::Asgs;
        let of_fluid = is_fluid && variant == Variant::Consistent;
        let default_c2 = if settings.stabilization == Stabilization::Asgs || of_fluid { 1.0 } else { 0.0 };
        Self {
            moduli,
            c1: settings.c1,
            shear,
            dynamic: c_t * block.density * c0,
            c2: settings.c2.unwrap_or(default_c2),
            dynamic_share: if of_fluid { DYNAMIC_SHARE } else { 0.0 },
            inertia: inertia.filter(|_| of_residual).map_or(0.0, Inertia::stiffness),
        }
    }

    /// Weight of the subscale of displacement, 1/(2 c₁ μ/h² + c_t ρ/(β Δt²)) (m²/Pa).
    #[inline(always)]
    pub fn tau1(&self, size: f64) -> f64 {
        1.0 / (2.0 * self.c1 * self.shear / (size * size) + self.dynamic)
    }

    /// Weight of the subscale of pressure, 1/(1/(c₂ (2 μ + [c_t ρ h²/(10 β Δt²)])) + 1/κ), the bracket in
    /// fluids (Pa).
    #[inline(always)]
    pub fn tau2(&self, size: f64) -> f64 {
        let incompressible = self.c2 * (2.0 * self.shear + self.dynamic_share * self.dynamic * size * size);
        incompressible / (1.0 + incompressible * self.moduli.compressibility)
    }

    /// Its value in Kratos, 2 c₂ μ.
    #[inline(always)]
    pub fn kratos_tau2(&self) -> f64 {
        2.0 * self.c2 * self.shear
    }

    /// Value of τ₁ in Kratos, c₁ h²/(2 μ).
    #[inline(always)]
    pub fn kratos_tau1(&self, size: f64) -> f64 {
        self.c1 * size * size / (2.0 * self.shear)
    }

    /// Weight of the projected pressure in `D` dimensions (1/Pa).
    #[inline(always)]
    pub fn projection<const D: usize>(&self, size: f64) -> f64 {
        let factor = if D == 3 { 10.0 } else { 8.0 };
        factor / (self.shear + self.dynamic * size * size)
    }

    /// Its value in Kratos.
    #[inline(always)]
    pub fn kratos_projection<const D: usize>(&self) -> f64 {
        (if D == 3 { 10.0 } else { 8.0 }) / self.shear
    }
}

/// Size of a cell in m.
pub fn element_size<const D: usize, const N: usize>(kind: ElementSize, corners: &[[f64; D]; N]) -> f64 {
    match (kind, D) {
        (ElementSize::Edge, 2) => edge_measure(corners).sqrt(),
        (ElementSize::Edge, _) => edge_measure(corners).cbrt(),
        (ElementSize::Circle, 2) => CIRCLE * measure(corners).sqrt(),
        (ElementSize::Circle, _) => BALL * measure(corners).cbrt(),
    }
}

/// Area or volume spanned by the edges at the first corner, or the simplex's share of it.
fn edge_measure<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> f64 {
    let (ends, share) = match (D, N) {
        (2, 3) => ([1, 2, 0], 0.5),
        (2, _) => ([1, 3, 0], 1.0),
        (_, 4) => ([1, 2, 3], 1.0 / 6.0),
        _ => ([1, 3, 4], 1.0),
    };
    let edge = |k: usize, a: usize| corners[ends[k]][a] - corners[0][a];
    let determinant = if D == 2 {
        edge(0, 0) * edge(1, 1) - edge(0, 1) * edge(1, 0)
    } else {
        let minor = |a: usize, b: usize| edge(1, a) * edge(2, b) - edge(1, b) * edge(2, a);
        edge(0, 0) * minor(1, 2) + edge(0, 1) * minor(2, 0) + edge(0, 2) * minor(0, 1)
    };
    share * determinant.abs()
}

/// Area or volume of a cell.
fn measure<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> f64 {
    let shape = match (D, N) {
        (2, 3) => Shape::Triangle3,
        (2, _) => Shape::Quadrilateral4,
        (_, 4) => Shape::Tetrahedron4,
        _ => Shape::Hexahedron8,
    };
    let mut places = [[0.0; 3]; N];
    places.iter_mut().zip(corners).for_each(|(place, corner)| place[..D].copy_from_slice(corner));
    if D == 2 { shape.plane_area(&places).abs() } else { shape.measure(&places).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_all_shapes() {
        let edge = |size: f64, expected: f64| assert!((size - expected).abs() < 1e-15, "{size} {expected}");
        let [o, x, y, z] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
        let flat = |p: [f64; 3]| [p[0], p[1]];
        edge(element_size(ElementSize::Edge, &[flat(o), flat(x), flat(y)]), 3f64.sqrt());
        edge(element_size(ElementSize::Edge, &[flat(o), flat(x), [2.0, 3.0], flat(y)]), 6f64.sqrt());
        edge(element_size(ElementSize::Edge, &[o, x, y, z]), 4f64.cbrt());
        let hexahedron = [o, x, [2.0, 3.0, 0.0], y, z, [2.0, 0.0, 4.0], [2.0, 3.0, 4.0], [0.0, 3.0, 4.0]];
        edge(element_size(ElementSize::Edge, &hexahedron), 24f64.cbrt());
        edge(element_size(ElementSize::Circle, &hexahedron), BALL * 24f64.cbrt());
        let circle = element_size(ElementSize::Circle, &[flat(o), flat(x), flat(y)]);
        assert!((std::f64::consts::PI / 4.0 * circle * circle - 3.0).abs() < 1e-8);
    }
}
