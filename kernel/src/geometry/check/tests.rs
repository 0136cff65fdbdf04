use super::super::testing::{part, tensor};
use super::*;

fn faults(coordinates: &[[f64; 3]], shape: Shape, nodes: &[u32]) -> Vec<CellFault> {
    let part = part(coordinates.to_vec(), &[(shape, nodes.to_vec())]);
    let plane = coordinates.iter().all(|x| x[2] == 0.0);
    check_cells(&part, &part.elements, if plane { 2 } else { 3 })
}

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];

#[test]
fn good_cells_have_no_fault_and_mirrored_ones_do_in_every_shape() {
    for shape in [Shape::Triangle3, Shape::Quadrilateral4, Shape::Tetrahedron4, Shape::Hexahedron8] {
        let corners = shape.reference_corners();
        let order: Vec<u32> = (0..corners.len() as u32).collect();
        assert_eq!(faults(corners, shape, &order), []);
        let mirrored: Vec<u32> = match shape {
            Shape::Triangle3 => vec![0, 2, 1],
            Shape::Quadrilateral4 => vec![0, 3, 2, 1],
            Shape::Tetrahedron4 => vec![0, 2, 1, 3],
            _ => vec![4, 5, 6, 7, 0, 1, 2, 3],
        };
        let found = faults(corners, shape, &mirrored);
        let [fault @ CellFault::Inverted { id: 1, measure, .. }] = &found[..] else { panic!("{shape:?}: {found:?}") };
        assert!((measure + shape.reference_measure()).abs() < 1e-14, "{shape:?}");
        // The advice names the order that undoes the mirroring.
        let advice: String = mirrored.iter().map(|a| format!(" {}", a + 1)).collect();
        assert!(fault.to_string().ends_with(&advice), "{fault}");
        assert!(fault.to_string().starts_with(&format!("Element{} 1 is inside out", shape.name())), "{fault}");
    }
}

#[test]
fn bow_ties_and_re_entrant_corners_are_folded() {
    let bow_tie = faults(&SQUARE, Shape::Quadrilateral4, &[0, 1, 3, 2]);
    assert!(matches!(bow_tie[..], [CellFault::Folded { smallest, .. }] if smallest < 0.0), "{bow_tie:?}");
    let mut dart = SQUARE;
    dart[2] = [0.5, 0.5, 0.0];
    let dart = faults(&dart, Shape::Quadrilateral4, &[0, 1, 2, 3]);
    assert!(matches!(dart[..], [CellFault::Folded { measure, .. }] if measure > 0.0), "{dart:?}");
    let (coordinates, _) = tensor(&[vec![0.0, 1.0], vec![0.0, 1.0], vec![0.0, 1.0]]);
    // The tensor product numbers nodes across, not around: the classical mistake.
    let hexahedron = faults(&coordinates, Shape::Hexahedron8, &[0, 1, 2, 3, 4, 5, 6, 7]);
    assert!(matches!(hexahedron[..], [CellFault::Folded { .. }]), "{hexahedron:?}");
}

#[test]
fn flat_cells_and_repeated_nodes_are_reported() {
    let mut line = SQUARE;
    line[2] = [1.0, 0.0, 0.0];
    let flat = faults(&line, Shape::Triangle3, &[0, 2, 1]);
    assert!(matches!(flat[..], [CellFault::Degenerate { id: 1, measure: 0.0, .. }]), "{flat:?}");
    let twice = faults(&SQUARE, Shape::Quadrilateral4, &[0, 1, 1, 3]);
    let [fault @ CellFault::RepeatedNode { node: 2, .. }] = &twice[..] else { panic!("{twice:?}") };
    assert_eq!(fault.to_string(), "ElementQuadrilateral4 1 has node 2 twice: a Quadrilateral4 has 4 different nodes");
    let flat = faults(&[[0.0, 1.0, 2.0]; 4], Shape::Tetrahedron4, &[0, 1, 2, 3]);
    assert!(matches!(flat[..], [CellFault::Degenerate { .. }]), "{flat:?}");
}

#[test]
fn thin_cells_are_no_fault_and_surfaces_in_space_have_no_sign() {
    let mut thin = SQUARE;
    thin.iter_mut().for_each(|x| x[1] *= 1e-6);
    assert_eq!(faults(&thin, Shape::Quadrilateral4, &[0, 1, 2, 3]), []);
    let mut wall = SQUARE;
    wall.iter_mut().for_each(|x| x[2] = 1.0);
    assert_eq!(faults(&wall, Shape::Quadrilateral4, &[3, 2, 1, 0]), []);
    assert_eq!(faults(&wall, Shape::Triangle3, &[2, 1, 0]), []);
    assert_eq!(faults(&wall, Shape::Line2, &[1, 0]), []);
    let short = faults(&[[0.0; 3], [0.0; 3]], Shape::Line2, &[0, 1]);
    assert!(matches!(short[..], [CellFault::Degenerate { .. }]), "{short:?}");
}

#[test]
fn blocks_are_judged_as_their_distorted_likes() {
    // Slanted, and with one corner moved: by nothing, by little, so far that the cell folds, to nowhere.
    let block = |shift: f64| -> Vec<[f64; 3]> {
        let slanted = |x: &[f64; 3]| [x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], x[2] + 0.1 * x[0]];
        let mut corners: Vec<[f64; 3]> = Shape::Hexahedron8.reference_corners().iter().map(slanted).collect();
        corners[6][2] -= shift;
        corners
    };
    let nodes = [0, 1, 2, 3, 4, 5, 6, 7];
    for sound in [0.0, 1e-12, 1e-3, 0.5] {
        assert_eq!(faults(&block(sound), Shape::Hexahedron8, &nodes), []);
    }
    assert!(matches!(faults(&block(4.0), Shape::Hexahedron8, &nodes)[..], [CellFault::Folded { .. }]));
    assert!(matches!(faults(&block(f64::NAN), Shape::Hexahedron8, &nodes)[..], [CellFault::Degenerate { .. }]));
    let flat: Vec<[f64; 3]> = block(0.0).iter().map(|x| [x[0], x[1], 1e-13 * x[2]]).collect();
    assert!(matches!(faults(&flat, Shape::Hexahedron8, &nodes)[..], [CellFault::Degenerate { .. }]));
}
