//! A field as formulas of x, y, z, t and the initial positions X, Y, Z.

use super::{Compared, Place, ReferenceEntry, ReferenceSolution};
use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind};
use crate::processes::SpaceTimeValue;
use crate::registry::Building;

/// As the registry knows it.
pub const ENTRY: ReferenceEntry = ReferenceEntry {
    name: "formula",
    keys: &[Key::required("value", Kind::Any, "number or function of x, y, z, X, Y, Z, t, or a list of them")],
    help: "a function of place, initial place and time for each component",
    build,
};

struct Formula(Vec<SpaceTimeValue>);

fn build(building: Building, compared: &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let Some(value) = building.settings.get("value") else { return Err(InputErrors::default()) };
    let entries = if value.value().is_array() { value.entries() } else { vec![value.clone()] };
    let mut errors = InputErrors::default();
    let values: Vec<SpaceTimeValue> =
        entries.iter().filter_map(|entry| errors.absorb(SpaceTimeValue::read(entry))).collect();
    if let Some(width) = compared.width().filter(|width| *width != entries.len()) {
        errors.push(value.error(format!("has {} entries, {compared} has {width}", entries.len())));
    }
    errors.or(Box::new(Formula(values)))
}

impl ReferenceSolution for Formula {
    fn append(&self, place: &Place, out: &mut Vec<f64>) {
        out.extend(self.0.iter().map(|value| value.at(place.position, place.initial, place.time)));
    }
}
