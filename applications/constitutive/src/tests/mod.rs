//! Tests that hold for every law: stress against energy, tangent against stress, objectivity,
//! Hooke's law at small strain, exact values at extreme strain, digits at tiny strain, errors.

mod batches;
mod plane_stress;
mod values;

use bia_kernel::model::{Properties, Value};
use nalgebra::{DMatrix, Matrix3, Matrix6, Rotation3, Vector3};

use crate::tensor::{stress_from_voigt, stress_to_voigt};
use crate::verify::{stress_from_energy, tangent_from_stress};
use crate::{
    ConstitutiveLaw, Deformation, Kinematics, KirchhoffBar, LameParameters, LawEntry, LinearElastic,
    LinearElasticPlaneStress, MaterialPlaces, NeoHookean, NominalElastic, Options, POISSON_RATIO, PlaneStress,
    Response, Tangent, Voigt, Want, catalogue,
};

const ALL: &[usize] = &[0, 1, 2, 3, 4, 5];
const PLANE: &[usize] = &[0, 1, 3];

fn lame(young: f64, poisson: f64) -> LameParameters {
    LameParameters::from_engineering(young, poisson)
}

fn at(gradient: Matrix3<f64>) -> Deformation {
    Deformation::from_gradient(gradient)
}

/// Deformation gradients with det F > 0: sheared, stretched and compressed to a fifth, all rotated.
fn samples() -> Vec<Matrix3<f64>> {
    let turn = |angle: f64| *Rotation3::from_axis_angle(&Vector3::y_axis(), angle).matrix();
    vec![
        Matrix3::identity(),
        Matrix3::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05),
        turn(2.0) * Matrix3::new(2.0, 0.4, 0.0, -0.3, 1.5, 0.2, 0.1, 0.0, 0.7),
        turn(-0.7) * Matrix3::new(0.6, 0.1, 0.2, 0.0, 0.5, -0.1, 0.1, 0.2, 0.8),
    ]
}

/// The same with a rigid third direction, for the laws of plane stress.
fn plane_samples() -> Vec<Matrix3<f64>> {
    [[1.0, 0.0, 0.0, 1.0], [1.1, 0.3, -0.1, 0.9], [0.5, 0.8, -1.3, 0.4], [0.7, 0.1, 0.2, 0.8]]
        .map(|[a, b, c, d]| Matrix3::new(a, b, 0.0, c, d, 0.0, 0.0, 0.0, 1.0))
        .to_vec()
}

/// Asserts |a − b| ≤ tolerance · largest |b|, over the picked rows and columns.
#[track_caller]
fn assert_tangents_agree(a: &Tangent, b: &Tangent, picked: &[usize], tolerance: f64) {
    let scale = b.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for &row in picked {
        for &column in picked {
            let (x, y) = (a[row][column], b[row][column]);
            assert!((x - y).abs() <= tolerance * scale, "[{row}][{column}]: {x:e} and {y:e}, scale {scale:e}");
        }
    }
}

#[track_caller]
fn assert_stresses_agree(a: &Voigt, b: &Voigt, picked: &[usize], tolerance: f64) {
    for &row in picked {
        assert!((a[row] - b[row]).abs() <= tolerance, "[{row}]: {:e} and {:e}", a[row], b[row]);
    }
}

/// Stress against differences of the energy, tangent against differences of the stress, symmetry.
fn check_derivatives<L: ConstitutiveLaw>(law: &L, samples: &[Matrix3<f64>], picked: &[usize]) {
    for gradient in samples {
        let deformation = at(*gradient);
        let mut state = law.initial_state();
        let (stress, tangent) = law.stress_and_tangent(&deformation, &mut state).unwrap();
        let modulus = tangent.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));

        let reference = stress_from_energy(law, &deformation, picked).unwrap();
        assert_stresses_agree(&stress, &reference, picked, 2e-9 * modulus);
        assert_eq!(stress, law.stress(&deformation, &mut law.initial_state()).unwrap());

        let reference = tangent_from_stress(law, &deformation, &law.initial_state(), picked).unwrap();
        assert_tangents_agree(&tangent, &reference, picked, 2e-9);
        let transposed = std::array::from_fn(|row| std::array::from_fn(|column| tangent[column][row]));
        assert_tangents_agree(&tangent, &transposed, picked, 1e-15);
    }
}

#[test]
fn stresses_and_tangents_are_derivatives() {
    for poisson in [-0.4, 0.0, 0.3, 0.49] {
        let lame = lame(3.0e6, poisson);
        check_derivatives(&NeoHookean::from_lame(lame), &samples(), ALL);
        check_derivatives(&LinearElastic::from_lame(lame), &samples(), ALL);
        check_derivatives(&LinearElasticPlaneStress::from_lame(lame), &plane_samples(), PLANE);
        check_derivatives(&PlaneStress(NeoHookean::from_lame(lame)), &plane_samples(), PLANE);
        let stretches = [1.0, 1.3, 0.4].map(|f| Matrix3::from_diagonal(&Vector3::new(f, 1.0, 1.0)));
        check_derivatives(&NominalElastic::from_lame(lame), &stretches, &[0]);
        check_derivatives(&KirchhoffBar::from_young(3.0e6), &stretches, &[0]);
    }
}

/// σ(QF) = Q σ(F) Qᵀ with the energy unchanged, and σ(FQ) = σ(F): the laws are isotropic.
fn check_rotations<L: ConstitutiveLaw>(law: &L, samples: &[Matrix3<f64>], q: &Matrix3<f64>) {
    let stress = |f: &Matrix3<f64>| stress_from_voigt(&law.stress(&at(*f), &mut law.initial_state()).unwrap());
    let energy = |f: &Matrix3<f64>| law.energy(&at(*f)).unwrap();
    for f in samples {
        let turned = q * stress(f) * q.transpose();
        let scale = 1e-13 * (1e6 + turned.norm());
        assert!((stress(&(q * f)) - turned).norm() < scale);
        assert!((stress(&(f * q)) - stress(f)).norm() < scale);
        assert!((energy(&(q * f)) - energy(f)).abs() < scale);
    }
}

#[test]
fn laws_are_objective_and_isotropic() {
    let general = *Rotation3::from_euler_angles(0.4, -1.1, 2.3).matrix();
    let in_plane = *Rotation3::from_axis_angle(&Vector3::z_axis(), 1.3).matrix();
    let lame = lame(1.0e6, 0.3);
    check_rotations(&NeoHookean::from_lame(lame), &samples(), &general);
    check_rotations(&LinearElastic::from_lame(lame), &samples(), &general);
    check_rotations(&LinearElasticPlaneStress::from_lame(lame), &plane_samples(), &in_plane);
    check_rotations(&PlaneStress(NeoHookean::from_lame(lame)), &plane_samples(), &in_plane);
}

/// Hooke's law of each kinematics from the compliance 1/E, −ν/E, 2(1 + ν)/E, by inversion.
fn hooke(young: f64, poisson: f64, kinematics: Kinematics) -> DMatrix<f64> {
    let compliance = Matrix6::from_fn(|a, b| match (a == b, a < 3 && b < 3) {
        (true, true) => 1.0 / young,
        (false, true) => -poisson / young,
        (true, false) => 2.0 * (1.0 + poisson) / young,
        (false, false) => 0.0,
    });
    let components = kinematics.voigt();
    let pick = |full: &Matrix6<f64>| {
        DMatrix::from_fn(components.len(), components.len(), |a, b| full[(components[a], components[b])])
    };
    match kinematics {
        Kinematics::PlaneStress => pick(&compliance).try_inverse().unwrap(),
        _ => pick(&compliance.try_inverse().unwrap()),
    }
}

fn material(law: &str, young: f64, poisson: f64) -> Properties {
    let numbers = [("DENSITY", 7800.0), ("YOUNG_MODULUS", young), ("POISSON_RATIO", poisson)];
    let values = numbers.map(|(name, number)| (name.to_owned(), Value::Number(number))).into();
    Properties { law: Some(law.into()), values, ..Default::default() }
}

fn build(law: &str, young: f64, poisson: f64, kinematics: Kinematics, kratos_exact: bool) -> Box<dyn crate::Law> {
    let options = Options { kratos_exact, ..Options::default() };
    catalogue().build(&material(law, young, poisson), kinematics, &options, &MaterialPlaces::default()).unwrap()
}

fn respond(law: &dyn crate::Law, gradient: &Matrix3<f64>) -> Response {
    let mut state = vec![0.0; law.state_len()];
    law.initial_state(&mut state);
    let mut out = [Response::default()];
    law.respond(&[at(*gradient)], &mut state, &mut out, Want::StressAndTangent).unwrap();
    out[0]
}

/// A displacement gradient that the kinematics allows.
fn allowed(h: &Matrix3<f64>, kinematics: Kinematics) -> Matrix3<f64> {
    Matrix3::from_fn(|a, b| match kinematics {
        Kinematics::ThreeDimensional => h[(a, b)],
        Kinematics::Axisymmetric if (a, b) == (2, 2) => h[(a, b)],
        _ if a < kinematics.dimension() && b < kinematics.dimension() => h[(a, b)],
        _ => 0.0,
    })
}

#[test]
fn every_entry_is_hookes_law_at_small_strain() {
    let (young, poisson) = (2.0e11, 0.3);
    let h = Matrix3::new(0.3, 0.8, -0.2, 0.1, -0.6, 0.5, 0.4, -0.7, 0.9);
    let size = 2.0_f64.powi(-30);
    // The constants of solids are all that this test has.
    let solid =
        |entry: &&LawEntry| !entry.mixed && entry.variables.iter().any(|variable| variable.name == POISSON_RATIO.name);
    for entry in catalogue().entries().iter().filter(solid) {
        for &kinematics in entry.kinematics {
            let law = build(entry.name, young, poisson, kinematics, false);
            let components = kinematics.voigt();
            let hooke = hooke(young, poisson, kinematics);
            let h = allowed(&h, kinematics);
            let answer = respond(&*law, &(Matrix3::identity() + size * h));
            let strain = stress_to_voigt(&(h + h.transpose())); // doubled: halved below for the normal ones
            for (row, &component) in components.iter().enumerate() {
                let stress: f64 = components
                    .iter()
                    .enumerate()
                    .map(|(column, &other)| hooke[(row, column)] * strain[other] * if other < 3 { 0.5 } else { 1.0 })
                    .sum();
                let error = answer.stress[component] / size - stress;
                assert!(error.abs() < 1e-7 * young, "{} {component}: {error:e}", entry.name);
                for (column, &other) in components.iter().enumerate() {
                    let error = answer.tangent[component][other] - hooke[(row, column)];
                    assert!(error.abs() < 1e-7 * young, "{} {component} {other}: {error:e}", entry.name);
                }
            }
            let speed = (hooke[(0, 0)] / 7800.0).sqrt();
            assert!((law.wave_speed(7800.0) / speed - 1.0).abs() < 1e-14, "{}", entry.name);
        }
    }
}

/// In plane strain and axisymmetry a law is the three-dimensional one on the embedded F, bit for bit.
#[test]
fn plane_strain_and_axisymmetry_embed_in_three_dimensions() {
    use Kinematics::{Axisymmetric, PlaneStrain, ThreeDimensional};
    let f = Matrix3::new(1.3, 0.2, 0.0, -0.4, 0.8, 0.0, 0.0, 0.0, 1.2);
    for family in ["LinearElasticIsotropic", "HyperElasticNeoHookean"] {
        let full = build(&format!("{family}3DLaw"), 1e6, 0.3, ThreeDimensional, false);
        for (kinematics, ending) in [(PlaneStrain, "PlaneStrain2DLaw"), (Axisymmetric, "Axisym2DLaw")] {
            let law = build(&format!("{family}{ending}"), 1e6, 0.3, kinematics, false);
            assert_eq!(respond(&*law, &f), respond(&*full, &f), "{family} {kinematics}");
        }
    }
}
