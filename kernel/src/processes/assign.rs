//! Kratos's core assign and fix processes: values on nodes or conditions, constant or functions.

use super::{Clock, Context, Interval, Process, SpaceTimeValue, not_finite};
use crate::diagnostic::InputErrors;
use crate::error::{Error, Failure};
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::model::{Members, Model, ModelPart};
use crate::parameters::{Key, Kind, Settings};
use crate::registry::{Building, ProcessEntry, Registry};
use crate::variables::{Rank, Variable};

const PART: Key = Key::required("model_part_name", Kind::Text, "model part it acts on, such as Background_Grid.Floor");
const VARIABLE: Key = Key::required("variable_name", Kind::Text, "variable to assign, such as DISPLACEMENT");
const INTERVAL: Key = Key::new("interval", Kind::Interval, "[0.0, \"End\"]", "when it acts [s]");
const AXES: Key = Key::new("local_axes", Kind::Object(&[]), "{}", "no local axes are supported");
const HELP: Key = Key::optional("help", Kind::Text, "ignored");
const MESH: Key = Key::optional("mesh_id", Kind::Any, "ignored");

const VECTOR: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    AXES,
    HELP,
    MESH,
    Key::new("constrained", Kind::Bools3, "[true, true, true]", "components that become fixed"),
    Key::new("value", Kind::Functions3, "[0.0, 0.0, 0.0]", "value per component, null leaves it alone")
        .or(&["direction"]),
];
const BY_DIRECTION: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    AXES,
    HELP,
    MESH,
    Key::new("constrained", Kind::Bools3, "true", "whether the components become fixed"),
    Key::new("modulus", Kind::Function, "1.0", "size of the vector"),
    Key::new("direction", Kind::Any, "[1.0, 0.0, 0.0]", "direction, made a unit vector"),
];
const CONDITION_BY_DIRECTION: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    AXES,
    HELP,
    MESH,
    Key::new("modulus", Kind::Function, "1.0", "size of the vector"),
    Key::new("direction", Kind::Any, "[1.0, 0.0, 0.0]", "direction, made a unit vector"),
];
const SCALAR: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    AXES,
    HELP,
    MESH,
    Key::new("constrained", Kind::Bool, "true", "whether it becomes fixed"),
    Key::new("value", Kind::Function, "0.0", "the value"),
];
const FIX_VECTOR: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    HELP,
    MESH,
    Key::new("constrained", Kind::Bools3, "[true, true, true]", "components that become fixed"),
];
const FIX_SCALAR: &[Key] =
    &[PART, VARIABLE, INTERVAL, HELP, MESH, Key::new("constrained", Kind::Bool, "true", "whether it becomes fixed")];
const CONDITION_SCALAR: &[Key] =
    &[PART, VARIABLE, INTERVAL, AXES, HELP, MESH, Key::new("value", Kind::Function, "0.0", "the value")];
const CONDITION_VECTOR: &[Key] = &[
    PART,
    VARIABLE,
    INTERVAL,
    AXES,
    HELP,
    MESH,
    Key::new("value", Kind::Functions3, "[0.0, 0.0, 0.0]", "value per component, null leaves it alone"),
];

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    let entry = |name, keys, help, build| ProcessEntry { name, aliases: &[], application: None, keys, help, build };
    registry.process(ProcessEntry {
        aliases: &["apply_constant_vectorvalue_process"],
        ..entry("assign_vector_variable_process", VECTOR, "assigns and fixes a vector on nodes", |b| {
            vector(b, Target::Nodes)
        })
    });
    registry.process(entry("fix_vector_variable_process", FIX_VECTOR, "fixes a vector on nodes as it is", fix_vector));
    registry.process(entry("fix_scalar_variable_process", FIX_SCALAR, "fixes a scalar on nodes as it is", fix_scalar));
    registry.process(entry(
        "assign_vector_by_direction_process",
        BY_DIRECTION,
        "assigns modulus times direction on nodes",
        |b| by_direction(b, Target::Nodes),
    ));
    registry.process(ProcessEntry {
        aliases: &["apply_constant_scalarvalue_process"],
        ..entry("assign_scalar_variable_process", SCALAR, "assigns and fixes a scalar on nodes", |b| {
            scalar(b, Target::Nodes)
        })
    });
    registry.process(ProcessEntry {
        aliases: &["assign_vector_by_direction_to_conditions_process"],
        ..entry(
            "assign_vector_by_direction_to_condition_process",
            CONDITION_BY_DIRECTION,
            "assigns modulus times direction on conditions",
            |b| by_direction(b, Target::Conditions),
        )
    });
    registry.process(ProcessEntry {
        aliases: &["assign_scalar_variable_to_condition_process"],
        ..entry(
            "assign_scalar_variable_to_conditions_process",
            CONDITION_SCALAR,
            "assigns a scalar on conditions",
            |b| scalar(b, Target::Conditions),
        )
    });
    registry.process(ProcessEntry {
        aliases: &["assign_vector_variable_to_condition_process"],
        ..entry(
            "assign_vector_variable_to_conditions_process",
            CONDITION_VECTOR,
            "assigns a vector on conditions",
            |b| vector(b, Target::Conditions),
        )
    });
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    Nodes,
    Conditions,
}

/// Assigns or fixes up to three components of a variable, or both, while its interval lasts.
struct Assign {
    name: &'static str,
    settings: Settings,
    target: Target,
    variable: Variable,
    values: [Option<SpaceTimeValue>; 3],
    fixes: [bool; 3],
    interval: Interval,
    members: Option<Members>,
    active: bool,
}

fn vector(building: Building, target: Target) -> Result<Box<dyn Process>, InputErrors> {
    let mut errors = InputErrors::default();
    let settings = building.settings;
    let variable = errors.absorb(building.registry.variable_of(&settings, "variable_name", Rank::Vector));
    let values = match settings.get("value") {
        Some(value) => errors.absorb(SpaceTimeValue::read3(value)),
        None => None,
    };
    let fixes = if target == Target::Nodes { settings.flags("constrained") } else { [false; 3] };
    match (variable, values) {
        (Some((variable, _)), Some(values)) => {
            if values.iter().all(Option::is_none) {
                let help = "null leaves a component alone: give at least one a value, or remove the process";
                errors.push(
                    settings.error("value", "is null for every component, so this process does nothing").help(help),
                );
            }
            // A component whose value is null is left alone, as in Kratos.
            let fixes = std::array::from_fn(|i| fixes[i] && values[i].is_some());
            errors.or(assign("assign_vector_variable", settings, target, variable, values, fixes))
        }
        _ => Err(errors),
    }
}

fn by_direction(building: Building, target: Target) -> Result<Box<dyn Process>, InputErrors> {
    let mut errors = InputErrors::default();
    let settings = building.settings;
    let variable = errors.absorb(building.registry.variable_of(&settings, "variable_name", Rank::Vector));
    let direction = errors.absorb(unit_direction(&settings));
    let modulus = settings.get("modulus").and_then(|modulus| errors.absorb(SpaceTimeValue::read(modulus)));
    let fixes = if target == Target::Nodes { settings.flags("constrained") } else { [false; 3] };
    match (variable, direction, modulus) {
        (Some((variable, _)), Some(direction), Some(modulus)) => {
            let values = direction.map(|d| Some(modulus.times(d)));
            errors.or(assign("assign_vector_by_direction", settings, target, variable, values, fixes))
        }
        _ => Err(errors),
    }
}

fn scalar(building: Building, target: Target) -> Result<Box<dyn Process>, InputErrors> {
    let mut errors = InputErrors::default();
    let settings = building.settings;
    let variable = errors.absorb(building.registry.variable_of(&settings, "variable_name", Rank::Scalar));
    let value = settings.get("value").and_then(|value| errors.absorb(SpaceTimeValue::read(value)));
    let fixed = target == Target::Nodes && settings.flag("constrained");
    match (variable, value) {
        (Some((variable, component)), Some(value)) => {
            let component = component.unwrap_or(0);
            let mut values = [None, None, None];
            values[component] = Some(value);
            let fixes = std::array::from_fn(|i| fixed && i == component);
            errors.or(assign("assign_scalar_variable", settings, target, variable, values, fixes))
        }
        _ => Err(errors),
    }
}

fn fix_vector(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings;
    let (variable, _) = building.registry.variable_of(&settings, "variable_name", Rank::Vector)?;
    let fixes = settings.flags("constrained");
    Ok(assign("fix_vector_variable", settings, Target::Nodes, variable, [None, None, None], fixes))
}

fn fix_scalar(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings;
    let (variable, component) = building.registry.variable_of(&settings, "variable_name", Rank::Scalar)?;
    let fixes = std::array::from_fn(|i| settings.flag("constrained") && i == component.unwrap_or(0));
    Ok(assign("fix_scalar_variable", settings, Target::Nodes, variable, [None, None, None], fixes))
}

fn assign(
    name: &'static str,
    settings: Settings,
    target: Target,
    variable: Variable,
    values: [Option<SpaceTimeValue>; 3],
    fixes: [bool; 3],
) -> Box<dyn Process> {
    let interval = Interval(settings.interval("interval"));
    Box::new(Assign { name, settings, target, variable, values, fixes, interval, members: None, active: false })
}

/// The direction as a unit vector.
fn unit_direction(settings: &Settings) -> Result<[f64; 3], InputErrors> {
    let list = settings.get("direction").map(|d| d.value().clone()).unwrap_or_default();
    let given: Option<Vec<f64>> = list.as_array().and_then(|l| l.iter().map(serde_json::Value::as_f64).collect());
    match given.as_deref() {
        Some(&[x, y, z]) if x * x + y * y + z * z > 0.0 => {
            let size = (x * x + y * y + z * z).sqrt();
            Ok([x / size, y / size, z / size])
        }
        Some([_, _, _]) => Err(settings.error("direction", "is the zero vector, which has no direction").into()),
        _ => Err(settings.error("direction", "must be a list of three numbers").into()),
    }
}

impl Assign {
    fn apply(&self, model: &mut Model, clock: &Clock) -> Result<(), Failure> {
        let Some(members) = &self.members else { return Ok(()) };
        let Some(part) = model.part_mut(&members.root) else { return Ok(()) };
        let (chosen, time) = match self.target {
            Target::Nodes => (&members.nodes, clock.time),
            Target::Conditions => (&members.conditions, clock.load_time),
        };
        for &index in chosen {
            let position = self.position(part, index);
            for (component, value) in self.values.iter().enumerate() {
                if let Some(value) = value {
                    let value = value.at(position, position, time);
                    if !value.is_finite() {
                        return Err(self.failure(part, index as usize, component, value, position));
                    }
                    self.store(part, index as usize, component, value);
                }
            }
        }
        self.fix(part, chosen, true);
        Ok(())
    }

    /// Who would get which value that is not finite, and from which function.
    fn failure(&self, part: &ModelPart, index: usize, component: usize, value: f64, position: [f64; 3]) -> Failure {
        let name = match self.variable.rank {
            Rank::Vector => format!("{}_{}", self.variable.name, ["X", "Y", "Z"][component]),
            _ => self.variable.name.to_string(),
        };
        let entity = match self.target {
            Target::Nodes => format!("node {}", part.nodes.ids[index]),
            Target::Conditions => format!("condition {}", part.conditions.ids[index]),
        };
        let function = ["value", "modulus"].iter().find_map(|key| self.settings.get(key));
        let failure = not_finite(self.name, &name, value).at(entity, position);
        match function {
            Some(function) => failure.detail(format!("{}: {}", function.place(), function.value())),
            None => failure,
        }
    }

    /// A node's coordinates, or the mean of a condition's nodes.
    fn position(&self, part: &ModelPart, index: u32) -> [f64; 3] {
        match self.target {
            Target::Nodes => part.nodes.coordinates[index as usize],
            Target::Conditions => {
                let nodes = part.conditions.nodes_of(index as usize);
                let sum = |i: usize| nodes.iter().map(|&n| part.nodes.coordinates[n as usize][i]).sum::<f64>();
                std::array::from_fn(|i| sum(i) / nodes.len() as f64)
            }
        }
    }

    fn store(&self, part: &mut ModelPart, index: usize, component: usize, value: f64) {
        let (fields, count) = match self.target {
            Target::Nodes => (&mut part.node_fields, part.nodes.len()),
            Target::Conditions => (&mut part.condition_fields, part.conditions.len()),
        };
        match self.variable.rank {
            Rank::Vector => fields.vector_mut(&self.variable, count)[index][component] = value,
            _ => fields.scalar_mut(&self.variable, count)[index] = value,
        }
    }

    fn fix(&self, part: &mut ModelPart, chosen: &[u32], state: bool) {
        if self.target == Target::Conditions || self.fixes == [false; 3] {
            return;
        }
        let count = part.nodes.len();
        let fixed = part.node_fields.fixed_mut(&self.variable, count);
        for &index in chosen {
            for component in 0..3 {
                if self.fixes[component] {
                    fixed[index as usize][component] = state;
                }
            }
        }
    }
}

impl Assign {
    fn release(&self, model: &mut Model) {
        if self.target == Target::Nodes
            && let Some(members) = &self.members
            && let Some(part) = model.part_mut(&members.root)
        {
            self.fix(part, &members.nodes, false);
        }
    }
}

impl Process for Assign {
    fn name(&self) -> &str {
        self.name
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let path = self.settings.text("model_part_name");
        let Some(members) = model.members(path) else {
            let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
            return Err(model.suggest_part(diagnostic, path).into());
        };
        let empty = match self.target {
            Target::Nodes => members.nodes.is_empty(),
            Target::Conditions => members.conditions.is_empty(),
        };
        if empty {
            let what = if self.target == Target::Nodes { "nodes" } else { "conditions" };
            let message = format!("the model part {path:?} has no {what}, so this process would do nothing");
            return Err(self.settings.error("model_part_name", message).into());
        }
        self.members = Some(members);
        Ok(())
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.execute_initialize_solution_step(context)
    }

    fn execute_initialize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        self.active = self.interval.contains(context.clock.time);
        if self.active {
            self.apply(context.model, context.clock)?;
        }
        Ok(())
    }

    fn execute_between_pieces(&mut self, context: &mut Context) -> Result<(), Error> {
        self.execute_finalize_solution_step(context)
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        // Fixity ends with the step, so that a process whose interval is over holds nothing.
        if self.active {
            self.release(context.model);
        }
        Ok(())
    }
}
