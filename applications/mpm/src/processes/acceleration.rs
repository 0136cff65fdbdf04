//! Gravity and initial velocity on material points (spec 07 §6).

use crate::points::MaterialPoints;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::processes::{Context, Process, Requirements};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of points, such as MPM_Material or Initial_MPM_Material.Body"),
    Key::new("modulus", Kind::Number(Range::ANY), "1.0", "size of the vector [m/s² or m/s]"),
    Key::new("direction", Kind::Vector3, "[0.0, 0.0, 0.0]", "direction, used as given"),
    Key::optional("variable_name", Kind::Any, "accepted"),
    Key::optional("constrained", Kind::Any, "accepted"),
    Key::optional("local_axes", Kind::Any, "accepted"),
    Key::optional("interval", Kind::Any, "accepted; it acts once, before the loop"),
    Key::optional("mesh_id", Kind::Any, "accepted"),
    Key::optional("help", Kind::Any, "accepted"),
];

/// Registers the processes of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "assign_gravity_to_material_point_process",
        aliases: &["assign_gravity_to_particle_process"],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "body force per mass on material points",
        build: |building| Ok(Box::new(AssignToPoints::new(building, Quantity::Gravity)?)),
    });
    registry.process(ProcessEntry {
        name: "assign_initial_velocity_to_material_point_process",
        aliases: &["assign_initial_velocity_to_particle_process"],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "velocity of material points at the start",
        build: |building| Ok(Box::new(AssignToPoints::new(building, Quantity::Velocity)?)),
    });
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Gravity,
    Velocity,
}

struct AssignToPoints {
    quantity: Quantity,
    settings: Settings,
    vector: [f64; 3],
    kratos_exact: bool,
}

impl AssignToPoints {
    fn new(building: Building, quantity: Quantity) -> Result<Self, InputErrors> {
        let (modulus, direction) = (building.settings.number("modulus"), building.settings.vector("direction"));
        if modulus != 0.0 && direction == [0.0; 3] {
            let error = building.settings.error("direction", "is the zero vector, so this process does nothing");
            return Err(error.help("such as [0.0, -1.0, 0.0], or a modulus of 0").into());
        }
        let vector = direction.map(|d| modulus * d);
        Ok(Self { quantity, vector, settings: building.settings, kratos_exact: building.options.kratos_exact })
    }
}

impl Process for AssignToPoints {
    fn name(&self) -> &str {
        match self.quantity {
            Quantity::Gravity => "assign_gravity_to_material_point",
            Quantity::Velocity => "assign_initial_velocity_to_material_point",
        }
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn require(&self, _: &mut Requirements) {}

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let Some(points) = context.model.extension_mut::<MaterialPoints>() else { return Ok(()) };
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return Ok(()) };
        for block in points.blocks.iter_mut().filter(|block| selection.holds(block.body)) {
            match self.quantity {
                Quantity::Velocity if block.velocity.is_used() => {
                    for point in 0..block.ids.len() {
                        block.velocity.row_mut(point).iter_mut().zip(self.vector).for_each(|(value, v)| *value = v);
                    }
                }
                Quantity::Velocity => {}
                Quantity::Gravity => {
                    block.gravity = self.vector;
                    // In statics there is no acceleration; Kratos sets it all the same.
                    if points.dynamic || self.kratos_exact {
                        block.start_with_body_acceleration();
                    }
                }
            }
        }
        Ok(())
    }
}

/// Checks that a process's part of points is a body, before the points exist.
pub fn check_part(model: &Model, settings: &Settings) -> Result<(), InputErrors> {
    check_path(model, settings, settings.text("model_part_name"))
}

/// Checks that the path that the settings give selects a body, before the points exist.
pub fn check_path(model: &Model, settings: &Settings, path: &str) -> Result<(), InputErrors> {
    let Some(initial) = model.parts().iter().find(|part| part.name.starts_with("Initial_")) else { return Ok(()) };
    let name = initial.name.trim_start_matches("Initial_");
    let (root, below) = path.split_once('.').map_or((path, None), |(root, below)| (root, Some(below)));
    let is_root = root == name || root == initial.name || root == crate::grid::GRID;
    let body = match (is_root, below) {
        (true, None) => return Ok(()),
        (true, Some(below)) => below,
        (false, _) => path,
    };
    if initial.children.iter().any(|child| child.name == body) {
        return Ok(());
    }
    let mut names = vec![name.to_string()];
    names.extend(initial.children.iter().map(|child| format!("{name}.{}", child.name)));
    let diagnostic = settings.error("model_part_name", format!("there is no part of points {path:?}"));
    Err(diagnostic.allowed(path, names.iter().map(String::as_str)).into())
}
