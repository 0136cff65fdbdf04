//! Values of single material points, named by their ids or by the places that they are nearest to at
//! the start.

use crate::points::MaterialPoints;
use crate::points::fields::append;
use crate::processes::acceleration::check_part;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::table::Heading;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::measure::{Measurement, TABLE, TableOutput, positions};
use bia_kernel::processes::quantity::Quantity;
use bia_kernel::processes::{Location, Process, Requirements};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &Key::join::<7, 4, 11>(
    TABLE,
    [
        Key::new("model_part_name", Kind::Text, "\"MPM_Material\"", "part of points, such as MPM_Material.Body"),
        Key::required("output_variables", Kind::Texts, "variables of points, such as MP_DISPLACEMENT"),
        Key::optional("material_point_ids", Kind::List, "ids of the points"),
        Key::optional("positions", Kind::List, "places [m]: the points that are nearest to them at the start"),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_point_output_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "values of single material points in time as a table",
        build,
    });
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings.clone();
    let mut errors = InputErrors::default();
    let quantities = errors.absorb(Quantity::read_list(&settings, "output_variables", building.registry));
    let mut ids = Vec::new();
    for entry in settings.get("material_point_ids").map_or(Vec::new(), |list| list.entries()) {
        match entry.value().as_u64().and_then(|id| u32::try_from(id).ok()) {
            Some(id) => ids.push(id),
            None => errors.push(entry.error("must be the id of a material point")),
        }
    }
    let places = settings.get("positions").and_then(|list| errors.absorb(positions(list))).unwrap_or_default();
    if settings.given("material_point_ids") == settings.given("positions") {
        let message = "needs either \"material_point_ids\" or \"positions\"";
        errors.push(settings.parameters().error(message));
    }
    let quantities = errors.or(quantities)?.unwrap_or_default();
    let found = Vec::new();
    Ok(Box::new(TableOutput::new(&building, PointProbe { settings, quantities, ids, places, found })?))
}

struct PointProbe {
    settings: Settings,
    quantities: Vec<Quantity>,
    /// Ids of the points, those of places too once the points are there.
    ids: Vec<u32>,
    places: Vec<[f64; 3]>,
    /// Where each point stood last: block and index.
    found: Vec<(usize, usize)>,
}

impl PointProbe {
    /// The id of the selected point that is nearest to a place, the smallest of several.
    fn nearest(&self, points: &MaterialPoints, place: [f64; 3]) -> Option<u32> {
        let selection = points.select(self.settings.text("model_part_name"))?;
        let blocks = points.blocks.iter().filter(|block| selection.holds(block.body));
        let all =
            blocks.flat_map(|block| (0..block.len()).map(move |point| (block.ids[point], block.coordinates(point))));
        let distance = |x: [f64; 3]| (0..3).map(|a| (x[a] - place[a]).powi(2)).sum::<f64>();
        let nearest = all.map(|(id, x)| (distance(x), id)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        nearest.map(|(_, id)| id)
    }

    /// Block and index of a point; looked for only where it does not stand any more.
    fn locate(&mut self, points: &MaterialPoints, which: usize) -> Option<(usize, usize)> {
        let (id, last) = (self.ids[which], self.found[which]);
        let stands = |(b, p): (usize, usize)| points.blocks.get(b).and_then(|block| block.ids.get(p)) == Some(&id);
        if !stands(last) {
            let mut blocks = points.blocks.iter().enumerate();
            let place = blocks.find_map(|(b, block)| Some((b, block.ids.iter().position(|other| *other == id)?)));
            self.found[which] = place?;
        }
        Some(self.found[which])
    }

    fn widths(&self, points: &MaterialPoints) -> Vec<usize> {
        let mut values = Vec::new();
        let first = points.blocks.iter().find(|block| !block.is_empty());
        let width = |quantity: &Quantity| {
            values.clear();
            first.map_or(0, |block| {
                append(block, 0, quantity.variable.name, &mut values);
                if quantity.component.is_some() { 1 } else { values.len() }
            })
        };
        self.quantities.iter().map(width).collect()
    }
}

impl Measurement for PointProbe {
    fn name(&self) -> &'static str {
        "material_points"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Ok(()) };
        let nearest: Vec<u32> = self.places.iter().filter_map(|place| self.nearest(points, *place)).collect();
        self.ids.extend(nearest);
        self.found = vec![(usize::MAX, 0); self.ids.len()];
        let mut errors = InputErrors::default();
        for which in 0..self.ids.len() {
            if self.locate(points, which).is_none() {
                let message = format!("there is no material point {}", self.ids[which]);
                errors.push(self.settings.error("material_point_ids", message));
            }
        }
        errors.or(())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, Location::Points, requirements);
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, model: &Model) -> Vec<Heading> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Vec::new() };
        let both = self.quantities.iter().zip(self.widths(points));
        let values = both.flat_map(|(quantity, width)| quantity.headings(width));
        std::iter::once(Heading::new("ID", "1")).chain(values).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(points) = model.extension::<MaterialPoints>() else { return };
        let widths = self.widths(points);
        for which in 0..self.ids.len() {
            rows.push(f64::from(self.ids[which]));
            let place = self.locate(points, which);
            for (quantity, width) in self.quantities.iter().zip(&widths) {
                let first = rows.len();
                let Some((block, point)) = place else {
                    // It has left the grid.
                    rows.extend(std::iter::repeat_n(f64::NAN, *width));
                    continue;
                };
                append(&points.blocks[block], point, quantity.variable.name, rows);
                if let Some(component) = quantity.component {
                    rows.drain(first..first + component);
                    rows.truncate(first + 1);
                }
            }
        }
    }
}
