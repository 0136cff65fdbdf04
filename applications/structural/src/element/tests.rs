//! The tangent against differences of the forces, and the forces against differences of the energy.

use super::*;
use bia_constitutive::{ConstitutiveLaw, LameParameters, NeoHookean};
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3, rule};

const STEP: f64 = 1e-6;

/// A number in [−1, 1] that looks random.
fn noise(seed: usize) -> f64 {
    (12.9898 * seed as f64 + 4.1).sin() * 43758.5453 % 1.0
}

struct Sample<const D: usize, const N: usize> {
    kinematics: Kinematics,
    corners: [[f64; D]; N],
    displacements: [[f64; D]; N],
    law: NeoHookean,
}

impl<const D: usize, const N: usize> Sample<D, N> {
    /// A distorted cell away from the axis, displaced at random.
    fn new(kinematics: Kinematics, shape: Shape) -> Self {
        let reference = shape.reference_corners();
        let at = |i: usize, a: usize, scale: f64| scale * noise(7 * i + a + shape.node_count());
        Self {
            kinematics,
            corners: std::array::from_fn(|i| std::array::from_fn(|a| 3.0 + reference[i][a] + at(i, a, 0.1))),
            displacements: std::array::from_fn(|i| std::array::from_fn(|a| at(i + 20, a, 0.12))),
            law: NeoHookean::from_lame(LameParameters { lambda: 3.0, mu: 2.0 }),
        }
    }

    /// Energy, and the buffer with minus the forces and the tangent.
    fn evaluate<S: CellShape<D, N>>(&self, displacements: &[[f64; D]; N]) -> (f64, CellBuffer) {
        let (mut energy, mut buffer) = (0.0, CellBuffer::default());
        buffer.clear(N * D, true);
        for point in rule(S::SHAPE, N).unwrap() {
            let point = Point::<D, N>::new::<S>(&self.corners, &point, self.kinematics, 0.7);
            let deformation = Deformation::from_gradient(point.gradient(self.kinematics, displacements));
            let (stress, tangent) = self.law.stress_and_tangent(&deformation, &mut ()).unwrap();
            energy += point.volume * self.law.energy(&deformation).unwrap();
            point.add_stress(self.kinematics, &deformation, &Response { stress, tangent }, &mut buffer, true);
        }
        (energy, buffer)
    }

    fn check<S: CellShape<D, N>>(&self) {
        let (_, buffer) = self.evaluate::<S>(&self.displacements);
        for j in 0..N {
            for b in 0..D {
                let moved = |by: f64| {
                    let mut displacements = self.displacements;
                    displacements[j][b] += by;
                    self.evaluate::<S>(&displacements)
                };
                let ((more, after), (less, before)) = (moved(STEP), moved(-STEP));
                let force = -(more - less) / (2.0 * STEP);
                let name = S::SHAPE.name();
                assert!(
                    (force - buffer.vector[j * D + b]).abs() < 1e-7,
                    "{name}: force {force} is {:?}",
                    buffer.vector
                );
                for row in 0..N * D {
                    let slope = -(after.vector[row] - before.vector[row]) / (2.0 * STEP);
                    let tangent = buffer.matrix[row * N * D + b * N + j];
                    assert!((slope - tangent).abs() < 1e-6, "{name}, row {row}, node {j}: {slope} is {tangent}");
                }
            }
        }
    }
}

#[test]
fn forces_and_tangent_are_derivatives_of_the_energy() {
    use Kinematics::{Axisymmetric, PlaneStrain, ThreeDimensional, UniaxialStrain};
    Sample::new(UniaxialStrain, Shape::Line2).check::<Line2>();
    for kinematics in [PlaneStrain, Axisymmetric] {
        Sample::new(kinematics, Shape::Triangle3).check::<Triangle3>();
        Sample::new(kinematics, Shape::Quadrilateral4).check::<Quadrilateral4>();
    }
    Sample::new(ThreeDimensional, Shape::Tetrahedron4).check::<Tetrahedron4>();
    Sample::new(ThreeDimensional, Shape::Hexahedron8).check::<Hexahedron8>();
}
