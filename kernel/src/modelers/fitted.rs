//! Bodies whose cells follow the boundary: lattices, polar grids, and grids around a core.
//!
//! Discs and balls have a core, a square or cube of cells with bulged sides, and layers around
//! it, one block on each side of the core. No cell then has an angle near 180°, as it would if a
//! single square were bent into the disc. Nodes on the circle have equal angles between them, so
//! a disc's area is that of a regular polygon, n/2 R² sin(2π/n), and its error O(h²).

use super::mesh::{Key, MOST_CELLS, Mesh, corners_of};
use super::primitive::{Form, Primitive};
use super::reading::{AXES, counts, places};
use crate::diagnostic::InputErrors;
use crate::geometry::Shape;
use crate::parameters::Settings;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// Distance of the core's corners from the centre as a share of the radius.
const CORE: f64 = 0.65;
/// How far the core's sides are from straight (0) towards arcs (1): a third gives the three cells
/// that meet at a corner of a disc's core about 120° each.
const BULGE: f64 = 1.0 / 3.0;

/// The mesh of quadrilaterals, hexahedra or lines that follows a primitive's boundary. The counts
/// of cells come from `divisions`, or from `cell_size` rounded to the nearest whole numbers.
pub(super) fn mesh(primitive: &Primitive, settings: &Settings) -> Result<Mesh, InputErrors> {
    let counts = divisions(primitive, settings)?;
    let shift = |x: [f64; 3]| std::array::from_fn(|i| x[i] + primitive.center[i]);
    Ok(match &primitive.form {
        Form::Box(extent) => {
            let axis = |i: usize| places(extent.low[i], extent.high[i], counts[i], 1.0);
            Mesh::lattice(&(0..extent.dimension).map(axis).collect::<Vec<_>>())
        }
        Form::Disc { inner, outer } => {
            let round = Round::new(2, *inner, *outer, &counts);
            Mesh::from_keys(Shape::Quadrilateral4, &round.keys(), |key| shift(round.position(key)))
        }
        Form::Cylinder { inner, outer, height, axis } => {
            let round = Round::new(2, *inner, *outer, &counts);
            let levels = places(-0.5 * height, 0.5 * height, counts[2], 1.0);
            Mesh::from_keys(Shape::Hexahedron8, &extrude(&round.keys(), counts[2]), |key| {
                let [x, y, _] = round.position(key);
                let mut local = [x, y, levels[key[2] as usize]];
                local.rotate_right((axis + 1) % 3);
                shift(local)
            })
        }
        Form::Sphere { inner, outer } => {
            let round = Round::new(3, *inner, *outer, &counts);
            Mesh::from_keys(Shape::Hexahedron8, &round.keys(), |key| shift(round.position(key)))
        }
        Form::Polygon(_) | Form::Surface(_) => Mesh::lattice(&[]),
    })
}

/// Numbers of cells: along each axis of a box; around, from the core or hole to the surface, and
/// along the axis of round ones.
fn divisions(primitive: &Primitive, settings: &Settings) -> Result<Vec<usize>, InputErrors> {
    let names: &[&str] = match &primitive.form {
        Form::Box(extent) => &AXES[..extent.dimension],
        Form::Disc { .. } | Form::Sphere { .. } => &["around", "radial"],
        Form::Cylinder { .. } => &["around", "radial", "along"],
        Form::Polygon(_) | Form::Surface(_) => {
            let message = format!("a {} cannot be filled with fitted cells", primitive.name);
            return Err(settings.error("fill", message).help("set fill to \"grid\" and give a cell_size").into());
        }
    };
    let numbers = match (settings.get("divisions"), settings.given("cell_size")) {
        (Some(list), false) => counts(list, names)?,
        (None, true) => from_size(primitive, settings.number("cell_size")),
        (given, _) => {
            let found = if given.is_some() { "both" } else { "neither" };
            let message = format!("a fitted body takes divisions or cell_size, and {found} is given");
            let help = format!("divisions are [{}]", names.join(", "));
            return Err(settings.error("name", message).help(help).into());
        }
    };
    let around = match &primitive.form {
        Form::Box(_) | Form::Polygon(_) | Form::Surface(_) => None,
        Form::Disc { inner, .. } | Form::Cylinder { inner, .. } if *inner > 0.0 => Some(3),
        _ => Some(4),
    };
    match around {
        Some(4) if numbers[0] % 4 != 0 => {
            let message = format!("has {} cells around, must be a multiple of 4", numbers[0]);
            return Err(settings
                .error("divisions", message)
                .help("one block of cells stands on each side of the core")
                .into());
        }
        Some(3) if numbers[0] < 3 => {
            return Err(settings
                .error("divisions", format!("has {} cells around, must be at least 3", numbers[0]))
                .into());
        }
        _ => {}
    }
    let total = numbers.iter().fold(1usize, |product, n| product.saturating_mul(*n));
    if total > MOST_CELLS {
        let message = format!("the body would have more than {MOST_CELLS} cells");
        return Err(settings.error("name", message).help("take larger cells").into());
    }
    Ok(numbers)
}

/// Whole numbers of cells of about this size, at least 1 (and 8 around a hole).
fn from_size(primitive: &Primitive, size: f64) -> Vec<usize> {
    // A length without bound gives a number that the limit of cells refuses.
    let cells = |length: f64| (length / size).round().max(1.0) as usize;
    let around = |inner: f64, outer: f64| match inner > 0.0 {
        true => [cells(TAU * outer).max(8), cells(outer - inner)],
        false => [4 * cells(FRAC_PI_2 * outer), cells((1.0 - mean_core_share()) * outer)],
    };
    match &primitive.form {
        Form::Box(extent) => (0..extent.dimension).map(|axis| cells(extent.size(axis))).collect(),
        Form::Disc { inner, outer } => around(*inner, *outer).to_vec(),
        Form::Cylinder { inner, outer, height, .. } => {
            let [around, radial] = around(*inner, *outer);
            vec![around, radial, cells(*height)]
        }
        Form::Sphere { inner, outer } if *inner > 0.0 => {
            vec![4 * cells(FRAC_PI_2 * outer), cells(outer - inner)]
        }
        Form::Sphere { outer, .. } => around(0.0, *outer).to_vec(),
        Form::Polygon(_) | Form::Surface(_) => Vec::new(),
    }
}

/// Mean distance of a disc's core boundary from the centre, as a share of the radius.
fn mean_core_share() -> f64 {
    let side = (1.0 - BULGE) * CORE * FRAC_PI_4.cos() + BULGE * CORE;
    0.5 * (side + CORE)
}

/// A disc or ball with a core, a polar ring, or a spherical shell, about the origin.
///
/// Keys: (i, j, k, layer) on and in the core's square or cube, (i, 0, 0, layer) of a ring; the
/// third entry is free for [`extrude`] in the plane.
struct Round {
    dimension: usize,
    inner: f64,
    outer: f64,
    /// Cells along a side of the core; around a ring.
    sides: i32,
    layers: i32,
}

impl Round {
    fn new(dimension: usize, inner: f64, outer: f64, counts: &[usize]) -> Self {
        let polar = dimension == 2 && inner > 0.0;
        let sides = if polar { counts[0] } else { counts[0] / 4 };
        Self { dimension, inner, outer, sides: sides as i32, layers: counts[1] as i32 }
    }

    fn is_polar(&self) -> bool {
        self.dimension == 2 && self.inner > 0.0
    }

    /// Keys of the cells' nodes, cell after cell; the orientation of a cell is not settled.
    fn keys(&self) -> Vec<Key> {
        let mut keys = Vec::new();
        let corners = corners_of(self.dimension).iter().map(|corner| corner.map(|c| c as i32));
        if self.is_polar() {
            for layer in 0..self.layers {
                for i in 0..self.sides {
                    keys.extend(corners.clone().map(|[a, b, _]| [(i + a) % self.sides, 0, 0, layer + b]));
                }
            }
            return keys;
        }
        let n = self.sides;
        let tangential: Vec<[i32; 2]> = match self.dimension {
            2 => (0..n).map(|i| [i, 0]).collect(),
            _ => (0..n).flat_map(|j| (0..n).map(move |i| [i, j])).collect(),
        };
        if self.inner == 0.0 {
            for k in 0..if self.dimension == 3 { n } else { 1 } {
                for j in 0..n {
                    for i in 0..n {
                        keys.extend(corners.clone().map(|[a, b, c]| [i + a, j + b, k + c, 0]));
                    }
                }
            }
        }
        for layer in 0..self.layers {
            for axis in 0..self.dimension {
                for side in [0, n] {
                    for place in &tangential {
                        keys.extend(corners.clone().map(|corner| {
                            let mut key = [0, 0, 0, layer + corner[self.dimension - 1]];
                            key[axis] = side;
                            for t in 1..self.dimension {
                                key[(axis + t) % self.dimension] = place[t - 1] + corner[t - 1];
                            }
                            key
                        }));
                    }
                }
            }
        }
        keys
    }

    fn position(&self, [i, j, k, layer]: Key) -> [f64; 3] {
        let share = f64::from(layer) / f64::from(self.layers);
        let radius = self.inner + (self.outer - self.inner) * share;
        if self.is_polar() {
            let angle = TAU * f64::from(i) / f64::from(self.sides);
            return [radius * angle.cos(), radius * angle.sin(), 0.0];
        }
        let mut place = [i, j, k].map(|index| 2.0 * f64::from(index) / f64::from(self.sides) - 1.0);
        place[self.dimension..].fill(0.0);
        if self.inner > 0.0 {
            return direction(place).map(|d| radius * d);
        }
        let core = self.core(place);
        if layer == 0 {
            return core;
        }
        let surface = direction(place).map(|d| self.outer * d);
        std::array::from_fn(|a| core[a] + (surface[a] - core[a]) * share)
    }

    /// From the square or cube [−1, 1]^D to the core, straight at the centre and bulged outside.
    fn core(&self, place: [f64; 3]) -> [f64; 3] {
        let level = place.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        if level == 0.0 {
            return [0.0; 3];
        }
        let side = place.map(|x| x / level);
        let arc = direction(side);
        let (bulge, corner) = (BULGE * level, CORE * self.outer);
        let straight = corner / (self.dimension as f64).sqrt();
        std::array::from_fn(|a| level * ((1.0 - bulge) * straight * side[a] + bulge * corner * arc[a]))
    }
}

/// Unit vector through a place on the boundary of [−1, 1]^D, so that equal steps on a side are
/// equal angles (Ronchi, Iacono, Paolucci, The cubed sphere, J. Comput. Phys. 124 (1996)).
fn direction(place: [f64; 3]) -> [f64; 3] {
    let through = place.map(|x| (FRAC_PI_4 * x).tan());
    let length = through.iter().map(|x| x * x).sum::<f64>().sqrt();
    through.map(|x| x / length)
}

/// Hexahedra over quadrilaterals in `levels` layers; the third entry of a key counts the levels.
fn extrude(quadrilaterals: &[Key], levels: usize) -> Vec<Key> {
    let mut keys = Vec::with_capacity(quadrilaterals.len() * 2 * levels);
    for level in 0..levels as i32 {
        for cell in quadrilaterals.chunks(4) {
            for z in [level, level + 1] {
                keys.extend(cell.iter().map(|&[i, j, _, layer]| [i, j, z, layer]));
            }
        }
    }
    keys
}
