//! Exact values: extreme strain, tiny strain, closed forms, Kratos's tangent, errors.

use super::*;
use crate::{LawError, tensor};

/// Rows of refs/stiff_extreme/constitutive_extreme.csv, confined uniaxial strain F11 = F:
/// E, ν, F, P11 and W of neo-Hookean, P11 of Saint-Venant–Kirchhoff. Twelve digits.
const EXTREME: [[f64; 6]; 12] = [
    [1e6, 0.0, 0.9, -105555.555556, 5180.25782891, -85500.0],
    [1e6, 0.0, 0.05, -9975000.0, 1248491.13678, -24937.5],
    [1e6, 0.0, 10.0, 4950000.0, 23598707.4535, 495000000.0],
    [1e6, 0.3, 0.9, -148735.373285, 7186.97859715, -115096.153846],
    [1e6, 0.3, 0.1, -17091837.075, 2224618.72148, -66634.6153846],
    [1e6, 0.3, 2.0, 776869.379008, 448920.22303, 4038461.53846],
    [1e6, 0.45, 0.3, -13500868.0907, 2507569.00529, -517758.62069],
    [1e6, 0.45, 10.0, 4128388.47714, 24502053.9325, 1877586206.9],
    [1e6, 0.499, 0.9, -19555591.6215, 927291.414759, -14288025.3502],
    [1e6, 0.499, 0.05, -9979105433.65, 747702715.16, -4167340.72715],
    [1e6, 0.499, 2.0, 58185530.8705, 40253462.2388, 501334222.815],
    [1e6, 0.499, 10.0, 41627416.9915, 456978316.702, 82720146764.5],
];

#[test]
fn extreme_uniaxial_strain_has_the_exact_values() {
    for [young, poisson, stretch, p_neo_hookean, w_neo_hookean, p_saint_venant] in EXTREME {
        let deformation = at(Matrix3::from_diagonal(&Vector3::new(stretch, 1.0, 1.0)));
        let near = |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-11, "{value} {expected}");
        // P = J σ F⁻ᵀ, and J = F11 here: P11 = σ11.
        let law = NeoHookean::from_lame(lame(young, poisson));
        near(law.stress(&deformation, &mut ()).unwrap()[0], p_neo_hookean);
        near(law.energy(&deformation).unwrap(), w_neo_hookean);
        let law = LinearElastic::from_lame(lame(young, poisson));
        near(law.stress(&deformation, &mut ()).unwrap()[0], p_saint_venant);
    }
}

/// At a strain ε of 1e-12 only the terms of order ε² part the laws from Hooke's; computed as FFᵀ − I,
/// the strain itself would have an error of 1e-16.
#[test]
fn tiny_strains_keep_their_digits() {
    let (lambda, mu) = (3.0, 2.0);
    let size = 2.0_f64.powi(-40);
    let deformation = at(Matrix3::new(1.0 + size, 0.0, 0.0, 0.0, 1.0 - 2.0 * size, 0.0, 0.0, size, 1.0));
    let expected = [-lambda + 2.0 * mu, -lambda - 4.0 * mu, -lambda, 0.0, mu, 0.0].map(|stress| stress * size);
    let parameters = LameParameters { lambda, mu };
    for stress in [
        NeoHookean::from_lame(parameters).stress(&deformation, &mut ()).unwrap(),
        LinearElastic::from_lame(parameters).stress(&deformation, &mut ()).unwrap(),
    ] {
        assert_stresses_agree(&stress, &expected, ALL, 100.0 * size * size);
    }
}

/// J = 1 − ε² rounds to 1 for ε = 2⁻³⁰; its logarithm must not vanish.
#[test]
fn logarithm_of_the_volume_ratio_sees_what_the_ratio_loses() {
    let size = 2.0_f64.powi(-30);
    let f = Matrix3::from_diagonal(&Vector3::new(1.0 + size, 1.0 - size, 1.0));
    assert_eq!(f.determinant(), 1.0);
    let log = tensor::log_volume_ratio(&f, 1.0);
    assert!((log / -(size * size) - 1.0).abs() < 1e-15, "{log:e}");
}

/// Voigt stress · Voigt strain is the contraction of the tensors, with both measures from their
/// definitions ½(FᵀF − I) and ½(I − (FFᵀ)⁻¹).
#[test]
fn strain_measures_follow_their_definitions_and_contract_with_stresses() {
    let identity = Matrix3::identity();
    for f in samples() {
        let definitions = [
            (tensor::green_lagrange_strain(&f), 0.5 * (f.transpose() * f - identity)),
            (tensor::almansi_strain(&f), 0.5 * (identity - (f * f.transpose()).try_inverse().unwrap())),
        ];
        let stress = Matrix3::new(1.0, 4.0, 6.0, 4.0, 2.0, 5.0, 6.0, 5.0, 3.0);
        for (strain, definition) in definitions {
            assert!((strain - definition).norm() < 1e-14 * (1.0 + definition.norm()));
            let pairs = stress_to_voigt(&stress).into_iter().zip(tensor::strain_to_voigt(&strain));
            let work: f64 = pairs.map(|(a, b)| a * b).sum();
            assert!((work - stress.dot(&definition)).abs() < 1e-13 * (1.0 + definition.norm()));
        }
        assert_eq!(stress_from_voigt(&stress_to_voigt(&stress)), stress);
    }
}

/// ln J has one formula near 1 and another away from it; they must meet.
#[test]
fn logarithm_of_the_volume_ratio_is_seamless() {
    for jacobian in [0.5, 0.749, 0.751, 0.9, 1.1, 1.249, 1.251, 3.0_f64] {
        let f = Matrix3::new(1.0, 0.4, 0.0, 0.0, jacobian, 0.0, 0.3, 0.0, 1.0);
        let log = tensor::log_volume_ratio(&f, f.determinant());
        assert!((log - jacobian.ln()).abs() < 1e-15, "{jacobian}: {log}");
    }
}

#[test]
fn strains_for_output_are_almansi_and_green_lagrange() {
    let shear = 0.5;
    let deformation = at(Matrix3::new(1.0, shear, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0));
    let parameters = lame(1.0, 0.3);
    let almansi = NeoHookean::from_lame(parameters).strain(&deformation);
    assert_stresses_agree(&almansi, &[0.0, -shear * shear / 2.0, 0.375, shear, 0.0, 0.0], ALL, 1e-15);
    let green_lagrange = LinearElastic::from_lame(parameters).strain(&deformation);
    assert_stresses_agree(&green_lagrange, &[0.0, shear * shear / 2.0, 1.5, shear, 0.0, 0.0], ALL, 1e-15);
    let singular = at(Matrix3::zeros());
    assert!(NeoHookean::from_lame(parameters).strain(&singular).iter().all(|component| component.is_nan()));
}

/// With `kratos_exact` the tangent is C/J, with Hooke's C of each kinematics; the stress is the same.
#[test]
fn kratos_exact_returns_the_unpushed_tangent() {
    let (young, poisson) = (2.0e6, 0.3);
    let h = Matrix3::new(0.3, 0.8, -0.2, 0.1, -0.3, 0.5, 0.4, -0.2, 0.9);
    for (name, kinematics) in [
        ("LinearElasticIsotropic3DLaw", Kinematics::ThreeDimensional),
        ("LinearElasticIsotropicPlaneStrain2DLaw", Kinematics::PlaneStrain),
        ("LinearElasticIsotropicPlaneStress2DLaw", Kinematics::PlaneStress),
        ("LinearElasticIsotropicAxisym2DLaw", Kinematics::Axisymmetric),
    ] {
        let f = Matrix3::identity() + allowed(&h, kinematics);
        let jacobian = f.determinant();
        let hooke = hooke(young, poisson, kinematics);
        let exact = respond(&*build(name, young, poisson, kinematics, true), &f);
        for (row, &a) in kinematics.voigt().iter().enumerate() {
            for (column, &b) in kinematics.voigt().iter().enumerate() {
                let error = exact.tangent[a][b] - hooke[(row, column)] / jacobian;
                assert!(error.abs() < 1e-14 * young / jacobian, "{name} {a} {b}: {error:e}");
            }
        }
        let consistent = respond(&*build(name, young, poisson, kinematics, false), &f);
        assert_eq!(exact.stress, consistent.stress);
        assert_ne!(exact.tangent, consistent.tangent);
    }
}

/// 2D formulas of the books, in the plane alone: C with k = E/((1 + ν)(1 − 2ν)) in plane strain,
/// E/(1 − ν²) in plane stress; σ = F S Fᵀ/J with 2×2 tensors.
#[test]
fn plane_linear_elasticity_is_the_two_dimensional_formula() {
    let (young, poisson) = (1.0e6, 0.3);
    let f = nalgebra::Matrix2::new(1.3, 0.2, -0.4, 0.8);
    let e: nalgebra::Matrix2<f64> = 0.5 * (f.transpose() * f - nalgebra::Matrix2::identity());
    let embedded = Matrix3::new(1.3, 0.2, 0.0, -0.4, 0.8, 0.0, 0.0, 0.0, 1.0);
    let k = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    for (kinematics, c11, c12) in [
        (Kinematics::PlaneStrain, k * (1.0 - poisson), k * poisson),
        (Kinematics::PlaneStress, young / (1.0 - poisson * poisson), young * poisson / (1.0 - poisson * poisson)),
    ] {
        let s12 = 2.0 * shear * e.m12;
        let s = nalgebra::Matrix2::new(c11 * e.m11 + c12 * e.m22, s12, s12, c12 * e.m11 + c11 * e.m22);
        let sigma = f * s * f.transpose() / f.determinant();
        let name = match kinematics {
            Kinematics::PlaneStrain => "LinearElasticIsotropicPlaneStrain2DLaw",
            _ => "LinearElasticIsotropicPlaneStress2DLaw",
        };
        let stress = respond(&*build(name, young, poisson, kinematics, false), &embedded).stress;
        let expected = [sigma.m11, sigma.m22, 0.0, sigma.m12, 0.0, 0.0];
        assert_stresses_agree(&stress, &expected, PLANE, 1e-14 * young);
    }
}

/// Steel, as in the plate impact of Renaud and Heuzé: c = 5875.097 m/s.
#[test]
fn pressure_wave_in_steel() {
    let law = LinearElastic::from_lame(lame(2e11, 0.3));
    assert!((law.wave_speed(7800.0) - 5875.097).abs() < 1e-3);
}

#[test]
fn inverted_and_infinite_deformations_are_errors() {
    let law = NeoHookean::from_lame(lame(1.0, 0.3));
    let elastic = LinearElastic::from_lame(lame(1.0, 0.3));
    let try_both = |f: Matrix3<f64>| {
        let first = law.stress(&at(f), &mut ()).unwrap_err();
        assert_eq!(elastic.stress_and_tangent(&at(f), &mut ()).unwrap_err().to_string(), first.to_string());
        first
    };
    let mirrored = Matrix3::from_diagonal(&Vector3::new(-0.5, 1.0, 1.0));
    assert_eq!(try_both(mirrored), LawError::NonPositiveJacobian { jacobian: -0.5 });
    assert_eq!(try_both(Matrix3::zeros()), LawError::NonPositiveJacobian { jacobian: 0.0 });
    for number in [f64::NAN, f64::INFINITY] {
        for entry in 0..9 {
            let mut f = Matrix3::identity();
            f[entry] = number;
            assert_eq!(try_both(f), LawError::NonFinite, "{number} at {entry}");
        }
    }
}
