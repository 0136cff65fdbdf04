//! The strain: what the velocity of the grid does to the points' deformation and stress.

use super::cells::Cell;
use super::chunk::Chunk;
use super::kinematics::{deform, strain};
use super::rows::Rows;
use super::to_points::{AtPoint, Cause, Field, groups, runs, shapes};
use crate::grid::{GridCell, corners, nodal_vectors, with_shape};
use crate::points::gradient_width;
use bia_constitutive::tensor::{Tensor, adjugate, identity};
use bia_constitutive::{Deformation, Group, Kinematics, Law, Voigt, WIDTH};
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use bia_kernel::lanes::{Lanes, Real};
use nalgebra::Matrix3;
use std::marker::PhantomData;
use std::ops::Range;

/// Groups of points whose law is asked in one call.
const BATCH: usize = 8;

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

/// Groups whose law has not been asked yet.
struct Batch {
    rows: [Rows; BATCH],
    /// Deformation gradients at the start of the step.
    before: [Tensor<Lanes<WIDTH>>; BATCH],
    groups: [Group; BATCH],
    stresses: [[Lanes<WIDTH>; 6]; BATCH],
    len: usize,
}

impl Material<'_> {
    /// Deforms the points of a chunk and asks their law for the stress.
    ///
    /// # Errors
    /// An inverted deformation, or a law without an answer.
    pub fn strain(&self, chunk: &mut Chunk) -> AtPoint<()> {
        let zero = Lanes::splat(0.0);
        let group = Group { gradient: [[zero; 3]; 3], strain: [zero; 6] };
        let mut batch = Batch {
            rows: [Rows { first: 0, count: 0 }; BATCH],
            before: [group.gradient; BATCH],
            groups: [group; BATCH],
            stresses: [[zero; 6]; BATCH],
            len: 0,
        };
        for (range, shape) in shapes(chunk.cell, self.field.grid) {
            with_shape!(shape, |S, D, N| {
                let batch = &mut batch;
                let task = Strain::<S, D, N> { material: self, chunk, range, batch, shape: PhantomData };
                self.field.arch.dispatch(task)?;
            }, else ());
        }
        self.ask(chunk, &mut batch)
    }

    fn accumulates_strain(&self, chunk: &Chunk) -> bool {
        self.law.uses_strain() || (self.field.faults.shows_accumulated_strain() && !chunk.strain.is_empty())
    }

    /// Asks the law about a batch and stores its answers.
    fn ask(&self, chunk: &mut Chunk, batch: &mut Batch) -> AtPoint<()> {
        let len = std::mem::take(&mut batch.len);
        let in_step = self.law.stresses_in_step(&batch.groups[..len], &mut batch.stresses[..len]);
        let components = self.kinematics.voigt();
        let accumulates = self.accumulates_strain(chunk);
        for k in 0..len {
            let (rows, group, mut stress) = (batch.rows[k], &batch.groups[k], batch.stresses[k]);
            let sum = stress[0] + stress[1] + stress[2] + stress[3] + stress[4] + stress[5];
            if !in_step || sum.0.iter().any(|sum| !sum.is_finite()) {
                stress = self.one_by_one(chunk, rows, group, &batch.before[k])?;
            }
            rows.store_components(chunk.stress, components, &stress);
            if accumulates {
                rows.store_components(chunk.strain, components, &group.strain);
            } else if !chunk.strain.is_empty() {
                self.show_strain(chunk, rows, group, &batch.before[k]);
            }
        }
        Ok(())
    }

    fn deformations(&self, chunk: &Chunk, group: &Group, before: &Tensor<Lanes<WIDTH>>) -> [Deformation; WIDTH] {
        let accumulates = self.accumulates_strain(chunk);
        std::array::from_fn(|l| Deformation {
            gradient: Matrix3::from_fn(|a, b| group.gradient[a][b].0[l]),
            previous: self.field.faults.previous(&Matrix3::from_fn(|a, b| before[a][b].0[l])),
            time_step: self.field.time_step,
            strain: accumulates.then(|| group.strain.map(|e| e.0[l])),
            pressure: None,
        })
    }

    /// Stresses of laws that answer point by point.
    fn one_by_one(
        &self,
        chunk: &mut Chunk,
        rows: Rows,
        group: &Group,
        before: &Tensor<Lanes<WIDTH>>,
    ) -> AtPoint<[Lanes<WIDTH>; 6]> {
        let deformations = self.deformations(chunk, group, before);
        let width = self.law.state_len();
        let states = &mut chunk.state[rows.first * width..(rows.first + rows.count) * width];
        let mut stresses: [Voigt; WIDTH] = [[0.0; 6]; WIDTH];
        let (deformations, out) = (&deformations[..rows.count], &mut stresses[..rows.count]);
        let asked = if self.field.faults.forgets_history() && width > 0 {
            self.law.stresses(deformations, &mut states.to_vec(), out)
        } else {
            self.law.stresses(deformations, states, out)
        };
        asked.map_err(|(k, error)| (rows.first + k, Cause::Law(error)))?;
        Ok(std::array::from_fn(|c| Lanes(std::array::from_fn(|l| stresses[l][c]))))
    }

    /// The strain in the measure of the law, where someone reads it.
    fn show_strain(&self, chunk: &mut Chunk, rows: Rows, group: &Group, before: &Tensor<Lanes<WIDTH>>) {
        let deformations = self.deformations(chunk, group, before);
        let strains = deformations.map(|deformation| self.law.strain(&deformation));
        let lanes = std::array::from_fn(|c| Lanes(std::array::from_fn(|l| strains[l][c])));
        rows.store_components(chunk.strain, self.kinematics.voigt(), &lanes);
    }
}

/// Deformation of points in cells of one shape.
struct Strain<'a, 'b, B, const D: usize, const N: usize> {
    material: &'a Material<'a>,
    chunk: &'a mut Chunk<'b>,
    range: Range<usize>,
    batch: &'a mut Batch,
    shape: PhantomData<B>,
}

impl<B: GridCell<D, N>, const D: usize, const N: usize> pulp::WithSimd for Strain<'_, '_, B, D, N> {
    type Output = AtPoint<()>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { material, chunk, batch, .. } = self;
        let field = material.field;
        let accumulates = material.accumulates_strain(chunk);
        for (run, index) in runs(chunk.cell, self.range) {
            let nodes = field.grid.elements.nodes_of(index);
            let cell = Cell::new(B::of(field.grid, index), corners::<D, N>(field.grid, nodes), field.mapping);
            let velocity = nodal_vectors::<D, N>(field.dofs, nodes, field.velocity);
            for rows in groups(run) {
                let step = material.step(&cell, &velocity, chunk, rows);
                let before = load_gradient::<D>(rows, chunk.gradient, material.kinematics);
                batch.before[batch.len] = before;
                let group = &mut batch.groups[batch.len];
                group.gradient = before;
                let motion = deform(&before, &step, field.frame, field.faults);
                if field.compressible {
                    material.deform(chunk, rows, &motion.gradient)?;
                    group.gradient = motion.gradient;
                }
                if accumulates {
                    let old = rows.load_components(chunk.strain, material.kinematics.voigt());
                    group.strain = strain(&old, &motion.step, field.faults);
                }
                batch.rows[batch.len] = rows;
                batch.len += 1;
                if batch.len == BATCH {
                    material.ask(chunk, batch)?;
                }
            }
        }
        Ok(())
    }
}

impl Material<'_> {
    /// Δt times the gradient of the grid's velocity, with the hoop rate if axisymmetric.
    #[inline(always)]
    fn step<B: GridCell<D, N>, const D: usize, const N: usize>(
        &self,
        cell: &Cell<B, D, N>,
        velocity: &[[f64; D]; N],
        chunk: &Chunk,
        rows: Rows,
    ) -> Tensor<Lanes<WIDTH>> {
        let zero = Lanes::splat(0.0);
        let position = rows.load(chunk.position);
        let xi = cell.local(&position, || rows.load(chunk.local));
        let mut gradients = cell.basis.gradients(&xi);
        let inverse = cell.inverse_jacobian(&gradients);
        let axisymmetric = D == 2 && self.kinematics == Kinematics::Axisymmetric;
        let mut functions = [zero; N];
        let mut radius = zero;
        if axisymmetric || self.field.faults.0 {
            functions = cell.basis.functions(&xi);
            radius = cell.radius(&functions);
            self.field.faults.misalign_lanes(&mut functions, &mut gradients);
        }
        let mut local = [[zero; D]; D];
        for i in 0..N {
            for a in 0..D {
                for c in 0..D {
                    local[a][c] += gradients[i][c] * velocity[i][a];
                }
            }
        }
        let mut step = [[zero; 3]; 3];
        for a in 0..D {
            for b in 0..D {
                let mut sum = local[a][0] * inverse[0][b];
                for c in 1..D {
                    sum += local[a][c] * inverse[c][b];
                }
                step[a][b] = sum * self.field.time_step;
            }
        }
        if axisymmetric {
            let mut radial = zero;
            for i in 0..N {
                radial += functions[i] * velocity[i][0];
            }
            step[2][2] = radial / radius * self.field.time_step;
        }
        step
    }

    /// Stores a new deformation gradient and volume.
    #[inline(always)]
    fn deform(&self, chunk: &mut Chunk, rows: Rows, gradient: &Tensor<Lanes<WIDTH>>) -> AtPoint<()> {
        let jacobian = adjugate(gradient).1;
        if let Some(lane) = jacobian.0.iter().position(|jacobian| !(*jacobian > 0.0 && *jacobian < f64::INFINITY)) {
            return Err((rows.first + lane.min(rows.count - 1), Cause::Inverted(jacobian.0[lane])));
        }
        store_gradient(rows, chunk.gradient, self.kinematics, gradient);
        if !chunk.volume.is_empty() {
            let [mass] = rows.load::<1>(chunk.mass);
            rows.store(chunk.volume, &[mass * (1.0 / self.density) * jacobian]);
        }
        Ok(())
    }
}

/// Deformation gradients of points in step (see [`crate::points::expand`] for their storage).
#[inline(always)]
fn load_gradient<const D: usize>(rows: Rows, column: &[f64], kinematics: Kinematics) -> Tensor<Lanes<WIDTH>> {
    let mut f = identity();
    match (D, gradient_width(kinematics)) {
        (1, _) => [f[0][0]] = rows.load(column),
        (2, 5) => [f[0][0], f[0][1], f[1][0], f[1][1], f[2][2]] = rows.load(column),
        (2, _) => [f[0][0], f[0][1], f[1][0], f[1][1]] = rows.load(column),
        _ => {
            let all = rows.load::<9>(column);
            for k in 0..9 {
                f[k / 3][k % 3] = all[k];
            }
        }
    }
    f
}

/// Writes what [`load_gradient`] reads.
#[inline(always)]
fn store_gradient(rows: Rows, column: &mut [f64], kinematics: Kinematics, f: &Tensor<Lanes<WIDTH>>) {
    match gradient_width(kinematics) {
        1 => rows.store(column, &[f[0][0]]),
        4 => rows.store(column, &[f[0][0], f[0][1], f[1][0], f[1][1]]),
        5 => rows.store(column, &[f[0][0], f[0][1], f[1][0], f[1][1], f[2][2]]),
        _ => rows.store::<9>(column, &std::array::from_fn(|k| f[k / 3][k % 3])),
    }
}
