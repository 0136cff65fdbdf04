//! All methods that take displacement-pressure systems, on all sorts of them.

use crate::test_systems::{MixedBox, Pressure, in_pools, set, vector};
use crate::{IterativeSettings, LinearError, Method, Nature, Preconditioner, SolveReport, solver};

fn gmres(tolerance: f64) -> Method {
    Method::Gmres(IterativeSettings { preconditioner: Preconditioner::Incomplete, ..IterativeSettings::new(tolerance) })
}

/// A solid in pascals and metres, a liquid at a step of 1 ms, and numbers about 1.
const MATERIALS: [(f64, f64); 3] = [(1e9, 0.0), (1.0, 1e9), (1.0, 0.0)];

/// Boxes of both dimensions, all materials, almost and fully incompressible, with cells that are nearly empty.
fn boxes(pressure: Pressure) -> Vec<MixedBox> {
    let mut boxes = Vec::new();
    for dimension in [2, 3] {
        for (shear, inertia) in MATERIALS {
            for ratio in [10.0, 1e6, f64::INFINITY] {
                for (cut, skew) in [(1.0, 0.0), (1.0, 0.2), (1e-6, 0.0), (1e-6, 0.2)] {
                    let cells = if dimension == 2 { 8 } else { 4 };
                    let plain = MixedBox { shear, inertia, ..MixedBox::new(dimension, cells) };
                    boxes.push(MixedBox { bulk: ratio * plain.stiffness(), pressure, cut, skew, ..plain });
                }
            }
        }
    }
    boxes
}

/// Greatest error of displacements about 1 and pressures about [`MixedBox::stiffness`], relative to these.
fn error_of(method: Method, mixed: &MixedBox) -> (f64, SolveReport) {
    let (a, _) = mixed.system();
    let held = mixed.held();
    let block = mixed.dimension + 1;
    let unit = |dof: usize| if dof % block == mixed.dimension { mixed.stiffness() } else { 1.0 };
    let exact: Vec<f64> = vector(held.len(), 17)
        .iter()
        .enumerate()
        .map(|(dof, value)| if held[dof] { 0.0 } else { unit(dof) * value })
        .collect();
    let mut load = vec![0.0; exact.len()];
    a.multiply(&exact, &mut load);
    let mut x = vec![f64::NAN; exact.len()];
    let report = solver(method).solve(&a, &load, &mut x).unwrap_or_else(|error| panic!("{mixed:?}: {error}"));
    let errors = x.iter().zip(&exact).enumerate().map(|(dof, (x, exact))| (x - exact).abs() / unit(dof));
    (errors.fold(0.0, f64::max), report)
}

#[test]
fn lu_solves_stabilised_unstable_and_inf_sup_stable_systems() {
    for pressure in [Pressure::Stabilised, Pressure::Coarse, Pressure::Unstable] {
        // Without stabilisation a checkerboard of pressure meets little resistance: only where it is compressible.
        let regular = |mixed: &MixedBox| pressure != Pressure::Unstable || mixed.bulk < 100.0 * mixed.stiffness();
        for mixed in boxes(pressure).into_iter().filter(regular) {
            let (error, report) = error_of(Method::Lu, &mixed);
            assert!(error < 1e-11 && report.note.is_none(), "{mixed:?}: {error:.1e}, {report:?}");
            assert!(report.backward_error.unwrap() <= 1e-13);
        }
    }
}

#[test]
fn gmres_solves_stabilised_systems() {
    for mixed in boxes(Pressure::Stabilised) {
        let (error, report) = error_of(gmres(1e-12), &mixed);
        assert!(error < 1e-9 && report.residual <= 1e-12, "{mixed:?}: {error:.1e}, {report:?}");
    }
}

#[test]
fn iterations_do_not_grow_with_the_bulk_modulus() {
    for inertia in [0.0, 1e4] {
        let iterations = [1e2, 1e4, 1e8, f64::INFINITY].map(|bulk| {
            let (a, load) = MixedBox { inertia, bulk, ..MixedBox::new(3, 6) }.system();
            let report = solver(gmres(1e-9)).solve(&a, &load, &mut vec![0.0; load.len()]).unwrap();
            report.iterations.unwrap()
        });
        assert!(iterations.iter().all(|&count| count <= 30 && count.abs_diff(iterations[0]) <= 3), "{iterations:?}");
    }
}

#[test]
fn symmetric_stabilised_systems_have_as_many_negative_pivots_as_pressures() {
    for mixed in boxes(Pressure::Stabilised).into_iter().filter(|mixed| mixed.skew == 0.0) {
        let (error, report) = error_of(Method::Ldlt, &mixed);
        assert_eq!((report.negative_pivots, &report.note), (Some(mixed.pressures()), &None), "{mixed:?}");
        assert!(error < 1e-11 && report.backward_error.unwrap() <= 1e-13, "{mixed:?}: {error:.1e}, {report:?}");
    }
}

#[test]
fn pivots_that_vanish_cost_time_but_no_accuracy() {
    let mut replaced = 0;
    for mixed in boxes(Pressure::Coarse).into_iter().filter(|mixed| mixed.skew == 0.0) {
        let (error, report) = error_of(Method::Ldlt, &mixed);
        assert!(error < 1e-10 && report.backward_error.unwrap() <= 1e-12, "{mixed:?}: {error:.1e}, {report:?}");
        replaced += usize::from(report.note.is_some_and(|note| note.contains("solved by sparse LU")));
    }
    assert!(replaced > 0);
}

#[test]
fn the_choice_is_direct_in_two_and_iterative_in_three_dimensions() {
    for (dimension, cells, symmetric, expected) in [
        (2, 40, true, "L D L^T"),
        (2, 40, false, "LU"),
        (3, 4, true, "L D L^T"),
        (3, 9, false, "GMRES"),
        (3, 9, true, "GMRES"),
    ] {
        let mixed = MixedBox { skew: if symmetric { 0.0 } else { 0.1 }, ..MixedBox::new(dimension, cells) };
        let (a, load) = mixed.system();
        let nature = Nature { symmetric, definite: false, dimension };
        let mut solver = solver(Method::Automatic { nature, tolerance: 1e-9 });
        let report = solver.solve(&a, &load, &mut vec![0.0; load.len()]).unwrap();
        assert!(solver.name().contains(expected), "{}", solver.name());
        assert!(report.residual <= 1e-9 && report.note.is_none());
    }
}

#[test]
fn an_iteration_in_vain_is_followed_by_a_factorisation() {
    let mixed = MixedBox { pressure: Pressure::Coarse, skew: 0.1, ..MixedBox::new(3, 10) };
    let nature = Nature { symmetric: false, definite: false, dimension: 3 };
    let (error, report) = error_of(Method::Automatic { nature, tolerance: 1e-9 }, &mixed);
    assert!(error < 1e-11 && report.backward_error.unwrap() <= 1e-13);
    let note = report.note.unwrap();
    assert!(note.contains("GMRES") && note.contains("solved by sparse LU"), "{note}");
}

#[test]
fn an_enclosed_incompressible_body_lacks_a_pressure_level() {
    for (dimension, cells) in [(2, 8), (3, 4)] {
        let mixed = MixedBox { skew: 0.1, ..MixedBox::new(dimension, cells) };
        let mut a = mixed.free();
        let enclosed = |dof: usize| {
            let place = mixed.lattice(dof / (dimension + 1));
            dof % (dimension + 1) < dimension && place[..dimension].iter().any(|&i| i == 0 || i == cells)
        };
        let mask: Vec<bool> = (0..a.pattern.order()).map(enclosed).collect();
        let mut load = vector(mask.len(), 3);
        a.constrain(&mask, &mut load);
        for method in [Method::Lu, Method::Ldlt] {
            match solver(method).solve(&a, &load, &mut vec![0.0; load.len()]) {
                Err(LinearError::Singular { dof }) => assert_eq!(dof % (dimension + 1), dimension),
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn a_pressure_without_equation_is_named() {
    let mixed = MixedBox { skew: 0.1, ..MixedBox::new(2, 6) };
    let (mut a, mut load) = mixed.system();
    // The equations of two neighbours hold their sum only.
    let (first, second) = (3 * 8 + 2, 3 * 15 + 2);
    let mask: Vec<bool> = (0..load.len()).map(|dof| dof == first || dof == second).collect();
    a.constrain(&mask, &mut load);
    for (i, j) in [(first, first), (first, second), (second, first), (second, second)] {
        set(&mut a, i, j, -1.0);
    }
    match solver(Method::Lu).solve(&a, &load, &mut vec![0.0; load.len()]) {
        Err(LinearError::Singular { dof }) => assert!(dof == first || dof == second),
        other => panic!("{other:?}"),
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let mixed = MixedBox { skew: 0.1, ..MixedBox::new(3, 10) };
    let (a, load) = mixed.system();
    for method in [Method::Lu, gmres(1e-9)] {
        let results = in_pools(|| {
            let mut x = vec![0.0; load.len()];
            let report = solver(method.clone()).solve(&a, &load, &mut x).unwrap();
            (report.iterations, x.iter().map(|value| value.to_bits()).collect::<Vec<_>>())
        });
        assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
    }
}
