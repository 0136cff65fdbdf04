//! The scheme on cells and faces, free of meshes' ids, files and processes.
//!
//! A stage: what the faces see of each cell → Riemann problems → new values in each cell. With the
//! transverse correction the Riemann problems are solved twice.

use crate::chunk::{Chunk, Shared, Stop, Values, uniform};
use crate::exact;
use crate::faces::{CHUNK, Faces};
use crate::kind::CellKind;
use crate::material::Material;
use crate::matrix::{Matrix, dot, inverse, minus, times};
use crate::riemann::{Condition, Interface, RiemannSolver, Trace};
use crate::stages::{Site, TimeIntegration};
use crate::transverse::{By, Transverse};
use rayon::prelude::*;
use std::collections::HashMap;

/// Faces that a task solves at least.
const FACES_A_TASK: usize = 512;
/// Corrections of the deformation at a boundary face.
const BOUNDARY_ITERATIONS: usize = 3;

/// Choices of the scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Time integration.
    pub time_integration: TimeIntegration,
    /// Riemann solver.
    pub riemann: RiemannSolver,
    /// Corner transport upwind.
    pub transverse: bool,
}

/// Cells, faces and what stands on them.
pub struct Scheme<const D: usize> {
    /// The scheme.
    pub method: Method,
    /// Materials.
    pub materials: Vec<Material>,
    /// Kinds of cells.
    pub kinds: Vec<CellKind<D>>,
    /// Cells with their values.
    pub chunks: Vec<Chunk<D>>,
    /// Faces.
    pub faces: Faces,
    /// What acts on each face of the boundary.
    pub conditions: Vec<Condition<D>>,
    /// Work that the boundary has done (J).
    pub work: f64,
    /// What the faces see of their cells, slot by slot.
    pub traces: Vec<Trace<D>>,
    stars: Vec<Trace<D>>,
    /// Traces at the start of a step, for the transverse correction.
    base: Vec<Trace<D>>,
    /// States that are corrected by one other axis, for the transverse correction in space.
    corrected: [Vec<Trace<D>>; 2],
    interfaces: Interfaces<D>,
}

/// Impedances of faces at small strain, which do not change; empty at finite strain.
#[derive(Default)]
struct Interfaces<const D: usize> {
    of_faces: Vec<u32>,
    list: Vec<Interface<D>>,
}

impl<const D: usize> Scheme<D> {
    /// Cells without motion; each entry of `blocks` has the kinds of its cells, which are of one
    /// material and one number of points. Their order is that of the indices in `faces`.
    pub fn new(
        method: Method,
        materials: Vec<Material>,
        kinds: Vec<CellKind<D>>,
        blocks: &[Vec<u32>],
        faces: Faces,
    ) -> Self {
        let finite = materials.iter().any(|material| material.law.is_some());
        let multistage = method.time_integration.stages().len() > 1;
        let mut chunks = Vec::new();
        for block in blocks {
            for cells in block.chunks(CHUNK) {
                let points_per_cell = kinds[cells[0] as usize].volumes.len();
                let slots = cells.len() * 2 * D;
                let count = |wanted: bool| if wanted { slots } else { 0 };
                chunks.push(Chunk {
                    first: chunks.len() * CHUNK,
                    kinds: cells.to_vec(),
                    points_per_cell,
                    points: Values::new(cells.len() * points_per_cell),
                    nodes: Values::new(if multistage { cells.len() << D } else { 0 }),
                    displacement: vec![[0.0; D]; cells.len() * points_per_cell],
                    impedances: vec![[[0.0; D]; D]; count(finite)],
                    traced_gradients: vec![[[0.0; D]; D]; count(method.riemann == RiemannSolver::Exact)],
                    ..Chunk::default()
                });
            }
        }
        let mut scheme = Self {
            method,
            traces: vec![Trace::REST; chunks.len() * CHUNK * 2 * D],
            stars: vec![Trace::REST; faces.len()],
            conditions: vec![Condition::FREE; faces.len() - faces.inner()],
            work: 0.0,
            base: Vec::new(),
            corrected: [Vec::new(), Vec::new()],
            interfaces: Interfaces::default(),
            materials,
            kinds,
            chunks,
            faces,
        };
        if !finite {
            scheme.interfaces = scheme.interfaces();
        }
        scheme
    }

    /// Kind of a cell.
    pub fn kind(&self, cell: usize) -> &CellKind<D> {
        &self.kinds[self.chunks[cell / CHUNK].kinds[cell % CHUNK] as usize]
    }

    fn kind_of_slot(&self, slot: u32) -> (u32, usize) {
        let (cell, face) = (slot as usize / (2 * D), slot as usize % (2 * D));
        (self.chunks[cell / CHUNK].kinds[cell % CHUNK], face)
    }

    fn interfaces(&self) -> Interfaces<D> {
        let (mut known, mut out) = (HashMap::new(), Interfaces::default());
        for face in 0..self.faces.len() {
            let left = self.kind_of_slot(self.faces.left[face]);
            let right = self.faces.right.get(face).map(|&slot| self.kind_of_slot(slot));
            let index = *known.entry((left, right)).or_insert_with(|| {
                let z = self.linear_impedance(left);
                out.list.push(Interface::new(z, right.map_or(z, |right| self.linear_impedance(right))));
                out.list.len() as u32 - 1
            });
            out.of_faces.push(index);
        }
        out
    }

    fn linear_impedance(&self, (kind, face): (u32, usize)) -> Matrix<D> {
        let kind = &self.kinds[kind as usize];
        let material = &self.materials[kind.material as usize];
        match self.method.riemann {
            RiemannSolver::Hll => uniform(material.density * material.wave_speed()),
            _ => material.hooke.impedance(material.density, &kind.normals[face]),
        }
    }

    /// Impedance of a slot at finite strain.
    fn impedance(&self, slot: u32) -> &Matrix<D> {
        let chunk = slot as usize / (CHUNK * 2 * D);
        &self.chunks[chunk].impedances[slot as usize % (CHUNK * 2 * D)]
    }

    /// Works on all chunks with their traces, and reports the first cell that stopped.
    fn on_chunks(&mut self, work: impl Fn(&mut Chunk<D>, &Shared<D>, &mut [Trace<D>]) + Sync) -> Result<(), Stop<D>> {
        let shared = Shared {
            kinds: &self.kinds,
            materials: &self.materials,
            faces: &self.faces,
            stars: &self.stars,
            riemann: self.method.riemann,
        };
        let traces = self.traces.par_chunks_mut(CHUNK * 2 * D);
        if self.chunks.len() == 1 || rayon::current_num_threads() == 1 {
            let traces = self.traces.chunks_mut(CHUNK * 2 * D);
            self.chunks.iter_mut().zip(traces).for_each(|(chunk, traces)| work(chunk, &shared, traces));
        } else {
            self.chunks.par_iter_mut().zip(traces).for_each(|(chunk, traces)| work(chunk, &shared, traces));
        }
        self.chunks.iter().find_map(|chunk| chunk.stop).map_or(Ok(()), Err)
    }

    /// Stresses and traces of the points as they are.
    ///
    /// # Errors
    /// A cell whose law has no answer; likewise below.
    pub fn start(&mut self) -> Result<(), Stop<D>> {
        self.on_chunks(|chunk, shared, traces| chunk.answer(shared, Site::Points, traces))
    }

    /// A step of so many seconds; [`Self::start`] comes before the first.
    ///
    /// # Errors
    /// A cell that stopped.
    pub fn step(&mut self, time_step: f64) -> Result<(), Stop<D>> {
        for (index, stage) in self.method.time_integration.stages().iter().enumerate() {
            self.solve_faces();
            if self.method.transverse && D > 1 {
                self.correct_transversely(time_step)?;
            }
            self.work += stage.weight * time_step * self.power();
            self.on_chunks(|chunk, shared, traces| chunk.advance(shared, index, stage, time_step, traces))?;
        }
        Ok(())
    }

    /// Corner transport upwind: the faces of each axis see their cells after half a step of what enters
    /// through the others. In space that half step itself uses states that a third of a step through the
    /// third axis has moved.
    fn correct_transversely(&mut self, time_step: f64) -> Result<(), Stop<D>> {
        std::mem::swap(&mut self.traces, &mut self.base);
        if self.traces.len() != self.base.len() {
            self.traces.resize(self.base.len(), Trace::REST);
        }
        let base = std::mem::take(&mut self.base);
        let correct = |this: &mut Self, share: f64, by: By<D>| {
            let transverse = Transverse { base: &base, share, by };
            this.on_chunks(|chunk, shared, traces| chunk.correct_transversely(shared, &transverse, time_step, traces))?;
            this.solve_faces();
            Ok(())
        };
        let first = std::mem::take(&mut self.stars);
        let mut corrected = std::mem::take(&mut self.corrected);
        let result = if D < 3 {
            self.stars = std::mem::take(&mut corrected[0]);
            self.stars.resize(first.len(), Trace::REST);
            let result = correct(self, 0.5, By::Others(&first));
            corrected[0] = first;
            result
        } else {
            let each = (0..2).try_for_each(|k| {
                self.stars = std::mem::take(&mut corrected[k]);
                self.stars.resize(first.len(), Trace::REST);
                let result = correct(self, 1.0 / 3.0, By::Next(k, &first));
                corrected[k] = std::mem::take(&mut self.stars);
                result
            });
            self.stars = first;
            each.and_then(|()| correct(self, 0.5, By::Corrected([&corrected[0], &corrected[1]])))
        };
        (self.base, self.corrected) = (base, corrected);
        result
    }

    /// Solves all Riemann problems.
    fn solve_faces(&mut self) {
        let mut stars = std::mem::take(&mut self.stars);
        let this = &*self;
        if stars.len() <= FACES_A_TASK || rayon::current_num_threads() == 1 {
            stars.iter_mut().enumerate().for_each(|(face, star)| *star = this.solve(face));
        } else {
            let tasks = stars.par_iter_mut().with_min_len(FACES_A_TASK).enumerate();
            tasks.for_each(|(face, star)| *star = this.solve(face));
        }
        self.stars = stars;
    }

    /// The state at a face.
    #[inline(always)]
    fn solve(&self, face: usize) -> Trace<D> {
        let slot = self.faces.left[face];
        let left = &self.traces[slot as usize];
        if self.method.riemann == RiemannSolver::Exact {
            return exact::solve(self, face);
        }
        let linear = !self.interfaces.list.is_empty();
        let Some(&other) = self.faces.right.get(face) else {
            let condition = &self.conditions[face - self.faces.inner()];
            let impedance = match linear {
                true => &self.interfaces.list[self.interfaces.of_faces[face] as usize].left,
                false => self.impedance(slot),
            };
            return condition.solve(impedance, left);
        };
        let right = &self.traces[other as usize];
        if linear {
            self.interfaces.list[self.interfaces.of_faces[face] as usize].solve(left, right)
        } else {
            Interface::new(*self.impedance(slot), *self.impedance(other)).solve(left, right)
        }
    }

    /// What the boundary does to the body per second (W).
    fn power(&self) -> f64 {
        let of_face = |face: usize| {
            let slot = self.faces.left[face] as usize;
            let area = self.kind(slot / (2 * D)).areas[slot % (2 * D)];
            area * dot(&self.stars[face].traction, &self.stars[face].velocity)
        };
        (self.faces.inner()..self.faces.len()).map(of_face).sum()
    }

    /// The time (s) in which a wave would cross the cell of a boundary face in the state at the face, which
    /// a sudden load reaches at once; infinite at small strain. The deformation there has the traction τ*:
    /// H ← H + A⁻¹ (τ* − Π N) ⊗ N, A = Z²/ρ₀ (Newton's method).
    pub fn boundary_crossing(&self, face: usize) -> f64 {
        let slot = self.faces.left[face] as usize;
        let (cell, side) = (slot / (2 * D), slot % (2 * D));
        let (chunk, kind) = (&self.chunks[cell / CHUNK], self.kind(cell));
        let material = &self.materials[kind.material as usize];
        if material.law.is_none() {
            return f64::INFINITY;
        }
        let (normal, wanted) = (kind.normals[side], self.solve(face).traction);
        let mut gradient = chunk.mean_gradient(cell % CHUNK, kind);
        let (mut stress, mut impedance, mut speed) = ([[[0.0; D]; D]], [[[0.0; D]; D]], [0.0]);
        for _ in 0..=BOUNDARY_ITERATIONS {
            let answered = material.stresses(&[gradient], &mut stress).is_ok()
                && material.impedances(&gradient, &[normal], &mut impedance, &mut speed).is_ok();
            if !answered {
                return f64::INFINITY;
            }
            let inverse = inverse(&impedance[0]);
            let missing = minus(&wanted, &times(&stress[0], &normal));
            let change = times(&inverse, &times(&inverse, &missing));
            for i in 0..D {
                (0..D).for_each(|a| gradient[i][a] += material.density * change[i] * normal[a]);
            }
        }
        kind.height(side / 2) / speed[0]
    }

    /// Material of the cell at a boundary face.
    pub fn material_at(&self, face: usize) -> usize {
        self.kind(self.faces.left[face] as usize / (2 * D)).material as usize
    }

    /// Trace and displacement gradient of a slot.
    pub fn traced(&self, slot: u32) -> (&Trace<D>, &Matrix<D>) {
        let (chunk, place) = (slot as usize / (CHUNK * 2 * D), slot as usize % (CHUNK * 2 * D));
        (&self.traces[slot as usize], &self.chunks[chunk].traced_gradients[place])
    }

    /// Material of a slot.
    pub fn material_of_slot(&self, slot: u32) -> &Material {
        &self.materials[self.kinds[self.kind_of_slot(slot).0 as usize].material as usize]
    }

    /// The shortest time that a wave needs from face to face of each chunk's cells (s).
    pub fn crossing(&self, chunk: usize) -> f64 {
        let chunk = &self.chunks[chunk];
        if !chunk.impedances.is_empty() {
            return chunk.crossing;
        }
        let of_cell = |&kind: &u32| {
            let kind = &self.kinds[kind as usize];
            let speed = self.materials[kind.material as usize].wave_speed();
            (0..D).map(|axis| kind.height(axis) / speed).fold(f64::INFINITY, f64::min)
        };
        chunk.kinds.iter().map(of_cell).fold(f64::INFINITY, f64::min)
    }
}
