//! Where a body stands: turned about its centre, then moved.

use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind, Range, Settings};
use nalgebra::{Rotation3, Unit, Vector3};

const ROTATION: &[Key] = &[
    Key::required("axis", Kind::Vector3, "axis of rotation through the centre of the primitive"),
    Key::required("angle", Kind::Number(Range::ANY), "angle [degrees], right-handed about the axis"),
];

/// x ↦ c + Q (x − c) + t with centre c, rotation Q and translation t.
#[derive(Debug, Clone)]
pub(super) struct Placement {
    center: Vector3<f64>,
    rotation: Option<Rotation3<f64>>,
    translation: Vector3<f64>,
}

impl Placement {
    /// From the keys `rotation` and `translation` of a body of this dimension.
    pub fn read(settings: &Settings, center: [f64; 3], dimension: usize) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let rotation = errors.absorb(rotation(settings, dimension)).flatten();
        let translation = settings.vector("translation");
        for axis in dimension..3 {
            if translation[axis] != 0.0 {
                let name = super::reading::AXES[axis];
                let message =
                    format!("is {} in {name}, must be 0 for a body of {dimension} dimensions", translation[axis]);
                errors.push(settings.error("translation", message));
            }
        }
        errors.or(Self { center: center.into(), rotation, translation: translation.into() })
    }

    /// The place to which a point of the primitive goes.
    pub fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        let x = Vector3::from(x);
        let turned = self.rotation.map_or(x, |rotation| self.center + rotation * (x - self.center));
        (turned + self.translation).into()
    }

    /// The point of the primitive that goes to this place.
    pub fn undo(&self, x: [f64; 3]) -> [f64; 3] {
        let x = Vector3::from(x) - self.translation;
        self.rotation.map_or(x, |rotation| self.center + rotation.inverse() * (x - self.center)).into()
    }
}

fn rotation(settings: &Settings, dimension: usize) -> Result<Option<Rotation3<f64>>, InputErrors> {
    let Some(given) = settings.get("rotation") else { return Ok(None) };
    let (axis, degrees) = match given.value().as_f64() {
        Some(degrees) => ([0.0, 0.0, 1.0], degrees),
        None if given.value().is_object() => {
            let rotation = given.read(ROTATION)?;
            (rotation.vector("axis"), rotation.number("angle"))
        }
        None => {
            let message = "must be an angle about z in degrees, or an object of axis and angle";
            return Err(given.error(message).into());
        }
    };
    let Some(unit) = Unit::try_new(Vector3::from(axis), 0.0) else {
        return Err(given.error("has an axis without length").into());
    };
    let leaves = if dimension == 2 { axis[0] != 0.0 || axis[1] != 0.0 } else { dimension == 1 };
    if leaves && degrees != 0.0 {
        let message = format!("would turn a body of {dimension} dimensions out of its space");
        return Err(given.error(message).help("plane bodies turn about z alone, bars on the x axis not at all").into());
    }
    Ok((degrees != 0.0).then(|| Rotation3::from_axis_angle(&unit, degrees.to_radians())))
}
