//! What acts on the faces of the boundary, from the variables of nodes and conditions.
//!
//! A component of the velocity is held on a face if all nodes of the face hold it: by a fixed VELOCITY,
//! or by a fixed DISPLACEMENT, whose rate counts. The other components have the traction of the loads on
//! the conditions that lie on the face, and none without.

use crate::faces::Faces;
use crate::kind::{CellKind, FACES, face_nodes};
use crate::matrix::Vector;
use crate::riemann::Condition;
use crate::variables::{DISPLACEMENT, VELOCITY};
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::geometry::Shape;
use bia_kernel::model::{Members, ModelPart};
use bia_kernel::solving::loads::{linear_rule, visit_loads};
use bia_kernel::solving::mesh::MeshSource;
use std::collections::HashMap;

/// A face of the boundary.
#[derive(Debug, Clone, Default, PartialEq)]
struct Face {
    nodes: Vec<u32>,
    /// Area (m²).
    area: f64,
    /// Indices of the conditions that lie on it.
    loads: Vec<u32>,
    transmitting: bool,
}

/// The faces of the boundary, in the order of [`Faces`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Boundary {
    faces: Vec<Face>,
    /// Displacements of the nodes at the end of the last step (m), if any is prescribed.
    pub(crate) last: Option<Vec<[f64; 3]>>,
}

impl Boundary {
    /// Finds the faces' nodes and the conditions that lie on them. `nodes_of` gives the nodes of a cell.
    ///
    /// # Errors
    /// Conditions that lie on no face of the boundary.
    pub fn new<'a, const D: usize>(
        part: &'a ModelPart,
        faces: &Faces,
        shape: Shape,
        of_cell: impl Fn(usize) -> (&'a [u32], &'a CellKind<D>),
        transmitting: &[Members],
        mesh: &MeshSource,
    ) -> Result<Self, InputErrors> {
        let mut boundary = Self::default();
        let mut through = vec![false; part.nodes.len()];
        transmitting.iter().flat_map(|members| &members.nodes).for_each(|&node| through[node as usize] = true);
        let mut known = HashMap::new();
        for &slot in &faces.left[faces.inner()..] {
            let (cell, face) = (slot as usize / (2 * D), slot as usize % (2 * D));
            let (all, kind) = of_cell(cell);
            let nodes: Vec<u32> = face_nodes(shape.reference_corners(), face).map(|local| all[local]).collect();
            debug_assert!(face < FACES);
            known.insert(sorted(&nodes), boundary.faces.len());
            let transmitting = nodes.iter().all(|&node| through[node as usize]);
            boundary.faces.push(Face { nodes, area: kind.areas[face], loads: Vec::new(), transmitting });
        }
        for condition in 0..part.conditions.len() {
            match known.get(&sorted(part.conditions.nodes_of(condition))) {
                Some(&face) => boundary.faces[face].loads.push(condition as u32),
                None => {
                    let id = part.conditions.ids[condition];
                    let message = format!("condition {id} does not lie on a face of the boundary");
                    let place = mesh.file().map_or_else(Default::default, bia_kernel::diagnostic::Place::file);
                    return Err(Diagnostic::error(place, message).help("a load there would act on nothing").into());
                }
            }
        }
        Ok(boundary)
    }

    /// Faces with a condition, and faces through which waves leave.
    pub fn counts(&self) -> [usize; 2] {
        let count = |of: fn(&Face) -> bool| self.faces.iter().filter(|face| of(face)).count();
        [count(|face| !face.loads.is_empty()), count(|face| face.transmitting)]
    }

    /// What acts on each face in a step of so many seconds that begins now.
    pub fn update<const D: usize>(&mut self, part: &ModelPart, time_step: f64, out: &mut [Condition<D>]) {
        let fixed = [&VELOCITY, &DISPLACEMENT].map(|variable| part.node_fields.fixed(variable));
        let values = [&VELOCITY, &DISPLACEMENT].map(|variable| part.node_fields.vector(variable));
        let moved = fixed[1].is_some();
        if moved && self.last.is_none() {
            self.last = Some(vec![[0.0; 3]; part.nodes.len()]);
        }
        // The velocity of a component of a node, if something holds it.
        let last = self.last.as_deref();
        let held = |node: u32, i: usize| {
            let node = node as usize;
            let is_fixed = |which: usize| fixed[which].is_some_and(|fixed| fixed[node][i]);
            let value = |which: usize| values[which].map_or(0.0, |values| values[node][i]);
            if is_fixed(1) {
                let rate = (value(1) - last.map_or(0.0, |last| last[node][i])) / time_step;
                return Some(if time_step > 0.0 { rate } else { 0.0 });
            }
            is_fixed(0).then(|| value(0))
        };
        for (face, condition) in self.faces.iter().zip(out) {
            *condition = Condition { transmitting: face.transmitting, ..Condition::FREE };
            for i in 0..D {
                let mut sum = 0.0;
                condition.held[i] = face.nodes.iter().all(|&node| match held(node, i) {
                    Some(velocity) => {
                        sum += velocity;
                        true
                    }
                    None => false,
                });
                condition.velocity[i] = sum / face.nodes.len() as f64;
            }
            condition.traction = traction(part, face);
        }
        if let (Some(last), Some(values)) = (&mut self.last, values[1]) {
            last.copy_from_slice(values);
        }
    }
}

/// Forces of the loads on a face over its area.
fn traction<const D: usize>(part: &ModelPart, face: &Face) -> Vector<D> {
    let mut traction = [0.0; D];
    for &condition in &face.loads {
        visit_loads(part, condition as usize, linear_rule, &mut |at| {
            for i in 0..D {
                traction[i] += at.weight * at.load[i] / face.area;
            }
        });
    }
    traction
}

fn sorted(nodes: &[u32]) -> [u32; 4] {
    let mut key = [u32::MAX; 4];
    key.iter_mut().zip(nodes).for_each(|(entry, node)| *entry = *node);
    key.sort_unstable();
    key
}
