//! The stable step of central differences: 2 / ω of the stiffest single element, below which the
//! whole body is stable (Belytschko et al., §6.6). The present tangent decides, so that a body that
//! stiffens under compression gets the smaller steps that it needs.

use crate::problem::{Step, Tangent};
use bia_kernel::error::Failure;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::solving::CellBuffer;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Most steps between two evaluations, where the stable step hardly changes.
const LONGEST: usize = 16;
/// Relative change of the stable step that does not call for another evaluation at once.
const STEADY: f64 = 1e-3;

/// The stable step, evaluated as often as its changes ask for.
#[derive(Default)]
pub struct Stability {
    /// The stable step in seconds.
    step: f64,
    /// The element that limits it.
    pub element: usize,
    age: usize,
    interval: usize,
}

impl Stability {
    /// Saves or loads the last evaluation and when the next one is due.
    ///
    /// # Errors
    /// The checkpoint does not hold them.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.number("step", &mut self.step)?;
        archive.count("element", &mut self.element)?;
        archive.count("age", &mut self.age)?;
        archive.count("interval", &mut self.interval)
    }

    /// The last evaluation in seconds, if there was one and the body has stiffness.
    pub fn last(&self) -> Option<f64> {
        (self.step > 0.0 && self.step.is_finite()).then_some(self.step)
    }

    /// The stable step in seconds before the run, if the body has stiffness.
    pub fn at_first(step: &Step, displacements: &[f64]) -> Option<f64> {
        let (stable, _) = stable_step(step, displacements).ok()?;
        stable.is_finite().then_some(stable)
    }

    /// The stable step in seconds at these displacements; infinite without stiffness.
    ///
    /// # Errors
    /// An element turned inside out, or a law without an answer.
    pub fn update(&mut self, step: &Step, displacements: &[f64]) -> Result<f64, Failure> {
        self.age += 1;
        if self.age <= self.interval {
            return Ok(self.step);
        }
        let (stable, element) = stable_step(step, displacements)?;
        let steady = (stable / self.step - 1.0).abs() < STEADY;
        let interval = if steady { (2 * self.interval).min(LONGEST) } else { 1 };
        *self = Self { step: stable, element, age: 0, interval };
        Ok(stable)
    }
}

fn stable_step(step: &Step, displacements: &[f64]) -> Result<(f64, usize), Failure> {
    let elements = 0..step.part.elements.len();
    let frequencies: Vec<f64> = elements
        .into_par_iter()
        .map_init(CellBuffer::default, |buffer, element| squared_frequency(step, element, displacements, buffer))
        .collect::<Result<_, Failure>>()?;
    let stiffest = (0..frequencies.len()).max_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b])).unwrap_or(0);
    let most = frequencies.get(stiffest).copied().unwrap_or(0.0);
    Ok((if most > 0.0 { 2.0 / most.sqrt() } else { f64::INFINITY }, stiffest))
}

/// Largest eigenvalue of M⁻¹ K of an element with its lumped mass, in 1/s².
fn squared_frequency(
    step: &Step,
    element: usize,
    displacements: &[f64],
    buffer: &mut CellBuffer,
) -> Result<f64, Failure> {
    let (nodes, block) = (step.part.elements.nodes_of(element).len(), step.dofs.block());
    let size = nodes * block;
    buffer.clear(size, true);
    step.element_body(element, |_| [1.0; 3], buffer);
    let mass = buffer.vector.clone();
    step.element(element, displacements, &[], Tangent { stiffness: true, mass: None }, buffer)?;
    // Columns are sorted by component, then node; rows by node, then component.
    let place = |row: usize, column: usize| row * size + (column % block) * nodes + column / block;
    let entry = |i: usize, j: usize| {
        let both = buffer.matrix[place(i, j)] + buffer.matrix[place(j, i)];
        0.5 * both / (mass[i] * mass[j]).sqrt()
    };
    let scaled = DMatrix::from_fn(size, size, entry);
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return Ok(f64::INFINITY);
    }
    Ok(scaled.symmetric_eigenvalues().iter().copied().fold(0.0, f64::max))
}
