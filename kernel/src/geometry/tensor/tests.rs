use super::super::testing::{Mesh, Random, part, renumbered, tensor};
use super::super::{Irregular, Shape};
use super::*;

const FAMILIES: [Family; 2] = [Family::Lagrange, Family::BSpline];

/// Lines of uneven spacing.
fn uneven(random: &mut Random, cells: usize) -> Vec<f64> {
    let mut lines = vec![random.within(-2.0, 2.0)];
    for i in 0..cells {
        lines.push(lines[i] + random.within(0.5, 1.5));
    }
    lines
}

fn line(lines: &[f64]) -> Mesh {
    let cells = (1..lines.len() as u32).map(|i| (Shape::Line2, vec![i - 1, i])).collect();
    (lines.iter().map(|&x| [x, 0.0, 0.0]).collect(), cells)
}

fn basis((coordinates, cells): Mesh, family: Family, degree: usize) -> TensorBasis {
    TensorBasis::new(RegularGrid::new(&part(coordinates, &cells)).unwrap(), family, degree)
}

/// All functions at x, seen from the cell at this place.
fn all<const P1: usize>(basis: &TensorBasis, cell: usize, x: f64) -> Vec<f64> {
    let mut values = vec![0.0; basis.len()];
    let of_cell = basis.cell::<1, P1, P1>(cell).unwrap();
    let found = of_cell.functions(&[basis.local(cell, [x, 0.0, 0.0])[0]]);
    basis.functions_of(cell).zip(found).for_each(|(i, n)| values[i as usize] = n);
    values
}

/// Partition of unity, the position from the anchors, the slope of it, and slopes as differences.
fn reproduces_position<const D: usize, const N: usize, const P1: usize>(random: &mut Random, family: Family) {
    let axes: Vec<Vec<f64>> = (0..D).map(|d| uneven(random, 3 + d)).collect();
    let mesh = if D == 1 { line(&axes[0]) } else { tensor(&axes) };
    let mesh = renumbered_unless_line(random, mesh);
    let basis = basis(mesh, family, P1 - 1);
    let expected: usize = axes
        .iter()
        .map(|lines| if family == Family::Lagrange { (lines.len() - 1) * (P1 - 1) + 1 } else { lines.len() + P1 - 2 })
        .product();
    assert_eq!(basis.len(), expected);
    for cell in 0..basis.grid().len() {
        let of_cell = basis.cell::<D, N, P1>(cell).unwrap();
        let numbers: Vec<u32> = basis.functions_of(cell).collect();
        assert_eq!(numbers.len(), N);
        let xi: [f64; D] = from_fn(|_| random.within(-1.0, 1.0));
        let (n, dn) = (of_cell.functions(&xi), of_cell.physical_gradients(&xi));
        let x = of_cell.position(&xi, &n);
        let anchors: Vec<[f64; 3]> = numbers.iter().map(|&i| basis.anchor(i as usize)).collect();
        assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        for i in 0..D {
            let moment: f64 = (0..N).map(|a| n[a] * anchors[a][i]).sum();
            assert!((moment - x[i]).abs() < 1e-12, "{family:?} {D} {P1}: {moment} {}", x[i]);
            for j in 0..D {
                let slope: f64 = (0..N).map(|a| dn[a][j] * anchors[a][i]).sum();
                assert!((slope - f64::from(i == j)).abs() < 1e-11, "{family:?} {D} {P1}: {slope}");
            }
        }
        let far: [f64; 3] = from_fn(|i| x.get(i).copied().unwrap_or(0.0));
        let back = basis.local(cell, far);
        (0..D).for_each(|i| assert!((back[i] - xi[i]).abs() < 1e-12));
        assert_eq!(basis.grid().cell_holding(far), Some(cell));
        let (local, h) = (of_cell.gradients(&xi), 1e-5);
        for j in 0..D {
            let moved = |by: f64| of_cell.functions(&from_fn(|i| if i == j { xi[i] + by } else { xi[i] }));
            let (above, below) = (moved(h), moved(-h));
            for a in 0..N {
                let difference = (above[a] - below[a]) / (2.0 * h);
                assert!((difference - local[a][j]).abs() < 1e-8, "{family:?} {D} {P1} {a} {j}");
            }
        }
        // By value the same bits.
        let mut values = Vec::new();
        basis.evaluate(cell, from_fn(|i| xi.get(i).copied().unwrap_or(0.0)), &mut values);
        assert_eq!(values, n);
    }
    assert!(basis.cell::<D, N, P1>(0).is_some());
}

fn renumbered_unless_line(random: &mut Random, mesh: Mesh) -> Mesh {
    if mesh.1[0].0 == Shape::Line2 { mesh } else { renumbered(random, &mesh.0, &mesh.1) }
}

#[test]
fn functions_sum_to_one_and_reproduce_the_position() {
    let mut random = Random(5);
    for family in FAMILIES {
        reproduces_position::<1, 2, 2>(&mut random, family);
        reproduces_position::<1, 3, 3>(&mut random, family);
        reproduces_position::<1, 4, 4>(&mut random, family);
        reproduces_position::<2, 4, 2>(&mut random, family);
        reproduces_position::<2, 9, 3>(&mut random, family);
        reproduces_position::<2, 16, 4>(&mut random, family);
        reproduces_position::<3, 8, 2>(&mut random, family);
        reproduces_position::<3, 27, 3>(&mut random, family);
        reproduces_position::<3, 64, 4>(&mut random, family);
    }
    reproduces_position::<1, 5, 5>(&mut random, Family::Lagrange);
    reproduces_position::<1, 6, 6>(&mut random, Family::Lagrange);
    reproduces_position::<1, 7, 7>(&mut random, Family::Lagrange);
}

#[test]
fn lagrange_functions_are_one_at_their_own_node_and_zero_at_the_others() {
    fn check<const P1: usize>(lines: &[f64]) {
        let basis = basis(line(lines), Family::Lagrange, P1 - 1);
        for cell in 0..lines.len() - 1 {
            for i in basis.functions_of(cell) {
                let values = all::<P1>(&basis, cell, basis.anchor(i as usize)[0]);
                for (j, value) in values.iter().enumerate() {
                    assert!((value - f64::from(j == i as usize)).abs() < 1e-12, "{P1} {i} {j} {value}");
                }
            }
        }
    }
    let lines = uneven(&mut Random(6), 4);
    check::<2>(&lines);
    check::<3>(&lines);
    check::<4>(&lines);
    check::<7>(&lines);
}

/// Cox and de Boor's recurrence on numbers, with a list of knots.
fn cox_de_boor(knots: &[f64], i: usize, q: usize, x: f64) -> f64 {
    if q == 0 {
        return f64::from(knots[i] <= x && x < knots[i + 1]);
    }
    let share = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
    share(x - knots[i], knots[i + q] - knots[i]) * cox_de_boor(knots, i, q - 1, x)
        + share(knots[i + q + 1] - x, knots[i + q + 1] - knots[i + 1]) * cox_de_boor(knots, i + 1, q - 1, x)
}

#[test]
fn splines_are_those_of_the_recurrence_and_join_smoothly() {
    fn check<const P1: usize>(lines: &[f64]) {
        let (degree, cells) = (P1 - 1, lines.len() - 1);
        let basis = basis(line(lines), Family::BSpline, degree);
        let ends = |x: f64| std::iter::repeat_n(x, degree);
        let knots: Vec<f64> = ends(lines[0]).chain(lines.iter().copied()).chain(ends(lines[cells])).collect();
        for cell in 0..cells {
            for part in [0.0, 0.3, 0.9] {
                let x = lines[cell] + part * (lines[cell + 1] - lines[cell]);
                for (i, value) in all::<P1>(&basis, cell, x).into_iter().enumerate() {
                    assert!((value - cox_de_boor(&knots, i, degree, x)).abs() < 1e-13, "{degree} {cell} {i}");
                }
            }
        }
        // Derivatives up to degree − 1 from both sides of a line, by the polynomials' coefficients.
        for cell in 1..cells {
            let jumps = |cell: usize, xi: f64| -> Vec<Vec<f64>> {
                let scale = 2.0 / (lines[cell + 1] - lines[cell]);
                let table = basis.cell::<1, P1, P1>(cell).unwrap().tables[0];
                (0..degree)
                    .map(|order| {
                        let mut all = vec![0.0; basis.len()];
                        for (a, i) in basis.functions_of(cell).enumerate() {
                            let falling = |k: usize| (k + 1 - order..=k).product::<usize>() as f64;
                            all[i as usize] = (order..P1)
                                .map(|k| table[k][a] * falling(k) * xi.powi((k - order) as i32))
                                .sum::<f64>()
                                * scale.powi(order as i32);
                        }
                        all
                    })
                    .collect()
            };
            let (left, right) = (jumps(cell - 1, 1.0), jumps(cell, -1.0));
            for (left, right) in left.iter().flatten().zip(right.iter().flatten()) {
                assert!((left - right).abs() < 1e-11, "{degree} {cell} {left} {right}");
            }
        }
    }
    let mut random = Random(7);
    for cells in [1, 2, 3, 7] {
        let lines = uneven(&mut random, cells);
        check::<2>(&lines);
        check::<3>(&lines);
        check::<4>(&lines);
    }
}

#[test]
fn even_cubic_splines_have_the_textbook_values_and_share_their_tables() {
    let lines: Vec<f64> = (0..=20).map(|i| 100.0 + 0.1 * f64::from(i)).collect();
    let cubic = basis(line(&lines), Family::BSpline, 3);
    let near = |found: &[f64], expected: &[f64]| {
        let close = found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-10);
        assert!(close, "{found:?} {expected:?}");
    };
    // At a line away from the ends 1/6, 2/3, 1/6; in the middle of a cell 1/48, 23/48, 23/48, 1/48.
    near(&all::<4>(&cubic, 10, lines[10])[10..14], &[1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0]);
    let middle = 0.5 * (lines[10] + lines[11]);
    near(&all::<4>(&cubic, 10, middle)[10..14], &[1.0 / 48.0, 23.0 / 48.0, 23.0 / 48.0, 1.0 / 48.0]);
    // The end interpolates; one cell inwards 1/4, 7/12, 1/6.
    near(&all::<4>(&cubic, 0, lines[0])[..4], &[1.0, 0.0, 0.0, 0.0]);
    near(&all::<4>(&cubic, 0, lines[1])[..4], &[0.0, 0.25, 7.0 / 12.0, 1.0 / 6.0]);
    let table = |cell: usize| cubic.cell::<1, 4, 4>(cell).unwrap().tables[0];
    assert!(std::ptr::eq(table(5), table(14)));
    assert!(!std::ptr::eq(table(0), table(1)));
}

#[test]
fn grids_say_why_they_are_not_regular() {
    let axes = [vec![0.0, 1.0, 2.0], vec![0.0, 1.0]];
    let reason = |(coordinates, cells): Mesh| RegularGrid::new(&part(coordinates, &cells)).map(|_| ()).unwrap_err();
    let (mut coordinates, cells) = tensor(&axes);
    coordinates[4][0] += 0.1;
    assert_eq!(reason((coordinates, cells)), Irregular::Skew(1));
    let (coordinates, mut cells) = tensor(&axes);
    cells.push(cells[1].clone());
    assert_eq!(reason((coordinates, cells)), Irregular::Overlap(2, 3));
    let (coordinates, mut cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]]);
    cells[0].1 = vec![0, 2, 5, 3];
    assert_eq!(reason((coordinates, cells)), Irregular::Hanging(1));
    assert_eq!(reason((vec![[0.0; 3]], Vec::new())), Irregular::Empty);
}

#[test]
fn crossings_interpolate_the_anchors_and_see_the_functions() {
    let mut random = Random(8);
    for (family, degree) in [(Family::Lagrange, 2), (Family::BSpline, 2), (Family::BSpline, 3)] {
        let axes = [uneven(&mut random, 4), uneven(&mut random, 2), uneven(&mut random, 1)];
        let (coordinates, cells) = tensor(&axes);
        let (coordinates, cells) = renumbered(&mut random, &coordinates, &cells);
        let part = part(coordinates, &cells);
        let basis = TensorBasis::new(RegularGrid::new(&part).unwrap(), family, degree);
        let nodes = basis.grid().crossings(&part).unwrap();
        let x = |crossing: usize| part.nodes.coordinates[nodes[crossing].unwrap() as usize];
        for function in 0..basis.len() {
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            basis.around_anchor(function, |crossing, weight| {
                (0..3).for_each(|i| sum[i] += weight * x(crossing)[i]);
                weights += weight;
            });
            let anchor = basis.anchor(function);
            (0..3).for_each(|i| assert!((sum[i] - anchor[i]).abs() < 1e-12, "{sum:?} {anchor:?}"));
            assert!((weights - 1.0).abs() < 1e-12);
        }
        for crossing in 0..nodes.len() {
            let mut sum = [0.0; 3];
            basis.at_crossing(crossing, |function, value| {
                (0..3).for_each(|i| sum[i] += value * basis.anchor(function as usize)[i]);
            });
            (0..3).for_each(|i| assert!((sum[i] - x(crossing)[i]).abs() < 1e-12));
        }
        // The corner of the grid is interpolated.
        let mut of_corner = Vec::new();
        basis.at_crossing(0, |function, value| of_corner.push((function, value)));
        assert_eq!(of_corner, [(0, 1.0)]);
    }
}

#[test]
fn doubled_nodes_are_a_slit() {
    let (mut coordinates, mut cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0]]);
    coordinates.push(coordinates[1]);
    cells[1].1[0] = 6;
    let part = part(coordinates, &cells);
    assert_eq!(RegularGrid::new(&part).unwrap().crossings(&part).unwrap_err(), Irregular::Slit(2, 7));
}
