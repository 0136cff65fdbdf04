//! Symmetric tensors in Voigt notation, the tangents of isotropic laws, and volume ratios that keep
//! their digits at small strain.
//!
//! Order: xx, yy, zz, xy, yz, xz. Stresses hold the tensor components, strains twice the shear
//! components, so that stress · strain is the contraction of the tensors and a tangent entry is the
//! tensor component c_abcd itself.

use bia_kernel::lanes::Real;
use nalgebra::Matrix3;

use crate::LawError;

/// A 3×3 tensor of numbers or of lanes, row by row.
pub type Tensor<R> = [[R; 3]; 3];

/// The tensor of a matrix.
#[inline(always)]
pub fn tensor_of(m: &Matrix3<f64>) -> Tensor<f64> {
    std::array::from_fn(|a| std::array::from_fn(|b| m[(a, b)]))
}

/// The identity; `of` says of which kind of numbers.
#[inline(always)]
pub fn identity<R: Real>(of: R) -> Tensor<R> {
    let (zero, one) = (of.constant(0.0), of.constant(1.0));
    [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
}

/// a b.
#[inline(always)]
pub fn product<R: Real>(a: &Tensor<R>, b: &Tensor<R>) -> Tensor<R> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    out
}

/// aᵀ.
#[inline(always)]
pub fn transpose<R: Real>(a: &Tensor<R>) -> Tensor<R> {
    [[a[0][0], a[1][0], a[2][0]], [a[0][1], a[1][1], a[2][1]], [a[0][2], a[1][2], a[2][2]]]
}

/// Adjugate and determinant: a · adj a = det a · 1.
#[inline(always)]
pub fn adjugate<R: Real>(a: &Tensor<R>) -> (Tensor<R>, R) {
    let mut out = *a;
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            out[j][i] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
    }
    (out, a[0][0] * out[0][0] + a[0][1] * out[1][0] + a[0][2] * out[2][0])
}

/// det F − 1 = I₁ + I₂ + I₃ of H = F − I: keeps the digits that det F loses near 1.
#[inline(always)]
pub fn volume_change<R: Real>(h: &Tensor<R>) -> R {
    let (adjugate, determinant) = adjugate(h);
    let trace = h[0][0] + h[1][1] + h[2][2];
    trace + (adjugate[2][2] + adjugate[0][0] + adjugate[1][1]) + determinant
}

/// Six components of a symmetric tensor.
pub type Voigt = [f64; 6];
/// Row: stress component; column: strain component with doubled shear.
pub type Tangent = [[f64; 6]; 6];

/// Tensor indices of each Voigt component.
pub const VOIGT_PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// Components of a symmetric stress-like tensor.
pub fn stress_to_voigt(t: &Matrix3<f64>) -> Voigt {
    VOIGT_PAIRS.map(|pair| t[pair])
}

/// Components of a symmetric strain-like tensor, shear doubled.
pub fn strain_to_voigt(t: &Matrix3<f64>) -> Voigt {
    [t[(0, 0)], t[(1, 1)], t[(2, 2)], 2.0 * t[(0, 1)], 2.0 * t[(1, 2)], 2.0 * t[(0, 2)]]
}

/// The tensor of stress-like components.
pub fn stress_from_voigt(v: &Voigt) -> Matrix3<f64> {
    Matrix3::new(v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2])
}

/// c_abcd = α δ_ab δ_cd + β (δ_ac δ_bd + δ_ad δ_bc): Hooke's law with α = λ, β = μ.
pub fn isotropic_tangent(alpha: f64, beta: f64) -> Tangent {
    let mut c = [[0.0; 6]; 6];
    for a in 0..3 {
        for b in 0..3 {
            c[a][b] = alpha;
        }
        c[a][a] = alpha + 2.0 * beta;
        c[a + 3][a + 3] = beta;
    }
    c
}

/// c_abcd = α m_ab m_cd + β (m_ac m_bd + m_ad m_bc) with a symmetric m.
///
/// With m = F Fᵀ this is the push-forward of the isotropic material tangent of α and β.
pub fn isotropic_tangent_of(alpha: f64, beta: f64, m: &Matrix3<f64>) -> Tangent {
    let mut tangent = [[0.0; 6]; 6];
    for row in 0..6 {
        let (a, b) = VOIGT_PAIRS[row];
        for column in row..6 {
            let (c, d) = VOIGT_PAIRS[column];
            let entry = alpha * m[(a, b)] * m[(c, d)] + beta * (m[(a, c)] * m[(b, d)] + m[(a, d)] * m[(b, c)]);
            tangent[row][column] = entry;
            tangent[column][row] = entry;
        }
    }
    tangent
}

/// F − I, the gradient of displacement. Strains are built from it because F Fᵀ − I cancels at small
/// strain while this difference is exact there.
pub fn displacement_gradient(f: &Matrix3<f64>) -> Matrix3<f64> {
    let mut h = *f;
    for a in 0..3 {
        h[(a, a)] -= 1.0;
    }
    h
}

/// Green–Lagrange strain E = ½(Fᵀ F − I) = ½(H + Hᵀ + Hᵀ H), H = F − I.
pub fn green_lagrange_strain(f: &Matrix3<f64>) -> Matrix3<f64> {
    let h = displacement_gradient(f);
    0.5 * (h + h.transpose() + h.transpose() * h)
}

/// Almansi strain e = ½(I − (F Fᵀ)⁻¹) = ½(h + hᵀ − hᵀ h), h = I − F⁻¹ = F⁻¹ (F − I).
/// Not a number when F is singular.
pub fn almansi_strain(f: &Matrix3<f64>) -> Matrix3<f64> {
    let Some(inverse) = f.try_inverse() else { return Matrix3::repeat(f64::NAN) };
    let h = inverse * displacement_gradient(f);
    0.5 * (h + h.transpose() - h.transpose() * h)
}

/// J = det F, the ratio of current to reference volume.
///
/// # Errors
/// J ≤ 0, or F not finite.
pub fn volume_ratio(f: &Matrix3<f64>) -> Result<f64, LawError> {
    let jacobian = f.determinant();
    if !jacobian.is_finite() {
        return Err(LawError::NonFinite);
    }
    if jacobian <= 0.0 {
        return Err(LawError::NonPositiveJacobian { jacobian });
    }
    Ok(jacobian)
}

/// ln J for J = det F > 0. Near 1 it comes from J − 1 = I₁ + I₂ + I₃ of H = F − I, which keeps the
/// digits that 1 + (J − 1) loses.
pub fn log_volume_ratio(f: &Matrix3<f64>, jacobian: f64) -> f64 {
    if (jacobian - 1.0).abs() > 0.25 {
        return jacobian.ln();
    }
    let h = displacement_gradient(f);
    let minor = |a: usize, b: usize| h[(a, a)] * h[(b, b)] - h[(a, b)] * h[(b, a)];
    (h.trace() + (minor(0, 1) + minor(1, 2) + minor(0, 2)) + h.determinant()).ln_1p()
}
