//! From the nodes to the points, in three strokes over points in step: the kick changes velocities,
//! the strain deforms points and asks their laws, the drift moves them.

use super::cells::{Cell, Mapping};
use super::chunk::{Chunk, Opened, open};
use super::kratos_faults::KratosFaults;
use super::rows::Rows;
use crate::active::NO_CELL;
use crate::grid::{GridCell, corners, nodal_vectors, with_shape};
use crate::points::MaterialPoints;
use crate::settings::{Frame, Transfer};
use bia_constitutive::{LawError, WIDTH};
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use bia_kernel::lanes::{Lanes, Real};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use rayon::prelude::*;
use std::marker::PhantomData;
use std::ops::Range;

/// What the points see of the grid.
pub struct Field<'a> {
    /// The grid.
    pub grid: &'a ModelPart,
    /// Numbers of the active nodes.
    pub dofs: &'a ActiveDofs,
    /// How positions become local coordinates.
    pub mapping: Mapping,
    /// Where functions are evaluated.
    pub frame: Frame,
    /// Velocity that deforms points and gives the PIC share of theirs.
    pub velocity: &'a [f64],
    /// Velocity that carries points.
    pub carrying: &'a [f64],
    /// Acceleration.
    pub acceleration: &'a [f64],
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
    /// Faults to repeat.
    pub faults: KratosFaults,
    /// Instruction set.
    pub arch: pulp::Arch,
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
        let material = super::strain::Material { law, density, kinematics, field };
        let work = |chunk: &mut Chunk| {
            let mut found = OfChunk::default();
            let worked = (|| {
                if strokes.strain {
                    material.strain(chunk)?;
                }
                if strokes.kick {
                    kick(chunk, field, &mut found)?;
                }
                if strokes.drift {
                    drift(chunk, field, &mut found)?;
                }
                Ok(())
            })();
            let first = chunk.first;
            worked.map_err(|(point, cause)| Trouble { block: index, point: first + point, cause })?;
            found.leavers.iter_mut().for_each(|point| *point += first as u32);
            Ok(found)
        };
        let of_chunks: Vec<Result<OfChunk, Trouble>> = if rayon::current_num_threads() > 1 {
            chunks.par_iter_mut().map(work).collect()
        } else {
            chunks.iter_mut().map(work).collect()
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

/// Runs of points whose cells have one shape.
pub fn shapes<'a>(cells: &'a [u32], grid: &'a ModelPart) -> impl Iterator<Item = (Range<usize>, Shape)> + 'a {
    let shape = |cell: u32| grid.elements.shapes.get(cell as usize).copied();
    let mut end = 0;
    cells.chunk_by(move |a, b| a == b || shape(*a) == shape(*b)).filter_map(move |run| {
        let range = end..end + run.len();
        end = range.end;
        shape(run[0]).map(|shape| (range, shape))
    })
}

/// Runs of points in one cell, and the cell.
#[inline(always)]
pub fn runs(cells: &[u32], range: Range<usize>) -> impl Iterator<Item = (Range<usize>, usize)> {
    let mut end = range.start;
    cells[range].chunk_by(|a, b| a == b).filter_map(move |run| {
        let range = end..end + run.len();
        end = range.end;
        (run[0] != NO_CELL).then_some((range, run[0] as usize))
    })
}

/// Points of a run in groups that fill the lanes.
#[inline(always)]
pub fn groups(run: Range<usize>) -> impl Iterator<Item = Rows> {
    run.clone().step_by(WIDTH).map(move |first| Rows { first, count: WIDTH.min(run.end - first) })
}

/// Functions at points in step, with the faults that they are to have.
#[inline(always)]
fn functions<B: GridCell<D, N>, const D: usize, const N: usize>(
    cell: &Cell<B, D, N>,
    xi: &[Lanes<WIDTH>; D],
    faults: KratosFaults,
) -> [Lanes<WIDTH>; N] {
    let mut functions = cell.basis.functions(xi);
    faults.misalign_lanes(&mut functions, &mut [[Lanes([0.0; WIDTH]); D]; N]);
    functions
}

/// Σ N v.
#[inline(always)]
fn interpolate<const D: usize, const N: usize>(
    functions: &[Lanes<WIDTH>; N],
    values: &[[f64; D]; N],
) -> [Lanes<WIDTH>; D] {
    let mut sum = [Lanes([0.0; WIDTH]); D];
    for i in 0..N {
        for a in 0..D {
            sum[a] += functions[i] * values[i][a];
        }
    }
    sum
}

/// |v|² of each lane.
#[inline(always)]
fn squared<const D: usize>(v: &[Lanes<WIDTH>; D]) -> Lanes<WIDTH> {
    let mut sum = v[0] * v[0];
    for a in 1..D {
        sum += v[a] * v[a];
    }
    sum
}

fn kick(chunk: &mut Chunk, field: &Field, found: &mut OfChunk) -> AtPoint<()> {
    for (range, shape) in shapes(chunk.cell, field.grid) {
        with_shape!(shape, |S, D, N| {
            let task = Kick::<S, D, N> { chunk, range, field, shape: PhantomData };
            found.fastest = found.fastest.max(field.arch.dispatch(task)?);
        }, else ());
    }
    Ok(())
}

/// New velocities of points in cells of one shape. Yields the largest squared speed.
struct Kick<'a, 'b, B, const D: usize, const N: usize> {
    chunk: &'a mut Chunk<'b>,
    range: Range<usize>,
    field: &'a Field<'a>,
    shape: PhantomData<B>,
}

impl<B: GridCell<D, N>, const D: usize, const N: usize> pulp::WithSimd for Kick<'_, '_, B, D, N> {
    type Output = AtPoint<f64>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { chunk, field, .. } = self;
        let share = if let Transfer::Flip(share) = field.transfer { share } else { 1.0 };
        let mut fastest = Lanes::<WIDTH>::splat(0.0);
        for (run, index) in runs(chunk.cell, self.range) {
            let nodes = field.grid.elements.nodes_of(index);
            let cell = Cell::new(B::of(field.grid, index), corners::<D, N>(field.grid, nodes), field.mapping);
            let acceleration = nodal_vectors::<D, N>(field.dofs, nodes, field.acceleration);
            for rows in groups(run) {
                let xi = cell.local(&rows.load(chunk.position), || rows.load(chunk.local));
                let functions = functions(&cell, &xi, field.faults);
                let change = interpolate(&functions, &acceleration);
                let mut velocity = rows.load::<D>(chunk.velocity);
                for a in 0..D {
                    velocity[a] += change[a] * (field.gamma * field.time_step);
                }
                if field.gamma != 1.0 {
                    let old = rows.load::<D>(chunk.acceleration);
                    for a in 0..D {
                        velocity[a] += old[a] * ((1.0 - field.gamma) * field.time_step);
                    }
                }
                if share < 1.0 {
                    let smooth = interpolate(&functions, &nodal_vectors::<D, N>(field.dofs, nodes, field.velocity));
                    for a in 0..D {
                        velocity[a] = velocity[a] * share + smooth[a] * (1.0 - share);
                    }
                }
                let speed = squared(&velocity);
                if let Some(lane) = speed.0[..rows.count].iter().position(|speed| !speed.is_finite()) {
                    return Err((rows.first + lane, Cause::Moved(f64::NAN)));
                }
                for l in 0..WIDTH {
                    fastest.0[l] = fastest.0[l].max(speed.0[l]);
                }
                rows.store(chunk.velocity, &velocity);
                if !chunk.acceleration.is_empty() {
                    rows.store(chunk.acceleration, &change);
                }
            }
        }
        Ok(fastest.0.into_iter().fold(0.0, f64::max))
    }
}

fn drift(chunk: &mut Chunk, field: &Field, found: &mut OfChunk) -> AtPoint<()> {
    for (range, shape) in shapes(chunk.cell, field.grid) {
        with_shape!(shape, |S, D, N| {
            let leavers = &mut found.leavers;
            field.arch.dispatch(Drift::<S, D, N> { chunk, range, field, leavers, shape: PhantomData })?;
        }, else ());
    }
    Ok(())
}

/// New positions of points in cells of one shape.
struct Drift<'a, 'b, B, const D: usize, const N: usize> {
    chunk: &'a mut Chunk<'b>,
    range: Range<usize>,
    field: &'a Field<'a>,
    leavers: &'a mut Vec<u32>,
    shape: PhantomData<B>,
}

impl<B: GridCell<D, N>, const D: usize, const N: usize> pulp::WithSimd for Drift<'_, '_, B, D, N> {
    type Output = AtPoint<()>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { chunk, field, leavers, .. } = self;
        for (run, index) in runs(chunk.cell, self.range) {
            let nodes = field.grid.elements.nodes_of(index);
            let cell = Cell::new(B::of(field.grid, index), corners::<D, N>(field.grid, nodes), field.mapping);
            let carrying = nodal_vectors::<D, N>(field.dofs, nodes, field.carrying);
            for rows in groups(run) {
                let mut position = rows.load::<D>(chunk.position);
                let xi = cell.local(&position, || rows.load(chunk.local));
                let mut path = interpolate(&functions(&cell, &xi, field.faults), &carrying);
                for a in 0..D {
                    path[a] *= Lanes::splat(field.time_step);
                }
                let distance = squared(&path);
                let too_far = |distance: &f64| !(*distance <= field.reach * field.reach);
                if let Some(lane) = distance.0[..rows.count].iter().position(too_far) {
                    return Err((rows.first + lane, Cause::Moved(distance.0[lane].sqrt())));
                }
                for a in 0..D {
                    position[a] += path[a];
                }
                rows.store(chunk.position, &position);
                if !chunk.displacement.is_empty() {
                    let mut displacement = rows.load::<D>(chunk.displacement);
                    for a in 0..D {
                        displacement[a] += path[a];
                    }
                    rows.store(chunk.displacement, &displacement);
                }
                if field.frame == Frame::Total {
                    continue;
                }
                let mut stays = [false; WIDTH];
                let local = cell.local(&position, || {
                    [Lanes([f64::NAN; WIDTH]); D] // a search finds them
                });
                B::holds(&local, &mut stays);
                if stays != [true; WIDTH] {
                    leavers.extend(rows.points().zip(stays).filter(|(_, stays)| !stays).map(|(point, _)| point as u32));
                }
            }
        }
        Ok(())
    }
}
