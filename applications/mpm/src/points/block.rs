//! Material points as columns, in blocks of one body and one material.

use super::conditions::PointConditions;
use super::lost::Losses;
use super::measures::resists_rates;
use bia_constitutive::{Kinematics, Law, LawError};
use bia_kernel::error::Failure;
use bia_kernel::variables::Column;
use nalgebra::Matrix3;

/// Which columns a scene needs beside id, cell, position, mass, deformation gradient and what the law
/// keeps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Columns {
    /// Displacement since the start.
    pub displacement: bool,
    /// Velocity.
    pub velocity: bool,
    /// Acceleration.
    pub acceleration: bool,
    /// Local coordinates in the cell.
    pub local: bool,
    /// Cauchy stress.
    pub stress: bool,
    /// Strain, where it is not told by the deformation gradient.
    pub strain: bool,
    /// Stress, strain and volume, where the law has no energy of its own.
    pub strain_energy: bool,
    /// Current volume.
    pub volume: bool,
    /// Pressure, of which mixed formulations make their start values.
    pub pressure: bool,
    /// Body force per mass that differs from point to point.
    pub body_acceleration: bool,
    /// Numbers a point that the transfer of velocity keeps.
    pub transfer: usize,
    /// These numbers are an affine part of the velocity.
    pub affine: bool,
    /// Kinetic energy, which such a part adds to.
    pub kinetic_energy: bool,
}

/// Points of one body with one material.
pub struct Block {
    /// Index of the body in [`MaterialPoints::bodies`].
    pub body: usize,
    /// Id of the properties.
    pub material: u32,
    /// Kinematics under which its law was built.
    pub kinematics: Kinematics,
    /// Name of the law in the materials file.
    pub law_name: String,
    /// The constitutive law.
    pub law: Box<dyn Law>,
    /// The strain energy is that of the law; else, and in Kratos always, it is half the work of
    /// stress on strain, which large strains do not conserve.
    pub has_energy: bool,
    /// Initial density in kg/m³.
    pub density: f64,
    /// Extent across a plane mesh in m, across a line in m²; 1 in space.
    pub extent: f64,
    /// An initial stress is given, which may hold the body forces: it does not start with their acceleration.
    pub starts_stressed: bool,
    /// Body force per mass in m/s² that all points share.
    pub gravity: [f64; 3],
    /// Body force per mass in m/s² of each point beside gravity, if used.
    pub body_acceleration: Column,
    /// What the transfer of velocity keeps, if anything: first moments of the velocity about the point
    /// (APIC) or its gradient (TPIC), row by row; or the velocity before it is filtered (XPIC).
    pub transfer: Column,
    /// Whether these are first moments, which count in the angular momentum.
    pub moments: bool,
    /// Kinetic energy per mass of the affine part of the velocity in J/kg, where there is one and energies are wanted.
    pub affine_energy: Column,
    /// Ids, each once. In what order the points stand is the solver's choice, which may sort them by
    /// cell ([`Block::reorder`]); whoever writes them out goes by [`Block::in_order_of_id`] or
    /// [`MaterialPoints::by_id`].
    pub ids: Vec<u32>,
    /// Background cell of each point.
    pub cell: Vec<u32>,
    /// Local coordinates in that cell, if used.
    pub local: Column,
    /// Position in m.
    pub position: Column,
    /// Displacement in m, if used.
    pub displacement: Column,
    /// Velocity in m/s, if used.
    pub velocity: Column,
    /// Acceleration in m/s², if used.
    pub acceleration: Column,
    /// Mass in kg.
    pub mass: Column,
    /// Deformation gradient: F11 in one dimension, the plane part row by row, then F33 if
    /// axisymmetric; or all nine.
    pub gradient: Column,
    /// History of the law.
    pub state: Column,
    /// Cauchy stress in Pa, in the Voigt order of the kinematics, if used.
    pub stress: Column,
    /// Strain that the law accumulates or, as Kratos shows it, in the law's measure; if used.
    pub strain: Column,
    /// Volume in m³, if used.
    pub volume: Column,
    /// Mean stress of the nodes in Pa, in mixed formulations.
    pub pressure: Column,
}

impl Block {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The deformation gradient of a point, 3×3.
    #[inline]
    pub fn deformation_gradient(&self, point: usize) -> Matrix3<f64> {
        expand(self.gradient.row(point))
    }

    /// Law, deformation gradient and J of a point, for failures.
    pub fn describe(&self, point: usize) -> String {
        describe_deformation(self.law.name(), &self.deformation_gradient(point))
    }

    /// Position of a point in m; the third coordinate is 0 in the plane.
    pub fn coordinates(&self, point: usize) -> [f64; 3] {
        let row = self.position.row(point);
        std::array::from_fn(|i| row.get(i).copied().unwrap_or(0.0))
    }

    /// Body force per mass of a point in m/s²: gravity and what functions add to it.
    #[inline]
    pub fn body_acceleration_of<const D: usize>(&self, point: usize) -> [f64; D] {
        let mut sum = std::array::from_fn(|a| self.gravity[a]);
        if self.body_acceleration.is_used() {
            let own = self.body_acceleration.get::<D>(point);
            (0..D).for_each(|a| sum[a] += own[a]);
        }
        sum
    }

    /// Angular momentum of a point about a place in kg m²/s: m x × v and, where the point keeps first moments
    /// B = Σ N v ⊗ (x_i − x_p) of an affine velocity, m times their axial vector (Jiang et al. 2015).
    pub fn angular_momentum(&self, point: usize, center: [f64; 3]) -> [f64; 3] {
        let of = |row: &[f64], a: usize| row.get(a).copied().unwrap_or(0.0);
        let (mass, x, v) = (self.mass.row(point)[0], self.coordinates(point), self.velocity.row(point));
        let (dimension, kept) = (self.kinematics.dimension(), self.transfer.row(point));
        let affine = |a: usize, b: usize| {
            if self.moments && a.max(b) < dimension { of(kept, a * dimension + b) } else { 0.0 }
        };
        std::array::from_fn(|k| {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let lever = (x[a] - center[a]) * of(v, b) - (x[b] - center[b]) * of(v, a);
            mass * (lever + affine(b, a) - affine(a, b))
        })
    }

    /// Mean stress of the nodes at a point in Pa, in mixed formulations.
    pub fn pressure_of(&self, point: usize) -> Option<f64> {
        self.pressure.row(point).first().copied()
    }

    /// Whether stresses that only its flow makes act from the first instant: velocities differ, and the law
    /// resists rates.
    pub fn starts_sheared(&self) -> bool {
        let velocities = || (0..self.len()).map(|point| self.velocity.row(point));
        velocities().any(|velocity| velocity != self.velocity.row(0)) && resists_rates(self.law.as_ref())
    }

    /// Lets a body start with the acceleration of its body forces: let go without stress, it
    /// accelerates so from the first instant. What stress holds at the start is taken to be in balance.
    pub fn start_with_body_acceleration(&mut self) {
        if !self.acceleration.is_used() || self.starts_stressed || self.starts_sheared() {
            return;
        }
        for point in 0..self.len() {
            let own = self.body_acceleration.row(point);
            for (a, value) in self.acceleration.row_mut(point).iter_mut().enumerate() {
                *value = self.gravity[a] + own.get(a).copied().unwrap_or(0.0);
            }
        }
    }

    /// All columns with their names.
    pub fn columns(&self) -> [(&'static str, &Column); 15] {
        [
            ("local coordinates", &self.local),
            ("position", &self.position),
            ("displacement", &self.displacement),
            ("velocity", &self.velocity),
            ("acceleration", &self.acceleration),
            ("mass", &self.mass),
            ("deformation gradient", &self.gradient),
            ("law history", &self.state),
            ("Cauchy stress", &self.stress),
            ("strain", &self.strain),
            ("volume", &self.volume),
            ("pressure", &self.pressure),
            ("body acceleration", &self.body_acceleration),
            ("transfer", &self.transfer),
            ("affine energy", &self.affine_energy),
        ]
    }

    pub(super) fn columns_mut(&mut self) -> [&mut Column; 15] {
        [
            &mut self.local,
            &mut self.position,
            &mut self.displacement,
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.mass,
            &mut self.gradient,
            &mut self.state,
            &mut self.stress,
            &mut self.strain,
            &mut self.volume,
            &mut self.pressure,
            &mut self.body_acceleration,
            &mut self.transfer,
            &mut self.affine_energy,
        ]
    }

    /// Makes room for so many points in the columns that points are pushed to.
    pub fn reserve(&mut self, points: usize) {
        self.ids.reserve_exact(points);
        self.cell.reserve_exact(points);
        for column in [&mut self.local, &mut self.position, &mut self.mass] {
            column.reserve(points);
        }
    }

    /// Bytes of all columns, ids and cells.
    pub fn bytes(&self) -> usize {
        self.columns().iter().map(|(_, column)| column.bytes()).sum::<usize>() + 8 * self.len()
    }

    /// Brings the points into another order: place k then holds what was at `order[k]`, a
    /// permutation of all points.
    ///
    /// # Panics
    /// `order` is shorter than the block, or names a point beyond it.
    pub fn reorder(&mut self, order: &[u32], scratch: &mut Scratch) {
        let old = &mut scratch.indices;
        for indices in [&mut self.ids, &mut self.cell] {
            old.clear();
            old.extend_from_slice(indices);
            indices.iter_mut().zip(order).for_each(|(index, &from)| *index = old[from as usize]);
        }
        for column in self.columns_mut() {
            column.reorder(order, &mut scratch.numbers);
        }
    }

    /// The points ascending by id.
    pub fn in_order_of_id(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        if self.ids.is_sorted() {
            return order;
        }
        let (first, last) = self.ids.iter().fold((u32::MAX, 0), |(low, high), &id| (low.min(id), high.max(id)));
        let span = (last - first) as usize + 1;
        if span > 8 * self.len() {
            order.sort_unstable_by_key(|&point| self.ids[point as usize]);
            return order;
        }
        // Ids have few gaps, so a table of all of them is shorter work than a sort.
        let mut places = vec![u32::MAX; span];
        self.ids.iter().enumerate().for_each(|(point, &id)| places[(id - first) as usize] = point as u32);
        order.clear();
        order.extend(places.into_iter().filter(|&point| point != u32::MAX));
        order
    }

    /// Keeps the points for which `keep` holds, in their order.
    pub fn retain(&mut self, keep: &[bool]) {
        let mut kept = keep.iter();
        self.ids.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        self.cell.retain(|_| kept.next() == Some(&true));
        for column in self.columns_mut() {
            column.retain(keep);
        }
    }
}

/// Memory for [`Block::reorder`], kept from call to call.
#[derive(Debug, Default)]
pub struct Scratch {
    numbers: Vec<f64>,
    indices: Vec<u32>,
}

/// Numbers of a stored deformation gradient.
pub fn gradient_width(kinematics: Kinematics) -> usize {
    match kinematics {
        Kinematics::ThreeDimensional => 9,
        Kinematics::PlaneStrain | Kinematics::PlaneStress => 4,
        Kinematics::Axisymmetric => 5,
        Kinematics::UniaxialStrain => 1,
    }
}

/// The 3×3 gradient of a stored row.
#[inline]
pub fn expand(row: &[f64]) -> Matrix3<f64> {
    match *row {
        [a] => Matrix3::new(a, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        [a, b, c, d] => Matrix3::new(a, b, 0.0, c, d, 0.0, 0.0, 0.0, 1.0),
        [a, b, c, d, e] => Matrix3::new(a, b, 0.0, c, d, 0.0, 0.0, 0.0, e),
        _ => Matrix3::from_row_slice(row),
    }
}

/// Stores a 3×3 gradient in a row.
#[inline]
pub fn compress(gradient: &Matrix3<f64>, row: &mut [f64]) {
    let f = |i, j| gradient[(i, j)];
    match row {
        [a] => *a = f(0, 0),
        [a, b, c, d] => (*a, *b, *c, *d) = (f(0, 0), f(0, 1), f(1, 0), f(1, 1)),
        [a, b, c, d, e] => (*a, *b, *c, *d, *e) = (f(0, 0), f(0, 1), f(1, 0), f(1, 1), f(2, 2)),
        _ => (0..9).for_each(|k| row[k] = f(k / 3, k % 3)),
    }
}

/// Law, deformation gradient row by row, and its determinant, for failures.
pub fn describe_deformation(law: &str, gradient: &Matrix3<f64>) -> String {
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| format!("{:.6e}", gradient[(i, j)])).join(", "));
    format!("law {law}, F = [{}], J = {:e}", rows.join("; "), gradient.determinant())
}

/// A law's refusal as a failure of the run.
pub fn law_failure(block: &Block, point: usize, gradient: &Matrix3<f64>, error: &LawError) -> Failure {
    Failure::new(format!("the law {} has no answer: {error}", block.law.name()), "a smaller time step or smaller loads")
        .at(format!("material point {}", block.ids[point]), block.coordinates(point))
        .detail(describe_deformation(block.law.name(), gradient))
}

/// One body or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// All bodies.
    All,
    /// The body of this index.
    Body(usize),
}

impl Selection {
    /// Whether it holds a body.
    pub fn holds(self, body: usize) -> bool {
        self == Selection::All || self == Selection::Body(body)
    }
}

/// All material points of a run; kept beside the model parts in the model.
pub struct MaterialPoints {
    /// Name of the part of points, `MPM_Material` by default.
    pub name: String,
    /// Kinematics of the scene.
    pub kinematics: Kinematics,
    /// The points have inertia.
    pub dynamic: bool,
    /// Names of the bodies: the first-level parts of the initial model part.
    pub bodies: Vec<String>,
    /// Blocks, by body and material, in the order of their first ids.
    pub blocks: Vec<Block>,
    /// Material-point conditions.
    pub conditions: PointConditions,
    /// What has left the grid.
    pub losses: Losses,
}

impl MaterialPoints {
    /// Dimension of space.
    pub fn dimension(&self) -> usize {
        self.kinematics.dimension()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.blocks.iter().map(Block::len).sum()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// (block, point) of the selected points, ascending by id.
    pub fn by_id(&self, selection: Selection) -> Vec<(u32, u32)> {
        let blocks = self.blocks.iter().enumerate().filter(|(_, block)| selection.holds(block.body));
        let mut order: Vec<(u32, u32)> = Vec::with_capacity(self.len());
        for (b, block) in blocks {
            order.extend(block.in_order_of_id().into_iter().map(|p| (b as u32, p)));
        }
        let id = |&(b, p): &(u32, u32)| self.blocks[b as usize].ids[p as usize];
        if !order.is_sorted_by_key(id) {
            order.sort_by_key(id); // which merges the blocks' runs
        }
        order
    }

    /// What a part path selects: `MPM_Material.Body`, `Initial_MPM_Material.Body`,
    /// `Background_Grid.Body` or `Body` alone; a root alone selects all bodies.
    pub fn select(&self, path: &str) -> Option<Selection> {
        let initial = format!("Initial_{}", self.name);
        let (root, below) = path.split_once('.').map_or((path, None), |(root, below)| (root, Some(below)));
        let is_root = root == self.name || root == initial || root == crate::grid::GRID;
        let name = match (is_root, below) {
            (true, None) => return Some(Selection::All),
            (true, Some(below)) => below,
            (false, _) => path,
        };
        self.bodies.iter().position(|body| body == name).map(Selection::Body)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_survive_storage() {
        for (width, f) in [
            (1, Matrix3::new(1.2, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)),
            (4, Matrix3::new(1.1, 0.2, 0.0, -0.3, 0.9, 0.0, 0.0, 0.0, 1.0)),
            (5, Matrix3::new(1.1, 0.2, 0.0, -0.3, 0.9, 0.0, 0.0, 0.0, 1.4)),
            (9, Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)),
        ] {
            let mut row = vec![0.0; width];
            compress(&f, &mut row);
            assert_eq!(expand(&row), f);
        }
    }
}
