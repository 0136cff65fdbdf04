use super::preconditioning::{Definiteness, Preconditioning};
use super::{IterativeSettings, Preconditioner};
use crate::test_systems::{dense, elastic_box, in_pools, laplacian, random_system, set, vector};
use crate::{BlockMatrix, LinearError, Method, solver};
use nalgebra::{DMatrix, DVector};

const PRECONDITIONERS: [Preconditioner; 3] =
    [Preconditioner::BlockJacobi, Preconditioner::DiagonalIncomplete, Preconditioner::Incomplete];

fn settings(preconditioner: Preconditioner, tolerance: f64) -> IterativeSettings {
    IterativeSettings { preconditioner, ..IterativeSettings::new(tolerance) }
}

/// `M^-1`, column by column.
fn inverse_of(preconditioner: Preconditioner, definiteness: Definiteness, a: &BlockMatrix) -> DMatrix<f64> {
    let mut preconditioning = Preconditioning::new(preconditioner, definiteness);
    preconditioning.set_up(a).unwrap();
    let order = a.pattern.order();
    let mut inverse = DMatrix::zeros(order, order);
    for (j, mut column) in inverse.column_iter_mut().enumerate() {
        let mut unit = vec![0.0; order];
        unit[j] = 1.0;
        let mut z = vec![f64::NAN; order];
        preconditioning.apply(a, &unit, &mut z);
        column.copy_from_slice(&z);
    }
    inverse
}

#[test]
fn systems_of_all_block_sizes_are_solved() {
    for block in 1..=4 {
        for preconditioner in PRECONDITIONERS {
            for symmetric in [true, false] {
                let a = random_system(block, 50, symmetric, 3);
                let b = vector(a.pattern.order(), 1);
                let expected = dense(&a).lu().solve(&DVector::from_column_slice(&b)).unwrap();
                let settings = settings(preconditioner, 1e-12);
                let mut methods = vec![Method::BiCgStab(settings.clone())];
                if symmetric {
                    methods.push(Method::ConjugateGradient(settings));
                }
                for method in methods {
                    let mut x = vec![0.0; b.len()];
                    let report = solver(method).solve(&a, &b, &mut x).unwrap();
                    assert!(report.residual <= 1e-12 && report.iterations.unwrap() < 100);
                    assert!(x.iter().zip(expected.iter()).all(|(x, expected)| (x - expected).abs() < 1e-9));
                }
            }
        }
    }
}

#[test]
fn conjugate_gradients_end_after_as_many_steps_as_eigenvalues() {
    // In exact arithmetic the residual vanishes after n steps. A right-hand side that is symmetric about the middle
    // excites only every second eigenvector: n / 2 steps.
    let n = 40;
    let a = laplacian(n);
    for (b, bound) in [(vector(n, 1), n), (vec![1.0; n], n / 2)] {
        let method = Method::ConjugateGradient(settings(Preconditioner::BlockJacobi, 1e-10));
        let iterations = solver(method).solve(&a, &b, &mut vec![0.0; n]).unwrap().iterations.unwrap();
        assert!(iterations <= bound && iterations > bound / 2, "{iterations} for at most {bound}");
    }
}

#[test]
fn incomplete_factors_without_dropped_fill_are_exact() {
    // A tridiagonal (block) matrix has no fill-in.
    for preconditioner in [Preconditioner::DiagonalIncomplete, Preconditioner::Incomplete] {
        let inverse = inverse_of(preconditioner, Definiteness::Positive, &laplacian(30));
        let defect = (inverse * dense(&laplacian(30)) - DMatrix::identity(30, 30)).abs().max();
        assert!(defect < 1e-12);
    }
}

#[test]
fn preconditioners_equal_their_definitions() {
    let a = random_system(3, 12, false, 5);
    let full = dense(&a);
    let stored = |i: usize, j: usize| a.pattern.position(i / 3, j / 3).is_some();
    let jacobi = inverse_of(Preconditioner::BlockJacobi, Definiteness::Unknown, &a).try_inverse().unwrap();
    let diagonal = inverse_of(Preconditioner::DiagonalIncomplete, Definiteness::Unknown, &a).try_inverse().unwrap();
    let incomplete = inverse_of(Preconditioner::Incomplete, Definiteness::Unknown, &a).try_inverse().unwrap();
    for i in 0..36 {
        for j in 0..36 {
            let close = |m: &DMatrix<f64>, value: f64| (m[(i, j)] - value).abs() < 1e-11;
            assert!(close(&jacobi, if i / 3 == j / 3 { full[(i, j)] } else { 0.0 }));
            // D-ILU reproduces the diagonal blocks, ILU(0) the whole pattern.
            assert!(i / 3 != j / 3 || close(&diagonal, full[(i, j)]));
            assert!(!stored(i, j) || close(&incomplete, full[(i, j)]));
        }
    }
}

#[test]
fn preconditioners_of_positive_matrices_are_symmetric_and_positive() {
    let a = elastic_box(4, 30.0);
    for preconditioner in PRECONDITIONERS {
        let inverse = inverse_of(preconditioner, Definiteness::Positive, &a);
        assert!((&inverse - inverse.transpose()).abs().max() < 1e-10 * inverse.abs().max());
        assert!(inverse.cholesky().is_some());
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let a = elastic_box(13, 3.0);
    let b = vector(a.pattern.order(), 1);
    for preconditioner in PRECONDITIONERS {
        let settings = settings(preconditioner, 1e-8);
        for method in [Method::ConjugateGradient(settings.clone()), Method::BiCgStab(settings.clone())] {
            let results = in_pools(|| {
                let mut x = vec![0.0; b.len()];
                let report = solver(method.clone()).solve(&a, &b, &mut x).unwrap();
                (report.iterations, x.iter().map(|value| value.to_bits()).collect::<Vec<_>>())
            });
            assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
        }
    }
}

#[test]
fn negative_curvature_is_named() {
    let mut a = random_system(2, 30, true, 6);
    let value = dense(&a)[(17, 17)];
    set(&mut a, 17, 17, -value);
    for preconditioner in PRECONDITIONERS {
        let method = Method::ConjugateGradient(settings(preconditioner, 1e-9));
        let result = solver(method).solve(&a, &vector(60, 1), &mut [0.0; 60]);
        assert_eq!(result, Err(LinearError::NotPositiveDefinite { dof: 17 }));
    }
    // Positive diagonal blocks, but an indefinite whole.
    let mut a = laplacian(10);
    for i in 0..10 {
        set(&mut a, i, i, 1.0);
    }
    let method = Method::ConjugateGradient(settings(Preconditioner::BlockJacobi, 1e-9));
    let result = solver(method).solve(&a, &vector(10, 1), &mut [0.0; 10]);
    assert!(matches!(result, Err(LinearError::NotPositiveDefinite { .. })));
}

#[test]
fn too_few_iterations_are_an_error() {
    let a = laplacian(100);
    let few = IterativeSettings { maximum_iterations: 7, ..settings(Preconditioner::BlockJacobi, 1e-9) };
    for method in [Method::ConjugateGradient(few.clone()), Method::BiCgStab(few)] {
        match solver(method).solve(&a, &vector(100, 1), &mut [0.0; 100]) {
            Err(LinearError::NotConverged { iterations, residual, tolerance }) => {
                assert_eq!((iterations, tolerance), (7, 1e-9));
                assert!(residual > tolerance);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_warm_start_from_the_solution_takes_no_iteration() {
    let a = random_system(3, 30, true, 1);
    let exact = vector(90, 2);
    let mut b = vec![0.0; 90];
    a.multiply(&exact, &mut b);
    for warm_start in [true, false] {
        let settings = IterativeSettings { warm_start, ..IterativeSettings::new(1e-9) };
        for method in [Method::ConjugateGradient(settings.clone()), Method::BiCgStab(settings)] {
            let mut x = exact.clone();
            let iterations = solver(method).solve(&a, &b, &mut x).unwrap().iterations;
            assert_eq!(iterations == Some(0), warm_start);
        }
    }
}
