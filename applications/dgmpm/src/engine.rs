//! The body of any dimension, as the solver and the processes see it.

use crate::body::Body;
use crate::faces::CHUNK;
use crate::fields::append;
use crate::material::Material;
use crate::matrix::Vector;
use crate::settings::SolverSettings;
use crate::stability::Limits;
use crate::variables::VOLUME_ACCELERATION;
use bia_constitutive::{BodyMaterial, Catalogue, Kinematics, Voigt};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Failure;
use bia_kernel::geometry::{Hexahedron8, Line2, Quadrilateral4};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::{Model, ModelPart, PointHandle, PointPlace, PointSet};
use bia_kernel::processes::Clock;
use bia_kernel::variables::Variable;
use nalgebra::Matrix3;

/// What is known of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Index of its element.
    pub element: usize,
    /// Position at the start (m).
    pub initial: [f64; 3],
    /// Displacement since (m).
    pub displacement: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Deformation gradient F.
    pub gradient: Matrix3<f64>,
    /// First Piola–Kirchhoff stress (Pa), without components across the mesh.
    pub nominal_stress: Matrix3<f64>,
    /// Volume at the start (m³).
    pub volume: f64,
    /// Mass (kg).
    pub mass: f64,
    /// Id of its properties.
    pub material: u32,
}

/// Stable steps of a group of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// The material's id and law.
    pub material: String,
    /// Points of a cell.
    pub points: usize,
    /// Stable Courant numbers, if there are any.
    pub limits: Option<Limits>,
    /// Time that the fastest wave needs from face to face now (s).
    pub crossing: f64,
}

/// A body of any dimension, one model extension.
pub trait Engine: Send {
    /// Kinematics.
    fn kinematics(&self) -> Kinematics;
    /// Number of points.
    fn len(&self) -> usize;
    /// Points of an element: the first, and beyond the last.
    fn points_of(&self, element: usize) -> [usize; 2];
    /// A point.
    fn point(&self, index: usize) -> Point;
    /// Cauchy stress of a point with the components across the mesh; not a number without an answer.
    fn cauchy(&self, index: usize) -> Voigt;
    /// Strain energy of a point (J), where its law has one.
    fn strain_energy(&self, index: usize) -> Option<f64>;
    /// Gives a point a velocity (m/s).
    fn set_velocity(&mut self, index: usize, velocity: [f64; 3]);
    /// Gives a point a deformation gradient.
    fn set_deformation(&mut self, index: usize, gradient: &Matrix3<f64>);
    /// Work that the boundary has done (J).
    fn work(&self) -> f64;
    /// Stable steps of all groups of cells.
    fn stability(&self) -> Vec<Stability>;
    /// Bytes of the points, of the nodes between stages, and of the faces.
    fn bytes(&self) -> [usize; 3];
    /// Numbers of cells, of their kinds, of inner and boundary faces, of boundary faces with loads and
    /// of those through which waves leave.
    fn counts(&self) -> [usize; 6];
    /// A line for each material: points, law, mass, wave speed.
    fn describe(&self) -> Vec<(u32, String)>;
    /// Stresses at the start.
    ///
    /// # Errors
    /// A cell whose law has no answer; likewise below.
    fn start(&mut self, part: &ModelPart) -> Result<(), Failure>;
    /// A step.
    ///
    /// # Errors
    /// A cell that stopped.
    fn step(&mut self, part: &ModelPart, clock: &Clock) -> Result<(), Failure>;
    /// Saves the state to a checkpoint or loads it from there.
    ///
    /// # Errors
    /// The checkpoint does not fit.
    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError>;
}

/// The model extension: the body, and what is to be written of its cells.
pub struct Points {
    /// The body.
    pub body: Box<dyn Engine>,
    /// Variables of cells.
    pub wanted: Vec<Variable>,
}

impl PointSet for Points {
    fn select(&self, model: &Model, part: &str) -> Option<Vec<PointHandle>> {
        let elements = model.members(part)?.elements;
        let points = elements.into_iter().flat_map(|element| {
            let [first, end] = self.body.points_of(element as usize);
            (first..end).map(|point| (0, point as u32))
        });
        Some(points.collect())
    }

    fn place(&self, (_, point): PointHandle) -> PointPlace {
        let Point { initial, displacement, volume, .. } = self.body.point(point as usize);
        let position = std::array::from_fn(|a| initial[a] + displacement[a]);
        PointPlace { id: point + 1, position, initial, volume }
    }

    fn append(&self, (_, point): PointHandle, variable: &Variable, out: &mut Vec<f64>) {
        append(self.body.as_ref(), point as usize, variable.name, out);
    }
}

/// The body of a part, with its stable Courant numbers.
///
/// # Errors
/// Those of [`Body::new`].
pub fn build(
    model: &Model,
    part: &ModelPart,
    materials: &[BodyMaterial],
    settings: &SolverSettings,
    catalogue: &Catalogue,
) -> Result<Points, InputErrors> {
    macro_rules! body {
        ($shape:ty, $dimension:literal, $nodes:literal) => {{
            let mut body = Body::<$dimension>::new::<$shape, $nodes>(model, part, materials, settings, catalogue)?;
            match settings.courant_limit {
                None => body.analyse::<$shape, $nodes>(),
                Some(given) => {
                    let limits = Limits { spectral: given, no_overshoot: Some(given) };
                    body.blocks.iter_mut().for_each(|block| block.limits = Some(limits));
                }
            }
            Ok(Points { body: Box::new(body), wanted: Vec::new() })
        }};
    }
    match settings.kinematics.dimension() {
        1 => body!(Line2, 1, 2),
        2 => body!(Quadrilateral4, 2, 4),
        _ => body!(Hexahedron8, 3, 8),
    }
}

fn lift<const D: usize>(vector: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { vector[a] } else { 0.0 })
}

impl<const D: usize> Body<D> {
    fn element_of(&self, point: usize) -> usize {
        self.starts.partition_point(|&start| start as usize <= point) - 1
    }

    fn material_of(&self, point: usize) -> &Material {
        let cell = self.cells[self.element_of(point)] as usize;
        &self.scheme.materials[self.scheme.kind(cell).material as usize]
    }

    /// Body forces at the points from those of the nodes; none without a column.
    fn update_body_forces(&mut self, part: &ModelPart) {
        let Some(column) = part.node_fields.vector(&VOLUME_ACCELERATION) else { return };
        for (index, chunk) in self.scheme.chunks.iter_mut().enumerate() {
            chunk.body.resize(chunk.points.velocity.len(), [0.0; D]);
            for (local, kind) in chunk.kinds.iter().enumerate() {
                let element = self.elements[index * CHUNK + local] as usize;
                for (p, functions) in self.scheme.kinds[*kind as usize].functions.iter().enumerate() {
                    let mut force = [0.0; D];
                    for (n, &node) in functions.iter().zip(part.elements.nodes_of(element)) {
                        (0..D).for_each(|a| force[a] += n * column[node as usize][a]);
                    }
                    chunk.body[local * chunk.points_per_cell + p] = force;
                }
            }
        }
    }
}

impl<const D: usize> Engine for Body<D> {
    fn kinematics(&self) -> Kinematics {
        self.kinematics
    }

    fn len(&self) -> usize {
        self.positions.len()
    }

    fn points_of(&self, element: usize) -> [usize; 2] {
        [self.starts[element] as usize, self.starts[element + 1] as usize]
    }

    fn point(&self, index: usize) -> Point {
        let (element, (chunk, place)) = (self.element_of(index), self.find(index));
        let cell = self.cells[element] as usize;
        let (chunk, kind) = (&self.scheme.chunks[chunk], self.scheme.kind(cell));
        let material = &self.scheme.materials[kind.material as usize];
        let mut nominal_stress = Matrix3::zeros();
        for i in 0..D {
            (0..D).for_each(|a| nominal_stress[(i, a)] = chunk.points.stress[place][i][a]);
        }
        let volume = kind.volumes[index - self.starts[element] as usize];
        Point {
            element,
            initial: self.positions[index],
            displacement: lift(&chunk.displacement[place]),
            velocity: lift(&chunk.points.velocity[place]),
            gradient: Material::deformation_gradient(&chunk.points.gradient[place]),
            nominal_stress,
            volume,
            mass: material.density * volume,
            material: material.id,
        }
    }

    fn cauchy(&self, index: usize) -> Voigt {
        let (chunk, place) = self.find(index);
        self.material_of(index).cauchy(&self.scheme.chunks[chunk].points.gradient[place]).unwrap_or([f64::NAN; 6])
    }

    fn strain_energy(&self, index: usize) -> Option<f64> {
        let (chunk, place) = self.find(index);
        let element = self.element_of(index);
        let volume = self.scheme.kind(self.cells[element] as usize).volumes[index - self.starts[element] as usize];
        let energy = self.material_of(index).energy(&self.scheme.chunks[chunk].points.gradient[place]);
        energy.map(|energy| energy * volume)
    }

    fn set_velocity(&mut self, index: usize, velocity: [f64; 3]) {
        let (chunk, place) = self.find(index);
        self.scheme.chunks[chunk].points.velocity[place] = std::array::from_fn(|a| velocity[a]);
    }

    fn set_deformation(&mut self, index: usize, gradient: &Matrix3<f64>) {
        let (chunk, place) = self.find(index);
        let change = |i: usize, a: usize| gradient[(i, a)] - if i == a { 1.0 } else { 0.0 };
        self.scheme.chunks[chunk].points.gradient[place] =
            std::array::from_fn(|i| std::array::from_fn(|a| change(i, a)));
    }

    fn work(&self) -> f64 {
        self.scheme.work
    }

    fn stability(&self) -> Vec<Stability> {
        let of_block = |block: &crate::body::Block| {
            let material = &self.scheme.materials[block.material];
            let inside = (block.chunks[0]..block.chunks[1]).map(|chunk| self.scheme.crossing(chunk));
            let faces = (self.scheme.faces.inner()..self.scheme.faces.len())
                .filter(|&face| material.law.is_some() && self.scheme.material_at(face) == block.material);
            let crossings = inside.chain(faces.map(|face| self.scheme.boundary_crossing(face)));
            Stability {
                material: format!("{} ({})", material.id, material.name),
                points: block.places.len(),
                limits: block.limits,
                crossing: crossings.fold(f64::INFINITY, f64::min),
            }
        };
        self.blocks.iter().map(of_block).collect()
    }

    fn bytes(&self) -> [usize; 3] {
        let (of_values, numbers) = (8 * (D + 2 * D * D), |count: usize| 8 * D * count);
        let sum = |of: &dyn Fn(&crate::chunk::Chunk<D>) -> usize| self.scheme.chunks.iter().map(of).sum::<usize>();
        let points = sum(&|chunk| chunk.len() * of_values + numbers(chunk.displacement.len() + chunk.body.len()));
        let nodes = sum(&|chunk| chunk.nodes.velocity.len() * of_values);
        let impedances = sum(&|chunk| 8 * D * D * (chunk.impedances.len() + chunk.traced_gradients.len()));
        let slots = self.scheme.faces.of_slots.len();
        [points, nodes, slots * (4 + 16 * D) + self.scheme.faces.len() * (8 + 16 * D) + impedances]
    }

    fn counts(&self) -> [usize; 6] {
        let (faces, [loaded, open]) = (&self.scheme.faces, self.boundary.counts());
        [self.cells.len(), self.scheme.kinds.len(), faces.inner(), faces.len() - faces.inner(), loaded, open]
    }

    fn describe(&self) -> Vec<(u32, String)> {
        let of_block = |block: &crate::body::Block| {
            let material = &self.scheme.materials[block.material];
            let chunks = &self.scheme.chunks[block.chunks[0]..block.chunks[1]];
            let points: usize = chunks.iter().map(crate::chunk::Chunk::len).sum();
            let volume: f64 =
                chunks.iter().flat_map(|chunk| &chunk.kinds).map(|&kind| self.scheme.kinds[kind as usize].volume).sum();
            let strain = if material.law.is_some() { "finite strain" } else { "small strain" };
            let (kinematics, speed) = (self.kinematics, material.wave_speed());
            let text = format!(
                "{points} points, {kinematics}, {}, {strain}, mass {:.6e} kg, volume {volume:.6e} m³, wave speed \
                 {speed:.4e} m/s",
                material.name,
                material.density * volume
            );
            (material.id, text)
        };
        self.blocks.iter().map(of_block).collect()
    }

    fn start(&mut self, part: &ModelPart) -> Result<(), Failure> {
        self.boundary.update(part, 0.0, &mut self.scheme.conditions);
        self.scheme.start().map_err(|stop| self.failure(part, &stop))
    }

    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        Body::exchange(self, archive)
    }

    fn step(&mut self, part: &ModelPart, clock: &Clock) -> Result<(), Failure> {
        self.update_body_forces(part);
        self.boundary.update(part, clock.time_step, &mut self.scheme.conditions);
        self.scheme.step(clock.time_step).map_err(|stop| self.failure(part, &stop))
    }
}
