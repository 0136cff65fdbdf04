//! The strain: what the velocity of the grid does to the points' deformation and stress.

use super::chunk::Chunk;
use super::kinematics::{deform, strain};
use super::rows::Rows;
use super::sample::Sample;
use super::to_points::{AtPoint, Cause, Field};
use crate::points::gradient_width;
use bia_constitutive::tensor::{Tensor, adjugate, identity};
use bia_constitutive::{Deformation, Group, Kinematics, Law, Voigt};
use bia_kernel::lanes::{Lanes, Pack, WIDTH, dispatch};
use nalgebra::Matrix3;
use pulp::Simd;

/// Groups of points whose law is asked in one call.
const BATCH: usize = 4;

/// The points of one block as far as their stress goes.
pub struct Material<'a> {
    /// Their law.
    pub law: &'a dyn Law,
    /// Initial density in kg/m³.
    pub density: f64,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// The grid.
    pub field: &'a Field<'a>,
}

/// Groups of points on the way to their law and back.
pub struct Batch {
    /// Deformation gradients at the start of the step, for laws that do not answer in step.
    before: [Tensor<Pack>; BATCH],
    groups: [Group; BATCH],
    stresses: [[Pack; 6]; BATCH],
}

impl Default for Batch {
    fn default() -> Self {
        let zero = Pack([0.0; WIDTH]);
        Self {
            before: [[[zero; 3]; 3]; BATCH],
            groups: [Group { gradient: [[zero; 3]; 3], strain: [zero; 6] }; BATCH],
            stresses: [[zero; 6]; BATCH],
        }
    }
}

impl Material<'_> {
    /// Deforms the sampled points of a chunk and asks their law for the stress.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    pub fn strain<const D: usize>(&self, chunk: &mut Chunk, samples: &[Sample], batch: &mut Batch) -> AtPoint<()> {
        for samples in samples.chunks(BATCH) {
            dispatch(self.field.grid.arch, Strain::<D> { material: self, chunk, samples, batch })?;
            let (groups, stresses) = (&batch.groups[..samples.len()], &mut batch.stresses[..samples.len()]);
            if !self.law.stresses_in_step(groups, stresses) {
                for k in 0..samples.len() {
                    let (group, before) = (&batch.groups[k], &batch.before[k]);
                    batch.stresses[k] = self.one_by_one(chunk, samples[k].rows, group, before)?;
                }
            }
            dispatch(self.field.grid.arch, Answer::<D> { material: self, chunk, samples, batch });
            if !chunk.strain.is_empty() && !self.accumulates_strain(chunk) {
                for k in 0..samples.len() {
                    self.show_strain(chunk, samples[k].rows, &batch.groups[k], &batch.before[k]);
                }
            }
        }
        Ok(())
    }

    fn accumulates_strain(&self, chunk: &Chunk) -> bool {
        self.law.uses_strain() || (self.field.grid.faults.shows_accumulated_strain() && !chunk.strain.is_empty())
    }

    fn deformations(&self, chunk: &Chunk, group: &Group, before: &Tensor<Pack>) -> [Deformation; WIDTH] {
        let accumulates = self.accumulates_strain(chunk);
        std::array::from_fn(|l| Deformation {
            gradient: Matrix3::from_fn(|a, b| group.gradient[a][b].0[l]),
            previous: self.field.grid.faults.previous(&Matrix3::from_fn(|a, b| before[a][b].0[l])),
            time_step: self.field.time_step,
            strain: accumulates.then(|| group.strain.map(|e| e.0[l])),
            pressure: None,
        })
    }

    /// Stresses of laws that answer point by point.
    fn one_by_one(&self, chunk: &mut Chunk, rows: Rows, group: &Group, before: &Tensor<Pack>) -> AtPoint<[Pack; 6]> {
        let deformations = self.deformations(chunk, group, before);
        let width = self.law.state_len();
        let states = &mut chunk.state[rows.first * width..(rows.first + rows.count) * width];
        let mut stresses: [Voigt; WIDTH] = [[0.0; 6]; WIDTH];
        let (deformations, out) = (&deformations[..rows.count], &mut stresses[..rows.count]);
        let asked = if self.field.grid.faults.forgets_history() && width > 0 {
            self.law.stresses(deformations, &mut states.to_vec(), out)
        } else {
            self.law.stresses(deformations, states, out)
        };
        asked.map_err(|(k, error)| (rows.first + k, Cause::Law(error)))?;
        Ok(std::array::from_fn(|c| Pack(std::array::from_fn(|l| stresses[l][c]))))
    }

    /// The strain in the measure of the law, where someone reads it.
    fn show_strain(&self, chunk: &mut Chunk, rows: Rows, group: &Group, before: &Tensor<Pack>) {
        let deformations = self.deformations(chunk, group, before);
        let strains = deformations.map(|deformation| self.law.strain(&deformation));
        for (strain, row) in strains.iter().zip(rows.points()) {
            let components = self.kinematics.voigt();
            let row = &mut chunk.strain[row * components.len()..(row + 1) * components.len()];
            row.iter_mut().zip(components).for_each(|(entry, &c)| *entry = strain[c]);
        }
    }
}

/// Deformation of points.
struct Strain<'a, 'c, const D: usize> {
    material: &'a Material<'a>,
    chunk: &'a mut Chunk<'c>,
    samples: &'a [Sample],
    batch: &'a mut Batch,
}

impl<const D: usize> pulp::WithSimd for Strain<'_, '_, D> {
    type Output = AtPoint<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { material, chunk, samples, batch } = self;
        let field = material.field;
        let accumulates = material.accumulates_strain(chunk);
        // What is asked of the strain of a law that does not take it needs the old gradient too.
        let remembers = !material.law.answers_in_step() || (!chunk.strain.is_empty() && !accumulates);
        for (k, sample) in samples.iter().enumerate() {
            let rows = sample.rows;
            let mut step = [[Lanes::splat(simd, 0.0); 3]; 3];
            for a in 0..3 {
                for b in 0..3 {
                    if a.max(b) < D || (D == 2 && a == 2 && b == 2) {
                        step[a][b] = Lanes::load(simd, &sample.gradient[a][b]) * field.time_step;
                    }
                }
            }
            let before = load_gradient::<S, D>(simd, rows, chunk.gradient, material.kinematics);
            let motion = deform(&before, &step, field.frame, field.grid.faults);
            let after = if field.compressible { &motion.gradient } else { &before };
            if field.compressible {
                material.deform(simd, chunk, rows, after)?;
            }
            let group = &mut batch.groups[k];
            for a in 0..3 {
                for b in 0..3 {
                    after[a][b].store(&mut group.gradient[a][b]);
                    if remembers {
                        before[a][b].store(&mut batch.before[k][a][b]);
                    }
                }
            }
            if accumulates {
                let old = rows.load_components::<S, D>(simd, chunk.strain, material.kinematics.voigt());
                let new = strain(&old, &motion.step, field.grid.faults);
                for c in 0..6 {
                    new[c].store(&mut group.strain[c]);
                }
            }
        }
        Ok(())
    }
}

/// What the law answered, and the strain that it was asked about.
struct Answer<'a, 'c, const D: usize> {
    material: &'a Material<'a>,
    chunk: &'a mut Chunk<'c>,
    samples: &'a [Sample],
    batch: &'a Batch,
}

impl<const D: usize> pulp::WithSimd for Answer<'_, '_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { material, chunk, samples, batch } = self;
        let components = material.kinematics.voigt();
        let accumulates = material.accumulates_strain(chunk);
        for (k, sample) in samples.iter().enumerate() {
            store::<S, D>(simd, sample.rows, chunk.stress, components, &batch.stresses[k]);
            if accumulates {
                store::<S, D>(simd, sample.rows, chunk.strain, components, &batch.groups[k].strain);
            }
        }
    }
}

#[inline(always)]
fn store<S: Simd, const D: usize>(simd: S, rows: Rows, column: &mut [f64], components: &[usize], packs: &[Pack; 6]) {
    let mut lanes = [Lanes::splat(simd, 0.0); 6];
    for c in 0..6 {
        lanes[c] = Lanes::load(simd, &packs[c]);
    }
    rows.store_components::<S, D>(column, components, &lanes);
}

impl Material<'_> {
    /// Stores a new deformation gradient and volume.
    #[inline(always)]
    fn deform<S: Simd>(&self, simd: S, chunk: &mut Chunk, rows: Rows, gradient: &Tensor<Lanes<S>>) -> AtPoint<()> {
        let (_, jacobian) = adjugate(gradient);
        if !jacobian.all_within(f64::MIN_POSITIVE, f64::MAX) {
            let jacobians = jacobian.pack().0;
            let bad = |jacobian: &f64| !(*jacobian > 0.0 && jacobian.is_finite());
            let lane = jacobians[..rows.count].iter().position(bad).unwrap_or(0);
            return Err((rows.first + lane, Cause::Inverted(jacobians[lane])));
        }
        store_gradient(rows, chunk.gradient, self.kinematics, gradient);
        if !chunk.volume.is_empty() {
            let [mass] = rows.load::<S, 1>(simd, chunk.mass);
            rows.store(chunk.volume, &[mass * (1.0 / self.density) * jacobian]);
        }
        Ok(())
    }
}

/// Deformation gradients of points in step (see [`crate::points::expand`] for their storage).
#[inline(always)]
pub fn load_gradient<S: Simd, const D: usize>(
    simd: S,
    rows: Rows,
    column: &[f64],
    kinematics: Kinematics,
) -> Tensor<Lanes<S>> {
    let mut f = identity(Lanes::splat(simd, 0.0));
    match (D, gradient_width(kinematics)) {
        (1, _) => [f[0][0]] = rows.load(simd, column),
        (2, 5) => [f[0][0], f[0][1], f[1][0], f[1][1], f[2][2]] = rows.load(simd, column),
        (2, _) => [f[0][0], f[0][1], f[1][0], f[1][1]] = rows.load(simd, column),
        _ => {
            let all = rows.load::<S, 9>(simd, column);
            for k in 0..9 {
                f[k / 3][k % 3] = all[k];
            }
        }
    }
    f
}

/// Writes what [`load_gradient`] reads.
#[inline(always)]
fn store_gradient<S: Simd>(rows: Rows, column: &mut [f64], kinematics: Kinematics, f: &Tensor<Lanes<S>>) {
    match gradient_width(kinematics) {
        1 => rows.store(column, &[f[0][0]]),
        4 => rows.store(column, &[f[0][0], f[0][1], f[1][0], f[1][1]]),
        5 => rows.store(column, &[f[0][0], f[0][1], f[1][0], f[1][1], f[2][2]]),
        _ => {
            let mut all = [f[0][0]; 9];
            for k in 0..9 {
                all[k] = f[k / 3][k % 3];
            }
            rows.store(column, &all);
        }
    }
}
