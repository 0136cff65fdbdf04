//! The tangent of one cell against central differences of its residual, for every stabilisation, law,
//! volumetric law and shape, at large strain in the middle of a dynamic step.

use super::constants::{Constants, element_size};
use super::element::{MixedIntegrator, MixedState, MixedTask, Terms};
use crate::implicit::element::{CellState, Integrator, Rule};
use crate::implicit::kratos_faults::KratosFaults;
use crate::implicit::problem::Inertia;
use crate::points::{Block, compress, gradient_width};
use crate::settings::{ElementSize, Frame, MixedSettings, Stabilization, Variant};
use bia_constitutive::{Kinematics, Law, NeoHookeanMixed, NewtonianFluidMixed, VolumetricLaw};
use bia_kernel::geometry::{CellShape, Hexahedron8, MeshCell, Quadrilateral4, Tetrahedron4, Triangle3};
use bia_kernel::lanes::dispatch;
use bia_kernel::solving::CellBuffer;
use bia_kernel::solving::scheme::Newmark;
use bia_kernel::variables::Column;
use nalgebra::Matrix3;

const POINTS: usize = 3;
const TIME_STEP: f64 = 0.1;

/// Numbers without a pattern, in (−1, 1).
fn noise(seed: usize) -> f64 {
    (12.9898 * (seed + 1) as f64).sin() * 43_758.545_3 % 1.0
}

/// Three deformed points with gravity.
fn block<const D: usize>(law: Box<dyn Law>) -> Block {
    let kinematics = if D == 2 { Kinematics::PlaneStrain } else { Kinematics::ThreeDimensional };
    let mut gradient = Column::new(gradient_width(kinematics), POINTS);
    for point in 0..POINTS {
        let mut f = Matrix3::identity();
        for a in 0..D {
            (0..D).for_each(|b| f[(a, b)] += 0.2 * noise(31 * point + 3 * a + b));
        }
        compress(&f, gradient.row_mut(point));
    }
    let mut local = Column::new(D, POINTS);
    local.values_mut().iter_mut().enumerate().for_each(|(i, xi)| *xi = 0.3 + 0.05 * noise(7 * i));
    let none = Column::default;
    Block {
        body: 0,
        material: 1,
        kinematics,
        law_name: "law".into(),
        law,
        has_energy: false,
        moments: false,
        density: 1.3,
        extent: 1.0,
        starts_stressed: false,
        gravity: [0.4, -0.7, 0.2],
        ids: (0..POINTS as u32).collect(),
        cell: vec![0; POINTS],
        local,
        position: Column::new(D, POINTS),
        mass: Column::repeated(&[0.2], POINTS),
        gradient,
        body_acceleration: none(),
        transfer: none(),
        affine_energy: none(),
        displacement: none(),
        velocity: none(),
        acceleration: none(),
        state: none(),
        stress: none(),
        strain: none(),
        volume: none(),
        pressure: none(),
    }
}

/// One cell with its points.
struct Case<'a, const D: usize, const N: usize> {
    integrator: MixedIntegrator<'a>,
    corners: [[f64; D]; N],
    inertia: &'a Inertia,
}

impl<const D: usize, const N: usize> Case<'_, D, N> {
    /// Residual and, if wanted, tangent at unknowns that stand node by node.
    fn evaluate<S: CellShape<D, N>, const DOFS: usize>(&self, unknowns: &[f64], with_matrix: bool) -> CellBuffer {
        let at = |i: usize| &unknowns[i * DOFS..(i + 1) * DOFS];
        let factor = self.inertia.stiffness();
        let state = MixedState {
            motion: CellState {
                increments: std::array::from_fn(|i| std::array::from_fn(|a| at(i)[a])),
                inertia: std::array::from_fn(|i| std::array::from_fn(|a| factor * at(i)[a])),
            },
            acceleration: std::array::from_fn(|i| std::array::from_fn(|a| factor * at(i)[a])),
            pressures: std::array::from_fn(|i| at(i)[D]),
            projection: std::array::from_fn(|i| std::array::from_fn(|a| noise(100 + D * i + a))),
            size: element_size(ElementSize::Edge, &self.corners),
        };
        let (mut buffer, points) = (CellBuffer::default(), [(0, 0), (0, 1), (0, 2)]);
        buffer.clear(N * DOFS, with_matrix);
        let task = MixedTask::<_, D, N, DOFS> {
            integrator: &self.integrator,
            state: &state,
            points: &points,
            buffer: &mut buffer,
            with_matrix,
            basis: MeshCell::<S, D, N>::new(self.corners),
        };
        dispatch(pulp::Arch::new(), task).unwrap();
        buffer
    }
}

/// Largest difference of the tangent from −∂R/∂x, over the tangent's largest entry.
fn error_of_tangent<S: CellShape<D, N>, const D: usize, const N: usize, const DOFS: usize>(
    corners: [[f64; D]; N],
    law: Box<dyn Law>,
    stabilization: Stabilization,
    variant: Variant,
) -> f64 {
    let blocks = [block::<D>(law)];
    let inertia = Inertia {
        coefficients: Newmark { alpha: -0.1, beta: 0.25 }.coefficients(TIME_STEP),
        alpha: -0.1,
        consistent: true,
        velocity: Vec::new(),
        acceleration: Vec::new(),
    };
    let moduli = blocks[0].law.mixed().unwrap();
    let settings = MixedSettings {
        stabilization,
        variant: Some(variant),
        volumetric: moduli.volumetric,
        c1: 1.5,
        c2: Some(0.7),
        c_t: Some(0.3),
        inertia: Some(true),
        size: ElementSize::Edge,
        volume_correction: 0.0,
    };
    let terms = match (stabilization, variant) {
        (Stabilization::None, _) => Terms::Galerkin,
        (Stabilization::Ppp, Variant::Consistent) => Terms::Projected,
        (Stabilization::Ppp, Variant::Kratos) => Terms::KratosProjected,
        (_, Variant::Consistent) => Terms::Subscales,
        (_, Variant::Kratos) => Terms::KratosSubscales,
    };
    let constants = [Constants::new(&blocks[0], moduli, &settings, variant, Some(&inertia), TIME_STEP)];
    let base = Integrator {
        blocks: &blocks,
        kinematics: blocks[0].kinematics,
        frame: Frame::Updated,
        rule: Rule::EndPoint,
        time_step: TIME_STEP,
        faults: KratosFaults(false),
        consistent_mass: Some(inertia.stiffness()),
    };
    let integrator = MixedIntegrator { base, constants: &constants, terms };
    let case = Case { integrator, corners, inertia: &inertia };
    let unknowns: Vec<f64> = (0..N * DOFS).map(|i| if i % DOFS == D { noise(i) } else { 0.05 * noise(i) }).collect();
    let tangent = case.evaluate::<S, DOFS>(&unknowns, true).matrix;
    let largest = tangent.iter().fold(0.0, |m: f64, k| m.max(k.abs()));
    let step = 1e-6;
    let mut worst = 0.0_f64;
    for column in 0..N * DOFS {
        let moved = |by: f64| {
            let mut unknowns = unknowns.clone();
            unknowns[column] += by;
            case.evaluate::<S, DOFS>(&unknowns, false).vector
        };
        for (row, (after, before)) in moved(step).into_iter().zip(moved(-step)).enumerate() {
            // Columns stand component by component.
            let exact = tangent[row * N * DOFS + column % DOFS * N + column / DOFS];
            worst = worst.max((exact + (after - before) / (2.0 * step)).abs() / largest);
        }
    }
    worst
}

fn laws() -> Vec<Box<dyn Law>> {
    let mut laws: Vec<Box<dyn Law>> = Vec::new();
    for (volumetric, c) in [(VolumetricLaw::Linear, 0.2), (VolumetricLaw::Miehe, 0.2), (VolumetricLaw::Miehe, 0.0)] {
        laws.push(Box::new(NeoHookeanMixed::from_moduli(1.7, c, volumetric)));
        laws.push(Box::new(NewtonianFluidMixed::from_moduli(0.3, c, volumetric)));
    }
    laws
}

fn check<S: CellShape<D, N>, const D: usize, const N: usize, const DOFS: usize>(corners: [[f64; D]; N]) {
    use Stabilization::{Asgs, None, Ppp};
    for stabilization in [None, Ppp, Asgs] {
        for law in laws() {
            let told = format!("{} {stabilization:?} {:?}", law.name(), law.mixed());
            let error = error_of_tangent::<S, D, N, DOFS>(corners, law, stabilization, Variant::Consistent);
            assert!(error < 1e-8, "{told}: {error:e}");
        }
    }
    // Kratos's projection is exact, but the tangent of its subscales is not.
    let law = || Box::new(NeoHookeanMixed::from_moduli(1.7, 0.2, VolumetricLaw::Linear));
    assert!(error_of_tangent::<S, D, N, DOFS>(corners, law(), Ppp, Variant::Kratos) < 1e-8);
    assert!(error_of_tangent::<S, D, N, DOFS>(corners, law(), Asgs, Variant::Kratos) > 1e-3);
}

#[test]
fn tangents_are_derivatives_in_the_plane() {
    check::<Triangle3, 2, 3, 3>([[0.0, 0.1], [1.2, 0.0], [0.3, 0.9]]);
    check::<Quadrilateral4, 2, 4, 3>([[0.0, 0.1], [1.2, 0.0], [1.1, 1.3], [-0.2, 0.9]]);
}

#[test]
fn tangents_are_derivatives_in_space() {
    check::<Tetrahedron4, 3, 4, 4>([[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.3, 0.9, -0.1], [0.2, 0.1, 1.1]]);
    let mut corners = [[0.0; 3]; 8];
    for (i, corner) in corners.iter_mut().enumerate() {
        let base = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i % 4];
        *corner = [base[0] + 0.1 * noise(i), base[1] + 0.1 * noise(i + 8), (i / 4) as f64 + 0.1 * noise(i + 16)];
    }
    check::<Hexahedron8, 3, 8, 4>(corners);
}
