//! Values of material points and their conditions in time as JSON (spec 07 §8).

use super::acceleration::check_path;
use crate::grid::GRID;
use crate::points::MaterialPoints;
use crate::points::fields::{append, append_condition};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::history::Lookup;
use bia_kernel::model::Model;
use bia_kernel::parameters::Settings;
use bia_kernel::processes::Location;
use bia_kernel::processes::json::{Entity, EntitySource, JsonCheck, JsonOutput, READING, WRITING, part_path};
use bia_kernel::processes::quantity::Quantity;
use bia_kernel::registry::{ProcessEntry, Registry};

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_json_output_process",
        aliases: &["particle_json_output_process"],
        application: Some("MPMApplication"),
        keys: WRITING,
        help: "values of material points or their conditions in time as JSON",
        build: |building| {
            let source = PointSource::new(&building.settings);
            let lists = ["gauss_points_output_variables", "output_variables"];
            Ok(Box::new(JsonOutput::new("mpm_json_output", &building, source, lists)?))
        },
    });
    registry.process(ProcessEntry {
        name: "mpm_from_json_check_result_process",
        aliases: &["particle_from_json_check_result_process"],
        application: Some("MPMApplication"),
        keys: READING,
        help: "compares values of material points in time with a JSON file; the run fails where they differ",
        build: |building| {
            let source = PointSource::new(&building.settings);
            Ok(Box::new(JsonCheck::new("mpm_from_json_check_result", &building, source, Lookup::Nearest)?))
        },
    });
}

/// Points of a body or of all bodies, or the material-point conditions of a part.
struct PointSource {
    settings: Settings,
    path: String,
    conditions: bool,
}

impl PointSource {
    fn new(settings: &Settings) -> Self {
        let conditions = settings.text("entity_type") == "Condition";
        Self { settings: settings.clone(), path: part_path(settings), conditions }
    }

    /// The part of conditions that is meant; none for all.
    fn condition_part<'a>(&'a self, points: &str) -> Option<&'a str> {
        match self.path.split_once('.') {
            Some((root, below)) if root == GRID || root == points => Some(below),
            None if self.path == GRID || self.path == points => None,
            _ => Some(&self.path),
        }
    }

    fn visit_points(
        &self,
        points: &MaterialPoints,
        quantities: &[Quantity],
        visit: &mut dyn FnMut(Entity, &[f64]),
    ) -> Result<(), Error> {
        let Some(selection) = points.select(&self.path) else { return Ok(()) };
        let mut values = Vec::new();
        for (block, point) in points.by_id(selection) {
            let block = &points.blocks[block as usize];
            values.clear();
            for quantity in quantities {
                let first = values.len();
                append(block, point as usize, quantity.variable.name, &mut values);
                keep_component(&mut values, first, quantity.component);
            }
            let id = block.ids[point as usize];
            visit(Entity { key: &format!("MP_{id}"), kind: "material point", id }, &values);
        }
        Ok(())
    }

    fn visit_conditions(
        &self,
        points: &MaterialPoints,
        quantities: &[Quantity],
        visit: &mut dyn FnMut(Entity, &[f64]),
    ) -> Result<(), Error> {
        let conditions = &points.conditions;
        let wanted = self.condition_part(&points.name);
        let (first, end) = match wanted {
            None => (0, conditions.len()),
            Some(name) => match conditions.parts.iter().find(|(part, _, _)| part == name) {
                Some((_, first, end)) => (*first, *end),
                None => {
                    let message = format!("the part {name:?} has no material-point conditions");
                    let names = conditions.parts.iter().map(|(part, _, _)| part.as_str());
                    return Err(self.settings.error("model_part_name", message).allowed(name, names).into());
                }
            },
        };
        let mut values = Vec::new();
        for index in first..end {
            values.clear();
            for quantity in quantities {
                let first = values.len();
                append_condition(conditions, index, quantity.variable.name, &mut values);
                keep_component(&mut values, first, quantity.component);
            }
            let id = conditions.ids[index];
            visit(Entity { key: &format!("MP_{id}"), kind: "material-point condition", id }, &values);
        }
        Ok(())
    }
}

/// Leaves of the row that begins at `first` only the component that is meant, if only one is.
fn keep_component(values: &mut Vec<f64>, first: usize, component: Option<usize>) {
    if let Some(component) = component {
        values.drain(first..first + component);
        values.truncate(first + 1);
    }
}

impl EntitySource for PointSource {
    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        if !self.conditions {
            return check_path(model, &self.settings, &self.path);
        }
        let below = self.path.split_once('.').map_or(self.path.as_str(), |(_, below)| below);
        let known = self.path == below || model.part(GRID).is_none_or(|grid| grid.find(below).is_some());
        if known {
            return Ok(());
        }
        let diagnostic = self.settings.error("model_part_name", format!("the grid has no part {below:?}"));
        Err(model.suggest_part(diagnostic, &self.path).into())
    }

    fn location(&self) -> Location {
        if self.conditions { Location::PointConditions } else { Location::Points }
    }

    fn tensor_length(&self, model: &Model) -> usize {
        model.extension::<MaterialPoints>().map_or(0, |points| points.kinematics.voigt().len())
    }

    fn visit(
        &self,
        model: &Model,
        quantities: &[Quantity],
        visit: &mut dyn FnMut(Entity, &[f64]),
    ) -> Result<(), Error> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Ok(()) };
        if self.conditions {
            self.visit_conditions(points, quantities, visit)
        } else {
            self.visit_points(points, quantities, visit)
        }
    }
}
