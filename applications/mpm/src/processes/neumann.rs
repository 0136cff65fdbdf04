//! Loads on material-point conditions that move with the body (spec 07 §2).

use crate::grid::GRID;
use crate::points::MaterialPoints;
use crate::points::conditions::{Request, Requests};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::{Context, Interval, Process, SpaceTimeValue, not_finite};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of grid conditions, such as Background_Grid.Tip"),
    Key::new("material_points_per_condition", Kind::Integer { min: 0 }, "0", "points on each condition, 0 counts as 1")
        .or(&["particles_per_condition"]),
    Key::new(
        "variable_name",
        Kind::Choice(&["POINT_LOAD", "LINE_LOAD", "SURFACE_LOAD"]),
        "\"POINT_LOAD\"",
        "force [N], force per length [N/m] or per area [N/m²]",
    ),
    Key::new("modulus", Kind::Function, "1.0", "size of the load"),
    Key::new("constrained", Kind::Choice(&["fixed", "normal"]), "\"fixed\"", "fixed direction, or along the normal"),
    Key::new("direction", Kind::Functions3, "[0.0, 0.0, 0.0]", "direction, used as given"),
    Key::new("interval", Kind::Interval, "[0.0, 1e30]", "when it acts [s]"),
    Key::new("option", Kind::Choice(&["", "flip_normal"]), "\"\"", "flip_normal turns the normals round"),
    Key::new("is_equal_distributed", Kind::Bool, "false", "evenly spaced points with both ends of a line"),
    Key::new(
        "carrier",
        Kind::Choice(&["grid", "points"]),
        "\"grid\"",
        "what moves and bears the load: the cell it lies in, or that of the material point nearest at the start",
    ),
    Key::optional("local_axes", Kind::Any, "accepted"),
];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "apply_mpm_particle_neumann_condition_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "loads on conditions that move with the material",
        build,
    });
}

struct Neumann {
    settings: Settings,
    part: String,
    modulus: SpaceTimeValue,
    direction: [SpaceTimeValue; 3],
    interval: Interval,
    along_normal: bool,
    per_area: bool,
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings;
    let mut errors = InputErrors::default();
    let modulus = settings.get("modulus").and_then(|value| errors.absorb(SpaceTimeValue::read(value)));
    let direction = settings.get("direction").and_then(|value| errors.absorb(SpaceTimeValue::read3(value)));
    let (Some(modulus), Some(direction)) = (modulus, direction) else {
        return Err(errors);
    };
    let path = settings.text("model_part_name");
    let part = path.strip_prefix(&format!("{GRID}.")).unwrap_or(path).to_string();
    errors.or(Box::new(Neumann {
        part,
        modulus,
        direction: direction.map(|d| d.unwrap_or_else(|| SpaceTimeValue::constant(0.0))),
        interval: Interval(settings.interval("interval")),
        along_normal: settings.text("constrained") == "normal",
        per_area: settings.text("variable_name") != "POINT_LOAD",
        settings,
    }))
}

impl Process for Neumann {
    fn name(&self) -> &str {
        "apply_mpm_particle_neumann_condition"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let path = format!("{GRID}.{}", self.part);
        let found = model.members(&path).filter(|members| !members.conditions.is_empty());
        if found.is_none() || self.part.contains('.') {
            let message = format!("{path:?} is no first-level part of the grid with conditions");
            let diagnostic = self.settings.error("model_part_name", message);
            return Err(model.suggest_part(diagnostic, &path).into());
        }
        let request = Request {
            part: self.part.clone(),
            count: self.settings.integer("material_points_per_condition") as usize,
            equally_distributed: self.settings.flag("is_equal_distributed"),
            on_points: self.settings.text("carrier") == "points",
            flip_normal: self.settings.text("option") == "flip_normal",
            place: self.settings.parameters().clone(),
        };
        if model.extension::<Requests>().is_none() {
            model.extend(Requests::default());
        }
        if let Some(requests) = model.extension_mut::<Requests>() {
            if let Some(other) = requests.0.iter().find(|other| other.part == self.part) {
                let message = format!("the part {:?} has a load already, at {}", self.part, other.place.place());
                let help = "one process gives the load of a part; a function of t may change it in time";
                return Err(self.settings.error("model_part_name", message).help(help).into());
            }
            requests.0.push(request);
        }
        Ok(())
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.execute_initialize_solution_step(context)
    }

    fn execute_initialize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        let time = context.clock.load_time;
        let active = self.interval.contains(context.clock.time);
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        let conditions = &mut points.conditions;
        let Some(&(_, first, end)) = conditions.parts.iter().find(|(part, _, _)| *part == self.part) else {
            return Ok(());
        };
        for i in first..end {
            let x = conditions.position[i];
            let start = std::array::from_fn(|a| x[a] - conditions.displacement[i][a]);
            let mut size = if active { self.modulus.at(x, start, time) } else { 0.0 };
            if self.per_area {
                size *= conditions.area[i];
            }
            conditions.load[i] = match self.along_normal {
                true => conditions.normal[i].map(|n| size * n),
                false => std::array::from_fn(|a| size * self.direction[a].at(x, start, time)),
            };
            if let Some(load) = conditions.load[i].iter().find(|load| !load.is_finite()) {
                let entity = format!("material-point condition {}", conditions.ids[i]);
                let variable = self.settings.text("variable_name");
                return Err(not_finite(self.name(), variable, *load).at(entity, x).into());
            }
        }
        Ok(())
    }
}
