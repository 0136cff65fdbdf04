//! Grids and bodies bent from a box: the key `map`.

use super::mesh::{Mesh, corners_of};
use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind, Settings};

/// The key of grids and bodies.
pub(super) const MAP: Key = Key::optional(
    "map",
    Kind::List,
    "corners [m] to which those of the unit line, square or cube go, in the order of a cell's nodes; sizes, sides \
     and boxes are then those before the map, which is linear along each axis and goes on beyond the unit box",
);

/// x ↦ Σ N_i(x) c_i with the multilinear functions N_i of the unit box and its corners' images c_i.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Map {
    dimension: usize,
    corners: Vec<[f64; 3]>,
}

impl Map {
    /// The map of a mesh of this dimension; none where the key is not given.
    pub fn read(settings: &Settings, dimension: usize) -> Result<Option<Self>, InputErrors> {
        let Some(list) = settings.get("map") else { return Ok(None) };
        let mut errors = InputErrors::default();
        let expected = corners_of(dimension).len();
        let mut corners = Vec::new();
        for entry in list.entries() {
            let numbers: Vec<f64> = entry.value().as_array().into_iter().flatten().filter_map(|x| x.as_f64()).collect();
            let given = entry.value().as_array().map_or(0, Vec::len);
            let beyond = numbers.iter().skip(dimension).any(|x| *x != 0.0);
            if numbers.len() != given || !(dimension..=3).contains(&given) || beyond {
                let message = format!("is {}, must be a place of {dimension} coordinates", entry.value());
                errors.push(entry.error(message).help("further coordinates may follow and are 0"));
            }
            corners.push(std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or(0.0)));
        }
        if corners.len() != expected {
            let message = format!("has {} corners, must have {expected}", corners.len());
            errors
                .push(list.error(message).help("in the order of the nodes of a cell, counter-clockwise in the plane"));
        }
        errors.or(Some(Self { dimension, corners }))
    }

    /// Where a place of the box goes.
    fn apply(&self, place: [f64; 3]) -> [f64; 3] {
        let mut image = [0.0; 3];
        for (offset, corner) in corners_of(self.dimension).iter().zip(&self.corners) {
            let factor = |axis: usize| if offset[axis] == 1 { place[axis] } else { 1.0 - place[axis] };
            let weight: f64 = (0..self.dimension).map(factor).product();
            (0..3).for_each(|axis| image[axis] += weight * corner[axis]);
        }
        image
    }

    /// The mesh after the map.
    pub fn bend(&self, mesh: &Mesh) -> Mesh {
        let mut bent = mesh.clone();
        bent.nodes.iter_mut().for_each(|x| *x = self.apply(*x));
        bent
    }
}
