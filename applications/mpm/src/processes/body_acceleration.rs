//! Body acceleration and initial velocity of material points as functions of place and time.
//!
//! Bia's own: Kratos knows one constant vector a body for each ([`super::acceleration`]).

use super::acceleration::check_part;
use crate::points::fields::BODY_ACCELERATION;
use crate::points::{Block, MaterialPoints};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::{Context, Interval, Location, Process, Requirements, SpaceTimeValue, Wanted};
use bia_kernel::registry::{Building, ProcessEntry, Registry};
use rayon::prelude::*;

const PART: Key =
    Key::required("model_part_name", Kind::Text, "part of points, such as MPM_Material or Initial_MPM_Material.Body");
const ACCELERATION: &[Key] = &[
    PART,
    Key::new(
        "value",
        Kind::Functions3,
        "[0.0, 0.0, 0.0]",
        "body force per mass beside gravity [m/s²]; x, y, z are the position at the start of the step, X, Y, Z the \
         initial one, t the time at which the forces of the step act: its end if implicit or if the stress is updated \
         first, its start if last, its middle in schemes that keep energy",
    ),
    Key::new("interval", Kind::Interval, "[0.0, \"End\"]", "when it acts [s]"),
];
const VELOCITY: &[Key] =
    &[PART, Key::new("value", Kind::Functions3, "[0.0, 0.0, 0.0]", "velocity [m/s], a function of x, y, z and t")];

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "assign_body_acceleration_to_material_point_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: ACCELERATION,
        help: "body force per mass as functions of place and time, evaluated at each point in each step",
        build: |building| Ok(Box::new(BodyAcceleration { values: Values::new(building)?, first: false })),
    });
    registry.process(ProcessEntry {
        name: "assign_initial_velocity_field_to_material_point_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: VELOCITY,
        help: "velocity of material points at the start as functions of place",
        build: |building| Ok(Box::new(InitialVelocity(Values::new(building)?))),
    });
}

/// A vector of functions on a part of points.
struct Values {
    settings: Settings,
    functions: [SpaceTimeValue; 3],
}

impl Values {
    fn new(building: Building) -> Result<Self, InputErrors> {
        let settings = building.settings;
        let functions = match settings.get("value") {
            Some(value) => SpaceTimeValue::read3(value)?,
            None => [None, None, None],
        };
        let functions = functions.map(|f| f.unwrap_or_else(|| SpaceTimeValue::constant(0.0)));
        Ok(Self { settings, functions })
    }

    /// Adds the values at each point of the part to the column that `choose` picks.
    ///
    /// # Errors
    /// A value that is not finite.
    fn add(
        &self,
        points: &mut MaterialPoints,
        time: f64,
        choose: fn(&mut Block) -> &mut bia_kernel::variables::Column,
    ) -> Result<(), Error> {
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return Ok(()) };
        for block in points.blocks.iter_mut().filter(|block| selection.holds(block.body)) {
            let mut column = std::mem::take(choose(block));
            let shared = &*block;
            let width = column.width();
            let written = if width == 0 {
                Ok(())
            } else {
                let rows = column.values_mut().par_chunks_mut(width).enumerate().with_min_len(64);
                rows.try_for_each(|(point, row)| self.at(shared, point, time, row))
            };
            *choose(block) = column;
            written?;
        }
        Ok(())
    }

    fn at(&self, block: &Block, point: usize, time: f64, row: &mut [f64]) -> Result<(), Failure> {
        let of = |row: &[f64]| std::array::from_fn(|a| row.get(a).copied().unwrap_or(0.0));
        let position: [f64; 3] = of(block.position.row(point));
        let moved: [f64; 3] = of(block.displacement.row(point));
        let initial = std::array::from_fn(|a| position[a] - moved[a]);
        for (value, function) in row.iter_mut().zip(&self.functions) {
            *value += function.at(position, initial, time);
        }
        if row.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let name = format!("material point {}", block.ids[point]);
        let advice = "a function that is finite on the whole body at all times";
        Err(Failure::new(format!("a function of {} is not finite", self.settings.parameters().place()), advice)
            .at(name, position))
    }
}

/// Body acceleration, evaluated at the start of each step; several processes add up.
struct BodyAcceleration {
    values: Values,
    /// The first of them in the pipeline clears what the last step left.
    first: bool,
}

/// Tells, in the model, that a process clears the body acceleration.
struct Cleared;

impl BodyAcceleration {
    /// Evaluates the functions.
    fn apply(&self, context: &mut Context) -> Result<(), Error> {
        let (end, time) = (context.clock.time, context.clock.load_time);
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        if self.first {
            points.blocks.iter_mut().for_each(|block| block.body_acceleration.values_mut().fill(0.0));
        }
        if Interval(self.values.settings.interval("interval")).contains(end) {
            self.values.add(points, time, |block| &mut block.body_acceleration)?;
        }
        Ok(())
    }
}

impl Process for BodyAcceleration {
    fn name(&self) -> &str {
        "assign_body_acceleration_to_material_point"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.first = model.extension::<Cleared>().is_none();
        model.extend(Cleared);
        check_part(model, &self.values.settings)
    }

    fn require(&self, requirements: &mut Requirements) {
        requirements.variables.push(Wanted {
            location: Location::Points,
            variable: BODY_ACCELERATION.into(),
            place: self.values.settings.parameters().clone(),
        });
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.apply(context)?;
        if let Some(points) = context.model.extension_mut::<MaterialPoints>().filter(|points| points.dynamic) {
            points.blocks.iter_mut().for_each(Block::start_with_body_acceleration);
        }
        Ok(())
    }

    fn execute_initialize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        self.apply(context)
    }
}

/// Velocity at the start.
struct InitialVelocity(Values);

impl Process for InitialVelocity {
    fn name(&self) -> &str {
        "assign_initial_velocity_field_to_material_point"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.0.settings)
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let time = context.clock.time;
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        let Some(selection) = points.select(self.0.settings.text("model_part_name")) else { return Ok(()) };
        let chosen = points.blocks.iter_mut().filter(|block| selection.holds(block.body));
        chosen.for_each(|block| block.velocity.values_mut().fill(0.0));
        self.0.add(points, time, |block| &mut block.velocity)
    }
}
