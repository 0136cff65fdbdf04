//! How much of a nodal field changes sign from node to node: the share of a checkerboard in a pressure,
//! say.
//!
//! For a node and two neighbours on opposite sides of it, d = (q₋ − 2 q + q₊)/4 is the second difference;
//! the number is the root mean square of d over all such pairs, divided by the standard deviation of q. It
//! is 1 for a checkerboard on quadrilaterals, and falls with the square of the cell size for smooth fields.

use super::{Measurement, TABLE, TableOutput};
use crate::diagnostic::InputErrors;
use crate::geometry::Shape;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::table::Heading;
use crate::model::{Members, Model, ModelPart};
use crate::parameters::{Key, Kind, Settings};
use crate::processes::quantity::Quantity;
use crate::processes::{Location, Requirements, Wanted};
use crate::registry::{ProcessEntry, Registry};
use crate::variables::{Rank, Variable};
use std::collections::BTreeSet;

const KEYS: &[Key] = &Key::join::<7, 3, 10>(
    TABLE,
    [
        Key::required("model_part_name", Kind::Text, "mesh, or a part of it, such as Background_Grid"),
        Key::required("output_variables", Kind::Texts, "scalars or components of nodes, such as PRESSURE"),
        Key::new("mask_variable", Kind::Text, "\"\"", "only nodes where this scalar is above 0 count, NODAL_MASS say"),
    ],
);

/// Cosine of the largest angle between the directions to neighbours on opposite sides: 120 degrees.
const OPPOSITE: f64 = -0.5;

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "oscillation_output_process",
        aliases: &[],
        application: None,
        keys: KEYS,
        help: "share of a checkerboard in nodal variables, in time as a table",
        build: |building| {
            let settings = building.settings.clone();
            let mut errors = InputErrors::default();
            let quantities = Quantity::read_list(&settings, "output_variables", building.registry)?;
            for quantity in quantities.iter().filter(|q| q.variable.rank != Rank::Scalar && q.component.is_none()) {
                errors.push(quantity.place.error(format!("{:?} is no scalar: name a component", quantity.name)));
            }
            let mut mask = None;
            if !settings.text("mask_variable").is_empty() {
                let found = building.registry.variable_of(&settings, "mask_variable", Rank::Scalar);
                mask = errors.absorb(found).map(|(variable, _)| variable);
            }
            let lines = Vec::new();
            let oscillation = Oscillation { settings, quantities, mask, members: None, lines };
            let table = errors.absorb(TableOutput::new(&building, oscillation));
            match table {
                Some(table) => errors.or(Box::new(table)),
                None => Err(errors),
            }
        },
    });
}

struct Oscillation {
    settings: Settings,
    quantities: Vec<Quantity>,
    mask: Option<Variable>,
    members: Option<Members>,
    /// A neighbour, the node, and the neighbour on its other side.
    lines: Vec<[u32; 3]>,
}

/// Pairs of nodes that share an edge, both ways, ascending.
fn edges(part: &ModelPart, elements: &[u32]) -> BTreeSet<(u32, u32)> {
    let mut edges = BTreeSet::new();
    for &element in elements {
        let nodes = part.elements.nodes_of(element as usize);
        let pairs: &[[usize; 2]] = match part.elements.shapes[element as usize] {
            Shape::Point1 => &[],
            Shape::Line2 => &[[0, 1]],
            Shape::Triangle3 => &[[0, 1], [1, 2], [2, 0]],
            Shape::Quadrilateral4 => &[[0, 1], [1, 2], [2, 3], [3, 0]],
            Shape::Tetrahedron4 => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
            Shape::Hexahedron8 => {
                &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
            }
        };
        for &[a, b] in pairs {
            edges.extend([(nodes[a], nodes[b]), (nodes[b], nodes[a])]);
        }
    }
    edges
}

/// The pairs of neighbours of each node that are each other's most opposite ones.
fn lines(part: &ModelPart, elements: &[u32]) -> Vec<[u32; 3]> {
    let edges: Vec<(u32, u32)> = edges(part, elements).into_iter().collect();
    let mut lines = Vec::new();
    for around in edges.chunk_by(|a, b| a.0 == b.0) {
        let node = around[0].0;
        let origin = part.nodes.coordinates[node as usize];
        let directions: Vec<[f64; 3]> = around
            .iter()
            .map(|(_, other)| {
                let x = part.nodes.coordinates[*other as usize];
                let d: [f64; 3] = std::array::from_fn(|a| x[a] - origin[a]);
                let size = d.iter().map(|d| d * d).sum::<f64>().sqrt();
                d.map(|d| d / size)
            })
            .collect();
        let cosine = |i: usize, j: usize| (0..3).map(|a| directions[i][a] * directions[j][a]).sum::<f64>();
        let partner = |i: usize| {
            let others = (0..around.len()).filter(|&j| j != i);
            others.min_by(|&j, &k| cosine(i, j).total_cmp(&cosine(i, k))).filter(|&j| cosine(i, j) < OPPOSITE)
        };
        for i in 0..around.len() {
            if let Some(j) = partner(i).filter(|&j| i < j && partner(j) == Some(i)) {
                lines.push([around[i].1, node, around[j].1]);
            }
        }
    }
    lines
}

impl Measurement for Oscillation {
    fn name(&self) -> &'static str {
        "oscillation"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        let path = self.settings.text("model_part_name");
        let found = model.members(path).and_then(|members| Some((model.part(&members.root)?, members)));
        let Some((part, members)) = found else {
            let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
            return Err(model.suggest_part(diagnostic, path).into());
        };
        self.lines = lines(part, &members.elements);
        if self.lines.is_empty() {
            let message = format!("{path:?} has no node with neighbours on opposite sides");
            return Err(self.settings.error("model_part_name", message).into());
        }
        self.members = Some(members);
        Ok(())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, Location::Nodes, requirements);
        if let Some(mask) = &self.mask {
            let (variable, place) = (mask.name.into(), self.settings.parameters().clone());
            requirements.variables.push(Wanted { location: Location::Nodes, variable, place });
        }
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, _: &Model) -> Vec<Heading> {
        self.quantities.iter().map(|quantity| Heading::new(format!("OSCILLATION_OF_{}", quantity.name), "1")).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(members) = &self.members else { return };
        let Some(part) = model.part(&members.root) else { return };
        let mask = self.mask.map(|mask| part.node_fields.scalar(&mask).unwrap_or_default());
        let counts = |node: u32| mask.is_none_or(|mask| mask.get(node as usize).is_some_and(|value| *value > 0.0));
        for quantity in &self.quantities {
            let mut column = Vec::with_capacity(part.nodes.len());
            (0..part.nodes.len()).for_each(|node| quantity.append(&part.node_fields, node, &mut column));
            let at = |node: u32| column[node as usize];
            let counted = || members.nodes.iter().filter(|&&node| counts(node));
            let mean = mean_of(counted().map(|&node| at(node)));
            let variance = mean_of(counted().map(|&node| (at(node) - mean).powi(2)));
            let whole = self.lines.iter().filter(|line| line.iter().all(|&node| counts(node)));
            let square = mean_of(whole.map(|&[a, node, b]| (0.25 * (at(a) - 2.0 * at(node) + at(b))).powi(2)));
            // A constant field does not oscillate.
            rows.push(if square == 0.0 { 0.0 } else { (square / variance).sqrt() });
        }
    }
}

fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { f64::NAN } else { sum / count as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n × n squares, sheared, each cut in two if wanted.
    fn mesh(n: u32, triangles: bool) -> ModelPart {
        let mut part = ModelPart::new("Mesh");
        for j in 0..=n {
            for i in 0..=n {
                part.nodes.ids.push(j * (n + 1) + i + 1);
                part.nodes.coordinates.push([f64::from(i) + 0.3 * f64::from(j), f64::from(j), 0.0]);
            }
        }
        for cell in 0..n * n {
            let a = cell / n * (n + 1) + cell % n;
            let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
            if triangles {
                part.elements.push(2 * cell + 1, "Triangle", Shape::Triangle3, 0, &[a, b, c]);
                part.elements.push(2 * cell + 2, "Triangle", Shape::Triangle3, 0, &[a, c, d]);
            } else {
                part.elements.push(cell + 1, "Square", Shape::Quadrilateral4, 0, &[a, b, c, d]);
            }
        }
        part
    }

    /// Each row and column of n + 1 nodes has n − 1 lines, and so have the diagonals of triangles inside.
    #[test]
    fn lines_are_those_of_the_mesh() {
        let all = |part: &ModelPart| lines(part, &(0..part.elements.len() as u32).collect::<Vec<_>>());
        let squares = all(&mesh(4, false));
        assert_eq!(squares.len(), 2 * 5 * 3);
        for [a, node, b] in squares {
            assert_eq!(a + b, 2 * node, "the node is in the middle");
        }
        let halves = all(&mesh(4, true));
        assert_eq!(halves.len(), 2 * 5 * 3 + 3 * 3);
        assert!(halves.iter().all(|[a, node, b]| a + b == 2 * node));
    }
}
