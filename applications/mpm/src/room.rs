//! Room of the grid's nodes, and whether material has more volume than there is where it lies.

use crate::grid::GRID;
use crate::points::MaterialPoints;
use crate::scene::points_of;
use bia_constitutive::Kinematics;
use bia_kernel::geometry::{CellLocator, Shape, ShapeTable, rule};
use bia_kernel::model::{Model, ModelPart};

/// Share of the volume without room that is told: where points lie irregularly in full cells it is up to half of that.
const CROWDED: f64 = 0.1;

/// Room R_i = ∫ N_i dx of each of the grid's nodes (m³, in the plane m², on a line m).
pub fn room(grid: &ModelPart) -> Vec<f64> {
    let mut room = vec![0.0; grid.nodes.len()];
    for cell in 0..grid.elements.len() {
        let (shape, corners) = (grid.elements.shapes[cell], grid.corners(&grid.elements, cell));
        let count = match shape {
            Shape::Quadrilateral4 => 4,
            Shape::Hexahedron8 => 8,
            _ => 1,
        };
        for point in rule(shape, count).unwrap_or_default() {
            let table = ShapeTable::new(shape, point.xi);
            let weight = point.weight * table.jacobian_determinant(&corners).abs();
            let mut functions = [0.0; 8];
            shape.functions(point.xi, &mut functions);
            for (&node, n) in grid.elements.nodes_of(cell).iter().zip(functions) {
                room[node as usize] += weight * n;
            }
        }
    }
    room
}

/// The share of the points' volume that has no room where it is, on any mesh (the process's `overfill` is that of
/// blocks of whole cells): Σ max(0, V_i − R_i)/Σ V_p with
/// V_i = Σ N_i V_p at the nodes.
fn without_room(grid: &ModelPart, points: &MaterialPoints, locator: &CellLocator) -> f64 {
    let mut filled = vec![0.0; grid.nodes.len()];
    let mut total = 0.0;
    for block in &points.blocks {
        for point in block.in_order_of_id() {
            let point = point as usize;
            let Some((cell, xi)) = locator.locate(block.coordinates(point), Some(block.cell[point])) else { continue };
            let first = block.mass.row(point)[0] / (block.density * block.extent);
            let volume = first * block.deformation_gradient(point).determinant();
            let mut functions = [0.0; 8];
            grid.elements.shapes[cell as usize].functions(xi, &mut functions);
            for (&node, n) in grid.elements.nodes_of(cell as usize).iter().zip(functions) {
                filled[node as usize] += n * volume;
            }
            total += volume;
        }
    }
    let excess: f64 = filled.iter().zip(room(grid)).map(|(filled, room)| (filled - room).max(0.0)).sum();
    excess / total
}

/// That bodies lie in each other, as where a fluid has sunk into itself.
pub fn crowding(model: &Model, locator: Option<&CellLocator>) -> Option<String> {
    let (grid, points) = (model.part(GRID)?, points_of(model)?);
    if points.kinematics == Kinematics::Axisymmetric || points.is_empty() {
        return None;
    }
    let share = without_room(grid, points, locator?);
    (share > CROWDED).then(|| {
        format!(
            "{:.0} % of the volume of the material has no room where it lies: points have gathered, as in a fluid that \
             sinks into itself (a smaller time step, less FLIP, or \"volume_correction\" keeps them apart), or each \
             has been stretched over more than its cell (finer points, or the total frame)",
            100.0 * share
        )
    })
}
