//! Values of nodal variables at fixed places, Σ N_i(x) q_i, with the functions of the cell around each.

use super::{Measurement, TABLE, TableOutput};
use crate::diagnostic::InputErrors;
use crate::geometry::CellLocator;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::table::Heading;
use crate::model::{Model, ModelPart};
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use crate::processes::quantity::Quantity;
use crate::processes::{Location, Process, Requirements};
use crate::registry::{Building, ProcessEntry, Registry};
use crate::variables::Fields;

const SHARED: [Key; 13] = Key::join::<7, 6, 13>(
    TABLE,
    [
        Key::required("model_part_name", Kind::Text, "mesh, or a part of it, such as Background_Grid"),
        Key::new(
            "entity_type",
            Kind::Choice(&["element", "node"]),
            "\"element\"",
            "interpolated, or of the node there",
        ),
        Key::required("output_variables", Kind::Texts, "variables of nodes, such as PRESSURE or VELOCITY_X"),
        Key::new("search_tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-6", "local coordinates, or m to a node"),
        Key::new(
            "search_configuration",
            Kind::Choice(&["initial"]),
            "\"initial\"",
            "places are those of the mesh file",
        ),
        Key::optional("historical_value", Kind::Any, "accepted: a node has one value of a variable"),
    ],
);
const POINT: &[Key] =
    &Key::join::<13, 1, 14>(SHARED, [Key::required("position", Kind::Vector3, "place of the probe [m]")]);
const POINTS: &[Key] =
    &Key::join::<13, 1, 14>(SHARED, [Key::required("positions", Kind::List, "places of the probes [m]")]);
const LINE: &[Key] = &Key::join::<13, 3, 16>(
    SHARED,
    [
        Key::required("start_point", Kind::Vector3, "first place [m]"),
        Key::required("end_point", Kind::Vector3, "last place [m]"),
        Key::new("sampling_points", Kind::Integer { min: 2 }, "3", "places, both ends among them"),
    ],
);

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    let entry = |name, keys, help, build| ProcessEntry { name, aliases: &[], application: None, keys, help, build };
    registry.process(entry("point_output_process", POINT, "nodal variables at a place in time as a table", |b| {
        let place = b.settings.vector("position");
        build(b, "point", vec![place])
    }));
    let help = "nodal variables at places in time as a table";
    registry.process(entry("multiple_points_output_process", POINTS, help, |b| {
        let places = b.settings.get("positions").map_or(Ok(Vec::new()), positions)?;
        build(b, "points", places)
    }));
    let help = "nodal variables along a line in time as a table";
    registry.process(entry("line_output_process", LINE, help, |b| {
        let (start, end) = (b.settings.vector("start_point"), b.settings.vector("end_point"));
        let last = (b.settings.integer("sampling_points") - 1).max(1);
        let at = |i: i64| {
            let share = i as f64 / last as f64;
            std::array::from_fn(|a| (1.0 - share) * start[a] + share * end[a])
        };
        build(b, "line", (0..=last).map(at).collect())
    }));
}

/// The places of a list.
///
/// # Errors
/// Entries that are no three numbers.
pub fn positions(list: &Parameters) -> Result<Vec<[f64; 3]>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut places = Vec::new();
    for entry in list.entries() {
        let numbers = entry.value().as_array().map(|list| list.iter().map(serde_json::Value::as_f64).collect());
        match numbers.and_then(|numbers: Option<Vec<f64>>| <[f64; 3]>::try_from(numbers?).ok()) {
            Some(place) => places.push(place),
            None => errors.push(entry.error("must be a list of three numbers")),
        }
    }
    if places.is_empty() && errors.0.is_empty() {
        errors.push(list.error("names no place"));
    }
    errors.or(places)
}

fn build(building: Building, name: &'static str, places: Vec<[f64; 3]>) -> Result<Box<dyn Process>, InputErrors> {
    let quantities = Quantity::read_list(&building.settings, "output_variables", building.registry)?;
    let settings = building.settings.clone();
    let (shows_places, root) = (name != "point", String::new());
    let probe = Probe { name, shows_places, settings, quantities, places, root, shares: Vec::new() };
    Ok(Box::new(TableOutput::new(&building, probe)?))
}

/// The nodes of the cell around each place, with their functions there. The settings have
/// `model_part_name` and `search_tolerance`.
///
/// # Errors
/// Places outside of the elements.
pub fn shares_in_cells(
    part: &ModelPart,
    elements: &[u32],
    places: &[[f64; 3]],
    settings: &Settings,
) -> Result<Vec<Vec<(u32, f64)>>, InputErrors> {
    let locator = CellLocator::new(part, settings.number("search_tolerance"));
    let mut errors = InputErrors::default();
    let mut shares = Vec::new();
    for place in places {
        let found = locator.locate(*place, None).filter(|(cell, _)| elements.binary_search(cell).is_ok());
        let Some((cell, xi)) = found else {
            let path = settings.text("model_part_name");
            errors.push(settings.error("model_part_name", format!("no element of {path:?} holds {place:?}")));
            continue;
        };
        let mut functions = [0.0; 8];
        part.elements.shapes[cell as usize].functions(xi, &mut functions);
        shares.push(part.elements.nodes_of(cell as usize).iter().copied().zip(functions).collect());
    }
    errors.or(shares)
}

/// Nodal values at places; several of them are rows with their coordinates.
struct Probe {
    name: &'static str,
    shows_places: bool,
    settings: Settings,
    quantities: Vec<Quantity>,
    places: Vec<[f64; 3]>,
    root: String,
    /// Nodes and their functions for each place.
    shares: Vec<Vec<(u32, f64)>>,
}

impl Probe {
    fn at_node(&self, part: &ModelPart, nodes: &[u32]) -> Result<Vec<Vec<(u32, f64)>>, InputErrors> {
        let mut errors = InputErrors::default();
        let mut shares = Vec::new();
        for place in &self.places {
            let distance = |node: &u32| {
                let x = part.nodes.coordinates[*node as usize];
                (0..3).map(|a| (x[a] - place[a]).powi(2)).sum::<f64>().sqrt()
            };
            match nodes.iter().map(|node| (*node, distance(node))).min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((node, distance)) if distance <= self.settings.number("search_tolerance") => {
                    shares.push(vec![(node, 1.0)]);
                }
                Some((node, distance)) => {
                    let id = part.nodes.ids[node as usize];
                    let message = format!("no node is at {place:?}; the nearest, {id}, is {distance:e} m off");
                    errors.push(self.settings.error("search_tolerance", message));
                }
                None => errors.push(self.settings.error("model_part_name", "has no nodes")),
            }
        }
        errors.or(shares)
    }

    fn fields<'a>(&self, model: &'a Model) -> Option<&'a Fields> {
        model.part(&self.root).map(|part| &part.node_fields)
    }
}

impl Measurement for Probe {
    fn name(&self) -> &'static str {
        self.name
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        let path = self.settings.text("model_part_name");
        let found = model.members(path).and_then(|members| Some((model.part(&members.root)?, members)));
        let Some((part, members)) = found else {
            let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
            return Err(model.suggest_part(diagnostic, path).into());
        };
        let of_nodes = self.settings.text("entity_type") == "node";
        let shares = match of_nodes {
            true => self.at_node(part, &members.nodes),
            false => shares_in_cells(part, &members.elements, &self.places, &self.settings),
        };
        (self.shares, self.root) = (shares?, members.root);
        Ok(())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, Location::Nodes, requirements);
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, model: &Model) -> Vec<Heading> {
        let mut headings = Vec::new();
        if self.shows_places {
            headings.extend(["X", "Y", "Z"].map(|axis| Heading::new(axis, "m")));
        }
        if let Some(fields) = self.fields(model) {
            headings.extend(self.quantities.iter().flat_map(|quantity| quantity.headings(quantity.width(fields))));
        }
        headings
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(fields) = self.fields(model) else { return };
        let mut values = Vec::new();
        for (place, shares) in self.places.iter().zip(&self.shares) {
            if self.shows_places {
                rows.extend(place);
            }
            for quantity in &self.quantities {
                let mut sums = vec![0.0; quantity.width(fields)];
                for &(node, share) in shares {
                    values.clear();
                    quantity.append(fields, node as usize, &mut values);
                    sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += share * value);
                }
                rows.extend(sums);
            }
        }
    }
}
