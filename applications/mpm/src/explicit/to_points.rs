//! From the nodes to the points, in three strokes over points in step: the kick changes velocities,
//! the strain deforms points and asks their laws, the drift moves them.

use super::chunk::{Chunk, Opened, open};
use super::rows::AHEAD;
use super::rows::Rows;
use super::sample::{Fields, Grid, Records, Sample, Samples};
use super::strain::{Batch, Material};
use crate::points::MaterialPoints;
use crate::settings::{Frame, Transfer};
use bia_constitutive::LawError;
use bia_constitutive::tensor::Tensor;
use bia_kernel::lanes::{Lanes, Pack, Real, WIDTH, dispatch};
use pulp::Simd;
use rayon::prelude::*;

/// What changes the points in one step.
pub struct Field<'a> {
    /// The grid.
    pub grid: Grid<'a>,
    /// Its fields.
    pub fields: Fields<'a>,
    /// The same node by node.
    pub records: &'a Records,
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
    /// Points move with their own velocity instead of the grid's.
    pub moves_by_point: bool,
    /// Points keep moments of the velocity about themselves, with nodes that move along.
    pub turns_moments: bool,
}

/// What is done with the points, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Strokes {
    /// Deform points and ask their laws for the stress.
    pub strain: bool,
    /// Take from velocities what the grid shows of them.
    pub filter: bool,
    /// Change velocities.
    pub kick: bool,
    /// Keep the affine part of the smooth velocity.
    pub keep: bool,
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
        let work = |scratch: &mut Scratch, chunk: &mut Chunk| {
            let worked = match kinematics.dimension() {
                1 => work_on::<1>(chunk, &material, strokes, scratch),
                2 => work_on::<2>(chunk, &material, strokes, scratch),
                _ => work_on::<3>(chunk, &material, strokes, scratch),
            };
            let first = chunk.first;
            let mut found = worked.map_err(|(point, cause)| Trouble { block: index, point: first + point, cause })?;
            found.leavers.iter_mut().for_each(|point| *point += first as u32);
            Ok(found)
        };
        let of_chunks: Vec<Result<OfChunk, Trouble>> = if rayon::current_num_threads() > 1 {
            chunks.par_iter_mut().map_init(Scratch::default, work).collect()
        } else {
            let mut scratch = Scratch::default();
            chunks.iter_mut().map(|chunk| work(&mut scratch, chunk)).collect()
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

/// Room for work, kept from chunk to chunk.
#[derive(Default)]
struct Scratch {
    samples: Samples,
    batch: Box<Batch>,
}

/// All strokes on a chunk, a few groups of points at a time.
fn work_on<const D: usize>(
    chunk: &mut Chunk,
    material: &Material,
    strokes: Strokes,
    scratch: &mut Scratch,
) -> AtPoint<OfChunk> {
    let (field, arch) = (material.field, material.field.grid.arch);
    let Scratch { samples, batch } = scratch;
    let (mut found, mut next, mut fetched) = (OfChunk::default(), 0, 0);
    while next < chunk.cell.len() {
        let end = chunk.cell.len().min(next + AHEAD);
        chunk.prefetch(fetched..end, strokes);
        fetched = end;
        next = samples.take(chunk, next, &field.grid, &field.fields, field.records);
        let samples = samples.taken();
        if strokes.strain {
            material.strain::<D>(chunk, samples, batch)?;
        }
        if strokes.filter {
            dispatch(arch, Filter::<D> { chunk, samples });
        }
        if strokes.kick {
            found.fastest = dispatch(arch, Kick::<D> { chunk, samples, field })?.max(found.fastest);
        }
        if strokes.keep {
            samples.iter().for_each(|sample| store_affine::<D>(sample.rows, chunk.transfer, &sample.affine));
        }
        if strokes.drift {
            dispatch(arch, Drift::<D> { chunk, samples, field, leavers: &mut found.leavers })?;
        }
    }
    Ok(found)
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
        let share = match field.transfer {
            Transfer::Flip(share) => share,
            Transfer::Apic | Transfer::Tpic => 0.0,
            Transfer::Xpic(_) => 1.0,
        };
        let xpic = matches!(field.transfer, Transfer::Xpic(_));
        let mut fastest = Lanes::splat(simd, 0.0);
        for sample in samples {
            let rows = sample.rows;
            let mut velocity = rows.load::<S, D>(simd, chunk.velocity);
            if xpic {
                // The velocity was filtered: what is left of it is what the grid does not see.
                let before = rows.load::<S, D>(simd, chunk.transfer);
                for a in 0..D {
                    velocity[a] = before[a] - velocity[a];
                }
            }
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

/// Writes the affine part of the velocity, row by row.
fn store_affine<const D: usize>(rows: Rows, column: &mut [f64], affine: &Tensor<Pack>) {
    for (l, point) in rows.points().enumerate() {
        for a in 0..D {
            for b in 0..D {
                column[(point * D + a) * D + b] = affine[a][b].0[l];
            }
        }
    }
}

/// Points with the velocity v that move by w Δt, w another velocity (MUSL), gain the angular momentum
/// m Δt w × v: the moments about them give it back. With w = v nothing changes.
#[inline(always)]
fn turn_moments<S: Simd, const D: usize>(rows: Rows, moments: &mut [f64], v: &[Lanes<S>; D], path: &[Lanes<S>; D]) {
    for a in 0..D {
        for b in 0..a {
            let gained = ((v[a] * path[b] - path[a] * v[b]) * 0.5).pack();
            for (point, gained) in rows.points().zip(gained.0) {
                moments[(point * D + a) * D + b] -= gained;
                moments[(point * D + b) * D + a] += gained;
            }
        }
    }
}

/// Takes from velocities what the grid shows of them.
struct Filter<'a, 'c, const D: usize> {
    chunk: &'a mut Chunk<'c>,
    samples: &'a [Sample],
}

impl<const D: usize> pulp::WithSimd for Filter<'_, '_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for sample in self.samples {
            let mut velocity = sample.rows.load::<S, D>(simd, self.chunk.velocity);
            for a in 0..D {
                velocity[a] -= Lanes::load(simd, &sample.smooth[a]);
            }
            sample.rows.store(self.chunk.velocity, &velocity);
        }
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
            let own = rows.load::<S, D>(simd, chunk.velocity);
            for a in 0..D {
                let carried = if field.moves_by_point { own[a] } else { Lanes::load(simd, &sample.carrying[a]) };
                path[a] = carried * field.time_step;
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
            if field.turns_moments {
                turn_moments(rows, chunk.transfer, &own, &path);
            }
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
                if !sample.cell.as_ref().is_some_and(|cell| cell.holds_all(&place)) {
                    let holds = sample.cell.map_or([false; WIDTH], |cell| cell.holds(&place));
                    let out = rows.points().zip(holds).filter(|(_, holds)| !holds);
                    leavers.extend(out.map(|(point, _)| point as u32));
                }
            }
        }
        Ok(())
    }
}
