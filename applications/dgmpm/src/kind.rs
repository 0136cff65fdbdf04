//! What cells of the same form and the same layout of points share: the operators that take the values
//! of its points or nodes through a stage.
//!
//! With the functions S_i of the cell's own nodes, masses m_p and volumes V_p of its points,
//!
//! M_i = Σ_p S_i(X_p) m_p,  M_i Ū_i = Σ_p S_i(X_p) m_p U_p,
//! M_i v̇_i = −Σ_j Σ_p V_p ∂S_i/∂X_a S_j Π_j e_a + Σ_f w_if t*_f,
//! M_i Ḟ_i = −ρ₀ Σ_j Σ_p V_p ∂S_i/∂X_a S_j v_j ⊗ e_a + ρ₀ Σ_f w_if v*_f ⊗ N_f,
//! U_p = Σ_i S_i(X_p) Ū_i.
//!
//! The weights w_if of a face's nodes are such that a constant state stays constant: in cells with
//! parallel faces Σ_f w_if N_f = Σ_p V_p ∇S_i, which is an equal share of the face for every layout that
//! is symmetric, and else the points' own measure of the face. In other cells the shares are equal and
//! what they miss, times the mean stress and velocity of the cell, is taken from the volume term.
//!
//! Source: Renaud and Heuzé, COMPDYN 2017, §3, with the misprints of its (10), (13) and (15) put right.

use crate::matrix::{Matrix, Vector, dot, inverse, times};
use crate::stages::{Site, Stage};
use bia_kernel::geometry::{CellShape, adjugate, jacobian};

/// The most faces that a cell has.
pub const FACES: usize = 6;

/// A point of a layout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Local coordinates, from −1 to 1.
    pub local: [f64; 3],
    /// Local volume that the point stands for.
    pub weight: f64,
}

/// A stage's operator: values at `targets` places from those at `sources` places.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Operator<const D: usize> {
    /// Places that values go to.
    pub targets: usize,
    /// Places that values come from.
    pub sources: usize,
    /// Factors of the points' values at the start of the step, `[target][point]`; empty for none.
    pub base: Vec<f64>,
    /// Factors of the sources' values, `[target][source]`; empty for none.
    pub keep: Vec<f64>,
    /// (1/M) Σ_p V_p ∂S_i/∂X_a S_j, `[target][source]`, in 1/(m kg/m³) = m²/kg; empty where it is zero.
    pub volume: Vec<Vector<D>>,
    /// w_if/M_i in m²/kg, `[target][face]`.
    pub faces: Vec<[f64; FACES]>,
    /// Factors of the points' body forces, `[target][point]`.
    pub body: Vec<f64>,
}

/// Cells of one form with one layout of points of one material.
#[derive(Debug, Clone)]
pub struct CellKind<const D: usize> {
    /// Index of the material.
    pub material: u32,
    /// Volume (m³).
    pub volume: f64,
    /// Outward normals of the faces: −ξ, ξ, −η, η, −ζ, ζ.
    pub normals: [Vector<D>; FACES],
    /// Areas of the faces (m²).
    pub areas: [f64; FACES],
    /// Volumes of the points (m³).
    pub volumes: Vec<f64>,
    /// Functions of the nodes at the points, `[point][node]`.
    pub functions: Vec<[f64; 8]>,
    /// Operator of each stage.
    pub operators: Vec<Operator<D>>,
    /// Factors that average the points' values over each face, `[point][face]`.
    pub point_traces: Vec<[f64; FACES]>,
    /// The same from the nodes.
    pub node_traces: Vec<[f64; FACES]>,
    /// Shares of the points in the mean over the cell.
    pub point_means: Vec<f64>,
    /// Shares of the nodes.
    pub node_means: Vec<f64>,
    /// Opposite faces have the same normal.
    pub is_parallel: bool,
}

/// A node of the cell gets no mass from the points: the lumped mass matrix is singular.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Massless;

/// Local axis and side of a face: `(axis, upper)`.
pub const fn axis_of(face: usize) -> (usize, bool) {
    (face / 2, face % 2 == 1)
}

/// Local nodes of a face of a cell with these reference corners.
pub fn face_nodes(corners: &[[f64; 3]], face: usize) -> impl Iterator<Item = usize> {
    let (axis, upper) = axis_of(face);
    let side = if upper { 1.0 } else { -1.0 };
    (0..corners.len()).filter(move |&node| corners[node][axis] == side)
}

/// Values of a cell that all operators come from.
struct Moments<const D: usize, const N: usize> {
    /// S_i(X_p) by point.
    functions: Vec<[f64; N]>,
    /// ∇S_i(X_p) by point (1/m).
    gradients: Vec<[Vector<D>; N]>,
    volumes: Vec<f64>,
    masses: Vec<f64>,
    /// M_i.
    lumped: [f64; N],
    /// w_if by face (m²).
    shares: [[f64; N]; FACES],
    /// What the shares miss of a constant state: Σ_f w_if N_f − Σ_p V_p ∇S_i (m²).
    missed: [Vector<D>; N],
}

impl<const D: usize> CellKind<D> {
    /// Cells with these corners (m); `extent` is their measure across the mesh.
    ///
    /// # Errors
    /// A node without mass.
    pub fn new<S: CellShape<D, N>, const N: usize>(
        corners: &[Vector<D>; N],
        places: &[Place],
        (material, density, extent): (u32, f64, f64),
        stages: &[Stage],
    ) -> Result<Self, Massless> {
        let (normals, areas) = faces::<S, D, N>(corners, extent);
        let is_parallel = (0..D).all(|axis| {
            let (low, high) = (2 * axis, 2 * axis + 1);
            let turned = 1.0 + dot(&normals[low], &normals[high]);
            turned.abs() < 1e-12 && (areas[low] / areas[high] - 1.0).abs() < 1e-12
        });
        let moments = Moments::new::<S>(corners, places, [density, extent], (&normals, &areas, is_parallel))?;
        let operators = stages.iter().map(|stage| moments.operator(stage)).collect();
        let total: f64 = moments.masses.iter().sum();
        let mut trace = [[0.0; FACES]; N];
        for face in 0..2 * D {
            let area: f64 = moments.shares[face].iter().sum();
            (0..N).for_each(|i| trace[i][face] = moments.shares[face][i] / area);
        }
        let of_point = |p: usize| {
            let mut row = [0.0; FACES];
            for (i, of_node) in trace.iter().enumerate() {
                let factor = moments.projection(i, p);
                row.iter_mut().zip(of_node).for_each(|(entry, share)| *entry += factor * share);
            }
            row
        };
        Ok(Self {
            material,
            volume: moments.volumes.iter().sum(),
            normals,
            areas,
            operators,
            point_traces: (0..places.len()).map(of_point).collect(),
            node_traces: trace.to_vec(),
            point_means: moments.masses.iter().map(|m| m / total).collect(),
            node_means: moments.lumped.iter().map(|m| m / total).collect(),
            functions: moments
                .functions
                .iter()
                .map(|of_point| std::array::from_fn(|i| of_point.get(i).copied().unwrap_or(0.0)))
                .collect(),
            volumes: moments.volumes,
            is_parallel,
        })
    }

    /// Distance of the two faces of an axis (m).
    pub fn height(&self, axis: usize) -> f64 {
        2.0 * self.volume / (self.areas[2 * axis] + self.areas[2 * axis + 1])
    }
}

/// Outward normals and areas of the faces.
fn faces<S: CellShape<D, N>, const D: usize, const N: usize>(
    corners: &[Vector<D>; N],
    extent: f64,
) -> ([Vector<D>; FACES], [f64; FACES]) {
    let (mut normals, mut areas) = ([[0.0; D]; FACES], [0.0; FACES]);
    for face in 0..2 * D {
        let (axis, upper) = axis_of(face);
        let mut centre = [0.0; D];
        centre[axis] = if upper { 1.0 } else { -1.0 };
        let (cofactor, _) = adjugate(&jacobian(corners, &S::gradients(&centre)));
        let mut normal = cofactor[axis].map(|n| n * centre[axis]);
        let length = dot(&normal, &normal).sqrt();
        normal.iter_mut().for_each(|n| *n /= length);
        // The reference face has the measure 2^(D − 1).
        (normals[face], areas[face]) = (normal, length * (1 << (D - 1)) as f64 * extent);
    }
    (normals, areas)
}

impl<const D: usize, const N: usize> Moments<D, N> {
    fn new<S: CellShape<D, N>>(
        corners: &[Vector<D>; N],
        places: &[Place],
        [density, extent]: [f64; 2],
        (normals, areas, is_parallel): (&[Vector<D>; FACES], &[f64; FACES], bool),
    ) -> Result<Self, Massless> {
        let (mut functions, mut gradients, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
        for place in places {
            let local: Vector<D> = std::array::from_fn(|a| place.local[a]);
            let slopes = S::gradients(&local);
            let (cofactor, determinant) = adjugate(&jacobian(corners, &slopes));
            let physical = |slope: &Vector<D>| -> Vector<D> {
                std::array::from_fn(|i| (0..D).map(|j| slope[j] * cofactor[j][i]).sum::<f64>() / determinant)
            };
            functions.push(S::functions(&local));
            gradients.push(slopes.map(|slope| physical(&slope)));
            volumes.push(place.weight * determinant * extent);
        }
        let masses: Vec<f64> = volumes.iter().map(|volume| density * volume).collect();
        let mut lumped = [0.0; N];
        for (function, mass) in functions.iter().zip(&masses) {
            (0..N).for_each(|i| lumped[i] += function[i] * mass);
        }
        let total: f64 = masses.iter().sum();
        if lumped.iter().any(|&mass| mass.is_nan() || mass <= 1e-12 * total) {
            return Err(Massless);
        }
        let mut moments =
            Self { functions, gradients, volumes, masses, lumped, shares: [[0.0; N]; FACES], missed: [[0.0; D]; N] };
        moments.share_faces(S::SHAPE.reference_corners(), normals, areas, is_parallel);
        Ok(moments)
    }

    /// The weights w_if, and what they miss of a constant state.
    fn share_faces(
        &mut self,
        corners: &[[f64; 3]],
        normals: &[Vector<D>; FACES],
        areas: &[f64; FACES],
        is_parallel: bool,
    ) {
        for i in 0..N {
            let own: [usize; D] = std::array::from_fn(|axis| 2 * axis + usize::from(corners[i][axis] > 0.0));
            let mut sum = [0.0; D];
            for (gradient, volume) in self.gradients.iter().zip(&self.volumes) {
                (0..D).for_each(|a| sum[a] += volume * gradient[i][a]);
            }
            let mut matrix: Matrix<D> = [[0.0; D]; D];
            own.iter().enumerate().for_each(|(k, &face)| (0..D).for_each(|a| matrix[a][k] = normals[face][a]));
            let consistent = times(&inverse(&matrix), &sum);
            for (k, &face) in own.iter().enumerate() {
                let equal = areas[face] / (1 << (D - 1)) as f64;
                // Round-off must not tell the nodes of a symmetric layout apart.
                let differs = (consistent[k] / equal - 1.0).abs() > 1e-12;
                self.shares[face][i] = if is_parallel && differs { consistent[k] } else { equal };
                (0..D).for_each(|a| self.missed[i][a] += self.shares[face][i] * normals[face][a]);
            }
            (0..D).for_each(|a| self.missed[i][a] -= sum[a]);
            let scale: f64 = own.iter().map(|&face| areas[face]).sum();
            self.missed[i].iter_mut().filter(|m| m.abs() < 1e-12 * scale).for_each(|m| *m = 0.0);
        }
    }

    /// Factor of point p in the value of node i: S_i m_p/M_i.
    fn projection(&self, i: usize, p: usize) -> f64 {
        self.functions[p][i] * self.masses[p] / self.lumped[i]
    }

    /// (1/M_i) (Σ_p V_p ∂S_i/∂X_a S_j + missed_i M_j/M).
    fn volume_of_nodes(&self, i: usize, j: usize) -> Vector<D> {
        let total: f64 = self.masses.iter().sum();
        let mut sum = self.missed[i].map(|missed| missed * self.lumped[j] / total);
        for (p, volume) in self.volumes.iter().enumerate() {
            (0..D).for_each(|a| sum[a] += volume * self.gradients[p][i][a] * self.functions[p][j]);
        }
        sum.map(|entry| entry / self.lumped[i])
    }

    fn operator(&self, stage: &Stage) -> Operator<D> {
        let points = self.volumes.len();
        let count = |site: Site| if site == Site::Points { points } else { N };
        let (targets, sources) = (count(stage.to), count(stage.from));
        // Values at targets and sources in those of the nodes.
        let to = |t: usize, i: usize| match stage.to {
            Site::Points => self.functions[t][i],
            Site::Nodes => f64::from(u8::from(t == i)),
        };
        let from = |s: usize, j: usize| match stage.from {
            Site::Points => self.projection(j, s),
            Site::Nodes => f64::from(u8::from(s == j)),
        };
        let combined = |t: usize, source: &dyn Fn(usize) -> f64| (0..N).map(|i| to(t, i) * source(i)).sum::<f64>();
        let project = |t: usize, p: usize| combined(t, &|i| self.projection(i, p));
        let (mut base, mut keep, mut body) = (Vec::new(), Vec::new(), Vec::new());
        let (mut volume, mut faces) = (Vec::new(), Vec::new());
        let nodal: Vec<Vector<D>> = (0..N * N).map(|k| self.volume_of_nodes(k / N, k % N)).collect();
        for t in 0..targets {
            body.extend((0..points).map(|p| project(t, p)));
            if stage.base != 0.0 {
                base.extend((0..points).map(|p| stage.base * project(t, p)));
            }
            if stage.keep != 0.0 {
                keep.extend((0..sources).map(|s| stage.keep * combined(t, &|i| from(s, i))));
            }
            for s in 0..sources {
                let mut sum = [0.0; D];
                for (k, entry) in nodal.iter().enumerate() {
                    let factor = to(t, k / N) * from(s, k % N);
                    (0..D).for_each(|a| sum[a] += factor * entry[a]);
                }
                volume.push(sum);
            }
            let mut row = [0.0; FACES];
            for (face, shares) in self.shares.iter().enumerate().take(2 * D) {
                row[face] = combined(t, &|i| shares[i] / self.lumped[i]);
            }
            faces.push(row);
        }
        let largest = faces.as_flattened().iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
        if volume.as_flattened().iter().all(|entry: &f64| entry.abs() < 1e-13 * largest) {
            volume.clear();
        }
        Operator { targets, sources, base, keep, volume, faces, body }
    }
}
