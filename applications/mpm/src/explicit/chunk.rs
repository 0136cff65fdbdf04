//! Consecutive points of a block with the columns that a step changes: what one thread works on.

use super::rows::prefetch_rows;
use super::to_points::Strokes;
use crate::points::Block;
use bia_constitutive::Law;
use bia_kernel::variables::Column;
use std::ops::Range;

/// Points a thread takes at a time.
const POINTS: usize = 1024;

/// Some consecutive points of a block. Columns that are not used are empty.
pub struct Chunk<'a> {
    /// Index of the first point in the block.
    pub first: usize,
    /// Cells.
    pub cell: &'a [u32],
    /// Local coordinates.
    pub local: &'a [f64],
    /// Mass.
    pub mass: &'a [f64],
    /// Position.
    pub position: &'a mut [f64],
    /// Displacement.
    pub displacement: &'a mut [f64],
    /// Velocity.
    pub velocity: &'a mut [f64],
    /// Acceleration.
    pub acceleration: &'a mut [f64],
    /// Deformation gradient.
    pub gradient: &'a mut [f64],
    /// History of the law.
    pub state: &'a mut [f64],
    /// Stress.
    pub stress: &'a mut [f64],
    /// Strain.
    pub strain: &'a mut [f64],
    /// Volume.
    pub volume: &'a mut [f64],
    /// What the transfer keeps.
    pub transfer: &'a mut [f64],
}

impl Chunk<'_> {
    /// Asks for what strokes will read and write at points.
    pub fn prefetch(&self, points: Range<usize>, strokes: Strokes) {
        let of = |column: &[f64]| prefetch_rows(column, column.len() / self.cell.len().max(1), points.clone());
        of(self.position);
        if strokes.strain {
            [&*self.gradient, &*self.volume, &*self.stress, &*self.strain, self.mass].into_iter().for_each(of);
        }
        if strokes.kick {
            [&*self.velocity, &*self.acceleration].into_iter().for_each(of);
        }
        if strokes.drift {
            of(self.displacement);
        }
    }
}

/// A block taken apart.
pub struct Opened<'a> {
    /// The law of all its points.
    pub law: &'a dyn Law,
    /// Their initial density.
    pub density: f64,
    /// The points.
    pub chunks: Vec<Chunk<'a>>,
}

/// Takes a block apart.
pub fn open(block: &mut Block) -> Opened<'_> {
    let count = block.ids.len();
    let mut position = Parts::of(&mut block.position);
    let mut displacement = Parts::of(&mut block.displacement);
    let mut velocity = Parts::of(&mut block.velocity);
    let mut acceleration = Parts::of(&mut block.acceleration);
    let mut gradient = Parts::of(&mut block.gradient);
    let mut state = Parts::of(&mut block.state);
    let mut stress = Parts::of(&mut block.stress);
    let mut strain = Parts::of(&mut block.strain);
    let mut volume = Parts::of(&mut block.volume);
    let mut transfer = Parts::of(&mut block.transfer);
    let (local, dimension) = (block.local.values(), block.local.width());
    let mass = block.mass.values();
    let chunk = |first: usize| {
        let points = POINTS.min(count - first);
        Chunk {
            first,
            cell: &block.cell[first..first + points],
            local: &local[first * dimension..(first + points) * dimension],
            mass: &mass[first..first + points],
            position: position.take(points),
            displacement: displacement.take(points),
            velocity: velocity.take(points),
            acceleration: acceleration.take(points),
            gradient: gradient.take(points),
            state: state.take(points),
            stress: stress.take(points),
            strain: strain.take(points),
            volume: volume.take(points),
            transfer: transfer.take(points),
        }
    };
    let chunks = (0..count).step_by(POINTS).map(chunk).collect();
    Opened { law: block.law.as_ref(), density: block.density, chunks }
}

/// A column from which parts are taken one after the other.
struct Parts<'a> {
    width: usize,
    rest: &'a mut [f64],
}

impl<'a> Parts<'a> {
    fn of(column: &'a mut Column) -> Self {
        Self { width: column.width(), rest: column.values_mut() }
    }

    fn take(&mut self, points: usize) -> &'a mut [f64] {
        let (part, rest) = std::mem::take(&mut self.rest).split_at_mut(points * self.width);
        self.rest = rest;
        part
    }
}
