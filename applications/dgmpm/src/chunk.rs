//! A chunk of cells with all that stands at their points and nodes, and the work on it.

use crate::faces::{Faces, RIGHT};
use crate::kind::{CellKind, FACES, Operator};
use crate::material::Material;
use crate::matrix::{Matrix, Vector, times};
use crate::riemann::{RiemannSolver, Trace};
use crate::stages::{Site, Stage};
use bia_constitutive::LawError;

/// Values at points or nodes, cell after cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Values<const D: usize> {
    /// Velocities (m/s).
    pub velocity: Vec<Vector<D>>,
    /// Displacement gradients H = F − 1, which keep the digits of small strain.
    pub gradient: Vec<Matrix<D>>,
    /// First Piola–Kirchhoff stress (Pa).
    pub stress: Vec<Matrix<D>>,
}

impl<const D: usize> Values<D> {
    /// Zeros at so many places.
    pub fn new(count: usize) -> Self {
        Self {
            velocity: vec![[0.0; D]; count],
            gradient: vec![[[0.0; D]; D]; count],
            stress: vec![[[0.0; D]; D]; count],
        }
    }

    fn of(&self, first: usize, count: usize) -> Slices<'_, D> {
        let range = first..first + count;
        Slices {
            velocity: &self.velocity[range.clone()],
            gradient: &self.gradient[range.clone()],
            stress: &self.stress[range],
        }
    }
}

/// Values of one cell.
#[derive(Clone, Copy)]
struct Slices<'a, const D: usize> {
    velocity: &'a [Vector<D>],
    gradient: &'a [Matrix<D>],
    stress: &'a [Matrix<D>],
}

/// Why a cell cannot go on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop<const D: usize> {
    /// Index of the cell.
    pub cell: usize,
    /// Displacement gradient there.
    pub gradient: Matrix<D>,
    /// Why.
    pub reason: Reason,
}

/// What has gone wrong in a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// The law has no answer.
    Law(LawError),
    /// Waves have no speed.
    NoWaveSpeed,
    /// A velocity is beyond [`FASTEST`], or not a number.
    Unbounded,
}

/// Velocity in m/s at which a run has blown up; its energies are still numbers then.
const FASTEST: f64 = 1e100;

/// A chunk of cells of one material and one number of points a cell.
#[derive(Debug, Clone, Default)]
pub struct Chunk<const D: usize> {
    /// Index of the first cell.
    pub first: usize,
    /// Kind of each cell.
    pub kinds: Vec<u32>,
    /// Points of a cell.
    pub points_per_cell: usize,
    /// Values at the points.
    pub points: Values<D>,
    /// Values at the cells' own nodes, between the stages; empty if there is one stage.
    pub nodes: Values<D>,
    /// Displacements of the points (m).
    pub displacement: Vec<Vector<D>>,
    /// Body forces per mass at the points (m/s²); empty for none.
    pub body: Vec<Vector<D>>,
    /// Impedance of each slot at finite strain; else empty.
    pub impedances: Vec<Matrix<D>>,
    /// Displacement gradient at each slot, for the exact Riemann solver; else empty.
    pub traced_gradients: Vec<Matrix<D>>,
    /// Smallest time that a wave needs from face to face (s).
    pub crossing: f64,
    /// The first cell that stopped.
    pub stop: Option<Stop<D>>,
    /// New values of one cell.
    pub scratch: (Vec<Vector<D>>, Vec<Matrix<D>>),
}

/// What the work on chunks reads.
pub struct Shared<'a, const D: usize> {
    /// Kinds of cells.
    pub kinds: &'a [CellKind<D>],
    /// Materials.
    pub materials: &'a [Material],
    /// Faces.
    pub faces: &'a Faces,
    /// States at the faces.
    pub stars: &'a [Trace<D>],
    /// Riemann solver.
    pub riemann: RiemannSolver,
}

impl<const D: usize> Shared<'_, D> {
    /// The state at a face of a cell on its own outward normal.
    #[inline(always)]
    pub fn star(&self, stars: &[Trace<D>], cell: usize, face: usize) -> Trace<D> {
        let tagged = self.faces.of_slots[cell * 2 * D + face];
        let mut star = stars[(tagged & !RIGHT) as usize];
        if tagged & RIGHT != 0 {
            star.traction = star.traction.map(|t| -t);
        }
        star
    }

    /// The states at all faces of a cell.
    #[inline(always)]
    fn stars_of(&self, cell: usize) -> [Trace<D>; FACES] {
        let mut out = [Trace::REST; FACES];
        for face in 0..2 * D {
            out[face] = self.star(self.stars, cell, face);
        }
        out
    }
}

impl<const D: usize> Chunk<D> {
    fn values(&self, site: Site) -> (&Values<D>, usize) {
        match site {
            Site::Points => (&self.points, self.points_per_cell),
            Site::Nodes => (&self.nodes, 1 << D),
        }
    }

    fn put(&mut self, site: Site, values: Values<D>) {
        match site {
            Site::Points => self.points = values,
            Site::Nodes => self.nodes = values,
        }
    }

    /// A stage of a step of `time_step` seconds: new values, their stress, and what the faces see.
    pub fn advance(
        &mut self,
        shared: &Shared<D>,
        index: usize,
        stage: &Stage,
        time_step: f64,
        traces: &mut [Trace<D>],
    ) {
        let step = stage.step * time_step;
        let mut new = std::mem::take(&mut self.scratch);
        for local in 0..self.kinds.len() {
            let kind = &shared.kinds[self.kinds[local] as usize];
            let density = shared.materials[kind.material as usize].density;
            let stars = shared.stars_of(self.first + local);
            let operator = &kind.operators[index];
            let (source, count) = self.values(stage.from);
            let source = source.of(local * count, count);
            let start = self.points.of(local * self.points_per_cell, self.points_per_cell);
            let body = match self.body.is_empty() {
                true => &[][..],
                false => &self.body[local * self.points_per_cell..(local + 1) * self.points_per_cell],
            };
            new.0.clear();
            new.1.clear();
            for target in 0..operator.targets {
                let (velocity, gradient) =
                    advance_target(target, operator, kind, density, [&source, &start], &stars, body, step);
                new.0.push(velocity);
                new.1.push(gradient);
            }
            self.store(stage.to, local, time_step, &new);
        }
        self.scratch = new;
        self.answer(shared, stage.to, traces);
    }

    /// Keeps the new values of a cell; its points move by the mean of their old and new velocity.
    #[inline(always)]
    fn store(&mut self, site: Site, local: usize, time_step: f64, new: &(Vec<Vector<D>>, Vec<Matrix<D>>)) {
        let count = new.0.len();
        let range = local * count..(local + 1) * count;
        if site == Site::Points {
            let moved = self.displacement[range.clone()].iter_mut().zip(&self.points.velocity[range.clone()]);
            for ((displacement, old), new) in moved.zip(&new.0) {
                for i in 0..D {
                    displacement[i] += 0.5 * time_step * (old[i] + new[i]);
                }
            }
        }
        let values = if site == Site::Points { &mut self.points } else { &mut self.nodes };
        values.velocity[range.clone()].copy_from_slice(&new.0);
        values.gradient[range].copy_from_slice(&new.1);
    }

    /// Stresses of the values at a site, and what the faces see of them.
    pub fn answer(&mut self, shared: &Shared<D>, site: Site, traces: &mut [Trace<D>]) {
        self.stop = None;
        self.crossing = f64::INFINITY;
        let Some(kind) = self.kinds.first() else { return };
        let material = &shared.materials[shared.kinds[*kind as usize].material as usize];
        let mut values = std::mem::take(if site == Site::Points { &mut self.points } else { &mut self.nodes });
        let answered = material.stresses(&values.gradient, &mut values.stress);
        if let Err((place, reason)) = answered {
            let count = values.velocity.len() / self.kinds.len();
            let gradient = values.gradient[place];
            self.stop = Some(Stop { cell: self.first + place / count, gradient, reason: Reason::Law(reason) });
        }
        // Linear laws answer anything, and what grows without bound spreads through the body without a word.
        if material.law.is_none() && site == Site::Points && !all_bounded(&values.velocity) {
            let place = values.velocity.iter().position(|v| !v.iter().all(|x| x.abs() < FASTEST)).unwrap_or(0);
            let cell = self.first + place / (values.velocity.len() / self.kinds.len()).max(1);
            self.stop = Some(Stop { cell, gradient: values.gradient[place], reason: Reason::Unbounded });
        }
        self.put(site, values);
        self.trace(shared, site, traces);
        if self.stop.is_none() && material.law.is_some() {
            self.find_impedances(shared, material, site);
        }
    }

    fn trace(&mut self, shared: &Shared<D>, site: Site, traces: &mut [Trace<D>]) {
        let mut gradients = std::mem::take(&mut self.traced_gradients);
        let (values, count) = self.values(site);
        for (local, kind) in self.kinds.iter().enumerate() {
            let kind = &shared.kinds[*kind as usize];
            let factors = if site == Site::Points { &kind.point_traces } else { &kind.node_traces };
            let cell = values.of(local * count, count);
            for face in 0..2 * D {
                let (mut velocity, mut stress) = ([0.0; D], [[0.0; D]; D]);
                for s in 0..count {
                    let factor = factors[s][face];
                    for i in 0..D {
                        velocity[i] += factor * cell.velocity[s][i];
                        for a in 0..D {
                            stress[i][a] += factor * cell.stress[s][i][a];
                        }
                    }
                }
                let slot = local * 2 * D + face;
                traces[slot] = Trace { velocity, traction: times(&stress, &kind.normals[face]) };
                if let Some(to) = gradients.get_mut(slot) {
                    *to = weighted(cell.gradient, |s| factors[s][face]);
                }
            }
        }
        self.traced_gradients = gradients;
    }

    /// Impedances of all slots from the mean deformation of each cell.
    fn find_impedances(&mut self, shared: &Shared<D>, material: &Material, site: Site) {
        let mut impedances = std::mem::take(&mut self.impedances);
        for (local, kind) in self.kinds.iter().enumerate() {
            let kind = &shared.kinds[*kind as usize];
            let (values, count) = self.values(site);
            let shares = if site == Site::Points { &kind.point_means } else { &kind.node_means };
            let mean = weighted(&values.gradient[local * count..(local + 1) * count], |s| shares[s]);
            let slots = &mut impedances[local * 2 * D..(local + 1) * 2 * D];
            let mut speeds = [0.0; FACES];
            if let Err(reason) = cell_impedances(kind, material, &mean, slots, &mut speeds) {
                let reason = reason.map_or(Reason::NoWaveSpeed, Reason::Law);
                self.stop = Some(Stop { cell: self.first + local, gradient: mean, reason });
                break;
            }
            for axis in 0..D {
                let speed = speeds[2 * axis].max(speeds[2 * axis + 1]);
                self.crossing = self.crossing.min(kind.height(axis) / speed);
            }
            if shared.riemann == RiemannSolver::Hll {
                let fastest = speeds.iter().fold(0.0_f64, |most, &speed| most.max(speed));
                slots.iter_mut().for_each(|slot| *slot = uniform(material.density * fastest));
            }
        }
        self.impedances = impedances;
    }

    /// Mean displacement gradient of a cell of this kind.
    pub fn mean_gradient(&self, local: usize, kind: &CellKind<D>) -> Matrix<D> {
        let count = self.points_per_cell;
        weighted(&self.points.gradient[local * count..(local + 1) * count], |s| kind.point_means[s])
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.velocity.len()
    }
}

/// `value` 1.
pub fn uniform<const D: usize>(value: f64) -> Matrix<D> {
    let mut matrix = [[0.0; D]; D];
    (0..D).for_each(|i| matrix[i][i] = value);
    matrix
}

fn weighted<const D: usize>(values: &[Matrix<D>], weight: impl Fn(usize) -> f64) -> Matrix<D> {
    let mut sum = [[0.0; D]; D];
    for (s, value) in values.iter().enumerate() {
        let factor = weight(s);
        for i in 0..D {
            for a in 0..D {
                sum[i][a] += factor * value[i][a];
            }
        }
    }
    sum
}

/// Impedances of a cell's slots and the speeds along their normals; opposite faces share them where they
/// are parallel.
fn cell_impedances<const D: usize>(
    kind: &CellKind<D>,
    material: &Material,
    mean: &Matrix<D>,
    slots: &mut [Matrix<D>],
    speeds: &mut [f64; FACES],
) -> Result<(), Option<LawError>> {
    if !kind.is_parallel {
        return material.impedances(mean, &kind.normals[..2 * D], slots, &mut speeds[..2 * D]);
    }
    let (mut normals, mut impedances, mut along) = ([[0.0; D]; D], [[[0.0; D]; D]; D], [0.0; D]);
    (0..D).for_each(|axis| normals[axis] = kind.normals[2 * axis + 1]);
    material.impedances(mean, &normals, &mut impedances, &mut along)?;
    for face in 0..2 * D {
        (slots[face], speeds[face]) = (impedances[face / 2], along[face / 2]);
    }
    Ok(())
}

/// New velocity and displacement gradient at a target.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // one inner loop, which must see all of them
fn advance_target<const D: usize>(
    target: usize,
    operator: &Operator<D>,
    kind: &CellKind<D>,
    density: f64,
    [source, start]: [&Slices<D>; 2],
    stars: &[Trace<D>; FACES],
    body: &[Vector<D>],
    step: f64,
) -> (Vector<D>, Matrix<D>) {
    let (mut velocity, mut gradient) = ([0.0; D], [[0.0; D]; D]);
    let mut add = |factors: &[f64], values: &Slices<D>| {
        for (s, factor) in factors.iter().enumerate() {
            for i in 0..D {
                velocity[i] += factor * values.velocity[s][i];
                for a in 0..D {
                    gradient[i][a] += factor * values.gradient[s][i][a];
                }
            }
        }
    };
    if !operator.base.is_empty() {
        let points = operator.base.len() / operator.targets;
        add(&operator.base[target * points..(target + 1) * points], start);
    }
    if !operator.keep.is_empty() {
        add(&operator.keep[target * operator.sources..(target + 1) * operator.sources], source);
    }
    if !operator.volume.is_empty() {
        let factors = &operator.volume[target * operator.sources..(target + 1) * operator.sources];
        for (s, factor) in factors.iter().enumerate() {
            for i in 0..D {
                for a in 0..D {
                    velocity[i] -= step * factor[a] * source.stress[s][i][a];
                    gradient[i][a] -= step * density * factor[a] * source.velocity[s][i];
                }
            }
        }
    }
    for (face, star) in stars.iter().enumerate().take(2 * D) {
        let factor = step * operator.faces[target][face];
        for i in 0..D {
            velocity[i] += factor * star.traction[i];
            let pushed = factor * density * star.velocity[i];
            for a in 0..D {
                gradient[i][a] += pushed * kind.normals[face][a];
            }
        }
    }
    for (p, force) in body.iter().enumerate() {
        let factor = step * operator.body[target * body.len() + p];
        for i in 0..D {
            velocity[i] += factor * force[i];
        }
    }
    (velocity, gradient)
}

/// Whether all are numbers below [`FASTEST`]; without branches, so that it costs next to nothing.
fn all_bounded<const D: usize>(vectors: &[Vector<D>]) -> bool {
    let high = |x: f64| (x.to_bits() >> 32) as u32 & 0x7fff_ffff;
    let beyond = vectors.as_flattened().iter().map(|x| u32::from(high(*x) >= high(FASTEST)));
    beyond.sum::<u32>() == 0
}
