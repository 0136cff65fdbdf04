//! Transfers between points and grid with the shape functions at the start of the step.

use super::element::PointKinematics;
use super::kratos_faults::shift_mean;
use crate::active::{ActiveCells, NO_CELL};
use crate::grid::{nodal_vectors, numbers};
use crate::points::{Block, MaterialPoints, compress, law_failure};
use crate::settings::Frame;
use crate::space::{Space, with_basis};
use bia_constitutive::{Deformation, Kinematics, Response, Want};
use bia_kernel::error::Failure;
use bia_kernel::geometry::PlacedBasis;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::solving::ordered::in_order;
use rayon::prelude::*;

/// Points handled together when their state is written back.
const SLAB: usize = 4096;
/// Points a thread takes at a time.
const GRAIN: usize = 64;

/// Sums gathered on the active nodes: mass, and momentum and inertia if points move.
#[derive(Default)]
pub struct NodalSums {
    /// Σ N m.
    pub mass: Vec<f64>,
    /// Σ N m v, entry `number * D + component`.
    pub momentum: Vec<f64>,
    /// Σ N m a.
    pub inertia: Vec<f64>,
    buffers: Vec<Vec<f64>>,
}

impl NodalSums {
    /// Gathers from all points; `with_motion` asks for momentum and inertia.
    pub fn gather(
        &mut self,
        blocks: &[Block],
        active: &ActiveCells,
        space: &Space,
        dofs: &ActiveDofs,
        with_motion: bool,
    ) {
        let dimension = dofs.block();
        let nodes = dofs.nodes().len();
        for (sums, size) in
            [(&mut self.mass, nodes), (&mut self.momentum, nodes * dimension), (&mut self.inertia, nodes * dimension)]
        {
            sums.clear();
            sums.resize(if with_motion || size == nodes { size } else { 0 }, 0.0);
        }
        let width = if with_motion { 1 + 2 * dimension } else { 1 };
        let compute = |index: usize, buffer: &mut Vec<f64>| {
            let cell = active.cells[index] as usize;
            buffer.clear();
            buffer.resize(width * space.nodes_of(cell).len(), 0.0);
            for (block, point) in active.points(index) {
                let block = &blocks[block as usize];
                with_basis!(space, cell, |basis, D, N| {
                    add_point::<_, D, N>(&basis, block, point as usize, with_motion, buffer);
                }, else ());
            }
            Ok::<(), ()>(())
        };
        let (mass, momentum, inertia) = (&mut self.mass, &mut self.momentum, &mut self.inertia);
        let add = |index: usize, buffer: &Vec<f64>| {
            for (i, &node) in space.nodes_of(active.cells[index] as usize).iter().enumerate() {
                let Some(number) = dofs.number(node) else { continue };
                mass[number] += buffer[i * width];
                if with_motion {
                    for a in 0..dimension {
                        momentum[number * dimension + a] += buffer[i * width + 1 + a];
                        inertia[number * dimension + a] += buffer[i * width + 1 + dimension + a];
                    }
                }
            }
        };
        // The computation cannot fail.
        let _ = in_order(active.len(), &mut self.buffers, compute, add);
    }
}

fn add_point<B: PlacedBasis<D, N>, const D: usize, const N: usize>(
    basis: &B,
    block: &Block,
    point: usize,
    with_motion: bool,
    buffer: &mut [f64],
) {
    let functions = basis.functions(&block.local.get::<D>(point));
    let mass = block.mass.get::<1>(point)[0];
    if !with_motion {
        for i in 0..N {
            buffer[i] += functions[i] * mass;
        }
        return;
    }
    let (velocity, acceleration) = (block.velocity.get::<D>(point), block.acceleration.get::<D>(point));
    let width = 1 + 2 * D;
    for i in 0..N {
        let share = functions[i] * mass;
        buffer[i * width] += share;
        for a in 0..D {
            buffer[i * width + 1 + a] += share * velocity[a];
            buffer[i * width + 1 + D + a] += share * acceleration[a];
        }
    }
}

/// Nodal results of a step, as the points see them.
pub struct NodalResults<'a> {
    /// The grid's functions.
    pub space: &'a Space,
    /// Where they are evaluated.
    pub frame: Frame,
    /// Numbers of the active nodes.
    pub dofs: &'a ActiveDofs,
    /// Displacement increments.
    pub increments: &'a [f64],
    /// Increments at the last assembly: the volume that Kratos shows lags there.
    pub increments_of_volume: &'a [f64],
    /// Pressures; empty unless the formulation has them.
    pub pressures: &'a [f64],
    /// Normal stresses are shown as in Kratos, which corrects their mean.
    pub shifts_stress: bool,
    /// Accelerations; empty without inertia.
    pub accelerations: &'a [f64],
    /// Velocities at the end of the step; empty without inertia.
    pub velocities: &'a [f64],
    /// Changes of velocity, where the points take them as they are; else `gamma` rules.
    pub velocity_changes: &'a [f64],
    /// Share of FLIP in the velocity of the points; the rest is PIC.
    pub flip_fraction: f64,
    /// Time step in seconds.
    pub time_step: f64,
    /// Weight of the new acceleration in the points' velocity. 1/2 is Kratos's convention, by which
    /// Bossak's low modes gain energy at the rate -alpha ω² dt; with the scheme's own gamma they
    /// dissipate.
    pub gamma: f64,
    /// Shape functions up to this one are left out, as in Kratos; none to use them all. A point that
    /// lies outside its cell by less than the search tolerance has negative ones: left out, they
    /// would take momentum from the body.
    pub least_function: Option<f64>,
}

/// What a point takes from the grid at the end of a step.
#[derive(Clone, Copy)]
struct Update {
    deformation: Deformation,
    step: [f64; 3],
    acceleration: [f64; 3],
    /// Change of velocity, where the points take it as it is.
    velocity_change: [f64; 3],
    /// Velocity of the grid at the end of the step, where PIC has a share.
    velocity: [f64; 3],
    volume_ratio: f64,
    /// Volume at the end of the step over that at its start.
    stretch: f64,
}

/// The largest change of a point's volume in a step.
pub struct Leap {
    /// The larger of the two volumes over the smaller one.
    factor: f64,
    /// Block and point.
    place: (usize, usize),
}

/// A volume that changes by more than this factor in a step of dynamics has not been followed.
const FARTHEST: f64 = 2.0;

impl Leap {
    /// Warns, once, where a step is too large for what happens in it. Newton's method may converge all the
    /// same, and energy come from nowhere.
    pub fn tell(&self, points: &MaterialPoints, told: &mut bool) {
        if *told || self.factor <= FARTHEST {
            return;
        }
        *told = true;
        let block = &points.blocks[self.place.0];
        let (id, x) = (block.ids[self.place.1], block.coordinates(self.place.1));
        tracing::warn!(
            "the volume of material point {id} at {x:?} changes {:.2} fold in one step: the step is too large for \
             what happens there, and results may be wrong where Newton's method converges; take a smaller one",
            self.factor
        );
    }
}

/// Moves the points, updates their deformation, history and the columns that the scene uses.
///
/// # Errors
/// A law without an answer, or an inverted deformation.
pub fn update_points(points: &mut MaterialPoints, nodal: &NodalResults) -> Result<Leap, Failure> {
    let kinematics = points.kinematics;
    let mut leap = Leap { factor: 1.0, place: (0, 0) };
    for (index, block) in points.blocks.iter_mut().enumerate() {
        for first in (0..block.len()).step_by(SLAB) {
            let range = first..(first + SLAB).min(block.len());
            let moved = |point: usize| update(block, point, kinematics, nodal);
            let updates: Vec<Update> =
                range.clone().into_par_iter().with_min_len(GRAIN).map(moved).collect::<Result<_, Failure>>()?;
            answer(block, &range, &updates, kinematics, nodal.shifts_stress)?;
            for (update, point) in updates.iter().zip(range) {
                let factor = update.stretch.max(update.stretch.recip());
                if factor > leap.factor {
                    leap = Leap { factor, place: (index, point) };
                }
                store(block, point, update, nodal);
            }
        }
    }
    Ok(leap)
}

fn update(block: &Block, point: usize, kinematics: Kinematics, nodal: &NodalResults) -> Result<Update, Failure> {
    let gradient = block.deformation_gradient(point);
    let mut deformation = Deformation::from_gradient(gradient);
    deformation.previous = gradient;
    deformation.pressure = block.pressure_of(point);
    deformation.time_step = nodal.time_step;
    let none = [0.0; 3];
    let volume_ratio = gradient.determinant();
    let rest = Update {
        deformation,
        step: none,
        acceleration: none,
        velocity_change: none,
        velocity: none,
        volume_ratio,
        stretch: 1.0,
    };
    let cell = block.cell[point];
    if cell == NO_CELL {
        return Ok(rest);
    }
    with_basis!(nodal.space, cell as usize, |basis, D, N| {
        update_in::<_, D, N>(&basis, block, point, kinematics, nodal, rest)
    }, else Ok(rest))
}

fn update_in<B: PlacedBasis<D, N>, const D: usize, const N: usize>(
    basis: &B,
    block: &Block,
    point: usize,
    kinematics: Kinematics,
    nodal: &NodalResults,
    mut update: Update,
) -> Result<Update, Failure> {
    let nodes = nodal.space.nodes_of(block.cell[point] as usize);
    let of_scene = (kinematics, nodal.frame);
    let increments = nodal_vectors::<D, N>(nodal.dofs, nodes, nodal.increments);
    let at = PointKinematics::<D, N>::new(basis, block, point, of_scene, &increments)?;
    update.deformation.gradient = at.gradient;
    if !nodal.pressures.is_empty() {
        let numbers = numbers::<N>(nodal.dofs, nodes);
        update.deformation.pressure = Some((0..N).map(|i| at.functions[i] * nodal.pressures[numbers[i]]).sum());
    }
    let start = std::mem::replace(&mut update.volume_ratio, at.gradient.determinant());
    update.stretch = update.volume_ratio / start;
    if !std::ptr::eq(nodal.increments, nodal.increments_of_volume) {
        let increments = nodal_vectors::<D, N>(nodal.dofs, nodes, nodal.increments_of_volume);
        let earlier = PointKinematics::<D, N>::new(basis, block, point, of_scene, &increments)?;
        update.volume_ratio = earlier.gradient.determinant();
    }
    let accelerations = nodal_vectors::<D, N>(nodal.dofs, nodes, nodal.accelerations);
    if nodal.flip_fraction < 1.0 {
        update.velocity = interpolate::<D, N>(&at.functions, nodal, nodes, nodal.velocities);
    }
    if !nodal.velocity_changes.is_empty() {
        update.velocity_change = interpolate::<D, N>(&at.functions, nodal, nodes, nodal.velocity_changes);
    }
    for i in (0..N).filter(|&i| nodal.least_function.is_none_or(|least| at.functions[i] > least)) {
        for a in 0..D {
            update.step[a] += at.functions[i] * increments[i][a];
            update.acceleration[a] += at.functions[i] * accelerations[i][a];
        }
    }
    Ok(update)
}

/// Σ N v.
fn interpolate<const D: usize, const N: usize>(
    functions: &[f64; N],
    nodal: &NodalResults,
    nodes: &[u32],
    values: &[f64],
) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (n, value) in functions.iter().zip(nodal_vectors::<D, N>(nodal.dofs, nodes, values)) {
        (0..D).for_each(|a| sum[a] += n * value[a]);
    }
    sum
}

/// Asks the law for the stress and the new history, if either is kept.
fn answer(
    block: &mut Block,
    range: &std::ops::Range<usize>,
    updates: &[Update],
    kinematics: Kinematics,
    shifts_stress: bool,
) -> Result<(), Failure> {
    let length = block.state.width();
    if !block.stress.is_used() && length == 0 {
        return Ok(());
    }
    let deformations: Vec<Deformation> = updates.iter().map(|update| update.deformation).collect();
    let mut responses = vec![Response::default(); updates.len()];
    let mut states = block.state.values()[range.start * length..range.end * length].to_vec();
    let law = block.law.as_ref();
    let mut tasks = Vec::new();
    let mut rest = states.as_mut_slice();
    for (deformations, responses) in deformations.chunks(GRAIN).zip(responses.chunks_mut(GRAIN)) {
        let (of_chunk, after) = std::mem::take(&mut rest).split_at_mut(deformations.len() * length);
        rest = after;
        tasks.push((deformations, responses, of_chunk));
    }
    let answers: Vec<_> = tasks
        .into_par_iter()
        .enumerate()
        .map(|(grain, (deformations, responses, states))| {
            let asked = law.respond(deformations, states, responses, Want::Stress);
            asked.map_err(|(k, error)| (grain * GRAIN + k, error))
        })
        .collect();
    if let Some((k, error)) = answers.into_iter().find_map(Result::err) {
        return Err(law_failure(block, range.start + k, &deformations[k].gradient, &error));
    }
    block.state.values_mut()[range.start * length..range.end * length].copy_from_slice(&states);
    let voigt = kinematics.voigt();
    for ((response, update), point) in responses.iter().zip(updates).zip(range.clone()) {
        if block.stress.is_used() {
            let row = block.stress.row_mut(point);
            voigt.iter().zip(&mut *row).for_each(|(&v, entry)| *entry = response.stress[v]);
            if let Some(pressure) = update.deformation.pressure.filter(|_| shifts_stress) {
                shift_mean(&mut row[..kinematics.dimension()], pressure);
            }
        }
        if block.strain.is_used() {
            let strain = block.law.strain(&update.deformation);
            let row = block.strain.row_mut(point);
            voigt.iter().zip(row).for_each(|(&v, entry)| *entry = strain[v]);
        }
    }
    Ok(())
}

/// Writes a point's update.
fn store(block: &mut Block, point: usize, update: &Update, nodal: &NodalResults) {
    let (time_step, gamma) = (nodal.time_step, nodal.gamma);
    let has_cell = block.cell[point] != NO_CELL;
    compress(&update.deformation.gradient, block.gradient.row_mut(point));
    block.position.row_mut(point).iter_mut().zip(update.step).for_each(|(x, step)| *x += step);
    if block.displacement.is_used() {
        block.displacement.row_mut(point).iter_mut().zip(update.step).for_each(|(x, step)| *x += step);
    }
    if block.velocity.is_used() {
        let old = block.acceleration.row_mut(point);
        for (i, (v, a)) in block.velocity.row_mut(point).iter_mut().zip(old).enumerate() {
            *v += match nodal.velocity_changes {
                [] => time_step * (gamma * update.acceleration[i] + (1.0 - gamma) * *a),
                _ => update.velocity_change[i],
            };
            *a = update.acceleration[i];
            if nodal.flip_fraction < 1.0 && has_cell {
                *v = nodal.flip_fraction * *v + (1.0 - nodal.flip_fraction) * update.velocity[i];
            }
        }
    }
    if let Some(pressure) = update.deformation.pressure.filter(|_| block.pressure.is_used()) {
        block.pressure.set(point, [pressure]);
    }
    if block.volume.is_used() {
        let reference = block.mass.get::<1>(point)[0] / block.density;
        block.volume.set(point, [reference * update.volume_ratio]);
    }
}
