//! The body: a mesh whose cells are all filled with points, made into cells, faces and materials.

use crate::boundary::Boundary;
use crate::chunk::{Reason, Stop};
use crate::faces::{CHUNK, Faces, ThreeCells};
use crate::kind::{CellKind, Place};
use crate::layout::places;
use crate::material::{Hooke, Material, Unsuitable};
use crate::scheme::Scheme;
use crate::settings::SolverSettings;
use crate::stability::{Lattice, Limits, limits};
use bia_constitutive::{BodyMaterial, BuiltLaw, Catalogue, Kinematics, Options};
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::error::Failure;
use bia_kernel::geometry::{CellShape, Shape};
use bia_kernel::model::{Members, Model, ModelPart};
use std::collections::HashMap;

/// Cells of one material.
pub struct Block {
    /// Index of the material.
    pub material: usize,
    /// Points of a cell.
    pub places: Vec<Place>,
    /// Indices of the first and beyond the last chunk.
    pub chunks: [usize; 2],
    /// Stable Courant numbers; none before they are asked for.
    pub limits: Option<Limits>,
}

/// A body in `D` dimensions.
pub struct Body<const D: usize> {
    /// The scheme.
    pub scheme: Scheme<D>,
    /// Its materials' cells.
    pub blocks: Vec<Block>,
    /// What acts on its boundary.
    pub boundary: Boundary,
    /// Cell of each element.
    pub cells: Vec<u32>,
    /// Element of each cell; `u32::MAX` in gaps.
    pub elements: Vec<u32>,
    /// Coordinates of the points at the start (m), element after element.
    pub positions: Vec<[f64; 3]>,
    /// First point of each element, and the number of all.
    pub starts: Vec<u32>,
    /// Kinematics for messages and output.
    pub kinematics: Kinematics,
}

impl<const D: usize> Body<D> {
    /// The body of a part with the laws that its materials name.
    ///
    /// # Errors
    /// Elements without material or of another shape, constants at fault, layouts that leave a node
    /// without mass, loads on no face: all together, as far as they can be judged.
    pub fn new<S: CellShape<D, N>, const N: usize>(
        model: &Model,
        part: &ModelPart,
        given: &[BodyMaterial],
        settings: &SolverSettings,
        catalogue: &Catalogue,
    ) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let materials: Vec<Option<Material>> =
            given.iter().map(|m| errors.absorb(material(m, settings, catalogue))).collect();
        let of_elements = materials_of(part, given, settings, S::SHAPE)?;
        let materials: Vec<Material> = errors.or(materials)?.into_iter().flatten().collect();
        let (mut kinds, mut kind_lists, mut blocks) = (KindList::<D>::default(), Vec::new(), Vec::new());
        let (mut cells, mut elements) = (vec![0; part.elements.len()], Vec::new());
        for index in 0..materials.len() {
            let own: Vec<usize> = (0..of_elements.len()).filter(|&e| of_elements[e] == index).collect();
            if own.is_empty() {
                continue;
            }
            let places = places(&settings.placement, S::SHAPE, &given[index])?;
            let numbers = (index as u32, materials[index].density, materials[index].extent);
            let mut list = Vec::with_capacity(own.len());
            for &element in &own {
                let corners = part.nodes.gather::<D, N>(part.elements.nodes_of(element));
                let stages = settings.method.time_integration.stages();
                let kind = kinds.find(&corners, index, || CellKind::new::<S, N>(&corners, &places, numbers, stages));
                list.push(kind.map_err(|_| massless(&given[index], part.elements.ids[element]))?);
                cells[element] = elements.len() as u32;
                elements.push(element as u32);
            }
            let first = (elements.len() - own.len()) / CHUNK;
            elements.resize(elements.len().next_multiple_of(CHUNK), u32::MAX);
            blocks.push(Block { material: index, places, chunks: [first, elements.len() / CHUNK], limits: None });
            kind_lists.push(list);
        }
        let all = cells.iter().enumerate().map(|(element, &cell)| (cell as usize, part.elements.nodes_of(element)));
        let faces = Faces::new(all, S::SHAPE.reference_corners(), D, elements.len() * 2 * D)
            .map_err(|ThreeCells { cell }| three_cells(part, settings, elements[cell]))?;
        check_axes(&faces, settings, D)?;
        let scheme = Scheme::new(settings.method, materials, kinds.kinds, &kind_lists, faces);
        let transmitting = transmitting(model, part, settings)?;
        let of_cell = |cell: usize| (part.elements.nodes_of(elements[cell] as usize), scheme.kind(cell));
        let boundary = Boundary::new(part, &scheme.faces, S::SHAPE, of_cell, &transmitting, &settings.mesh)?;
        let kinematics = settings.kinematics;
        let mut body =
            Self { scheme, blocks, boundary, cells, elements, positions: Vec::new(), starts: vec![0], kinematics };
        body.place_points(part);
        Ok(body)
    }

    fn place_points(&mut self, part: &ModelPart) {
        for element in 0..self.cells.len() {
            let kind = self.scheme.kind(self.cells[element] as usize);
            let nodes = part.elements.nodes_of(element);
            for functions in &kind.functions {
                let mut x = [0.0; 3];
                for (n, &node) in functions.iter().zip(nodes) {
                    (0..D).for_each(|a| x[a] += n * part.nodes.coordinates[node as usize][a]);
                }
                self.positions.push(x);
            }
            self.starts.push(self.positions.len() as u32);
        }
    }

    /// Finds the stable Courant number of each block.
    pub fn analyse<S: CellShape<D, N>, const N: usize>(&mut self) {
        for block in 0..self.blocks.len() {
            let Some(lattice) = self.lattice(block) else { continue };
            let same = (0..block).find(|&other| self.lattice(other).is_some_and(|other| other == lattice));
            let found = match same {
                Some(other) => self.blocks[other].limits,
                None => limits::<S, D, N>(&lattice),
            };
            self.blocks[block].limits = found;
        }
    }

    /// The cell of a block that waves cross first, as a box.
    fn lattice(&self, block: usize) -> Option<Lattice<'_, D>> {
        let block = &self.blocks[block];
        let kinds = self.scheme.chunks[block.chunks[0]..block.chunks[1]].iter().flat_map(|chunk| &chunk.kinds);
        let least = |kind: u32| {
            let kind = &self.scheme.kinds[kind as usize];
            (0..D).map(|axis| kind.height(axis)).fold(f64::INFINITY, f64::min)
        };
        let smallest = kinds.copied().min_by(|&a, &b| least(a).total_cmp(&least(b)))?;
        let (kind, material) = (&self.scheme.kinds[smallest as usize], &self.scheme.materials[block.material]);
        Some(Lattice {
            edges: std::array::from_fn(|axis| kind.height(axis)),
            places: &block.places,
            hooke: material.hooke,
            density: material.density,
            method: self.scheme.method,
        })
    }

    /// Chunk of a point and its index there.
    pub fn find(&self, point: usize) -> (usize, usize) {
        let element = self.starts.partition_point(|&start| start as usize <= point) - 1;
        let cell = self.cells[element] as usize;
        let chunk = &self.scheme.chunks[cell / CHUNK];
        (cell / CHUNK, cell % CHUNK * chunk.points_per_cell + point - self.starts[element] as usize)
    }

    /// Adds the element, its place and deformation to why a cell stopped.
    pub fn failure(&self, part: &ModelPart, stop: &Stop<D>) -> Failure {
        let element = self.elements[stop.cell] as usize;
        let material = &self.scheme.materials[self.scheme.kind(stop.cell).material as usize];
        let what = match stop.reason {
            Reason::Law(reason) => format!("the law {} has no answer: {reason}", material.name),
            Reason::NoWaveSpeed => format!("the law {} has no wave speed: its tangent is not positive", material.name),
            Reason::Unbounded => "the run is unstable: velocities grow without bound".to_string(),
        };
        let advice = match stop.reason {
            Reason::Unbounded => "a time step below the stable one, such as \"time_step\": \"auto\"",
            _ => "a smaller time step or load, or a law that stiffens under compression",
        };
        let x = self.positions[self.starts[element] as usize];
        let gradient = Material::deformation_gradient(&stop.gradient);
        Failure::new(what, advice)
            .at(format!("element {}", part.elements.ids[element]), x)
            .detail(format!("deformation gradient: {:?}", gradient.transpose().as_slice()))
            .detail(format!("J = {:e}", gradient.determinant()))
    }
}

/// Kinds of cells, each once.
#[derive(Default)]
struct KindList<const D: usize> {
    kinds: Vec<CellKind<D>>,
    known: HashMap<(usize, Vec<[i64; D]>), u32>,
    size: Option<f64>,
}

impl<const D: usize> KindList<D> {
    /// The kind of a cell with these corners, made if it is new. Cells are equal if their edges are to a
    /// part in 1e9.
    fn find<const N: usize, E>(
        &mut self,
        corners: &[[f64; D]; N],
        material: usize,
        make: impl FnOnce() -> Result<CellKind<D>, E>,
    ) -> Result<u32, E> {
        let farthest = corners.iter().flatten().zip(corners[0].iter().cycle()).map(|(x, x0)| (x - x0).abs());
        let size = *self.size.get_or_insert(farthest.fold(0.0, f64::max));
        let relative =
            |corner: &[f64; D]| std::array::from_fn(|a| ((corner[a] - corners[0][a]) / size * 1e9).round() as i64);
        let key = (material, corners.iter().map(relative).collect());
        if let Some(&index) = self.known.get(&key) {
            return Ok(index);
        }
        let index = self.kinds.len() as u32;
        self.kinds.push(make()?);
        self.known.insert(key, index);
        Ok(index)
    }
}

/// Index of the material of each element.
fn materials_of(
    part: &ModelPart,
    given: &[BodyMaterial],
    settings: &SolverSettings,
    shape: Shape,
) -> Result<Vec<usize>, InputErrors> {
    let mut list = Vec::with_capacity(part.elements.len());
    if part.elements.is_empty() {
        let message = format!("the part {:?} has no elements", part.name);
        return Err(settings.settings.error("model_part_name", message).into());
    }
    for (element, &found) in part.elements.shapes.iter().enumerate() {
        let id = part.elements.ids[element];
        let place = || settings.mesh.place(id);
        if found != shape {
            let message = format!("element {id} is a {}, must be a {}", found.name(), shape.name());
            let help = "the method has lines, quadrilaterals and hexahedra; check domain_size";
            return Err(Diagnostic::error(place(), message).help(help).into());
        }
        let wanted = part.elements.properties[element];
        match given.iter().position(|material| material.properties.id == wanted) {
            Some(position) => list.push(position),
            None => {
                let diagnostic = Diagnostic::error(place(), format!("element {id} has no material"));
                return Err(diagnostic.help("give every part a material in the materials file").into());
            }
        }
    }
    Ok(list)
}

fn massless(material: &BodyMaterial, element: u32) -> InputErrors {
    let message = format!("the layout of points leaves a node of cells like element {element} without mass");
    let help = "points must not all lie on one side of a cell";
    material.place_of(Some("MATERIAL_POINTS_PER_ELEMENT")).error(message).help(help).into()
}

fn three_cells(part: &ModelPart, settings: &SolverSettings, element: u32) -> InputErrors {
    let id = part.elements.ids[element as usize];
    let message = format!("a face of element {id} belongs to two other elements, too");
    Diagnostic::error(settings.mesh.place(id), message).help("at most two cells share a face").into()
}

/// Refuses the transverse correction in space where the axes of neighbours do not agree.
fn check_axes(faces: &Faces, settings: &SolverSettings, dimension: usize) -> Result<(), InputErrors> {
    let face_of = |slot: u32| slot as usize % (2 * dimension);
    let agree = faces.left.iter().zip(&faces.right).all(|(&left, &right)| face_of(left) ^ 1 == face_of(right));
    if agree || dimension < 3 || !settings.method.transverse {
        return Ok(());
    }
    let message = "the transverse correction in space needs cells whose local axes agree with their neighbours'";
    Err(settings.settings.error("transverse_correction", message).help("leave it out, or use a regular grid").into())
}

fn transmitting(model: &Model, part: &ModelPart, settings: &SolverSettings) -> Result<Vec<Members>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut list = Vec::new();
    for path in &settings.transmitting {
        match model.members(path).filter(|members| members.root == part.name) {
            Some(members) => list.push(members),
            None => {
                let message = format!("there is no part {path:?} of {:?}", part.name);
                errors.push(model.suggest_part(settings.settings.error("transmitting_parts", message), path));
            }
        }
    }
    errors.or(list)
}

fn material(
    material: &BodyMaterial,
    settings: &SolverSettings,
    catalogue: &Catalogue,
) -> Result<Material, InputErrors> {
    let mut errors = InputErrors::default();
    let kinematics = settings.kinematics;
    let entry = material.properties.law.as_deref().and_then(|name| catalogue.find(name));
    let by_law = entry.is_some_and(|entry| entry.variables.iter().any(|variable| variable.name == "DENSITY"));
    let density = match by_law {
        true => material.properties.number("DENSITY"),
        false => errors.absorb(material.positive("DENSITY", true)).flatten(),
    };
    let extent = match kinematics {
        Kinematics::ThreeDimensional => None,
        Kinematics::UniaxialStrain => errors.absorb(material.positive("CROSS_AREA", false)).flatten(),
        _ => errors.absorb(material.positive("THICKNESS", false)).flatten(),
    };
    let built = errors.absorb(material.law(catalogue, kinematics, &Options::default()));
    let (Some(BuiltLaw { law, name, .. }), Some(density), false) = (built, density, errors.any_error()) else {
        return Err(errors);
    };
    let place = material.parameters.child("Material").and_then(|m| m.child("constitutive_law"));
    let refuse = |reason: &Unsuitable| {
        let (message, help) = match reason {
            Unsuitable::NoAnswer(error) => (format!("the law {name} has no answer: {error}"), "use another law"),
            Unsuitable::Tangent => {
                (format!("the law {name} has no waves: its tangent is not isotropic and positive"), "use a solid's law")
            }
            Unsuitable::History => {
                let help = "use a law without history, or \"strain\": \"small\"";
                (format!("the law {name} keeps a history, which cells of this method do not"), help)
            }
        };
        InputErrors::from(place.as_ref().unwrap_or(&material.parameters).error(message).help(help))
    };
    let hooke = Hooke::of(law.as_ref(), kinematics.dimension()).map_err(|reason| refuse(&reason))?;
    if !settings.small_strain && law.state_len() > 0 {
        return Err(refuse(&Unsuitable::History));
    }
    let law = Some(law).filter(|_| !settings.small_strain);
    Ok(Material { id: material.properties.id, name, density, extent: extent.unwrap_or(1.0), hooke, law })
}
