//! Velocity of the points at the start, as functions of place, and their deformation.

use super::{elements_of, points_of};
use crate::engine::Points;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::{Context, Process, SpaceTimeValue, not_finite};
use bia_kernel::registry::{ProcessEntry, Registry};
use nalgebra::Matrix3;

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of the cells, such as Background_Grid or Background_Grid.Left"),
    Key::new("value", Kind::Functions3, "[0.0, 0.0, 0.0]", "velocity [m/s], functions of x, y, z; null leaves it 0"),
    Key::optional("deformation_gradient", Kind::List, "F at the start, 9 numbers row by row: the undeformed state"),
];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "dgmpm_initial_state_process",
        aliases: &[],
        application: Some("DGMPMApplication"),
        keys: KEYS,
        help: "velocity of material points at the start as functions of place, and their deformation",
        build: |building| {
            let settings = building.settings;
            let values = match settings.get("value") {
                Some(value) => SpaceTimeValue::read3(value)?,
                None => [None, None, None],
            };
            let gradient = gradient(&settings)?;
            Ok(Box::new(InitialState { settings, values, gradient, elements: Vec::new() }))
        },
    });
}

/// The deformation gradient at the start, if it is given.
fn gradient(settings: &Settings) -> Result<Option<Matrix3<f64>>, InputErrors> {
    let Some(list) = settings.get("deformation_gradient") else { return Ok(None) };
    let numbers: Vec<f64> = list.entries().iter().filter_map(|entry| entry.value().as_f64()).collect();
    let gradient = (numbers.len() == 9).then(|| Matrix3::from_row_slice(&numbers));
    match gradient.filter(|gradient| gradient.determinant() > 0.0) {
        Some(gradient) => Ok(Some(gradient)),
        None => Err(settings.error("deformation_gradient", "must be 9 numbers with a positive determinant").into()),
    }
}

struct InitialState {
    settings: Settings,
    values: [Option<SpaceTimeValue>; 3],
    gradient: Option<Matrix3<f64>>,
    elements: Vec<u32>,
}

impl Process for InitialState {
    fn name(&self) -> &str {
        "dgmpm_initial_state"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.elements = elements_of(model, &self.settings)?;
        Ok(())
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let Some(points) = context.model.extension_mut::<Points>() else { return Ok(()) };
        let chosen: Vec<usize> = points_of(points, &self.elements).collect();
        for index in chosen {
            let x = points.body.point(index).initial;
            let value = |value: &Option<SpaceTimeValue>| value.as_ref().map_or(0.0, |v| v.at(x, x, context.clock.time));
            let velocity = std::array::from_fn(|a| value(&self.values[a]));
            if let Some(wrong) = velocity.iter().find(|v: &&f64| !v.is_finite()) {
                let failure = not_finite(self.name(), "MP_VELOCITY", *wrong);
                return Err(failure.at(format!("material point {}", index + 1), x).into());
            }
            points.body.set_velocity(index, velocity);
            if let Some(gradient) = &self.gradient {
                points.body.set_deformation(index, gradient);
            }
        }
        Ok(())
    }
}
