use super::*;
use crate::variables::DISPLACEMENT;

/// A grid of 4 × 3 cells of uneven spacing.
fn grid() -> ModelPart {
    let (xs, ys) = ([0.0, 1.0, 1.5, 2.5, 4.0], [0.0, 0.5, 2.0, 3.0]);
    let mut part = ModelPart::new("Background_Grid");
    for y in ys {
        part.nodes.coordinates.extend(xs.map(|x| [x, y, 0.0]));
    }
    part.nodes.ids = (1..=part.nodes.coordinates.len() as u32).collect();
    for j in 0..3u32 {
        for i in 0..4u32 {
            let low = 5 * j + i;
            part.elements.push(
                4 * j + i + 1,
                "Element2D4N",
                Shape::Quadrilateral4,
                0,
                &[low, low + 1, low + 6, low + 5],
            );
        }
    }
    part
}

fn space(grid: &ModelPart, family: Family, degree: usize) -> Space {
    let regular = RegularGrid::new(grid).unwrap();
    let crossings = regular.crossings(grid).unwrap();
    Space::of_tensor(Tensor { basis: TensorBasis::new(regular, family, degree), crossings })
}

const CHOICES: [(Family, usize); 3] = [(Family::Lagrange, 2), (Family::BSpline, 2), (Family::BSpline, 3)];

#[test]
fn fixed_sides_hold_the_functions_that_are_anchored_on_them() {
    let grid = grid();
    for (family, degree) in CHOICES {
        let space = space(&grid, family, degree);
        let fixed: Vec<[bool; 3]> = grid.nodes.coordinates.iter().map(|x| [x[1] == 0.0, x[0] == 4.0, false]).collect();
        for (function, held) in space.held(&fixed).iter().enumerate() {
            let x = space.position(function);
            assert_eq!(*held, [x[1] == 0.0, x[0] == 4.0, false], "{family:?} {degree} {x:?}");
        }
    }
}

#[test]
fn linear_fields_pass_from_nodes_to_functions_and_back() {
    let mut grid = grid();
    for (family, degree) in CHOICES {
        let space = space(&grid, family, degree);
        let coefficients = space.at_anchors(&grid.nodes.coordinates).into_owned();
        for (function, found) in coefficients.iter().enumerate() {
            let exact = space.position(function);
            assert!((0..2).all(|a| (found[a] - exact[a]).abs() < 1e-14), "{found:?} {exact:?}");
        }
        let cells: Vec<u32> = (0..12).collect();
        let dofs = space.active_dofs(&cells, 2);
        assert_eq!(dofs.nodes().len(), space.len());
        let flat: Vec<f64> = coefficients.iter().flat_map(|x| [x[0], x[1]]).collect();
        space.write_field(&mut grid, &dofs, &DISPLACEMENT, &flat);
        let nodal = grid.node_fields.vector(&DISPLACEMENT).unwrap();
        for (found, exact) in nodal.iter().zip(&grid.nodes.coordinates) {
            assert!((0..2).all(|a| (found[a] - exact[a]).abs() < 1e-13), "{found:?} {exact:?}");
        }
    }
}

/// With one active cell, its functions alone have dofs, nodes beyond keep their values, and what is
/// spread keeps its sum.
#[test]
fn inactive_functions_have_no_part() {
    let mut grid = grid();
    for (family, degree) in CHOICES {
        let space = space(&grid, family, degree);
        let dofs = space.active_dofs(&[0], 1);
        assert_eq!(dofs.nodes().len(), (degree + 1).pow(2));
        let count = grid.nodes.len();
        grid.node_fields.vector_mut(&DISPLACEMENT, count).fill([7.0; 3]);
        space.write_field(&mut grid, &dofs, &DISPLACEMENT, &vec![1.0; dofs.order()]);
        let nodal = grid.node_fields.vector(&DISPLACEMENT).unwrap();
        for (node, value) in nodal.iter().enumerate() {
            let of_cell = grid.elements.nodes_of(0).contains(&(node as u32));
            assert!((value[0] - if of_cell { 1.0 } else { 7.0 }).abs() < 1e-14, "{family:?} {degree} {node}");
        }
        let mut sums = vec![0.0; dofs.nodes().len()];
        space.spread(&dofs, |number, _, share| sums[number] += share);
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-14));
    }
}
