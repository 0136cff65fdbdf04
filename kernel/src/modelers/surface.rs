//! Closed triangulated surfaces: their volume, and whether a point lies inside.

use super::mesh::bounds;
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::io::stl::{self, Triangle};
use std::collections::HashMap;
use std::path::Path;

/// A closed surface, its triangles sorted into columns along x for the test of points.
///
/// A point lies inside where the surface winds around it: of the triangles that a ray from the point along +x
/// pierces, those that face along it count 1, the others −1, and the sum is not 0. Cavities, several shells
/// and shells that overlap are so what they look like. Which triangle a ray through an edge or corner
/// pierces is settled by half-open edges, whose test is the same number by number for the triangles on both
/// sides: no ray slips through, none is counted twice (compare Edelsbrunner, Mücke, Simulation of simplicity,
/// ACM Trans. Graphics 9 (1990)).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surface {
    triangles: Vec<Triangle>,
    low: [f64; 3],
    high: [f64; 3],
    volume: f64,
    columns: Columns,
}

/// Triangles over the cells of a regular grid in the plane of y and z.
#[derive(Debug, Clone, PartialEq)]
struct Columns {
    /// Columns along y and z.
    counts: [usize; 2],
    /// Columns per metre.
    density: [f64; 2],
    starts: Vec<u32>,
    list: Vec<u32>,
}

/// Most columns along an axis.
const MOST_COLUMNS: f64 = 1024.0;

impl Surface {
    /// Reads a file, its lengths times `scale` in metres.
    ///
    /// # Errors
    /// Those of the file; triangles without an area, and edges that not exactly two triangles share, once in
    /// each direction.
    pub fn read(path: &Path, scale: f64) -> Result<Self, InputErrors> {
        let mut triangles = stl::read(path)?;
        triangles.iter_mut().flatten().flatten().for_each(|x| *x *= scale);
        Self::new(triangles).map_err(|(message, help)| Diagnostic::error(Place::file(path), message).help(help).into())
    }

    /// From triangles that form a closed surface; else what is wrong, and what to do.
    pub fn new(triangles: Vec<Triangle>) -> Result<Self, (String, String)> {
        check(&triangles)?;
        let (low, high) = bounds(triangles.as_flattened());
        let volume = volume(&triangles, std::array::from_fn(|a| 0.5 * (low[a] + high[a])));
        let extent: f64 = (0..3).map(|a| high[a] - low[a]).product();
        // The sum of n terms of the size of the box is wrong by round-off.
        if volume.abs() <= 1e-13 * triangles.len() as f64 * extent || !volume.is_finite() {
            let help = "a body needs a volume; plane bodies are made of the primitive \"polygon\"";
            return Err((format!("the surface encloses the volume {volume} m³"), help.into()));
        }
        let columns = Columns::new(&triangles, low, high);
        Ok(Self { triangles, low, high, volume: volume.abs(), columns })
    }

    /// Volume of the polyhedron in m³.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Lowest and highest coordinates in m.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        (self.low, self.high)
    }

    /// Whether the surface winds around a point; of points on the surface about half are inside.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        if (0..3).any(|axis| x[axis] < self.low[axis] || x[axis] > self.high[axis]) {
            return false;
        }
        let near = self.columns.at(self.low, x);
        near.iter().map(|&triangle| pierced(&self.triangles[triangle as usize], x)).sum::<i32>() != 0
    }
}

/// 1 or −1 for a triangle that the ray from `x` along +x leaves the body or enters it through; 0 for others.
fn pierced(triangle: &Triangle, x: [f64; 3]) -> i32 {
    // Seen along x: the ray is a point, and from it a second ray along +y crosses edges of the triangle. The
    // sum of the crossings is 0 outside; inside it is the triangle's sense of rotation.
    let mut around = 0;
    for corner in 0..3 {
        let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
        let upward = b[2] > x[2];
        if (a[2] > x[2]) == upward {
            continue;
        }
        // Always from the lower to the upper corner, so that the neighbour computes the same.
        let (low, high) = if upward { (a, b) } else { (b, a) };
        let y = low[1] + (x[2] - low[2]) / (high[2] - low[2]) * (high[1] - low[1]);
        if y > x[1] {
            around += if upward { 1 } else { -1 };
        }
    }
    if around != 0 && place_along(triangle, x) > x[0] { around } else { 0 }
}

/// The x at which the plane of a triangle meets the line through a point along x, kept within the triangle.
fn place_along([a, b, c]: &Triangle, x: [f64; 3]) -> f64 {
    let (u, v) = ([b[1] - a[1], b[2] - a[2]], [c[1] - a[1], c[2] - a[2]]);
    let (p, area) = ([x[1] - a[1], x[2] - a[2]], u[0] * v[1] - u[1] * v[0]);
    let (s, t) = ((p[0] * v[1] - p[1] * v[0]) / area, (u[0] * p[1] - u[1] * p[0]) / area);
    let place = a[0] + s * (b[0] - a[0]) + t * (c[0] - a[0]);
    let (low, high) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
    // A triangle seen from its edge has no such plane; anywhere within it will do.
    if place.is_finite() { place.clamp(low, high) } else { 0.5 * (low + high) }
}

/// Volume by the divergence theorem: tetrahedra from a point to the triangles.
fn volume(triangles: &[Triangle], origin: [f64; 3]) -> f64 {
    let from = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|a| x[a] - origin[a]) };
    let of = |[a, b, c]: &Triangle| {
        let (a, b, c) = (from(*a), from(*b), from(*c));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
    };
    triangles.iter().map(of).sum()
}

/// Refuses what is no closed surface: what is wrong, and what to do.
fn check(triangles: &[Triangle]) -> Result<(), (String, String)> {
    if triangles.is_empty() {
        return Err(("the surface has no triangle".into(), "an STL file of a closed surface is needed".into()));
    }
    // Corners are one where they have the same numbers; −0 is 0.
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut number = |x: &[f64; 3]| {
        let next = numbers.len() as u32;
        *numbers.entry(x.map(|x| (x + 0.0).to_bits())).or_insert(next)
    };
    let cells: Vec<[u32; 3]> = triangles.iter().map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
    let flat: Vec<usize> = (0..cells.len())
        .filter(|&i| {
            let [a, b, c] = cells[i];
            a == b || b == c || c == a || doubled_area(&triangles[i]) == 0.0
        })
        .collect();
    if let Some(&first) = flat.first() {
        let message = format!(
            "{} of {} triangles have no area, the first is number {} with a corner at {:?}",
            flat.len(),
            triangles.len(),
            first + 1,
            triangles[first][0]
        );
        return Err((message, "repair the surface: merge double corners and remove flat triangles".into()));
    }
    // For each edge how much oftener it is run through from its lower to its higher corner.
    let mut balance: HashMap<(u32, u32), (i32, usize, usize)> = HashMap::new();
    for (index, cell) in cells.iter().enumerate() {
        for corner in 0..3 {
            let (a, b) = (cell[corner], cell[(corner + 1) % 3]);
            let entry = balance.entry((a.min(b), a.max(b))).or_insert((0, 0, index));
            entry.0 += if a < b { 1 } else { -1 };
            entry.1 += 1;
        }
    }
    let faulty = balance.values().filter(|(balance, _, _)| *balance != 0);
    let (open, turned): (Vec<_>, Vec<_>) = faulty.partition(|(_, uses, _)| uses % 2 == 1);
    let first = |list: &[&(i32, usize, usize)]| list.iter().map(|(_, _, triangle)| *triangle).min().unwrap_or(0);
    if !open.is_empty() {
        let triangle = first(&open);
        let message = format!(
            "the surface is open: {} edges lack a triangle, the first at triangle {} near {:?}",
            open.len(),
            triangle + 1,
            triangles[triangle][0]
        );
        return Err((message, "close the holes; corners that should be one must have the same numbers".into()));
    }
    if !turned.is_empty() {
        let triangle = first(&turned);
        let message = format!(
            "{} edges have both of their triangles turned the same way, the first at triangle {} near {:?}",
            turned.len(),
            triangle + 1,
            triangles[triangle][0]
        );
        return Err((message, "make the normals of the surface point to one side".into()));
    }
    Ok(())
}

/// Length of the cross product of two edges.
fn doubled_area([a, b, c]: &Triangle) -> f64 {
    let (u, v): ([f64; 3], [f64; 3]) = (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    cross.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Columns {
    fn new(triangles: &[Triangle], low: [f64; 3], high: [f64; 3]) -> Self {
        let side = (triangles.len() as f64).sqrt().ceil().min(MOST_COLUMNS);
        let counts = [side as usize; 2];
        let density = [1, 2].map(|axis| side / (high[axis] - low[axis]));
        let mut columns = Self { counts, density, starts: vec![0; counts[0] * counts[1] + 1], list: Vec::new() };
        // Counted first, then filled.
        let mut places = Vec::new();
        for (index, triangle) in triangles.iter().enumerate() {
            let (from, to) = bounds(triangle);
            let ([y0, z0], [y1, z1]) = (columns.place(low, from), columns.place(low, to));
            for z in z0..=z1 {
                places.extend((y0..=y1).map(|y| (z * counts[0] + y, index as u32)));
            }
        }
        places.iter().for_each(|(column, _)| columns.starts[column + 1] += 1);
        (1..columns.starts.len()).for_each(|i| columns.starts[i] += columns.starts[i - 1]);
        let mut next = columns.starts.clone();
        columns.list = vec![0; places.len()];
        for (column, triangle) in places {
            columns.list[next[column] as usize] = triangle;
            next[column] += 1;
        }
        columns
    }

    fn place(&self, low: [f64; 3], x: [f64; 3]) -> [usize; 2] {
        std::array::from_fn(|i| (((x[i + 1] - low[i + 1]) * self.density[i]) as usize).min(self.counts[i] - 1))
    }

    /// Triangles that a line along x through a point may meet.
    fn at(&self, low: [f64; 3], x: [f64; 3]) -> &[u32] {
        let [y, z] = self.place(low, x);
        let column = z * self.counts[0] + y;
        &self.list[self.starts[column] as usize..self.starts[column + 1] as usize]
    }
}
