use crate::test_systems::{dense, elastic_box, laplacian, random_system, set, vector};
use crate::{BlockMatrix, BlockPattern, LinearError, Method, Nature, solver};
use nalgebra::{DVector, SymmetricEigen};
use std::sync::Arc;

const DIRECT: [Method; 3] = [Method::Cholesky, Method::Ldlt, Method::Lu];
const AUTOMATIC: Method =
    Method::Automatic { nature: Nature { symmetric: true, definite: true, dimension: 2 }, tolerance: 1e-9 };

/// Solves for a manufactured solution and returns the greatest error.
fn error_of(method: Method, a: &BlockMatrix) -> f64 {
    let exact = vector(a.pattern.order(), 17);
    let mut b = vec![0.0; exact.len()];
    a.multiply(&exact, &mut b);
    let mut x = vec![f64::NAN; exact.len()];
    let report = solver(method).solve(a, &b, &mut x).unwrap();
    assert!(report.residual < 1e-12 && report.iterations.is_none());
    x.iter().zip(&exact).map(|(x, exact)| (x - exact).abs()).fold(0.0, f64::max)
}

/// Couples displacements (2 components) with a pressure (third component, zero diagonal): `[K G; G^T 0]` on each node.
fn saddle_point(n: usize) -> BlockMatrix {
    let mut a = random_system(3, n, true, 8);
    for i in 0..n {
        for j in (0..n).filter(|&j| a.pattern.position(i, j).is_some()).collect::<Vec<_>>() {
            set(&mut a, 3 * i + 2, 3 * j + 2, 0.0);
        }
    }
    a
}

#[test]
fn positive_definite_systems_of_all_block_sizes() {
    for block in 1..=4 {
        let a = random_system(block, 40, true, block as u64);
        for method in DIRECT {
            assert!(error_of(method, &a) < 1e-11);
        }
    }
}

#[test]
fn supernodal_factors_of_a_solid() {
    // Large enough that faer works with supernodes.
    let a = elastic_box(6, 1.0);
    for method in DIRECT {
        assert!(error_of(method, &a) < 1e-12);
    }
}

#[test]
fn unsymmetric_systems_equal_dense_lu() {
    for block in 1..=4 {
        let a = random_system(block, 30, false, 21);
        let b = vector(a.pattern.order(), 2);
        let expected = dense(&a).lu().solve(&DVector::from_column_slice(&b)).unwrap();
        let mut x = vec![0.0; b.len()];
        solver(Method::Lu).solve(&a, &b, &mut x).unwrap();
        assert!(x.iter().zip(expected.iter()).all(|(x, expected)| (x - expected).abs() < 1e-12));
    }
}

#[test]
fn inertia_equals_the_dense_eigenvalues() {
    let mut small = random_system(2, 25, true, 5);
    let mut solid = elastic_box(6, 1.0);
    for a in [&mut small, &mut solid] {
        for dof in [3, 11, 12, 30] {
            let value = dense(a)[(dof, dof)];
            set(a, dof, dof, -3.0 * value);
        }
        let negative = SymmetricEigen::new(dense(a)).eigenvalues.iter().filter(|&&value| value < 0.0).count();
        let b = vector(a.pattern.order(), 2);
        let report = solver(Method::Ldlt).solve(a, &b, &mut vec![0.0; b.len()]).unwrap();
        assert_eq!((report.negative_pivots, report.note), (Some(negative), None));
        assert!(negative > 0);
    }
}

#[test]
fn saddle_points_are_solved_after_all() {
    let a = saddle_point(20);
    assert!(error_of(Method::Ldlt, &a) < 1e-9);
    assert!(error_of(AUTOMATIC, &a) < 1e-9);
}

#[test]
fn a_zero_pivot_falls_back_to_pivoting() {
    // [0 1; 1 0] blocks cannot be eliminated without pivoting, whatever the order.
    let pattern = Arc::new(BlockPattern::from_cliques(2, 4, [].into_iter()));
    let mut a = BlockMatrix::new(pattern);
    a.values.copy_from_slice(&[0.0, 1.0, 1.0, 0.0].repeat(4));
    let b = vector(8, 1);
    let mut x = vec![0.0; 8];
    let report = solver(Method::Ldlt).solve(&a, &b, &mut x).unwrap();
    let expected: Vec<f64> = b.chunks(2).flat_map(|pair| [pair[1], pair[0]]).collect();
    assert_eq!(x, expected);
    assert!(report.note.unwrap().contains("solved by sparse LU"));
}

#[test]
fn cholesky_names_the_row_of_a_negative_pivot() {
    // The bad row is decoupled, so every elimination order fails in it: in simplicial and in supernodal factors.
    let small = random_system(2, 30, true, 6);
    let solid = elastic_box(6, 1.0);
    for mut a in [small, solid] {
        for dof in [0, 17, a.pattern.order() - 1] {
            let mut bad = a.clone();
            let mut mask = vec![false; a.pattern.order()];
            mask[dof] = true;
            let mut b = vector(mask.len(), 1);
            bad.constrain(&mask, &mut b);
            set(&mut bad, dof, dof, -1.0);
            let result = solver(Method::Cholesky).solve(&bad, &b, &mut vec![0.0; mask.len()]);
            assert_eq!(result, Err(LinearError::NotPositiveDefinite { dof }));
        }
        a.clear();
    }
}

#[test]
fn singular_matrices_name_the_loose_unknown() {
    for coupled in [false, true] {
        let mut a = random_system(2, 30, true, 6);
        let full = dense(&a);
        let dof = 23;
        // A zero row and column, or (coupled) a diagonal entry that makes the Schur complement of the rest zero.
        let mut mask = vec![false; 60];
        mask[dof] = true;
        let mut b = vector(60, 1);
        if coupled {
            let keep: Vec<usize> = (0..60).filter(|&i| i != dof).collect();
            let rest = full.select_rows(&keep).select_columns(&keep);
            let column = full.select_rows(&keep).column(dof).into_owned();
            let schur = column.dot(&rest.lu().solve(&column).unwrap());
            set(&mut a, dof, dof, schur);
        } else {
            a.constrain(&mask, &mut b);
            set(&mut a, dof, dof, 0.0);
        }
        for method in DIRECT {
            match solver(method.clone()).solve(&a, &b, &mut [0.0; 60]) {
                Err(LinearError::Singular { dof: found }) => assert_eq!(found, dof),
                // Rounding decides on which side of zero the last pivot of Cholesky falls.
                Err(LinearError::NotPositiveDefinite { .. }) if coupled && method == Method::Cholesky => {}
                other => panic!("{method:?}: {other:?}"),
            }
        }
    }
}

#[test]
fn exactly_singular_blocks_are_found_by_every_method() {
    // Node 2 has a block of rank 1 and no neighbours: elimination meets an exact zero.
    let mut a = random_system(2, 6, true, 3);
    let mut b = vector(12, 1);
    let mask: Vec<bool> = (0..12).map(|dof| dof / 2 == 2).collect();
    a.constrain(&mask, &mut b);
    for (i, j) in [(4, 4), (4, 5), (5, 4), (5, 5)] {
        set(&mut a, i, j, 1.0);
    }
    for method in [Method::Ldlt, Method::Lu, AUTOMATIC] {
        match solver(method).solve(&a, &b, &mut [0.0; 12]) {
            Err(LinearError::Singular { dof }) => assert!(dof / 2 == 2),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_free_body_is_singular() {
    let a = elastic_box(4, f64::INFINITY);
    let b = vector(a.pattern.order(), 1);
    for method in DIRECT {
        let result = solver(method).solve(&a, &b, &mut vec![0.0; b.len()]);
        assert!(
            matches!(result, Err(LinearError::Singular { .. } | LinearError::NotPositiveDefinite { .. })),
            "{result:?}"
        );
    }
}

#[test]
fn an_unsymmetric_matrix_does_not_pass_cholesky() {
    let a = random_system(3, 20, false, 2);
    let result = solver(Method::Cholesky).solve(&a, &vector(60, 1), &mut [0.0; 60]);
    assert!(matches!(result, Err(LinearError::Inaccurate { backward_error, .. }) if backward_error > 1e-6));
}

#[test]
fn analysis_is_kept_for_new_values_and_renewed_for_new_patterns() {
    for method in DIRECT {
        let mut reused = solver(method.clone());
        let mut a = random_system(3, 30, true, 1);
        for seed in 0..3 {
            let b = vector(a.pattern.order(), seed);
            let (mut x, mut fresh) = (vec![0.0; b.len()], vec![0.0; b.len()]);
            reused.solve(&a, &b, &mut x).unwrap();
            solver(method.clone()).solve(&a, &b, &mut fresh).unwrap();
            assert_eq!(x, fresh);
            for row in 0..a.pattern.order() {
                let value = dense(&a)[(row, row)];
                set(&mut a, row, row, value * 1.3);
            }
        }
        // The same size, other couplings.
        let a = laplacian(90);
        let b = vector(90, 4);
        let mut x = vec![0.0; 90];
        assert!(reused.solve(&a, &b, &mut x).unwrap().residual < 1e-12);
    }
}

#[test]
fn bad_input_is_refused() {
    let mut a = random_system(1, 5, true, 1);
    for method in DIRECT {
        let result = solver(method.clone()).solve(&a, &[1.0, 1.0, f64::NAN, 1.0, 1.0], &mut [0.0; 5]);
        assert_eq!(result, Err(LinearError::NonFinite { dof: 2 }));
        let result = solver(method).solve(&a, &[0.0; 4], &mut [0.0; 5]);
        assert_eq!(result, Err(LinearError::Size { expected: 5, found: 4 }));
    }
    a.clear();
    assert_eq!(solver(Method::Lu).solve(&a, &[1.0; 5], &mut [0.0; 5]), Err(LinearError::Singular { dof: 0 }));
}

#[test]
fn a_zero_right_hand_side_gives_zero() {
    let a = random_system(2, 5, true, 1);
    for method in DIRECT {
        let mut x = [1.0; 10];
        assert_eq!(solver(method).solve(&a, &[0.0; 10], &mut x).unwrap().residual, 0.0);
        assert_eq!(x, [0.0; 10]);
    }
}
