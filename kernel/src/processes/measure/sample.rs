//! Where a field is compared: at all points or nodes of a part, or at places.

use crate::diagnostic::InputErrors;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::model::{Model, ModelPart, PointHandle, PointSet};
use crate::modelers::{BOX, corners};
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use crate::processes::measure::positions;
use crate::processes::measure::probe::shares_in_cells;
use crate::processes::quantity::{Quantity, tensor_components};
use crate::processes::{Location, Requirements, Wanted};
use crate::reference::{Compared, Place};
use crate::registry::Building;
use crate::variables::{Rank, Variable};

/// Keys of those who read samples.
pub const SOURCE: [Key; 4] = [
    Key::required("model_part_name", Kind::Text, "part of points or nodes, such as MPM_Material or Structure"),
    Key::new(
        "on",
        Kind::Any,
        "\"points\"",
        "\"points\", \"nodes\", or {\"positions\": [places], \"of\": either}, or {\"box\": …}",
    ),
    Key::optional("weight_variable", Kind::Text, "nodes: scalar that weighs them instead of volume: NODAL_MASS"),
    Key::new("search_tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-6", "of places in local coordinates"),
];

const PLACES: &[Key] = &[
    Key::optional("positions", Kind::List, "places at the start [m]: the nearest points, or interpolated from nodes"),
    Key::optional("box", Kind::Object(BOX), "instead: all points or nodes that are in it at the start"),
    Key::new("of", Kind::Choice(&["points", "nodes"]), "\"nodes\"", "which of them"),
];

/// The present values.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Numbers of each value.
    pub width: usize,
    /// Where each is compared, with its weight.
    pub places: Vec<(Place, f64)>,
    /// The values, one after the other.
    pub values: Vec<f64>,
}

/// What is compared.
enum Kinds {
    /// All points of the part that were in the region at the start.
    Points(Region),
    /// These points, by id, found at the first look; and the places that they are nearest to.
    NearPoints { ids: Vec<u32>, places: Vec<[f64; 3]> },
    /// Nodes in a region with their weights.
    Nodes { region: Region, weights: Vec<(u32, f64)> },
    /// Places with the nodes around and their functions.
    Places { places: Vec<[f64; 3]>, shares: Vec<Vec<(u32, f64)>> },
}

/// A box, or everywhere.
#[derive(Debug, Clone, Copy, Default)]
struct Region(Option<([f64; 3], [f64; 3])>);

impl Region {
    /// Round-off of its size is within it.
    fn holds(&self, x: [f64; 3]) -> bool {
        self.0.is_none_or(|(low, high)| {
            let margin = 1e-9 * (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
            (0..3).all(|a| (low[a] - margin..=high[a] + margin).contains(&x[a]))
        })
    }
}

/// Reads the samples out of the model.
pub struct Source {
    settings: Settings,
    kind: Kinds,
    /// Scalar that weighs nodes.
    weight: Option<Variable>,
    /// Root part of nodes.
    root: String,
}

impl Source {
    /// From `on`, `model_part_name` and `weight_variable`.
    ///
    /// # Errors
    /// A value that is none of these, an unknown variable.
    pub fn read(building: &Building) -> Result<Self, InputErrors> {
        let settings = building.settings.clone();
        let mut errors = InputErrors::default();
        let kind = settings.get("on").and_then(|on| errors.absorb(read_kind(on)));
        let weight = match settings.given("weight_variable") {
            true => errors.absorb(building.registry.variable_of(&settings, "weight_variable", Rank::Scalar)),
            false => None,
        };
        if weight.is_some() && !matches!(kind, Some(Kinds::Nodes { .. }) | None) {
            errors.push(settings.error("weight_variable", "weighs nodes, and here are none").help("\"on\": \"nodes\""));
        }
        match kind {
            Some(kind) => {
                errors.or(Self { settings, kind, weight: weight.map(|(variable, _)| variable), root: String::new() })
            }
            None => Err(errors),
        }
    }

    /// True at places, which have no volume.
    pub fn is_probe(&self) -> bool {
        matches!(self.kind, Kinds::Places { .. } | Kinds::NearPoints { .. })
    }

    fn is_of_points(&self) -> bool {
        matches!(self.kind, Kinds::Points(_) | Kinds::NearPoints { .. })
    }

    /// Resolves the part of nodes.
    ///
    /// # Errors
    /// There is no such part, places outside of it.
    pub fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        if self.is_of_points() {
            return Ok(());
        }
        let path = self.settings.text("model_part_name");
        let found = model.members(path).and_then(|members| Some((model.part(&members.root)?, members)));
        let Some((part, members)) = found else {
            let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
            return Err(model.suggest_part(diagnostic, path).into());
        };
        match &mut self.kind {
            Kinds::Nodes { region, weights } => {
                *weights = match self.weight {
                    Some(_) => members.nodes.iter().map(|node| (*node, 1.0)).collect(),
                    None => volumes(part, &members.elements, &members.nodes),
                };
                weights.retain(|(node, _)| region.holds(part.nodes.coordinates[*node as usize]));
            }
            Kinds::Places { places, shares } => {
                *shares = shares_in_cells(part, &members.elements, places, &self.settings)?;
            }
            Kinds::Points(_) | Kinds::NearPoints { .. } => {}
        }
        self.root = members.root;
        Ok(())
    }

    /// Names the variables that are read.
    pub fn require(&self, variable: &str, place: &Parameters, requirements: &mut Requirements) {
        let location = if self.is_of_points() { Location::Points } else { Location::Nodes };
        requirements.initial_positions |= self.is_of_points();
        let weight = self.weight.iter().map(|weight| weight.name);
        for name in std::iter::once(variable).chain(weight) {
            requirements.variables.push(Wanted { location, variable: name.into(), place: place.clone() });
        }
    }

    /// Finds the points that are nearest to the places, once the points are there.
    ///
    /// # Errors
    /// No solver has points, or none of this part.
    pub fn find_points(&mut self, model: &Model) -> Result<(), InputErrors> {
        if !self.is_of_points() {
            return Ok(());
        }
        let path = self.settings.text("model_part_name");
        let Some(points) = model.points() else {
            let message = "the solver of this project has no points";
            return Err(self.settings.error("on", message).help("\"on\": \"nodes\"").into());
        };
        let Some(selected) = points.select(model, path).filter(|selected| !selected.is_empty()) else {
            let diagnostic = self.settings.error("model_part_name", format!("there are no points in {path:?}"));
            return Err(model.suggest_part(diagnostic, path).into());
        };
        if let Kinds::NearPoints { ids, places } = &mut self.kind {
            *ids = places.iter().map(|place| nearest(points, &selected, *place)).collect();
        }
        Ok(())
    }

    /// Saves or loads which points were found.
    ///
    /// # Errors
    /// The checkpoint does not fit.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        match &mut self.kind {
            Kinds::NearPoints { ids, .. } => {
                let mut numbers: Vec<u64> = ids.iter().map(|id| u64::from(*id)).collect();
                archive.column("points", &mut numbers)?;
                *ids = numbers.into_iter().filter_map(|id| u32::try_from(id).ok()).collect();
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Reads all samples.
    pub fn sample(&self, model: &Model, compared: &Compared, samples: &mut Samples) {
        (samples.width, samples.places, samples.values) = (0, Vec::new(), Vec::new());
        match &self.kind {
            Kinds::Points(_) | Kinds::NearPoints { .. } => self.sample_points(model, compared, samples),
            Kinds::Nodes { weights, .. } => self.sample_nodes(model, weights, compared, samples),
            Kinds::Places { places, shares } => self.sample_places(model, places, shares, compared, samples),
        }
    }

    fn sample_points(&self, model: &Model, compared: &Compared, samples: &mut Samples) {
        let Some(points) = model.points() else { return };
        let selected = points.select(model, self.settings.text("model_part_name")).unwrap_or_default();
        let mut take = |point: PointHandle, weight: Option<f64>| {
            let first = samples.values.len();
            points.append(point, &compared.variable, &mut samples.values);
            keep_component(compared, first, &mut samples.values);
            samples.width = samples.values.len() - first;
            let place = points.place(point);
            let at = Place { position: place.position, initial: place.initial, time: 0.0 };
            samples.places.push((at, weight.unwrap_or(place.volume)));
        };
        let ids = match &self.kind {
            Kinds::NearPoints { ids, .. } => ids,
            Kinds::Points(region) => {
                let inside = selected.into_iter().filter(|point| region.holds(points.place(*point).initial));
                return inside.for_each(|point| take(point, None));
            }
            Kinds::Nodes { .. } | Kinds::Places { .. } => return,
        };
        let mut lost = 0;
        for id in ids {
            match selected.iter().find(|point| points.place(**point).id == *id) {
                Some(point) => take(*point, Some(1.0)),
                None => lost += 1,
            }
        }
        // A point that was lost is an error that no norm forgets.
        samples.width = samples.width.max(compared.width().unwrap_or(1));
        samples.places.extend((0..lost).map(|_| (Place::default(), 1.0)));
        samples.values.extend((0..lost * samples.width).map(|_| f64::NAN));
    }

    fn sample_nodes(&self, model: &Model, weights: &[(u32, f64)], compared: &Compared, samples: &mut Samples) {
        let Some(part) = model.part(&self.root) else { return };
        let quantity = self.quantity(compared);
        let column = self.weight.and_then(|weight| part.node_fields.scalar(&weight));
        for (node, weight) in weights {
            let first = samples.values.len();
            quantity.append(&part.node_fields, *node as usize, &mut samples.values);
            keep_component(compared, first, &mut samples.values);
            samples.width = samples.values.len() - first;
            let weight = match (self.weight, column) {
                (Some(_), column) => column.map_or(0.0, |column| column[*node as usize]),
                (None, _) => *weight,
            };
            samples.places.push((at_node(part.nodes.coordinates[*node as usize]), weight));
        }
    }

    fn sample_places(
        &self,
        model: &Model,
        places: &[[f64; 3]],
        shares: &[Vec<(u32, f64)>],
        compared: &Compared,
        samples: &mut Samples,
    ) {
        let Some(part) = model.part(&self.root) else { return };
        let quantity = self.quantity(compared);
        let mut values = Vec::new();
        for (place, shares) in places.iter().zip(shares) {
            let first = samples.values.len();
            for (node, share) in shares {
                values.clear();
                quantity.append(&part.node_fields, *node as usize, &mut values);
                keep_component(compared, 0, &mut values);
                samples.values.resize(first + values.len(), 0.0);
                samples.values[first..].iter_mut().zip(&values).for_each(|(sum, value)| *sum += share * value);
            }
            samples.width = samples.values.len() - first;
            samples.places.push((at_node(*place), 1.0));
        }
    }

    fn quantity(&self, compared: &Compared) -> Quantity {
        let place = self.settings.parameters().clone();
        Quantity { name: compared.variable.name.into(), variable: compared.variable, component: None, place }
    }
}

fn read_kind(on: &Parameters) -> Result<Kinds, InputErrors> {
    match on.value().as_str() {
        Some("points") => return Ok(Kinds::Points(Region::default())),
        Some("nodes") => return Ok(Kinds::Nodes { region: Region::default(), weights: Vec::new() }),
        Some(other) => {
            let message = format!("{other:?} is no place of values");
            return Err(on.error(message).allowed(other, ["points", "nodes"]).into());
        }
        None => {}
    }
    let settings = on.read(PLACES)?;
    let of_points = settings.text("of") == "points";
    match (settings.get("positions"), settings.nested("box")) {
        (Some(places), None) => {
            let places = positions(places)?;
            Ok(match of_points {
                true => Kinds::NearPoints { ids: Vec::new(), places },
                false => Kinds::Places { places, shares: Vec::new() },
            })
        }
        (None, Some(nested)) => {
            let region = Region(Some(corners(nested)?));
            Ok(match of_points {
                true => Kinds::Points(region),
                false => Kinds::Nodes { region, weights: Vec::new() },
            })
        }
        _ => Err(on.error("takes either \"positions\" or \"box\"").into()),
    }
}

/// Nodes of meshes stay where they are.
fn at_node(x: [f64; 3]) -> Place {
    Place { position: x, initial: x, time: 0.0 }
}

/// The id of the point that is nearest to a place, the smallest of several; the list is not empty.
fn nearest(points: &dyn PointSet, selected: &[PointHandle], place: [f64; 3]) -> u32 {
    let distance = |x: [f64; 3]| (0..3).map(|a| (x[a] - place[a]).powi(2)).sum::<f64>();
    let all = selected.iter().map(|point| points.place(*point)).map(|at| (distance(at.position), at.id));
    all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map_or(u32::MAX, |(_, id)| id)
}

/// Leaves only the compared component of the numbers from `first` on.
fn keep_component(compared: &Compared, first: usize, values: &mut Vec<f64>) {
    let Some(component) = &compared.component else { return };
    let width = values.len() - first;
    let index = match compared.variable.rank {
        Rank::Scalar => None,
        Rank::Vector => compared.axis(),
        Rank::Voigt | Rank::Tensor => tensor_components(width).iter().position(|name| name == component),
    };
    match index.filter(|index| *index < width) {
        Some(index) => {
            values.swap(first, first + index);
            values.truncate(first + 1);
        }
        None => values.truncate(first),
    }
}

/// Each node's share of the volume (area, length) of the elements: that of a cell is spread evenly.
fn volumes(part: &ModelPart, elements: &[u32], nodes: &[u32]) -> Vec<(u32, f64)> {
    let mut sums = vec![0.0; part.nodes.len()];
    for &element in elements {
        let corners = part.corners(&part.elements, element as usize);
        let size = part.elements.shapes[element as usize].measure(&corners).abs();
        for node in part.elements.nodes_of(element as usize) {
            sums[*node as usize] += size / corners.len() as f64;
        }
    }
    nodes.iter().map(|node| (*node, sums[*node as usize])).collect()
}
