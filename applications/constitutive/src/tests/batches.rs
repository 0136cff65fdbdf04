//! Batches through the object-safe interface: history layout, order, errors, speed.

use bytemuck::{Pod, Zeroable};

use super::*;
use crate::{Fault, LawError, Material, MaterialVariable};

/// A law that only remembers: how often it answered, and the largest F11 it saw.
struct Memory;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Remembered {
    answers: f64,
    largest: [f64; 2],
}

impl ConstitutiveLaw for Memory {
    const NAME: &'static str = "memory";
    const HELP: &'static str = "remembers";
    const VARIABLES: &'static [MaterialVariable] = &[];
    type State = Remembered;

    fn new(_: &Material) -> Result<Self, Fault> {
        Ok(Self)
    }

    fn initial_state(&self) -> Remembered {
        Remembered { answers: 0.0, largest: [-1.0, -2.0] }
    }

    fn stress(&self, deformation: &Deformation, state: &mut Remembered) -> Result<Voigt, LawError> {
        if deformation.pressure.is_none() {
            return Err(LawError::Unsuitable { problem: "needs the nodal pressure", advice: "use a u-p element" });
        }
        state.answers += 1.0;
        for (axis, largest) in state.largest.iter_mut().enumerate() {
            *largest = largest.max(deformation.gradient[(axis, axis)]);
        }
        Ok([state.answers, state.largest[0], deformation.time_step, deformation.previous[(0, 0)], 0.0, 0.0])
    }

    fn stress_and_tangent(&self, d: &Deformation, state: &mut Remembered) -> Result<(Voigt, Tangent), LawError> {
        Ok((self.stress(d, state)?, [[1.0; 6]; 6]))
    }

    fn strain(&self, _: &Deformation) -> Voigt {
        [0.0; 6]
    }

    fn wave_speed(&self, _: f64) -> f64 {
        0.0
    }
}

fn stretched(stretch: f64) -> Deformation {
    let gradient = Matrix3::from_diagonal(&Vector3::new(stretch, 2.0 * stretch, 1.0));
    Deformation { time_step: 0.25, pressure: Some(0.0), ..at(gradient) }
}

#[test]
fn history_is_point_major_and_survives_between_batches() {
    let law: Box<dyn crate::Law> = Box::new(Memory);
    assert_eq!(law.state_len(), 3);
    let mut states = vec![9.0; 9];
    law.initial_state(&mut states);
    assert_eq!(states, [0.0, -1.0, -2.0, 0.0, -1.0, -2.0, 0.0, -1.0, -2.0]);

    let mut out = [Response::default(); 3];
    let batch = [1.5, 2.0, 3.0].map(stretched);
    law.respond(&batch, &mut states, &mut out, Want::Stress).unwrap();
    assert_eq!(states, [1.0, 1.5, 3.0, 1.0, 2.0, 4.0, 1.0, 3.0, 6.0]);
    assert_eq!(out[1].stress, [1.0, 2.0, 0.25, 1.0, 0.0, 0.0]);
    assert_eq!(out[1].tangent, [[0.0; 6]; 6], "only the stress was asked for");

    let batch = [1.0, 4.0, 1.0].map(stretched);
    law.respond(&batch, &mut states, &mut out, Want::StressAndTangent).unwrap();
    assert_eq!(states, [2.0, 1.5, 3.0, 2.0, 4.0, 8.0, 2.0, 3.0, 6.0]);
    assert_eq!(out[2].tangent, [[1.0; 6]; 6]);
    assert_eq!(law.energy(&batch[0]), None);
}

#[test]
fn errors_name_the_point() {
    let law: Box<dyn crate::Law> = Box::new(Memory);
    let mut states = vec![0.0; 9];
    let mut out = [Response::default(); 3];
    let mut batch = [1.5, 2.0, 3.0].map(stretched);
    batch[1].pressure = None;
    let (point, error) = law.respond(&batch, &mut states, &mut out, Want::Stress).unwrap_err();
    assert_eq!(point, 1);
    assert_eq!(error.to_string(), "the law needs the nodal pressure; use a u-p element");
    batch[1] = stretched(f64::INFINITY);
    let failed = law.respond(&batch, &mut states, &mut out, Want::Stress);
    assert_eq!(failed, Err((1, LawError::NonFinite)), "whatever the law itself thinks of it");
}

#[test]
fn laws_without_history_take_empty_states_and_repeat_their_bits() {
    let law: Box<dyn crate::Law> = Box::new(NeoHookean::from_lame(lame(1e6, 0.3)));
    assert_eq!(law.state_len(), 0);
    law.initial_state(&mut []);
    let batch: Vec<Deformation> = samples().into_iter().map(at).collect();
    let mut out = vec![Response::default(); batch.len()];
    law.respond(&batch, &mut [], &mut out, Want::StressAndTangent).unwrap();
    for (answer, f) in out.iter().zip(samples()) {
        assert_eq!(*answer, respond(&*law, &f));
    }
    assert!(law.is_symmetric());
}

/// Prints nanoseconds per point: `cargo test --release -p bia-constitutive speed -- --ignored --nocapture`.
#[test]
#[ignore = "measures time"]
fn speed() {
    let elastic = lame(1e6, 0.3);
    let laws: [(Box<dyn crate::Law>, usize); 3] = [
        (Box::new(NeoHookean::from_lame(elastic)), 0),
        (Box::new(LinearElastic::from_lame(elastic)), 0),
        (Box::new(PlaneStress(NeoHookean::from_lame(elastic))), 1),
    ];
    const POINTS: usize = 256;
    for (law, state_len) in laws {
        let batch: Vec<Deformation> = (0..POINTS)
            .map(|i| at(Matrix3::new(1.0 + 1e-3 * i as f64, 0.1, 0.0, 0.2, 0.9, 0.0, 0.0, 0.0, 1.0)))
            .collect();
        let mut out = vec![Response::default(); POINTS];
        for want in [Want::Stress, Want::StressAndTangent] {
            let mut best = f64::INFINITY;
            for _ in 0..200 {
                let mut states = vec![0.0; POINTS * state_len];
                let start = std::time::Instant::now();
                law.respond(std::hint::black_box(&batch), &mut states, &mut out, want).unwrap();
                std::hint::black_box(&out);
                best = best.min(start.elapsed().as_nanos() as f64 / POINTS as f64);
            }
            println!("{} with {state_len} numbers of state, {want:?}: {best:.1} ns a point", law.name());
        }
    }
}
