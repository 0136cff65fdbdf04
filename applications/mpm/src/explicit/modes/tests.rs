//! Modes against the functions that they stand for.

use super::*;
use bia_kernel::geometry::{
    CellBasis, Family, Hexahedron8, Line2, Quadrilateral4, RegularGrid, Shape, TensorBasis, Tetrahedron4, Triangle3,
};
use bia_kernel::model::ModelPart;

/// Modes at points of a cell against its functions and gradients.
fn modes_are_functions<B: CellBasis<D, N> + Modes<D, N>, const D: usize, const N: usize>(basis: &B) {
    let field: [f64; N] = std::array::from_fn(|i| 1.0 + (3.7 * i as f64).sin());
    for seed in 0..5 {
        let xi: [f64; D] = std::array::from_fn(|d| (0.9 + 1.3 * seed as f64 + 2.1 * d as f64).cos());
        let (functions, gradients) = (basis.functions(&xi), basis.gradients(&xi));
        let at = basis.at(&xi);
        let mut coefficients = field;
        B::expand(&mut coefficients);
        let packs = coefficients.map(|c| {
            let mut pack = Pack([0.0; 8]);
            (2..2 + D).for_each(|a| pack.0[a] = c * B::SCALE);
            pack
        });
        let value: f64 = (0..N).map(|i| functions[i] * field[i]).sum();
        assert!((B::vector(&at, &packs, 2)[D - 1] - value).abs() < 1e-14);
        for (c, slope) in B::gradient(&at, &packs, 2)[D - 1].into_iter().enumerate() {
            let expected: f64 = (0..N).map(|i| gradients[i][c] * field[i]).sum();
            assert!((slope - expected).abs() < 1e-14, "{slope} {expected}");
        }
        sums_are_those_of_functions(basis, &xi, &functions, &gradients);
    }
}

/// Sums at the nodes of a point in the first lane.
fn sums_are_those_of_functions<B: Modes<D, N>, const D: usize, const N: usize>(
    basis: &B,
    xi: &[f64; D],
    functions: &[f64; N],
    gradients: &[[f64; D]; N],
) {
    let simd = pulp::Scalar::new();
    let lane = |value: f64| Lanes::splat(simd, value);
    let at = basis.at(&xi.map(lane));
    let (weight, pull): ([f64; D], [[f64; D]; D]) = (
        std::array::from_fn(|a| 1.5 + a as f64),
        std::array::from_fn(|a| std::array::from_fn(|c| (1.0 + a as f64) * (0.3 - c as f64))),
    );
    let load = Load {
        mass: lane(0.7),
        momentum: weight.map(|w| lane(3.0 * w)),
        weight: weight.map(lane),
        pull: pull.map(|row| row.map(lane)),
        hoop: lane(0.0),
    };
    let mut sums = B::sums(simd, &at, &load, Wanted::Both);
    for k in 0..1 + 2 * D {
        let mut column = sums.map(|pack| pack.0[k]);
        B::collect(&mut column);
        (0..N).for_each(|i| sums[i].0[k] = column[i] * B::SCALE);
    }
    for i in 0..N {
        assert!((sums[i].0[0] - 0.7 * functions[i]).abs() < 1e-14);
        for a in 0..D {
            let pull: f64 = (0..D).map(|c| pull[a][c] * gradients[i][c]).sum();
            assert!((sums[i].0[1 + a] - 3.0 * weight[a] * functions[i]).abs() < 1e-14);
            assert!((sums[i].0[1 + D + a] - (weight[a] * functions[i] - pull)).abs() < 1e-14);
        }
    }
}

#[test]
fn modes_of_mesh_cells_are_their_functions() {
    modes_are_functions(&MeshCell::<Line2, 1, 2>::new([[0.0; 1]; 2]));
    modes_are_functions(&MeshCell::<Triangle3, 2, 3>::new([[0.0; 2]; 3]));
    modes_are_functions(&MeshCell::<Quadrilateral4, 2, 4>::new([[0.0; 2]; 4]));
    modes_are_functions(&MeshCell::<Tetrahedron4, 3, 4>::new([[0.0; 3]; 4]));
    modes_are_functions(&MeshCell::<Hexahedron8, 3, 8>::new([[0.0; 3]; 8]));
}

/// A grid of two cells along each axis, of uneven size.
fn grid<const D: usize>() -> ModelPart {
    let lines = [0.0, 1.0, 2.5];
    let mut part = ModelPart::new("Background_Grid");
    for place in 0..3usize.pow(D as u32) {
        part.nodes.ids.push(place as u32 + 1);
        part.nodes
            .coordinates
            .push(std::array::from_fn(|d| if d < D { lines[place / 3usize.pow(d as u32) % 3] } else { 0.0 }));
    }
    let shape = [Shape::Line2, Shape::Quadrilateral4, Shape::Hexahedron8][D - 1];
    for cell in 0..2u32.pow(D as u32) {
        let node = |corner: &[f64]| {
            let index =
                |(d, x): (usize, &f64)| (cell / 2u32.pow(d as u32) % 2 + u32::from(*x > 0.0)) * 3u32.pow(d as u32);
            corner.iter().enumerate().map(index).sum()
        };
        let nodes: Vec<u32> = shape.reference_corners().iter().map(|corner| node(&corner[..D])).collect();
        part.elements.push(cell + 1, "Element", shape, 0, &nodes);
    }
    part
}

#[test]
fn modes_of_regular_grids_are_their_functions() {
    fn check<const D: usize, const N: usize, const P1: usize>() {
        for family in [Family::BSpline, Family::Lagrange] {
            let basis = TensorBasis::new(RegularGrid::new(&grid::<D>()).unwrap(), family, P1 - 1);
            for cell in 0..2 {
                modes_are_functions(&basis.cell::<D, N, P1>(cell).unwrap());
            }
        }
    }
    check::<1, 4, 4>();
    check::<2, 9, 3>();
    check::<3, 27, 3>();
    check::<3, 64, 4>();
}
