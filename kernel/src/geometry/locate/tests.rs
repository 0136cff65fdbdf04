use super::super::testing::{Mesh, Random, part, position, renumbered, simplices, tensor};
use super::super::{Shape, local_coordinates};
use super::*;

const TOLERANCE: f64 = 1e-5;

/// The rules, word by word, over all cells.
fn by_the_rules(part: &ModelPart, x: [f64; 3], hint: Option<u32>) -> Option<(u32, [f64; 3])> {
    let cells = &part.elements;
    let inside = |cell: usize| {
        let xi = local_coordinates(cells.shapes[cell], &part.corners(cells, cell), x)?;
        cells.shapes[cell].contains(xi, TOLERANCE).then_some((cell as u32, xi))
    };
    if let Some(hint) = hint {
        let nodes = cells.nodes_of(hint as usize);
        let touches = |cell: &usize| cells.nodes_of(*cell).iter().any(|node| nodes.contains(node));
        let found = inside(hint as usize).or_else(|| (0..cells.len()).filter(touches).find_map(inside));
        if found.is_some() {
            return found;
        }
    }
    (0..cells.len()).find_map(inside)
}

/// A random point of a random cell: inside, on a face, edge or corner, or just outside of it.
fn random_point(random: &mut Random, part: &ModelPart) -> [f64; 3] {
    let cell = random.below(part.elements.len());
    let shape = part.elements.shapes[cell];
    let mut xi = random.inside(shape);
    for i in 0..shape.dimension() {
        let low = if shape.reference_corners()[0][0] < 0.0 { -1.0 } else { 0.0 };
        match random.below(6) {
            0 => xi[i] = low,
            1 => xi[i] = low - 0.5 * TOLERANCE,
            2 if low < 0.0 => xi[i] = 1.0,
            3 if low < 0.0 => xi[i] = 1.0 + 0.5 * TOLERANCE,
            _ => {}
        }
    }
    if random.below(10) == 0 {
        xi[0] += 3.0;
    }
    position(shape, &part.corners(&part.elements, cell), xi)
}

/// Compares the locator, and the general search on the same mesh, with the rules.
fn agrees(random: &mut Random, (coordinates, cells): Mesh, regular: bool) {
    let part = part(coordinates, &cells);
    let locator = CellLocator::new(&part, TOLERANCE);
    assert_eq!(locator.is_regular(), regular, "{}", locator.describe());
    let general = CellLocator::general(&part, SearchMesh::new(&part, &part.elements, TOLERANCE));
    let mut outside = 0;
    for trial in 0..3000 {
        let x = random_point(random, &part);
        let hint = match trial % 3 {
            0 => None,
            1 => Some(random.below(cells.len()) as u32),
            // A neighbour of the cell where the point is.
            _ => by_the_rules(&part, x, None).map(|(cell, _)| {
                let node = part.elements.nodes_of(cell as usize)[0];
                let around = |c: &u32| part.elements.nodes_of(*c as usize).contains(&node);
                (0..cells.len() as u32).rev().find(around).unwrap_or(cell)
            }),
        };
        let expected = by_the_rules(&part, x, hint);
        outside += usize::from(expected.is_none());
        for found in [locator.locate(x, hint), general.locate(x, hint)] {
            assert_eq!(found.map(|f| f.0), expected.map(|e| e.0), "{x:?} {hint:?} {}", locator.describe());
            if let (Some((_, xi)), Some((_, reference))) = (found, expected) {
                assert!((0..3).all(|i| (xi[i] - reference[i]).abs() < 1e-12), "{xi:?} {reference:?}");
            }
        }
    }
    assert!(outside > 0 && outside < 1000, "{outside} of the points outside: no good sample");
}

fn axis(random: &mut Random, cells: usize, uniform: bool) -> Vec<f64> {
    let mut line = vec![random.within(-1.0, 1.0)];
    for i in 0..cells {
        let step = if uniform { 0.1 } else { random.within(0.02, 0.3) };
        line.push(if uniform { line[0] + 0.1 * (i + 1) as f64 } else { line[i] + step });
    }
    line
}

fn grid(random: &mut Random, cells: &[usize], uniform: bool) -> Mesh {
    let axes: Vec<_> = cells.iter().map(|&n| axis(random, n, uniform)).collect();
    tensor(&axes)
}

#[test]
fn regular_grids_in_any_numbering_with_and_without_holes() {
    let mut random = Random(21);
    for uniform in [true, false] {
        for counts in [&[7, 5][..], &[1, 9], &[4, 3, 5], &[1, 1, 6]] {
            let (coordinates, cells) = grid(&mut random, counts, uniform);
            agrees(&mut random, (coordinates.clone(), cells.clone()), true);
            let (coordinates, mut cells) = renumbered(&mut random, &coordinates, &cells);
            agrees(&mut random, (coordinates.clone(), cells.clone()), true);
            cells.truncate(cells.len() * 2 / 3);
            agrees(&mut random, (coordinates, cells), true);
        }
    }
}

#[test]
fn coordinates_with_few_digits_are_still_a_regular_grid() {
    let mut random = Random(22);
    for counts in [&[7, 5][..], &[4, 3, 5]] {
        let (mut coordinates, cells) = grid(&mut random, counts, false);
        for x in &mut coordinates {
            (0..counts.len()).for_each(|i| x[i] += random.within(-2e-11, 2e-11));
        }
        agrees(&mut random, (coordinates, cells), true);
    }
}

#[test]
fn doubled_nodes_separate_neighbours() {
    // Two blocks that touch along x = 1 without common nodes: the hint's neighbours end there.
    let mut random = Random(23);
    let (mut coordinates, mut cells) = tensor(&[vec![1.0, 1.5, 2.0], vec![0.0, 0.5, 1.0]]);
    let (left, left_cells) = tensor(&[vec![0.0, 0.5, 1.0], vec![0.0, 0.5, 1.0]]);
    let shift = coordinates.len() as u32;
    coordinates.extend(left);
    cells.extend(left_cells.into_iter().map(|(shape, nodes)| (shape, nodes.iter().map(|n| n + shift).collect())));
    agrees(&mut random, (coordinates, cells), true);
}

#[test]
fn distorted_mixed_and_simplex_meshes() {
    let mut random = Random(24);
    for counts in [&[7, 5][..], &[4, 3, 3]] {
        let (mut coordinates, cells) = grid(&mut random, counts, true);
        agrees(&mut random, (coordinates.clone(), simplices(&cells)), false);
        for x in &mut coordinates {
            (0..counts.len()).for_each(|i| x[i] += random.within(-0.015, 0.015));
        }
        agrees(&mut random, (coordinates.clone(), cells.clone()), false);
        let mut mixed = simplices(&cells[..cells.len() / 2]);
        if counts.len() == 2 {
            mixed.extend_from_slice(&cells[cells.len() / 2..]);
        }
        let (coordinates, mixed) = renumbered(&mut random, &coordinates, &mixed);
        agrees(&mut random, (coordinates, mixed), false);
    }
}

#[test]
fn bins_hold_the_points_within_the_tolerance_outside_of_a_cell() {
    let (mut random, tolerance) = (Random(28), 0.2);
    for counts in [&[7, 5][..], &[4, 3, 5]] {
        let (mut coordinates, cells) = grid(&mut random, counts, true);
        for x in &mut coordinates {
            (0..counts.len()).for_each(|i| x[i] += random.within(-0.02, 0.02));
        }
        for cells in [simplices(&cells), cells] {
            let part = part(coordinates.clone(), &cells);
            let bins = Bins::new(&SearchMesh::new(&part, &part.elements, tolerance));
            for _ in 0..2000 {
                let cell = random.below(cells.len());
                let shape = cells[cell].0;
                let mut xi = random.inside(shape);
                let i = random.below(shape.dimension());
                xi[i] = if shape.is_affine() { -tolerance } else { 1.0 + tolerance };
                let x = position(shape, &part.corners(&part.elements, cell), xi);
                assert!(bins.candidates(x).contains(&(cell as u32)), "{shape:?} {cell} {xi:?}");
            }
        }
    }
}

#[test]
fn graded_meshes_crowd_their_bins_and_are_searched_around_the_hint() {
    let mut random = Random(27);
    let graded: Vec<f64> = (0..14).map(|i| 1.7f64.powi(i) - 1.0).collect();
    let (coordinates, cells) = tensor(&[graded.clone(), graded]);
    let mesh = (coordinates, simplices(&cells));
    let locator = CellLocator::new(&part(mesh.0.clone(), &mesh.1), TOLERANCE);
    let Search::General { bins, .. } = &locator.search else { panic!("not a regular grid") };
    assert!(bins.candidates([0.5, 0.5, 0.0]).len() > 50, "{}", locator.describe());
    agrees(&mut random, mesh, false);
}

#[test]
fn grids_with_hanging_nodes_or_cells_twice_are_not_regular() {
    let mut random = Random(25);
    let (coordinates, mut cells) = grid(&mut random, &[4, 4], true);
    cells.push(cells[5].clone());
    agrees(&mut random, (coordinates, cells), false);
    let (mut coordinates, mut cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0]]);
    let (fine, fine_cells) = tensor(&[vec![2.0, 2.5, 3.0], vec![0.0, 0.5, 1.0]]);
    let shift = coordinates.len() as u32;
    coordinates.extend(fine);
    cells.extend(fine_cells.into_iter().map(|(shape, nodes)| (shape, nodes.iter().map(|n| n + shift).collect())));
    agrees(&mut random, (coordinates, cells), false);
}

#[test]
fn a_point_on_a_face_stays_with_its_hint_and_else_takes_the_lowest_cell() {
    let (coordinates, cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0]]);
    let locator = CellLocator::new(&part(coordinates, &cells), TOLERANCE);
    let on_face = [1.0, 0.25, 0.0];
    assert_eq!(locator.locate(on_face, None), Some((0, [1.0, -0.5, 0.0])));
    assert_eq!(locator.locate(on_face, Some(1)), Some((1, [-1.0, -0.5, 0.0])));
    assert_eq!(locator.locate(on_face, Some(77)), Some((0, [1.0, -0.5, 0.0])));
    // The local cell is 2 wide: the tolerance reaches h t / 2 beyond the face.
    for (beyond, cell) in [(0.49 * TOLERANCE, 0), (0.51 * TOLERANCE, 1)] {
        assert_eq!(locator.locate([1.0 + beyond, 0.5, 0.0], Some(0)).map(|f| f.0), Some(cell));
        assert_eq!(locator.locate([2.0 + beyond, 0.5, 0.0], Some(1)).is_some(), cell == 0);
    }
}

#[test]
fn strange_points_and_empty_meshes_are_not_found() {
    let (coordinates, cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0], vec![0.0, 1.0]]);
    for cells in [cells.clone(), simplices(&cells), Vec::new()] {
        let locator = CellLocator::new(&part(coordinates.clone(), &cells), TOLERANCE);
        for v in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
            for hint in [None, Some(0)] {
                assert_eq!(locator.locate([v; 3], hint), None);
                assert_eq!(locator.locate([0.5, v, 0.5], hint), None);
            }
        }
    }
}

/// A point just across a face stays where it was, unless it is asked for inside; beyond the mesh there is
/// no other cell for it.
#[test]
fn a_point_just_outside_changes_its_cell_when_it_must_lie_inside() {
    let across = 1.0 + 0.1 * TOLERANCE;
    for shear in [0.0, 0.3] {
        let (mut coordinates, cells) = tensor(&[vec![0.0, 1.0, 2.0], vec![0.0, 1.0]]);
        coordinates.iter_mut().for_each(|x| x[1] += shear * x[0]);
        let locator = CellLocator::new(&part(coordinates, &cells), TOLERANCE);
        assert_eq!(locator.is_regular(), shear == 0.0);
        let x = [across, 0.5 + shear * across, 0.0];
        assert_eq!(locator.locate(x, Some(0)).map(|found| found.0), Some(0));
        let (cell, xi) = locator.locate_inside(x, Some(0)).unwrap();
        assert!(cell == 1 && xi[0] >= -1.0 && xi[0] < -0.99, "{cell} {xi:?}");
        let edge = [-0.1 * TOLERANCE, 0.5, 0.0];
        assert_eq!(locator.locate_inside(edge, Some(0)).map(|found| found.0), Some(0));
        assert_eq!(locator.locate_inside([-0.1, 0.5, 0.0], Some(0)), None);
    }
}

#[test]
fn cells_of_fewer_dimensions_hold_no_points() {
    let (coordinates, mut cells) = tensor(&[vec![0.0, 1.0], vec![0.0, 1.0]]);
    cells.insert(0, (Shape::Line2, vec![0, 1]));
    let locator = CellLocator::new(&part(coordinates, &cells), TOLERANCE);
    assert_eq!(locator.locate([0.5, 0.0, 0.0], Some(0)).map(|f| f.0), Some(1));
    assert_eq!(locator.locate([0.5, 0.0, 0.0], None).map(|f| f.0), Some(1));
}

#[test]
fn long_thin_and_scattered_cells_keep_the_lists_short() {
    // Needles across the whole domain, and two distant clusters.
    let mut random = Random(26);
    let (mut coordinates, mut cells) = (Vec::new(), Vec::new());
    for i in 0..3000u32 {
        let origin = if i % 2 == 0 { [0.0, 0.0] } else { [1e4, 1e4] };
        let [x, y] = origin.map(|o| o + random.within(0.0, 10.0));
        let far = if i < 30 { 1e4 } else { 0.1 };
        coordinates.extend([[x, y, 0.0], [x + far, y + far, 0.0], [x, y + 0.1, 0.0]]);
        cells.push((Shape::Triangle3, vec![3 * i, 3 * i + 1, 3 * i + 2]));
    }
    let locator = CellLocator::new(&part(coordinates, &cells), TOLERANCE);
    let Search::General { bins, .. } = &locator.search else { panic!("not a regular grid") };
    let (counts, average) = bins.statistics();
    assert!(average * counts.iter().product::<usize>() as f64 <= 33.0 * 3000.0, "{}", locator.describe());
}

#[test]
fn locators_are_shared_between_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<CellLocator>();
}
