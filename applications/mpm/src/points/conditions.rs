//! Conditions that move with the material: points on boundary lines or surfaces that carry a load.

use super::carriers::Carrier;
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::geometry::{CellLocator, Shape, rule};
use bia_kernel::model::{ModelPart, kratos_order};
use bia_kernel::parameters::Parameters;

/// The most points on one condition.
const MOST_POINTS: usize = 1000;

/// A process's wish that the conditions of a grid part become material-point conditions.
#[derive(Debug, Clone)]
pub struct Request {
    /// Part below the grid's root.
    pub part: String,
    /// Points on each condition; 0 counts as 1.
    pub count: usize,
    /// Evenly spaced with both ends instead of Gauss points; points that meet are merged.
    pub equally_distributed: bool,
    /// Held by the nearest material points instead of the cells they lie in.
    pub on_points: bool,
    /// Normals point the other way.
    pub flip_normal: bool,
    /// Who asks.
    pub place: Parameters,
}

/// All requests of a scene; kept in the model between the processes' and the solver's set-up.
#[derive(Debug, Clone, Default)]
pub struct Requests(pub Vec<Request>);

/// Material-point conditions as columns.
#[derive(Debug, Clone, Default)]
pub struct PointConditions {
    /// Ids of grid conditions that belong to the part of points.
    pub grid_ids: Vec<u32>,
    /// Indices of those grid conditions.
    pub grid: Vec<u32>,
    /// (part, first, end) of the points of each requested part.
    pub parts: Vec<(String, usize, usize)>,
    /// Ids.
    pub ids: Vec<u32>,
    /// Background cell.
    pub cell: Vec<u32>,
    /// Local coordinates there.
    pub local: Vec<[f64; 3]>,
    /// Position in m.
    pub position: Vec<[f64; 3]>,
    /// Displacement in m.
    pub displacement: Vec<[f64; 3]>,
    /// Velocity in m/s.
    pub velocity: Vec<[f64; 3]>,
    /// Length (plane) or area (space) that the point stands for; 1 for a point condition.
    pub area: Vec<f64>,
    /// Unit normal; zero for a point condition.
    pub normal: Vec<[f64; 3]>,
    /// Force in N.
    pub load: Vec<[f64; 3]>,
    /// The material point that carries a condition, if one does.
    pub carriers: Vec<Option<Carrier>>,
    /// Ranges of conditions that material points carry.
    pub on_points: Vec<(usize, usize)>,
}

impl PointConditions {
    /// Number of material-point conditions.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    fn push(&mut self, id: u32, position: [f64; 3], area: f64, normal: [f64; 3]) {
        self.ids.push(id);
        self.cell.push(0);
        self.local.push([0.0; 3]);
        self.position.push(position);
        self.displacement.push([0.0; 3]);
        self.velocity.push([0.0; 3]);
        self.area.push(area);
        self.normal.push(normal);
        self.load.push([0.0; 3]);
        self.carriers.push(None);
    }
}

/// Makes the conditions of the part of points: grid conditions as they are, requested parts as
/// points (spec 02 §4). `elements` counts grid and body elements and material points.
///
/// # Errors
/// A number of points that a shape does not have, points outside the grid.
pub fn generate(
    grid: &ModelPart,
    requests: &Requests,
    locator: &CellLocator,
    elements: usize,
) -> Result<PointConditions, InputErrors> {
    let mut made = PointConditions::default();
    let mut errors = InputErrors::default();
    let (nodes, conditions) = (grid.nodes.len(), grid.conditions.len());
    let mut next_id =
        if elements > nodes && elements > conditions { elements } else { nodes.max(conditions) } as u32 + 1;
    let names: Vec<&str> = grid.children.iter().map(|child| child.name.as_str()).collect();
    // A load that stands in two parts acts once.
    let mut taken = vec![false; conditions];
    for index in kratos_order(&names) {
        let part = &grid.children[index];
        match requests.0.iter().find(|request| request.part == part.name) {
            None => {
                for &condition in part.conditions.iter().filter(|c| is_load(grid.conditions.name_of(**c as usize))) {
                    if std::mem::replace(&mut taken[condition as usize], true) {
                        continue;
                    }
                    made.grid.push(condition);
                    made.grid_ids.push(grid.conditions.ids[condition as usize]);
                }
            }
            Some(request) => {
                let first = made.len();
                for &condition in &part.conditions {
                    errors.absorb(add(grid, condition as usize, request, &mut next_id, &mut made, first));
                }
                made.parts.push((part.name.clone(), first, made.len()));
                if request.on_points {
                    made.on_points.push((first, made.len()));
                }
            }
        }
    }
    let mut outside = Vec::new();
    for i in 0..made.len() {
        match locator.locate(made.position[i], None) {
            Some((cell, xi)) => (made.cell[i], made.local[i]) = (cell, xi),
            None => outside.push(made.position[i]),
        }
    }
    if let Some(first) = outside.first() {
        let message =
            format!("{} material-point conditions lie outside the grid, the first at {first:?}", outside.len());
        errors.push(Diagnostic::error(Default::default(), message));
    }
    made.grid_ids.sort_unstable();
    errors.or(made)
}

fn is_load(name: &str) -> bool {
    name.starts_with("MPMGrid")
}

fn add(
    grid: &ModelPart,
    condition: usize,
    request: &Request,
    next_id: &mut u32,
    made: &mut PointConditions,
    first: usize,
) -> Result<(), InputErrors> {
    let shape = grid.conditions.shapes[condition];
    let corners = grid.corners(&grid.conditions, condition);
    let flip = if request.flip_normal { -1.0 } else { 1.0 };
    let normal = normal(shape, &corners).map(|n| flip * n);
    if shape == Shape::Point1 {
        made.push(*next_id, corners[0], 1.0, [0.0; 3]);
        *next_id += 1;
        return Ok(());
    }
    if request.count > MOST_POINTS {
        let message = format!("material_points_per_condition is {}, must be at most {MOST_POINTS}", request.count);
        return Err(request.place.error(message).into());
    }
    let points = if shape == Shape::Line2 && request.equally_distributed {
        even_points(request.count)
    } else {
        let rule = rule(shape, request.count.max(1)).map_err(|error| request.place.error(error.to_string()))?;
        rule.iter().map(|point| (point.xi, point.weight)).collect()
    };
    let mut functions = vec![0.0; corners.len()];
    for (xi, weight) in points {
        shape.functions(xi, &mut functions);
        let x: [f64; 3] = std::array::from_fn(|i| functions.iter().zip(&corners).map(|(n, c)| n * c[i]).sum());
        let area = weight * shape.jacobian_determinant(&corners, xi);
        let twin = (first..made.len()).find(|&i| request.equally_distributed && same_place(made.position[i], x));
        match twin {
            Some(twin) => made.area[twin] += area,
            None => {
                made.push(*next_id, x, area, normal);
                *next_id += 1;
            }
        }
    }
    Ok(())
}

/// `count` + 2 points with both ends; weights sum to 2.
fn even_points(count: usize) -> Vec<([f64; 3], f64)> {
    let intervals = count + 1;
    (0..=intervals)
        .map(|i| {
            let share = if i == 0 || i == intervals { 0.5 } else { 1.0 };
            ([-1.0 + 2.0 * i as f64 / intervals as f64, 0.0, 0.0], share * 2.0 / intervals as f64)
        })
        .collect()
}

fn same_place(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-12 * (1.0 + a[i].abs()))
}

/// Unit normal: of a line from node 1 to node 2 the one to its right, of a face by the right hand.
fn normal(shape: Shape, corners: &[[f64; 3]]) -> [f64; 3] {
    let normal = shape.normal(corners, shape.center());
    let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    if shape == Shape::Point1 { normal } else { normal.map(|n| n / size) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_points_share_the_whole_length() {
        for count in 0..5 {
            let points = even_points(count);
            assert_eq!(points.len(), count + 2);
            assert!((points.iter().map(|p| p.1).sum::<f64>() - 2.0).abs() < 1e-14);
            assert_eq!((points[0].0[0], points[count + 1].0[0]), (-1.0, 1.0));
        }
    }

    #[test]
    fn normals_and_measures() {
        let line = [[0.0; 3], [2.0, 0.0, 0.0]];
        assert_eq!(normal(Shape::Line2, &line), [0.0, -1.0, 0.0]);
        assert!((Shape::Line2.jacobian_determinant(&line, [0.3, 0.0, 0.0]) - 1.0).abs() < 1e-15);
        let square = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(normal(Shape::Quadrilateral4, &square), [0.0, 0.0, 1.0]);
        assert!((Shape::Quadrilateral4.jacobian_determinant(&square, [0.1, 0.2, 0.0]) - 1.0).abs() < 1e-15);
    }
}
