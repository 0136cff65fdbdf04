//! Sums of nodal variables over a part: the resultant of reactions, say, and its moment.

use super::{Measurement, TABLE, TableOutput};
use crate::diagnostic::InputErrors;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::table::Heading;
use crate::model::{Members, Model};
use crate::parameters::{Key, Kind, Settings};
use crate::processes::quantity::Quantity;
use crate::processes::{Location, Requirements};
use crate::registry::{ProcessEntry, Registry};
use crate::variables::Rank;

const KEYS: &[Key] = &Key::join::<7, 3, 10>(
    TABLE,
    [
        Key::required("model_part_name", Kind::Text, "part whose nodes are summed over, such as Background_Grid.Clamp"),
        Key::required("output_variables", Kind::Texts, "variables of nodes, such as REACTION"),
        Key::optional(
            "moment_center",
            Kind::Vector3,
            "place about which vectors have moments, which are wanted then [m]",
        ),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "resultant_output_process",
        aliases: &[],
        application: None,
        keys: KEYS,
        help: "sums of nodal variables over a part, and moments of vectors, in time as a table",
        build: |building| {
            let quantities = Quantity::read_list(&building.settings, "output_variables", building.registry)?;
            let settings = building.settings.clone();
            let center = settings.get("moment_center").map(|_| settings.vector("moment_center"));
            let resultant = Resultant { settings, quantities, center, members: None };
            Ok(Box::new(TableOutput::new(&building, resultant)?))
        },
    });
}

struct Resultant {
    settings: Settings,
    quantities: Vec<Quantity>,
    center: Option<[f64; 3]>,
    members: Option<Members>,
}

impl Resultant {
    /// The vectors that have moments.
    fn turning(&self) -> impl Iterator<Item = &Quantity> {
        let whole = |quantity: &&Quantity| quantity.variable.rank == Rank::Vector && quantity.component.is_none();
        self.quantities.iter().filter(whole).filter(|_| self.center.is_some())
    }
}

impl Measurement for Resultant {
    fn name(&self) -> &'static str {
        "resultant"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        let path = self.settings.text("model_part_name");
        self.members = model.members(path).filter(|members| !members.nodes.is_empty());
        if self.members.is_some() {
            return Ok(());
        }
        let message = format!("there is no model part {path:?} with nodes");
        Err(model.suggest_part(self.settings.error("model_part_name", message), path).into())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, Location::Nodes, requirements);
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, model: &Model) -> Vec<Heading> {
        let Some(part) = self.members.as_ref().and_then(|members| model.part(&members.root)) else { return Vec::new() };
        let sums = self.quantities.iter().flat_map(|quantity| quantity.headings(quantity.width(&part.node_fields)));
        let moments = self.turning().flat_map(|quantity| {
            let unit = format!("{} m", quantity.variable.unit);
            ["X", "Y", "Z"].map(|axis| Heading::new(format!("MOMENT_OF_{}_{axis}", quantity.name), unit.clone()))
        });
        sums.chain(moments).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(members) = &self.members else { return };
        let Some(part) = model.part(&members.root) else { return };
        let mut values = Vec::new();
        for quantity in &self.quantities {
            let mut sums = vec![0.0; quantity.width(&part.node_fields)];
            for &node in &members.nodes {
                values.clear();
                quantity.append(&part.node_fields, node as usize, &mut values);
                sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
            }
            rows.extend(sums);
        }
        let center = self.center.unwrap_or_default();
        for quantity in self.turning() {
            let mut moment = [0.0; 3];
            for &node in &members.nodes {
                let x = part.nodes.coordinates[node as usize];
                let Some(f) = part.node_fields.vector(&quantity.variable).map(|column| column[node as usize]) else {
                    continue;
                };
                let r: [f64; 3] = std::array::from_fn(|a| x[a] - center[a]);
                (0..3).for_each(|a| moment[a] += r[(a + 1) % 3] * f[(a + 2) % 3] - r[(a + 2) % 3] * f[(a + 1) % 3]);
            }
            rows.extend(moment);
        }
    }
}
