//! From the nodes to the points, in three strokes over points in step: the kick changes velocities,
//! the strain deforms points and asks their laws, the drift moves them.

use super::chunk::{Chunk, Opened, open};
use super::sample::{Fields, Grid, Sample, Samples};
use super::strain::Material;
use crate::points::MaterialPoints;
use crate::settings::{Frame, Transfer};
use bia_constitutive::LawError;
use bia_kernel::lanes::{Lanes, Real, WIDTH};
use pulp::Simd;
use rayon::prelude::*;

/// What changes the points in one step.
pub struct Field<'a> {
    /// The grid.
    pub grid: Grid<'a>,
    /// Its fields.
    pub fields: Fields<'a>,
    /// Where functions are evaluated.
    pub frame: Frame,
    /// Time step in seconds.
    pub time_step: f64,
    /// Weight of the new acceleration in the points' velocity.
    pub gamma: f64,
    /// How velocity returns to the points.
    pub transfer: Transfer,
    /// Farthest that a point may move, in metres.
    pub reach: f64,
    /// Deform the points; else their volume and density stay.
    pub compressible: bool,
}

/// What is done with the points, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Strokes {
    /// Deform points and ask their laws for the stress.
    pub strain: bool,
    /// Change velocities.
    pub kick: bool,
    /// Move points.
    pub drift: bool,
}

/// What the strokes found.
#[derive(Debug, Default)]
pub struct Findings {
    /// Largest speed in m/s after a kick.
    pub fastest: f64,
    /// Points that may have left their cell: (block, point).
    pub leavers: Vec<(u32, u32)>,
}

/// Why a run cannot go on, and where.
#[derive(Debug)]
pub struct Trouble {
    /// Block.
    pub block: usize,
    /// Point.
    pub point: usize,
    /// What happened.
    pub cause: Cause,
}

/// What happened to a point.
#[derive(Debug)]
pub enum Cause {
    /// The deformation gradient lost its inverse; its determinant.
    Inverted(f64),
    /// The point moved beyond the reach, or its motion is not finite; the distance in metres.
    Moved(f64),
    /// The law has no answer.
    Law(LawError),
}

/// A point of a chunk, and what happened to it.
pub type AtPoint<T> = Result<T, (usize, Cause)>;

/// What strokes do with one chunk.
#[derive(Default)]
struct OfChunk {
    fastest: f64,
    leavers: Vec<u32>,
}

/// Works on all points, a chunk at a time so that all strokes find it in the cache.
///
/// # Errors
/// The first point that the run breaks down at.
pub fn apply(points: &mut MaterialPoints, field: &Field, strokes: Strokes) -> Result<Findings, Trouble> {
    let mut findings = Findings::default();
    let kinematics = points.kinematics;
    for (index, block) in points.blocks.iter_mut().enumerate() {
        let Opened { law, density, mut chunks } = open(block);
        let material = Material { law, density, kinematics, field };
        let work = |samples: &mut Samples, chunk: &mut Chunk| {
            let mut found = OfChunk::default();
            chunk.warm();
            let samples = samples.take(chunk, &field.grid, &field.fields);
            let worked = match kinematics.dimension() {
                1 => strike::<1>(chunk, samples, &material, strokes, &mut found),
                2 => strike::<2>(chunk, samples, &material, strokes, &mut found),
                _ => strike::<3>(chunk, samples, &material, strokes, &mut found),
            };
            let first = chunk.first;
            worked.map_err(|(point, cause)| Trouble { block: index, point: first + point, cause })?;
            found.leavers.iter_mut().for_each(|point| *point += first as u32);
            Ok(found)
        };
        let of_chunks: Vec<Result<OfChunk, Trouble>> = if rayon::current_num_threads() > 1 {
            chunks.par_iter_mut().map_init(Samples::default, work).collect()
        } else {
            let mut samples = Samples::default();
            chunks.iter_mut().map(|chunk| work(&mut samples, chunk)).collect()
        };
        for found in of_chunks {
            let OfChunk { fastest, leavers } = found?;
            findings.fastest = findings.fastest.max(fastest);
            findings.leavers.extend(leavers.into_iter().map(|point| (index as u32, point)));
        }
    }
    findings.fastest = findings.fastest.sqrt();
    Ok(findings)
}

/// All strokes on one chunk.
fn strike<const D: usize>(
    chunk: &mut Chunk,
    samples: &[Sample],
    material: &Material,
    strokes: Strokes,
    found: &mut OfChunk,
) -> AtPoint<()> {
    let (field, arch) = (material.field, material.field.grid.arch);
    if strokes.strain {
        material.strain::<D>(chunk, samples)?;
    }
    if strokes.kick {
        found.fastest = arch.dispatch(Kick::<D> { chunk, samples, field })?;
    }
    if strokes.drift {
        arch.dispatch(Drift::<D> { chunk, samples, field, leavers: &mut found.leavers })?;
    }
    Ok(())
}

/// |v|² of each lane.
#[inline(always)]
fn squared<S: Simd, const D: usize>(v: &[Lanes<S>; D]) -> Lanes<S> {
    let mut sum = v[0] * v[0];
    for a in 1..D {
        sum += v[a] * v[a];
    }
    sum
}

/// New velocities. Yields the largest squared speed.
struct Kick<'a, 'c, const D: usize> {
    chunk: &'a mut Chunk<'c>,
    samples: &'a [Sample],
    field: &'a Field<'a>,
}

impl<const D: usize> pulp::WithSimd for Kick<'_, '_, D> {
    type Output = AtPoint<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { chunk, samples, field } = self;
        let share = if let Transfer::Flip(share) = field.transfer { share } else { 1.0 };
        let mut fastest = Lanes::splat(simd, 0.0);
        for sample in samples {
            let rows = sample.rows;
            let mut velocity = rows.load::<S, D>(simd, chunk.velocity);
            let mut change = velocity;
            for a in 0..D {
                change[a] = Lanes::load(simd, &sample.acceleration[a]);
                velocity[a] += change[a] * (field.gamma * field.time_step);
            }
            if field.gamma != 1.0 {
                let old = rows.load::<S, D>(simd, chunk.acceleration);
                for a in 0..D {
                    velocity[a] += old[a] * ((1.0 - field.gamma) * field.time_step);
                }
            }
            if share < 1.0 {
                for a in 0..D {
                    let smooth = Lanes::load(simd, &sample.smooth[a]);
                    velocity[a] = velocity[a] * share + smooth * (1.0 - share);
                }
            }
            let speed = squared(&velocity);
            if !speed.all_within(0.0, f64::MAX) {
                let lane = speed.pack().0[..rows.count].iter().position(|speed| !speed.is_finite());
                return Err((rows.first + lane.unwrap_or(0), Cause::Moved(f64::NAN)));
            }
            fastest = fastest.max(speed);
            rows.store(chunk.velocity, &velocity);
            if !chunk.acceleration.is_empty() {
                rows.store(chunk.acceleration, &change);
            }
        }
        Ok(fastest.pack().0.into_iter().fold(0.0, f64::max))
    }
}

/// New positions.
struct Drift<'a, 'c, const D: usize> {
    chunk: &'a mut Chunk<'c>,
    samples: &'a [Sample],
    field: &'a Field<'a>,
    leavers: &'a mut Vec<u32>,
}

impl<const D: usize> pulp::WithSimd for Drift<'_, '_, D> {
    type Output = AtPoint<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { chunk, samples, field, leavers } = self;
        for sample in samples {
            let rows = sample.rows;
            let mut position = rows.load::<S, D>(simd, chunk.position);
            let mut path = position;
            for a in 0..D {
                path[a] = Lanes::load(simd, &sample.carrying[a]) * field.time_step;
                position[a] += path[a];
            }
            let distance = squared(&path);
            if !distance.all_within(0.0, (field.reach * field.reach).min(f64::MAX)) {
                let distances = distance.pack().0;
                let too_far = |distance: &f64| !(*distance <= field.reach * field.reach && distance.is_finite());
                let lane = distances[..rows.count].iter().position(too_far).unwrap_or(0);
                return Err((rows.first + lane, Cause::Moved(distances[lane].sqrt())));
            }
            rows.store(chunk.position, &position);
            if !chunk.displacement.is_empty() {
                let mut displacement = rows.load::<S, D>(simd, chunk.displacement);
                for a in 0..D {
                    displacement[a] += path[a];
                }
                rows.store(chunk.displacement, &displacement);
            }
            if field.frame == Frame::Updated {
                let mut place = [path[0].constant(0.0); 3];
                place[..D].copy_from_slice(&position);
                let holds = sample.cell.map_or([false; WIDTH], |cell| cell.holds(&place));
                if holds != [true; WIDTH] {
                    let out = rows.points().zip(holds).filter(|(_, holds)| !holds);
                    leavers.extend(out.map(|(point, _)| point as u32));
                }
            }
        }
        Ok(())
    }
}
