//! Values of nodes.

use super::{Entity, EntitySource, JsonCheck, JsonOutput, READING, WRITING, part_path};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::history::Lookup;
use crate::model::{Members, Model};
use crate::parameters::Settings;
use crate::processes::Location;
use crate::processes::quantity::Quantity;
use crate::registry::{ProcessEntry, Registry};

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "json_output_process",
        aliases: &[],
        application: None,
        keys: WRITING,
        help: "values of nodes in time as JSON",
        build: |building| {
            let source = NodeSource::new(&building.settings);
            let lists = ["output_variables", "gauss_points_output_variables"];
            Ok(Box::new(JsonOutput::new("json_output", &building, source, lists)?))
        },
    });
    registry.process(ProcessEntry {
        name: "from_json_check_result_process",
        aliases: &[],
        application: None,
        keys: READING,
        help: "compares values of nodes in time with a JSON file; the run fails where they differ",
        build: |building| {
            let source = NodeSource::new(&building.settings);
            Ok(Box::new(JsonCheck::new("from_json_check_result", &building, source, Lookup::Linear)?))
        },
    });
}

/// Nodes of a model part.
struct NodeSource {
    settings: Settings,
    by_coordinates: bool,
    members: Option<Members>,
}

impl NodeSource {
    fn new(settings: &Settings) -> Self {
        Self { settings: settings.clone(), by_coordinates: settings.flag("use_node_coordinates"), members: None }
    }
}

impl EntitySource for NodeSource {
    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        let path = part_path(&self.settings);
        self.members = model.members(&path);
        if self.members.is_some() {
            return Ok(());
        }
        let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
        Err(model.suggest_part(diagnostic, &path).into())
    }

    fn location(&self) -> Location {
        Location::Nodes
    }

    fn tensor_length(&self, model: &Model) -> usize {
        let part = self.members.as_ref().and_then(|members| model.part(&members.root));
        part.map_or(0, |part| part.node_fields.symmetric_width())
    }

    fn visit(
        &self,
        model: &Model,
        quantities: &[Quantity],
        visit: &mut dyn FnMut(Entity, &[f64]),
    ) -> Result<(), Error> {
        let Some(members) = &self.members else { return Ok(()) };
        let Some(part) = model.part(&members.root) else { return Ok(()) };
        let mut values = Vec::new();
        for &node in &members.nodes {
            let (id, [x, y, z]) = (part.nodes.ids[node as usize], part.nodes.coordinates[node as usize]);
            values.clear();
            for quantity in quantities {
                quantity.append(&part.node_fields, node as usize, &mut values);
            }
            let key =
                if self.by_coordinates { format!("NODE_X_{x:.6}_Y_{y:.6}_Z_{z:.6}") } else { format!("NODE_{id}") };
            visit(Entity { key: &key, kind: "node", id }, &values);
        }
        Ok(())
    }
}
