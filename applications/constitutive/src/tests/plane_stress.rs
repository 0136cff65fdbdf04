//! The plane-stress adaptor against the closed form it must reproduce, and at its limits.

use super::*;
use crate::LawError;

/// Around Saint-Venant–Kirchhoff the adaptor finds S33 = 0: the closed form of plane stress.
#[test]
fn adaptor_around_saint_venant_kirchhoff_is_the_closed_form() {
    for poisson in [-0.3, 0.0, 0.3, 0.499] {
        let parameters = lame(1e6, poisson);
        let adapted = PlaneStress(LinearElastic::from_lame(parameters));
        let closed = LinearElasticPlaneStress::from_lame(parameters);
        for f in plane_samples() {
            let (stress, tangent) = adapted.stress_and_tangent(&at(f), &mut 0.0).unwrap();
            let (expected_stress, expected_tangent) = closed.stress_and_tangent(&at(f), &mut ()).unwrap();
            assert_stresses_agree(&stress, &expected_stress, ALL, 1e-12 * 1e6);
            assert_tangents_agree(&tangent, &expected_tangent, ALL, 1e-12);
            let (energy, expected) = (adapted.energy(&at(f)).unwrap(), closed.energy(&at(f)).unwrap());
            assert!((energy - expected).abs() < 1e-12 * 1e6, "{energy} {expected}");
        }
    }
}

/// The state is the logarithm of the thickness stretch; with it σ33 of the solid vanishes and the
/// answer is the solid's force per undeformed thickness. A first guess changes nothing but time.
#[test]
fn adaptor_frees_the_neo_hookean_solid_across_the_plane() {
    let solid = NeoHookean::from_lame(lame(1e6, 0.4));
    let law = PlaneStress(solid);
    for mut f in plane_samples() {
        let mut log_stretch = 0.0;
        let stress = law.stress(&at(f), &mut log_stretch).unwrap();
        let again = law.stress(&at(f), &mut log_stretch.clone()).unwrap();
        assert_stresses_agree(&again, &stress, ALL, 1e-9);

        let strain = law.strain(&at(f));
        assert!((strain[2] - 0.5 * (1.0 - (-2.0 * log_stretch).exp())).abs() < 1e-14);

        f[(2, 2)] = log_stretch.exp();
        let full = solid.stress(&at(f), &mut ()).unwrap();
        assert!(full[2].abs() < 1e-9, "{full:?}");
        assert_stresses_agree(&stress, &full.map(|component| component * f[(2, 2)]), PLANE, 1e-8);
    }
}

/// From a first guess of F33 = 1/e the slope dτ33/d(ln F33) of Saint-Venant–Kirchhoff points away.
#[test]
fn adaptor_turns_back_from_a_bad_first_guess() {
    let law = PlaneStress(LinearElastic::from_lame(lame(1e6, 0.3)));
    let closed = LinearElasticPlaneStress::from_lame(lame(1e6, 0.3));
    let f = plane_samples()[1];
    let stress = law.stress(&at(f), &mut -1.0).unwrap();
    assert_stresses_agree(&stress, &closed.stress(&at(f), &mut ()).unwrap(), ALL, 1e-12 * 1e6);
}

/// Stretched twofold both ways, Saint-Venant–Kirchhoff needs E33 < −½, which no F33 has.
#[test]
fn adaptor_says_when_no_thickness_exists() {
    let law = PlaneStress(LinearElastic::from_lame(lame(1e6, 0.3)));
    let f = Matrix3::from_diagonal(&Vector3::new(2.0, 2.0, 1.0));
    let error = law.stress(&at(f), &mut 0.0).unwrap_err();
    assert!(matches!(error, LawError::NoConvergence { iterations: 50, .. }), "{error}");
    assert!(error.to_string().contains("thickness stretch"), "{error}");
    assert_eq!(law.energy(&at(f)), None);
}
