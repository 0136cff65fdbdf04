//! The nodes of the active cells in one step: boundary values, velocities, accelerations.

use super::kratos_faults::KratosFaults;
use super::to_grid::NodalSums;
use crate::active::ActiveCells;
use crate::space::Space;
use crate::variables::DISPLACEMENT;
use bia_kernel::error::Failure;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::ModelPart;
use bia_kernel::solving::{ActiveDofs, NodalFrames};
use rayon::prelude::*;

/// Share of the largest mass by which one may be negative: points may stand a little outside their cells.
const NEGLIGIBLE: f64 = 1e-5;

/// Share of the largest mass up to which a node is light. Masses and momenta are sums with round-off of 1e-16 of
/// the largest, so that of their ratio no more than half of the digits would be right.
const LIGHT: f64 = 1e-8;

/// Nodes that one thread takes at a time.
const NODES: usize = 2048;

/// State of the active nodes; all vectors by active dof but `mass`, which `sums` holds by node.
#[derive(Default)]
pub struct Nodes {
    /// Numbers of the active nodes; fixed components.
    pub dofs: ActiveDofs,
    /// Frames of nodes that slide along walls.
    pub frames: NodalFrames,
    /// Mass, momentum, force.
    pub sums: NodalSums,
    /// Velocity; after the step, the one that deformed the points last.
    pub velocity: Vec<f64>,
    /// Velocity that carries the points.
    pub carrying: Vec<f64>,
    /// Displacement in the total frame, where the transfer asks for it; else empty.
    pub displacement: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
    /// Force that holds the fixed components.
    pub reaction: Vec<f64>,
    /// Force of loads; empty without any.
    loads: Vec<f64>,
    imposed: Vec<f64>,
    /// Velocities imposed in the last step by grid node, NaN where free; empty while none moves.
    last: Vec<[f64; 3]>,
    /// Supports move now, and did not before.
    begins: bool,
    least_mass: f64,
    /// Light nodes, each with the others of its active cells.
    light: Vec<(u32, Vec<u32>)>,
    /// Fixed components of the mesh's nodes and of the functions, where these are not the same.
    fixed: Vec<[bool; 3]>,
    held: Vec<[bool; 3]>,
}

impl Nodes {
    /// Numbers the nodes of the active cells.
    pub fn renumber(&mut self, space: &Space, active: &ActiveCells, dimension: usize) {
        self.dofs = space.active_dofs(&active.cells, dimension);
    }

    /// Saves or loads what is not found anew in each step.
    ///
    /// # Errors
    /// The checkpoint does not hold it.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.column("displacement", &mut self.displacement)?;
        archive.column("imposed velocities", &mut self.last)
    }

    /// Sets sums to zero and reads the fixed components. A displacement u imposed on one acts as the
    /// velocity u/Δt; its acceleration is the change of that velocity since the last step.
    pub fn start(&mut self, grid: &ModelPart, space: &Space, time_step: f64, faults: KratosFaults) {
        self.clear();
        let block = self.dofs.block();
        self.fix(grid, space, time_step, faults);
        let slides = if faults.ignores_walls() { &[] } else { grid.node_fields.slides(&DISPLACEMENT) };
        self.frames = NodalFrames::new(block, &self.dofs, slides);
    }

    /// Sets sums to zero, with room for all fields.
    pub fn clear(&mut self) {
        self.sums.reset(&self.dofs);
        self.loads.clear();
        let order = self.dofs.order();
        for values in [&mut self.velocity, &mut self.acceleration, &mut self.imposed, &mut self.reaction] {
            values.resize(order, 0.0);
        }
    }

    fn fix(&mut self, grid: &ModelPart, space: &Space, time_step: f64, faults: KratosFaults) {
        let block = self.dofs.block();
        let Some(fixed) = grid.node_fields.fixed(&DISPLACEMENT) else { return self.dofs.fixed_mut().fill(false) };
        if !space.is_mesh() && self.fixed != fixed {
            (self.fixed, self.held) = (fixed.to_vec(), space.held(fixed).into_owned());
        }
        let fixed = if space.is_mesh() { fixed } else { &self.held[..] };
        let values = space.at_anchors(grid.node_fields.vector(&DISPLACEMENT).unwrap_or_default());
        let imposed =
            |node: usize, a: usize| values.get(node).map_or(0.0, |u| faults.imposed_velocity(u[a], time_step));
        let (nodes, holds) = self.dofs.nodes_and_fixed_mut();
        let of_dofs = holds.par_chunks_mut(block * NODES).zip(self.acceleration.par_chunks_mut(block * NODES));
        let of_dofs = of_dofs.zip(self.imposed.par_chunks_mut(block * NODES));
        let moves = nodes.par_chunks(NODES).zip(of_dofs).map(|(nodes, ((holds, accelerations), velocities))| {
            let mut moves = false;
            for (number, &node) in nodes.iter().enumerate() {
                let node = node as usize;
                for a in 0..block {
                    let dof = number * block + a;
                    holds[dof] = fixed[node][a];
                    if fixed[node][a] {
                        velocities[dof] = imposed(node, a);
                        let last = self.last.get(node).map_or(f64::NAN, |last| last[a]);
                        let change = if last.is_finite() { velocities[dof] - last } else { 0.0 };
                        accelerations[dof] = change / time_step;
                        moves |= velocities[dof] != 0.0;
                    }
                }
            }
            moves
        });
        let moves = moves.reduce(|| false, |a, b| a | b);
        self.begins = moves && self.last.is_empty();
        // Only walls that move are remembered, and all their nodes, active or not.
        if !self.last.is_empty() || moves {
            self.last.resize(space.len(), [f64::NAN; 3]);
            for (node, last) in self.last.iter_mut().enumerate() {
                *last = std::array::from_fn(|a| if fixed[node][a] { imposed(node, a) } else { f64::NAN });
            }
        }
    }

    /// Whether supports move now and have not been seen to move.
    pub fn begin_to_move(&self) -> bool {
        self.begins
    }

    /// Takes supports that move now as having moved as the body did before, with this velocity.
    pub fn start_supports(&mut self, of_body: &[f64], time_step: f64) {
        for (dof, held) in self.dofs.fixed().iter().enumerate() {
            if *held && self.imposed[dof] != 0.0 {
                self.acceleration[dof] = (self.imposed[dof] - of_body[dof]) / time_step;
            }
        }
    }

    /// Adds loads to the forces.
    pub fn load(&mut self, add: impl FnOnce(&ActiveDofs, &mut [f64])) {
        self.loads.clear();
        self.loads.resize(self.dofs.order(), 0.0);
        add(&self.dofs, &mut self.loads);
        self.sums.force.iter_mut().zip(&self.loads).for_each(|(force, load)| *force += load);
    }

    /// Work in J of loads and of supports that move in a step of this length.
    pub fn work(&self, time_step: f64) -> f64 {
        let of = |forces: &[f64]| forces.iter().zip(&self.carrying).map(|(f, v)| f * v).sum::<f64>();
        // Supports move where walls are remembered.
        time_step * (of(&self.loads) + if self.last.is_empty() { 0.0 } else { of(&self.reaction) })
    }

    /// Fixes the mass below which nodes are left alone, once the masses are there, and finds such nodes.
    ///
    /// # Errors
    /// A function whose lumped mass is negative: with polynomials of degree 2 and more that change sign.
    pub fn weigh(&mut self, space: &Space, active: &ActiveCells, faults: KratosFaults) -> Result<(), Failure> {
        const NONE: (f64, f64) = (f64::INFINITY, 0.0);
        let bounds = |masses: &[f64]| masses.iter().fold(NONE, |(low, high), m| (m.min(low), m.max(high)));
        let widen = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        let (least, largest) = self.sums.mass.par_chunks(NODES).map(bounds).reduce(|| NONE, widen);
        self.least_mass = faults.least_mass(largest);
        self.light.clear();
        // Splines vanish smoothly where their support ends, so that light nodes do no harm there.
        let light = if space.is_mesh() { LIGHT * largest } else { self.least_mass };
        if least <= light && !faults.stops_light_nodes() {
            self.find_light(space, active, light);
        }
        if least >= -NEGLIGIBLE * largest {
            return Ok(());
        }
        let what = format!("a function of the grid has the negative lumped mass {least:e} kg");
        let advice = "\"consistent_mass_matrix\": true, more points in each cell, a lower basis_order or b_spline";
        Err(Failure::new(what, advice))
    }

    /// A point on a face of its cell gives the nodes beyond no mass, but they are in its gradients.
    fn find_light(&mut self, space: &Space, active: &ActiveCells, mass: f64) {
        let light = |number: &u32| self.sums.mass[*number as usize] <= mass;
        let mut sources = std::collections::BTreeMap::<u32, Vec<u32>>::new();
        for &cell in &active.cells {
            let numbers = space.nodes_of(cell as usize).iter();
            let numbers: Vec<u32> = numbers.filter_map(|&node| self.dofs.number(node)).map(|n| n as u32).collect();
            for &number in numbers.iter().filter(|number| light(number)) {
                let others = numbers.iter().filter(|number| !light(number));
                sources.entry(number).or_default().extend(others);
            }
        }
        for others in sources.values_mut() {
            others.sort_unstable();
            others.dedup();
        }
        self.light = sources.into_iter().collect();
    }

    /// The forces of light nodes act on the others, so that none is lost.
    fn pass_on_forces(&mut self) {
        let (block, mass, force) = (self.dofs.block(), &self.sums.mass, &mut self.sums.force);
        for (node, others) in &self.light {
            let total: f64 = others.iter().map(|&other| mass[other as usize]).sum();
            for a in (0..block).filter(|a| total > 0.0 && !self.dofs.fixed()[*node as usize * block + a]) {
                let passed = std::mem::take(&mut force[*node as usize * block + a]);
                for &other in others {
                    force[other as usize * block + a] += mass[other as usize] / total * passed;
                }
            }
        }
    }

    /// Light nodes move as the material of their cells does: so they would with any mass, however small,
    /// while at rest they would tear or hold it.
    fn drag_light(&mut self) {
        let (block, mass) = (self.dofs.block(), &self.sums.mass);
        for (node, others) in &self.light {
            let total: f64 = others.iter().map(|&other| mass[other as usize]).sum();
            for a in 0..block {
                let dof = *node as usize * block + a;
                if total > 0.0 && !self.dofs.fixed()[dof] {
                    let of = |other: &u32| mass[*other as usize] * self.velocity[*other as usize * block + a];
                    self.velocity[dof] = others.iter().map(of).sum::<f64>() / total;
                }
            }
        }
    }

    /// Velocity from momentum, imposed where fixed.
    pub fn find_velocity(&mut self) {
        let (sums, block, fixed) = (&self.sums, self.dofs.block(), self.dofs.fixed());
        let (least, imposed) = (self.least_mass, &self.imposed);
        self.velocity.par_chunks_mut(block * NODES).enumerate().for_each(|(chunk, velocity)| {
            for (node, velocity) in (chunk * NODES..).zip(velocity.chunks_exact_mut(block)) {
                let mass = sums.mass[node];
                for (dof, v) in (node * block..).zip(velocity) {
                    let free = if mass > least { sums.momentum[dof] / mass } else { 0.0 };
                    *v = if fixed[dof] { imposed[dof] } else { free };
                }
            }
        });
        self.drag_light();
        self.frames.slide(&mut self.velocity);
    }

    /// Lets the points be carried by the velocity as it is now.
    pub fn carry(&mut self) {
        self.carrying.resize(self.velocity.len(), 0.0);
        let carrying = self.carrying.par_chunks_mut(NODES).zip(self.velocity.par_chunks(NODES));
        carrying.for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// Momentum over mass, whatever is imposed.
    pub fn mean_velocity(&self) -> Vec<f64> {
        let (sums, block) = (&self.sums, self.dofs.block());
        let mass = |dof: usize| Some(sums.mass[dof / block]).filter(|mass| *mass > self.least_mass);
        let of = |dof: usize| mass(dof).map_or(0.0, |mass| sums.momentum[dof] / mass);
        (0..self.dofs.order()).into_par_iter().with_min_len(NODES).map(of).collect()
    }

    /// Replaces the accelerations of the free dofs.
    pub fn set_free_accelerations(&mut self, accelerations: &[f64]) {
        for (dof, acceleration) in self.acceleration.iter_mut().enumerate() {
            if !self.dofs.fixed()[dof] {
                *acceleration = accelerations[dof];
            }
        }
        self.frames.slide(&mut self.acceleration);
    }

    /// Accelerations, reactions, and momentum after the time `impulse`.
    pub fn accelerate(&mut self, impulse: f64) {
        self.pass_on_forces();
        let (block, fixed, least) = (self.dofs.block(), self.dofs.fixed(), self.least_mass);
        let (mass, force, imposed) = (&self.sums.mass, &self.sums.force, &self.imposed);
        let momentum = self.sums.momentum.par_chunks_mut(block * NODES);
        let answers = self.acceleration.par_chunks_mut(block * NODES).zip(self.reaction.par_chunks_mut(block * NODES));
        momentum.zip(answers).enumerate().for_each(|(chunk, (momentum, (acceleration, reaction)))| {
            for (i, &mass) in mass[chunk * NODES..].iter().enumerate().take(momentum.len() / block) {
                let mass = if mass > least { mass } else { 0.0 };
                for own in i * block..(i + 1) * block {
                    let dof = chunk * NODES * block + own;
                    if fixed[dof] {
                        reaction[own] = mass * acceleration[own] - force[dof];
                        momentum[own] = mass * imposed[dof];
                    } else {
                        reaction[own] = 0.0;
                        acceleration[own] = if mass > 0.0 { force[dof] / mass } else { 0.0 };
                        momentum[own] += impulse * force[dof];
                    }
                }
            }
        });
        if self.frames.is_empty() {
            return;
        }
        self.frames.slide(&mut self.acceleration);
        self.frames.slide(&mut self.sums.momentum);
        for dof in 0..self.dofs.order() {
            let mass = Some(self.sums.mass[dof / block]).filter(|mass| *mass > least).unwrap_or(0.0);
            self.reaction[dof] = mass * self.acceleration[dof] - self.sums.force[dof];
        }
        self.frames.keep_held(&self.dofs, &mut self.reaction);
    }
}
