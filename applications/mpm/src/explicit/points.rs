//! From the nodes to the points: motion, and stress from the velocity of the grid.

use super::chunk::{Chunk, Opened, open};
use super::kinematics::{ShapeAt, deform, jacobian, strain};
use super::kratos_faults::KratosFaults;
use crate::active::NO_CELL;
use crate::grid::{corners, nodal_vectors, with_shape};
use crate::points::{MaterialPoints, compress, expand};
use bia_constitutive::{Deformation, Kinematics, Law, LawError, Voigt};
use bia_kernel::geometry::{CellShape, Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::ActiveDofs;
use nalgebra::Matrix3;
use rayon::prelude::*;
use std::marker::PhantomData;
use std::ops::Range;

/// Points whose law is asked in one call.
const BATCH: usize = 16;

/// What the points see of the grid.
pub struct Field<'a> {
    /// The grid.
    pub grid: &'a ModelPart,
    /// Numbers of the active nodes.
    pub dofs: &'a ActiveDofs,
    /// Velocity that carries points and deforms them.
    pub velocity: &'a [f64],
    /// Acceleration.
    pub acceleration: &'a [f64],
    /// Time step in seconds.
    pub time_step: f64,
    /// Weight of the new acceleration in the points' velocity.
    pub gamma: f64,
    /// Farthest that a point may move, in metres.
    pub reach: f64,
    /// Deform the points; else their volume and density stay.
    pub compressible: bool,
    /// Faults to repeat.
    pub faults: KratosFaults,
    /// Instruction set.
    pub arch: pulp::Arch,
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

/// Moves the points. Returns the largest speed in m/s.
///
/// # Errors
/// A motion that is not finite or goes too far.
pub fn advance(points: &mut MaterialPoints, field: &Field) -> Result<f64, Trouble> {
    let mut fastest = 0.0f64;
    for (index, block) in points.blocks.iter_mut().enumerate() {
        let advanced = each(open(block).chunks, |chunk| advance_chunk(chunk, field), index)?;
        fastest = advanced.into_iter().fold(fastest, f64::max);
    }
    Ok(fastest.sqrt())
}

/// Deforms the points and asks their laws for the stress.
///
/// # Errors
/// An inverted deformation, or a law without an answer.
pub fn update_stress(points: &mut MaterialPoints, field: &Field) -> Result<(), Trouble> {
    let kinematics = points.kinematics;
    for (index, block) in points.blocks.iter_mut().enumerate() {
        let Opened { law, density, chunks } = open(block);
        let material = Material { law, density, kinematics, field };
        each(chunks, |chunk| material.update(chunk), index)?;
    }
    Ok(())
}

/// Works on all chunks; the trouble of the first point wins.
fn each<T: Send>(
    mut chunks: Vec<Chunk>,
    work: impl Fn(&mut Chunk) -> Result<T, (usize, Cause)> + Sync,
    block: usize,
) -> Result<Vec<T>, Trouble> {
    let work = |chunk: &mut Chunk| {
        let first = chunk.first;
        work(chunk).map_err(|(point, cause)| Trouble { block, point: first + point, cause })
    };
    if rayon::current_num_threads() > 1 {
        let results: Vec<Result<T, Trouble>> = chunks.par_iter_mut().map(work).collect();
        results.into_iter().collect()
    } else {
        chunks.iter_mut().map(work).collect()
    }
}

/// Runs of points in one cell, and the cell.
fn runs(cells: &[u32]) -> impl Iterator<Item = (Range<usize>, usize)> {
    let mut end = 0;
    cells.chunk_by(|a, b| a == b).filter_map(move |run| {
        let range = end..end + run.len();
        end = range.end;
        (run[0] != NO_CELL).then_some((range, run[0] as usize))
    })
}

/// Moves the points of a chunk. Returns the largest squared speed.
fn advance_chunk(chunk: &mut Chunk, field: &Field) -> Result<f64, (usize, Cause)> {
    let mut fastest = 0.0f64;
    for (run, cell) in runs(chunk.cell) {
        let nodes = field.grid.elements.nodes_of(cell);
        let moved = with_shape!(field.grid.elements.shapes[cell], |S, D, N| {
            let velocity = nodal_vectors::<D, N>(field.dofs, nodes, field.velocity);
            let acceleration = nodal_vectors::<D, N>(field.dofs, nodes, field.acceleration);
            field.arch.dispatch(Advance::<S, D, N> { chunk, run, field, velocity, acceleration, shape: PhantomData })
        }, else Ok(0.0));
        fastest = fastest.max(moved?);
    }
    Ok(fastest)
}

/// The motion of points in one cell.
struct Advance<'a, 'b, S, const D: usize, const N: usize> {
    chunk: &'a mut Chunk<'b>,
    run: Range<usize>,
    field: &'a Field<'a>,
    velocity: [[f64; D]; N],
    acceleration: [[f64; D]; N],
    shape: PhantomData<S>,
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> pulp::WithSimd for Advance<'_, '_, S, D, N> {
    type Output = Result<f64, (usize, Cause)>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Field { time_step, gamma, reach, faults, .. } = *self.field;
        let mut fastest = 0.0f64;
        for point in self.run {
            let xi = row::<D>(self.chunk.local, point);
            let functions = ShapeAt::<D, N>::functions::<S>(&xi, faults).functions;
            let (mut carried, mut acceleration) = ([0.0; D], [0.0; D]);
            for i in 0..N {
                for a in 0..D {
                    carried[a] += functions[i] * self.velocity[i][a];
                    acceleration[a] += functions[i] * self.acceleration[i][a];
                }
            }
            let place = point * D..(point + 1) * D;
            let old = &mut self.chunk.acceleration[place.clone()];
            let velocity = &mut self.chunk.velocity[place.clone()];
            let (mut speed, mut distance) = (0.0, 0.0);
            for a in 0..D {
                velocity[a] += time_step * ((1.0 - gamma) * old[a] + gamma * acceleration[a]);
                old[a] = acceleration[a];
                speed += velocity[a] * velocity[a];
                distance += (time_step * carried[a]).powi(2);
            }
            let finite = speed.is_finite() && distance.is_finite();
            if !(finite && distance <= reach * reach) {
                return Err((point, Cause::Moved(distance.sqrt())));
            }
            fastest = fastest.max(speed);
            for a in 0..D {
                self.chunk.position[place.start + a] += time_step * carried[a];
                if !self.chunk.displacement.is_empty() {
                    self.chunk.displacement[place.start + a] += time_step * carried[a];
                }
            }
        }
        Ok(fastest)
    }
}

/// The points of one block as far as their stress goes.
struct Material<'a> {
    law: &'a dyn Law,
    density: f64,
    kinematics: Kinematics,
    field: &'a Field<'a>,
}

impl Material<'_> {
    fn update(&self, chunk: &mut Chunk) -> Result<(), (usize, Cause)> {
        for (run, cell) in runs(chunk.cell) {
            let grid = self.field.grid;
            let nodes = grid.elements.nodes_of(cell);
            with_shape!(grid.elements.shapes[cell], |S, D, N| {
                let corners = corners::<D, N>(grid, nodes);
                let velocity = nodal_vectors::<D, N>(self.field.dofs, nodes, self.field.velocity);
                let task = UpdateStress::<S, D, N> { material: self, chunk, run, corners, velocity, shape: PhantomData };
                self.field.arch.dispatch(task)
            }, else Ok(()))?;
        }
        Ok(())
    }

    /// Asks the law about some points and stores its answers.
    fn answer(
        &self,
        chunk: &mut Chunk,
        points: Range<usize>,
        deformations: &[Deformation],
    ) -> Result<(), (usize, Cause)> {
        let width = self.law.state_len();
        let states = &mut chunk.state[points.start * width..points.end * width];
        let mut stresses: [Voigt; BATCH] = [[0.0; 6]; BATCH];
        let out = &mut stresses[..deformations.len()];
        let asked = if self.field.faults.forgets_history() && width > 0 {
            self.law.stresses(deformations, &mut states.to_vec(), out)
        } else {
            self.law.stresses(deformations, states, out)
        };
        asked.map_err(|(k, error)| (points.start + k, Cause::Law(error)))?;
        let components = self.kinematics.voigt();
        let store = |column: &mut [f64], point: usize, values: &Voigt| {
            let row = &mut column[point * components.len()..(point + 1) * components.len()];
            row.iter_mut().zip(components).for_each(|(entry, &component)| *entry = values[component]);
        };
        for ((point, deformation), stress) in points.zip(deformations).zip(&*out) {
            store(chunk.stress, point, stress);
            if !chunk.strain.is_empty() {
                let strain = deformation.strain.unwrap_or_else(|| self.law.strain(deformation));
                store(chunk.strain, point, &strain);
            }
        }
        Ok(())
    }
}

/// Deformation and stress of points in one cell.
struct UpdateStress<'a, 'b, S, const D: usize, const N: usize> {
    material: &'a Material<'a>,
    chunk: &'a mut Chunk<'b>,
    run: Range<usize>,
    corners: [[f64; D]; N],
    velocity: [[f64; D]; N],
    shape: PhantomData<S>,
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> pulp::WithSimd for UpdateStress<'_, '_, S, D, N> {
    type Output = Result<(), (usize, Cause)>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Material { law, density, kinematics, field } = *self.material;
        let chunk = self.chunk;
        let axisymmetric = kinematics == Kinematics::Axisymmetric;
        let accumulates = law.uses_strain() || (field.faults.shows_accumulated_strain() && !chunk.strain.is_empty());
        let width = crate::points::gradient_width(kinematics);
        let mut deformations = [Deformation::from_gradient(Matrix3::identity()); BATCH];
        let mut first = self.run.start;
        while first < self.run.end {
            let points = first..self.run.end.min(first + BATCH);
            first = points.end;
            for (point, deformation) in points.clone().zip(&mut deformations) {
                let xi = row::<D>(chunk.local, point);
                let shape = ShapeAt::<D, N>::new::<S>(&self.corners, &xi, field.faults);
                let rate = shape.velocity_gradient(&self.corners, &self.velocity, axisymmetric);
                let stored = &mut chunk.gradient[point * width..(point + 1) * width];
                let before = expand(stored);
                deformation.gradient = before;
                deformation.previous = field.faults.previous(&before);
                deformation.time_step = field.time_step;
                if field.compressible {
                    deformation.gradient = deform(&before, &rate, field.time_step, field.faults);
                    compress(&deformation.gradient, stored);
                    let jacobian = jacobian(stored);
                    if !(jacobian > 0.0 && jacobian.is_finite()) {
                        return Err((point, Cause::Inverted(jacobian)));
                    }
                    if !chunk.volume.is_empty() {
                        chunk.volume[point] = chunk.mass[point] / density * jacobian;
                    }
                }
                if accumulates {
                    let before = stored_strain(chunk.strain, point, kinematics);
                    deformation.strain = Some(strain(&before, &rate, field.time_step, field.faults));
                }
            }
            self.material.answer(chunk, points.clone(), &deformations[..points.len()])?;
        }
        Ok(())
    }
}

/// The strain of a point, with zeros for the components that its kinematics does not have.
#[inline(always)]
fn stored_strain(column: &[f64], point: usize, kinematics: Kinematics) -> Voigt {
    let components = kinematics.voigt();
    let mut strain = [0.0; 6];
    for (k, &component) in components.iter().enumerate() {
        strain[component] = column[point * components.len() + k];
    }
    strain
}

#[inline(always)]
fn row<const D: usize>(column: &[f64], point: usize) -> [f64; D] {
    std::array::from_fn(|i| column[point * D + i])
}
