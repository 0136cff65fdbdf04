//! What the body keeps from step to step, to and from checkpoints.

use crate::body::Body;
use crate::boundary::Boundary;
use crate::chunk::{Chunk, Values};
use crate::riemann::{Condition, Trace};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};

impl<const D: usize> Values<D> {
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.slice("velocity", self.velocity.as_flattened_mut())?;
        archive.slice("displacement gradient", self.gradient.as_flattened_mut().as_flattened_mut())?;
        archive.slice("stress", self.stress.as_flattened_mut().as_flattened_mut())
    }
}

impl<const D: usize> Chunk<D> {
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.section("points", |archive| self.points.exchange(archive))?;
        archive.section("nodes", |archive| self.nodes.exchange(archive))?;
        archive.slice("displacement", self.displacement.as_flattened_mut())?;
        archive.slice("impedances", self.impedances.as_flattened_mut().as_flattened_mut())?;
        archive.slice("traced gradients", self.traced_gradients.as_flattened_mut().as_flattened_mut())?;
        archive.number("crossing", &mut self.crossing)
    }
}

impl Boundary {
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let mut moves = self.last.is_some();
        archive.flag("moves", &mut moves)?;
        if moves {
            archive.column("last displacements", self.last.get_or_insert_default())?;
        }
        Ok(())
    }
}

/// Numbers of all traces, one after the other.
fn exchange_traces<const D: usize>(traces: &mut [Trace<D>], archive: &mut Archive) -> Result<(), CheckpointError> {
    let mut numbers: Vec<[f64; D]> = traces.iter().flat_map(|trace| [trace.velocity, trace.traction]).collect();
    archive.slice("traces", numbers.as_flattened_mut())?;
    let pairs = numbers.as_chunks::<2>().0;
    for (trace, &[velocity, traction]) in traces.iter_mut().zip(pairs) {
        *trace = Trace { velocity, traction };
    }
    Ok(())
}

/// What acts on the boundary in the last step tells the size of the next one.
fn exchange_conditions<const D: usize>(
    conditions: &mut [Condition<D>],
    archive: &mut Archive,
) -> Result<(), CheckpointError> {
    let mut held: Vec<[u8; D]> = conditions.iter().map(|condition| condition.held.map(u8::from)).collect();
    let mut numbers: Vec<[f64; D]> =
        conditions.iter().flat_map(|condition| [condition.velocity, condition.traction]).collect();
    archive.slice("held", held.as_flattened_mut())?;
    archive.slice("conditions", numbers.as_flattened_mut())?;
    let pairs = numbers.as_chunks::<2>().0;
    for (condition, (held, &[velocity, traction])) in conditions.iter_mut().zip(held.iter().zip(pairs)) {
        condition.held = held.map(|held| held != 0);
        (condition.velocity, condition.traction) = (velocity, traction);
    }
    Ok(())
}

impl<const D: usize> Body<D> {
    /// Points, what faces see of their cells, and what acts on the boundary.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        for (index, chunk) in self.scheme.chunks.iter_mut().enumerate() {
            archive.section(&format!("chunk {index}"), |archive| chunk.exchange(archive))?;
        }
        exchange_traces(&mut self.scheme.traces, archive)?;
        exchange_conditions(&mut self.scheme.conditions, archive)?;
        archive.number("work of the boundary", &mut self.scheme.work)?;
        self.boundary.exchange(archive)
    }
}
