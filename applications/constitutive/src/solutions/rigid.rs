//! The motion of a rigid body: x = C + v t + a t²/2 + R(ω t) (X − C), a turn about an axis through C.

use super::Field;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind};
use bia_kernel::reference::{Compared, Place, ReferenceEntry, ReferenceSolution};
use bia_kernel::registry::Building;
use nalgebra::{Rotation3, Vector3};

const KEYS: &[Key] = &[
    Key::new("velocity", Kind::Vector3, "[0.0, 0.0, 0.0]", "at the start [m/s]"),
    Key::new("acceleration", Kind::Vector3, "[0.0, 0.0, 0.0]", "such as gravity in free fall [m/s²]"),
    Key::new("angular_velocity", Kind::Vector3, "[0.0, 0.0, 0.0]", "ω [1/s]"),
    Key::new("center", Kind::Vector3, "[0.0, 0.0, 0.0]", "C at the start [m]"),
];

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "rigid_motion",
    keys: KEYS,
    help: "free fall, flight and steady turning of a body that does not deform",
    build,
};

struct Rigid {
    field: Field,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    turn: Vector3<f64>,
    center: Vector3<f64>,
    /// Only this component.
    component: Option<usize>,
}

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let settings = &building.settings;
    let field = Field::of(compared).filter(|field| *field != Field::Stress);
    let Some(field) = field else {
        let help = "it gives displacements and velocities";
        return Err(settings.parameters().error(format!("this solution does not give {compared}")).help(help).into());
    };
    let vector = |key: &str| Vector3::from(settings.vector(key));
    let (velocity, acceleration) = (vector("velocity"), vector("acceleration"));
    let (turn, center, component) = (vector("angular_velocity"), vector("center"), compared.axis());
    Ok(Box::new(Rigid { field, velocity, acceleration, turn, center, component }))
}

impl ReferenceSolution for Rigid {
    fn append(&self, place: &Place, out: &mut Vec<f64>) {
        let t = place.time;
        let arm = Vector3::from(place.initial) - self.center;
        let turned = Rotation3::from_scaled_axis(self.turn * t) * arm;
        let value = match self.field {
            Field::Displacement => self.velocity * t + self.acceleration * (0.5 * t * t) + turned - arm,
            _ => self.velocity + self.acceleration * t + self.turn.cross(&turned),
        };
        match self.component {
            Some(component) => out.push(value[component]),
            None => out.extend(value.iter()),
        }
    }
}
