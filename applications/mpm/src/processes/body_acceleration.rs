//! Body acceleration of material points as functions of place and time, and their velocity or acceleration at the
//! start, from functions or a file.
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
use bia_kernel::processes::sampled::{self, SampledField};
use bia_kernel::processes::{Context, Interval, Location, Process, Requirements, SpaceTimeValue, Wanted};
use bia_kernel::registry::{Building, ProcessEntry, Registry};
use bia_kernel::variables::Column;
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
const FIELD: &[Key] = &Key::join::<3, 4, 7>(
    [
        PART,
        Key::new(
            "variable_name",
            Kind::Choice(&["MP_VELOCITY", "MP_ACCELERATION"]),
            "\"MP_VELOCITY\"",
            "what is given at the start",
        ),
        Key::new("value", Kind::Functions3, "[0.0, 0.0, 0.0]", "components [m/s or m/s²], functions of x, y, z and t"),
    ],
    sampled::KEYS,
);

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
        name: "assign_initial_field_to_material_point_process",
        aliases: &["assign_initial_velocity_field_to_material_point_process"],
        application: Some("MPMApplication"),
        keys: FIELD,
        help: "velocity or acceleration of material points at the start, as functions of place or from a vtu file",
        build: |building| Ok(Box::new(InitialField::read(building)?)),
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
    fn add(&self, points: &mut MaterialPoints, time: f64, choose: fn(&mut Block) -> &mut Column) -> Result<(), Error> {
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

/// A vector field at the start.
struct InitialField {
    values: Values,
    file: Option<SampledField>,
}

impl InitialField {
    fn read(building: Building) -> Result<Self, InputErrors> {
        let settings = &building.settings;
        let mut errors = InputErrors::default();
        if settings.given("file") && settings.given("value") {
            errors.push(settings.error("file", "stands beside \"value\"; one of them gives the field"));
        }
        let folder = &building.options.folder;
        let file = errors.absorb(SampledField::read(settings, settings.text("variable_name"), 3, folder)).flatten();
        let values = errors.absorb(Values::new(building));
        match values {
            Some(values) => errors.or(Self { values, file }),
            None => Err(errors),
        }
    }

    fn column(&self) -> fn(&mut Block) -> &mut Column {
        match self.values.settings.text("variable_name") {
            "MP_ACCELERATION" => |block| &mut block.acceleration,
            _ => |block| &mut block.velocity,
        }
    }

    /// Sets the column of a block from the file.
    ///
    /// # Errors
    /// A point for which the file has no value.
    fn sample(&self, block: &mut Block, file: &SampledField) -> Result<(), Error> {
        for point in 0..block.len() {
            let (x, mut value) = (block.coordinates(point), [0.0; 3]);
            if file.at(x, &mut value).is_none() {
                let what = format!("{:?} has no value here", self.values.settings.text("file"));
                let advice = "a file that covers the body, \"match\": \"nearest\", or a larger tolerance";
                let name = format!("material point {}", block.ids[point]);
                return Err(Failure::new(what, advice).at(name, x).into());
            }
            let column = self.column()(block);
            if column.is_used() {
                column.row_mut(point).iter_mut().zip(value).for_each(|(entry, value)| *entry = value);
            }
        }
        Ok(())
    }
}

impl Process for InitialField {
    fn name(&self) -> &str {
        "assign_initial_field_to_material_point"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.values.settings)
    }

    /// Velocities are kept wherever there is inertia.
    fn require(&self, requirements: &mut Requirements) {
        let variable = self.values.settings.text("variable_name");
        if variable == "MP_ACCELERATION" {
            let place = self.values.settings.parameters().clone();
            requirements.variables.push(Wanted { location: Location::Points, variable: variable.into(), place });
        }
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let (time, column) = (context.clock.time, self.column());
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        let Some(selection) = points.select(self.values.settings.text("model_part_name")) else { return Ok(()) };
        let mut chosen = points.blocks.iter_mut().filter(|block| selection.holds(block.body));
        match &self.file {
            Some(file) => chosen.try_for_each(|block| self.sample(block, file))?,
            None => {
                chosen.for_each(|block| column(block).values_mut().fill(0.0));
                self.values.add(points, time, column)?;
            }
        }
        if self.values.settings.text("variable_name") == "MP_VELOCITY" {
            // Body forces may have been there before.
            let sheared = |block: &&mut Block| selection.holds(block.body) && block.starts_sheared();
            points.blocks.iter_mut().filter(sheared).for_each(|block| block.acceleration.values_mut().fill(0.0));
        }
        Ok(())
    }
}
