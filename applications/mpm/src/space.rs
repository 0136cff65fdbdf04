//! The grid's functions as the solvers see them: those of the mesh's own cells, or of higher order
//! on a regular grid. Solvers number and solve for functions; with the mesh's own shapes functions
//! and nodes are the same thing.

use crate::settings::{Basis, Discretisation};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::geometry::{Family, RegularGrid, Shape, TensorBasis};
use bia_kernel::model::ModelPart;
use bia_kernel::parameters::Settings;
use bia_kernel::solving::ActiveDofs;
use bia_kernel::variables::Variable;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Once;

/// Evaluates an expression with the functions of a cell as a [`PlacedBasis`] of `D` dimensions and
/// `N` functions: `with_basis!(space, cell, |basis, D, N| expression, else other)`. Cells that are no
/// solids yield the last expression.
///
/// [`PlacedBasis`]: bia_kernel::geometry::PlacedBasis
macro_rules! with_basis {
    ($space:expr, $cell:expr, |$basis:ident, $D:ident, $N:ident| $body:expr, else $other:expr) => {
        match $space.functions() {
            $crate::space::Functions::Mesh(shapes) => {
                use bia_kernel::geometry::MeshCell;
                bia_kernel::with_shape!(shapes[$cell], |S, $D, $N| {
                    let $basis = MeshCell::<S, $D, $N>::new($space.corners($cell));
                    $body
                }, else $other)
            }
            $crate::space::Functions::Tensor(tensor) => match (tensor.dimension(), tensor.basis.degree()) {
                (1, 2) => $crate::space::with_degree!(tensor, $cell, 1, 3, 3, |$basis, $D, $N| $body, else $other),
                (1, 3) => $crate::space::with_degree!(tensor, $cell, 1, 4, 4, |$basis, $D, $N| $body, else $other),
                (1, 4) => $crate::space::with_degree!(tensor, $cell, 1, 5, 5, |$basis, $D, $N| $body, else $other),
                (1, 5) => $crate::space::with_degree!(tensor, $cell, 1, 6, 6, |$basis, $D, $N| $body, else $other),
                (1, 6) => $crate::space::with_degree!(tensor, $cell, 1, 7, 7, |$basis, $D, $N| $body, else $other),
                (2, 2) => $crate::space::with_degree!(tensor, $cell, 2, 9, 3, |$basis, $D, $N| $body, else $other),
                (2, 3) => $crate::space::with_degree!(tensor, $cell, 2, 16, 4, |$basis, $D, $N| $body, else $other),
                (3, 2) => $crate::space::with_degree!(tensor, $cell, 3, 27, 3, |$basis, $D, $N| $body, else $other),
                (3, 3) => $crate::space::with_degree!(tensor, $cell, 3, 64, 4, |$basis, $D, $N| $body, else $other),
                _ => $other,
            },
        }
    };
}
pub(crate) use with_basis;

/// One degree of [`with_basis`].
macro_rules! with_degree {
    ($tensor:expr, $cell:expr, $d:literal, $n:literal, $p1:literal, |$basis:ident, $D:ident, $N:ident| $body:expr,
     else $other:expr) => {
        match $tensor.basis.cell::<$d, $n, $p1>($cell) {
            Some($basis) => {
                const $D: usize = $d;
                const $N: usize = $n;
                $body
            }
            None => $other,
        }
    };
}
pub(crate) use with_degree;

/// The highest degree of Lagrange polynomials on a line, and of all others.
const HIGHEST: [usize; 2] = [6, 3];

/// Kinds of functions.
pub enum Functions {
    /// Those of the mesh's cells, which have these shapes.
    Mesh(Vec<Shape>),
    /// Those of a regular grid.
    Tensor(Tensor),
}

/// Functions of a regular grid and the mesh from which it was recognised.
pub struct Tensor {
    /// The functions.
    pub basis: TensorBasis,
    /// Mesh node at each crossing of grid lines.
    crossings: Vec<Option<u32>>,
}

impl Tensor {
    /// Number of axes.
    pub fn dimension(&self) -> usize {
        self.basis.grid().dimension()
    }

    /// Mesh nodes around a function's anchor with their weights.
    fn around(&self, function: usize, mut visit: impl FnMut(usize, f64)) {
        self.basis.around_anchor(function, |crossing, weight| {
            if let Some(node) = self.crossings[crossing] {
                visit(node as usize, weight);
            }
        });
    }
}

/// How far inside a cell of the mesh points are taken to stand, in local coordinates. On a face a node beyond
/// it has no mass, but its function has a gradient there, so that it would act as a support; a little within,
/// it has a velocity. Its share of a point's mass is half of this.
pub const INSET: f64 = 1e-10;

/// The grid's functions.
pub struct Space {
    functions: Functions,
    /// Whether points on faces are taken to stand within their cells by [`INSET`].
    inset: bool,
    /// Where each cell's functions start in `of_cells`, one more entry than cells.
    starts: Vec<u32>,
    of_cells: Vec<u32>,
    positions: Vec<[f64; 3]>,
    told: Once,
}

impl Default for Space {
    fn default() -> Self {
        let (starts, of_cells, positions) = (vec![0], Vec::new(), Vec::new());
        Self { functions: Functions::Mesh(Vec::new()), inset: false, starts, of_cells, positions, told: Once::new() }
    }
}

impl Space {
    /// The functions that the settings choose.
    ///
    /// # Errors
    /// A degree that is not offered, or a grid that is not regular where the functions need one.
    pub fn new(grid: &ModelPart, choice: &Discretisation, settings: &Settings) -> Result<Self, InputErrors> {
        let (family, degree) = match choice.basis {
            // Of degree 1 they are the mesh's own.
            Basis::Mesh | Basis::Lagrange(1) | Basis::BSpline(1) => return Ok(Self::of_mesh(grid)),
            Basis::Lagrange(degree) => (Family::Lagrange, degree),
            Basis::BSpline(degree) => (Family::BSpline, degree),
        };
        let irregular = |reason| {
            let message = format!("{:?} needs a regular grid, but of {}: {reason}", settings.text("basis"), grid.name);
            settings.error("basis", message).help("make the grid with RegularGridModeler, or set basis to \"mesh\"")
        };
        let regular = RegularGrid::new(grid).map_err(irregular)?;
        let crossings = regular.crossings(grid).map_err(irregular)?;
        let highest = HIGHEST[usize::from(regular.dimension() > 1 || family == Family::BSpline)];
        if degree > highest {
            let message = format!("is {degree}, must be at most {highest} for this basis in {}D", regular.dimension());
            return Err(settings.error("basis_order", message).into());
        }
        Ok(Self::of_tensor(Tensor { basis: TensorBasis::new(regular, family, degree), crossings }))
    }

    fn of_mesh(grid: &ModelPart) -> Self {
        let cells = &grid.elements;
        Self {
            functions: Functions::Mesh(cells.shapes.clone()),
            inset: true,
            starts: cells.starts.clone(),
            of_cells: cells.nodes.clone(),
            positions: grid.nodes.coordinates.clone(),
            told: Once::new(),
        }
    }

    fn of_tensor(tensor: Tensor) -> Self {
        let basis = &tensor.basis;
        let (cells, each) = (basis.grid().len(), basis.per_cell());
        Self {
            starts: (0..=cells).map(|cell| (cell * each) as u32).collect(),
            of_cells: (0..cells).flat_map(|cell| basis.functions_of(cell)).collect(),
            positions: (0..basis.len()).map(|function| basis.anchor(function)).collect(),
            functions: Functions::Tensor(tensor),
            inset: false,
            told: Once::new(),
        }
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// The functions themselves.
    #[inline]
    pub fn functions(&self) -> &Functions {
        &self.functions
    }

    /// The shape of a cell of the mesh, where its own functions serve.
    #[inline(always)]
    pub fn shape(&self, cell: usize) -> Option<Shape> {
        match &self.functions {
            Functions::Mesh(shapes) => shapes.get(cell).copied(),
            Functions::Tensor(_) => None,
        }
    }

    /// Whether functions and nodes of the mesh are the same.
    pub fn is_mesh(&self) -> bool {
        matches!(self.functions, Functions::Mesh(_))
    }

    /// The functions that do not vanish in a cell, in the cell's order.
    #[inline(always)]
    pub fn nodes_of(&self, cell: usize) -> &[u32] {
        &self.of_cells[self.range_of(cell)]
    }

    /// The functions of all cells, cell by cell.
    pub fn entries(&self) -> &[u32] {
        &self.of_cells
    }

    /// Where a cell's functions stand in [`entries`](Self::entries).
    #[inline(always)]
    pub fn range_of(&self, cell: usize) -> Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    /// Where a function is anchored in m: its node, or the Greville abscissae of a B-spline.
    pub fn position(&self, function: usize) -> [f64; 3] {
        self.positions[function]
    }

    /// Whether the functions of two cells have one type (see [`with_basis`]).
    #[inline]
    pub fn alike(&self, one: usize, other: usize) -> bool {
        match &self.functions {
            Functions::Mesh(shapes) => shapes.get(one) == shapes.get(other),
            Functions::Tensor(_) => true,
        }
    }

    /// The anchor of a function in `D` coordinates.
    #[inline(always)]
    pub fn coordinates<const D: usize>(&self, function: u32) -> [f64; D] {
        let mut x = [0.0; D];
        x.copy_from_slice(&self.positions[function as usize][..D]);
        x
    }

    /// Anchors of the functions of a cell.
    #[inline(always)]
    pub fn corners<const D: usize, const N: usize>(&self, cell: usize) -> [[f64; D]; N] {
        let mut corners = [[0.0; D]; N];
        for (corner, &node) in corners.iter_mut().zip(self.nodes_of(cell)) {
            corner.copy_from_slice(&self.positions[node as usize][..D]);
        }
        corners
    }

    /// Leaves points on faces, and those beyond by less than the tolerance of the search, where they are.
    #[must_use]
    pub fn without_inset(mut self) -> Self {
        self.inset = false;
        self
    }

    /// Local coordinates of a position in a cell, given those in the mesh's own cell.
    #[inline]
    pub fn local(&self, cell: usize, x: [f64; 3], of_mesh: [f64; 3]) -> [f64; 3] {
        match &self.functions {
            Functions::Mesh(shapes) if self.inset => shapes.get(cell).map_or(of_mesh, |shape| inside(*shape, of_mesh)),
            Functions::Mesh(_) => of_mesh,
            Functions::Tensor(tensor) => tensor.basis.local(cell, x),
        }
    }

    /// The functions of a cell at local coordinates, for set-up and conditions; `values` is cleared.
    pub fn evaluate(&self, cell: usize, xi: [f64; 3], values: &mut Vec<f64>) {
        match &self.functions {
            Functions::Mesh(shapes) => {
                values.clear();
                values.resize(shapes[cell].node_count(), 0.0);
                shapes[cell].functions(xi, values);
            }
            Functions::Tensor(tensor) => tensor.basis.evaluate(cell, xi, values),
        }
    }

    /// The functions of higher order at a position and the cell whose they are; none outside the grid,
    /// and for the mesh's own functions.
    pub fn evaluate_at(&self, x: [f64; 3], values: &mut Vec<f64>) -> Option<usize> {
        let Functions::Tensor(tensor) = &self.functions else { return None };
        let cell = tensor.basis.grid().cell_holding(x)?;
        tensor.basis.evaluate(cell, tensor.basis.local(cell, x), values);
        Some(cell)
    }

    /// Degree along each axis of the functions; 1 for those of the mesh.
    pub fn degree(&self) -> usize {
        match &self.functions {
            Functions::Mesh(_) => 1,
            Functions::Tensor(tensor) => tensor.basis.degree(),
        }
    }

    /// The dofs of the functions of these cells.
    pub fn active_dofs(&self, cells: &[u32], block: usize) -> ActiveDofs {
        let mut active = vec![false; self.len()];
        for &cell in cells {
            for &function in self.nodes_of(cell as usize) {
                active[function as usize] = true;
            }
        }
        ActiveDofs::new(block, &active)
    }

    /// Which components of each function are fixed, given those of the mesh's nodes: all nodes of the
    /// smallest vertex, edge, face or cell that holds its anchor are fixed.
    pub fn held<'a>(&self, fixed: &'a [[bool; 3]]) -> Cow<'a, [[bool; 3]]> {
        let Functions::Tensor(tensor) = &self.functions else { return fixed.into() };
        if fixed.is_empty() {
            return fixed.into();
        }
        let of_function = |function: usize| {
            let mut held = None;
            tensor.around(function, |node, _| {
                let so_far = held.unwrap_or([true; 3]);
                held = Some(std::array::from_fn(|a| so_far[a] && fixed[node][a]));
            });
            held.unwrap_or([false; 3])
        };
        let held: Vec<[bool; 3]> = (0..self.len()).map(of_function).collect();
        self.told.call_once(|| tensor.tell_loose(fixed, &held));
        held.into()
    }

    /// Values of a nodal field at the anchors of the functions.
    pub fn at_anchors<'a>(&self, values: &'a [[f64; 3]]) -> Cow<'a, [[f64; 3]]> {
        let Functions::Tensor(tensor) = &self.functions else { return values.into() };
        if values.is_empty() {
            return values.into();
        }
        let of_function = |function: usize| {
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            tensor.around(function, |node, weight| {
                (0..3).for_each(|a| sum[a] += weight * values[node][a]);
                weights += weight;
            });
            if weights > 0.0 { sum.map(|s| s / weights) } else { sum }
        };
        (0..self.len()).map(of_function).collect()
    }

    /// Writes a field over the active functions to a column of the grid: its values at the nodes.
    /// Nodes that the active functions do not span keep their values.
    pub fn write_field(&self, grid: &mut ModelPart, dofs: &ActiveDofs, variable: &Variable, values: &[f64]) {
        let Functions::Tensor(tensor) = &self.functions else {
            return crate::grid::write_nodal(grid, dofs, variable, values);
        };
        let (count, block) = (grid.nodes.len(), dofs.block());
        let column = grid.node_fields.vector_mut(variable, count);
        for (crossing, node) in tensor.crossings.iter().enumerate() {
            let Some(node) = node else { continue };
            let mut sum = Some([0.0; 3]);
            tensor.basis.at_crossing(crossing, |function, value| {
                sum = sum.zip(dofs.number(function)).map(|(mut sum, number)| {
                    (0..block).for_each(|a| sum[a] += value * values[number * block + a]);
                    sum
                });
            });
            if let Some(sum) = sum {
                column[*node as usize][..block].copy_from_slice(&sum[..block]);
            }
        }
    }

    /// Where sums over the active functions, such as mass or reaction, are shown on the mesh: visits
    /// (number of the function, node, share) for the nodes around each anchor; shares add up to 1.
    pub fn spread(&self, dofs: &ActiveDofs, mut visit: impl FnMut(usize, usize, f64)) {
        for (number, &function) in dofs.nodes().iter().enumerate() {
            match &self.functions {
                Functions::Mesh(_) => visit(number, function as usize, 1.0),
                Functions::Tensor(tensor) => {
                    tensor.around(function as usize, |node, weight| visit(number, node, weight));
                }
            }
        }
    }

    /// Name of a function for messages.
    pub fn describe(&self, grid: &ModelPart, function: u32) -> String {
        match &self.functions {
            Functions::Mesh(_) => format!("grid node {}", grid.nodes.ids[function as usize]),
            Functions::Tensor(_) => format!("grid function {function}"),
        }
    }

    /// One line on functions that are not the mesh's, for the inventory.
    pub fn summary(&self) -> Option<String> {
        let Functions::Tensor(tensor) = &self.functions else { return None };
        let (family, degree) = (tensor.basis.family(), tensor.basis.degree());
        let family = if family == Family::BSpline { "B-splines" } else { "Lagrange polynomials" };
        Some(format!("{} {family} of degree {degree}, {} in each cell", self.len(), tensor.basis.per_cell()))
    }
}

impl Tensor {
    /// Warns of fixed nodes where functions remain that are not: a spline of degree 2 or more
    /// interpolates at the ends of the grid only.
    fn tell_loose(&self, fixed: &[[bool; 3]], held: &[[bool; 3]]) {
        let counts = self.basis.grid().line_counts();
        let place = |crossing: usize| {
            [crossing % counts[0], crossing / counts[0] % counts[1], crossing / (counts[0] * counts[1])]
        };
        let mut loose = 0;
        // For each component, axis and line: nodes, fixed ones, loose ones.
        let mut planes: Vec<[usize; 3]> = vec![[0; 3]; 9 * counts.iter().max().copied().unwrap_or(0)];
        for (crossing, node) in self.crossings.iter().enumerate() {
            let Some(node) = node else { continue };
            let is_fixed = fixed[*node as usize];
            let mut is_held = [true; 3];
            self.basis.at_crossing(crossing, |function, _| {
                (0..3).for_each(|a| is_held[a] &= held[function as usize][a]);
            });
            for a in 0..3 {
                let is_loose = is_fixed[a] && !is_held[a];
                loose += usize::from(is_loose);
                for (axis, line) in place(crossing).into_iter().enumerate() {
                    let plane = &mut planes[(line * 3 + axis) * 3 + a];
                    let marks = [true, is_fixed[a], is_loose];
                    plane.iter_mut().zip(marks).for_each(|(count, mark)| *count += usize::from(mark));
                }
            }
        }
        if loose == 0 {
            return;
        }
        let mut inside = Vec::new();
        for axis in 0..self.dimension() {
            for line in 1..counts[axis] - 1 {
                let is_loose = |a: usize| {
                    let [nodes, fixed, loose] = planes[(line * 3 + axis) * 3 + a];
                    fixed == nodes && loose > 0
                };
                if (0..self.dimension()).any(is_loose) {
                    inside.push(format!("{} = {}", ["x", "y", "z"][axis], self.basis.grid().lines(axis)[line]));
                }
            }
        }
        let inside =
            if inside.is_empty() { String::new() } else { format!(", such as those at {}", inside.join(", ")) };
        tracing::warn!(
            "B-splines hold {loose} fixed components of grid nodes only roughly{inside}: they interpolate at whole \
             faces of the grid; let the grid end where it is fixed, or use basis \"lagrange\""
        );
    }
}

/// Local coordinates at least [`INSET`] within the reference cell, for points that stand within, on its faces
/// or a little outside.
#[inline]
fn inside(shape: Shape, mut xi: [f64; 3]) -> [f64; 3] {
    let used = &mut xi[..shape.dimension()];
    match shape {
        Shape::Triangle3 | Shape::Tetrahedron4 => {
            used.iter_mut().for_each(|v| *v = v.max(INSET));
            let sum: f64 = used.iter().sum();
            if sum > 1.0 - INSET {
                used.iter_mut().for_each(|v| *v *= (1.0 - INSET) / sum);
            }
        }
        _ => used.iter_mut().for_each(|v| *v = v.clamp(INSET - 1.0, 1.0 - INSET)),
    }
    xi
}

#[cfg(test)]
mod tests;
