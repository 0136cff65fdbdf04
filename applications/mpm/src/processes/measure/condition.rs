//! Values of single material-point conditions, such as the corner of a loaded side, named by the places
//! that they are nearest to at the start.

use crate::points::MaterialPoints;
use crate::points::conditions::PointConditions;
use crate::points::fields::append_condition;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::table::Heading;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::measure::{Measurement, TABLE, TableOutput, positions};
use bia_kernel::processes::quantity::Quantity;
use bia_kernel::processes::{Location, Process, Requirements};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &Key::join::<7, 2, 9>(
    TABLE,
    [
        Key::required("output_variables", Kind::Texts, "variables of conditions, such as MPC_DISPLACEMENT"),
        Key::required("positions", Kind::List, "places [m]: the conditions that are nearest to them at the start"),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_condition_output_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "values of single material-point conditions in time as a table",
        build,
    });
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings.clone();
    let mut errors = InputErrors::default();
    let quantities = errors.absorb(Quantity::read_list(&settings, "output_variables", building.registry));
    let places = settings.get("positions").and_then(|list| errors.absorb(positions(list)));
    let (quantities, places) = (quantities.unwrap_or_default(), places.unwrap_or_default());
    let probe = errors.or(ConditionProbe { settings, quantities, places, ids: Vec::new() })?;
    Ok(Box::new(TableOutput::new(&building, probe)?))
}

struct ConditionProbe {
    settings: Settings,
    quantities: Vec<Quantity>,
    places: Vec<[f64; 3]>,
    ids: Vec<u32>,
}

/// The id of the condition that is nearest to a place, the first of several.
fn nearest(conditions: &PointConditions, place: [f64; 3]) -> Option<u32> {
    let distance = |x: &[f64; 3]| (0..3).map(|a| (x[a] - place[a]).powi(2)).sum::<f64>();
    let all = conditions.position.iter().map(distance).zip(&conditions.ids);
    all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(b.1))).map(|(_, id)| *id)
}

impl Measurement for ConditionProbe {
    fn name(&self) -> &'static str {
        "conditions"
    }

    fn connect(&mut self, _: &Model) -> Result<(), InputErrors> {
        Ok(())
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Ok(()) };
        self.ids = self.places.iter().filter_map(|place| nearest(&points.conditions, *place)).collect();
        if self.ids.len() == self.places.len() {
            return Ok(());
        }
        let help = "apply_mpm_particle_neumann_condition_process makes them";
        Err(self.settings.error("positions", "there are no material-point conditions").help(help).into())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, Location::PointConditions, requirements);
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, _: &Model) -> Vec<Heading> {
        // All are scalars and vectors.
        let values = self.quantities.iter().flat_map(|quantity| quantity.headings(3));
        std::iter::once(Heading::new("ID", "1")).chain(values).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(points) = model.extension::<MaterialPoints>() else { return };
        for id in &self.ids {
            rows.push(f64::from(*id));
            // No condition is ever taken away.
            let Some(index) = points.conditions.ids.iter().position(|other| other == id) else { continue };
            for quantity in &self.quantities {
                let first = rows.len();
                append_condition(&points.conditions, index, quantity.variable.name, rows);
                if let Some(component) = quantity.component {
                    rows.drain(first..first + component);
                    rows.truncate(first + 1);
                }
            }
        }
    }
}
