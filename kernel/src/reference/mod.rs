//! Reference solutions: what a field should be, as components that a project names.
//!
//! `"reference": {"type": "formula", "value": ["0.1*sin(pi*X)*cos(t)", 0, 0]}`. The kernel has formulas and
//! tables; applications register exact solutions of their equations with [`ReferenceEntry`].

mod formula;
mod table;

use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Parameters};
use crate::processes::RunOptions;
use crate::processes::quantity::tensor_components;
use crate::registry::{Building, Description, Registry};
use crate::variables::{Rank, Variable};
use std::fmt;

/// Where and when a value is wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Place {
    /// Position now, in metres.
    pub position: [f64; 3],
    /// Position at the start, in metres.
    pub initial: [f64; 3],
    /// Time in seconds.
    pub time: f64,
}

/// The field that is compared: a variable, or one component of it.
#[derive(Debug, Clone)]
pub struct Compared {
    /// The variable.
    pub variable: Variable,
    /// `X`, `Y` or `Z` of a vector, `XX`, `XY`, … of a tensor; all components if there is none.
    pub component: Option<String>,
}

impl Compared {
    /// The field that a text at `place` names: a variable, or with the component of a vector or tensor behind
    /// it, as in `VELOCITY_X` and `CAUCHY_STRESS_VECTOR_XY`.
    ///
    /// # Errors
    /// An unknown name.
    pub fn named(name: &str, place: &Parameters, registry: &Registry) -> Result<Self, InputErrors> {
        if let Some(variable) = registry.find_variable(name) {
            return Ok(Self { variable, component: None });
        }
        let (stem, component) = name.rsplit_once('_').unwrap_or((name, ""));
        let is_component = |rank: Rank| match rank {
            Rank::Scalar => false,
            Rank::Vector => ["X", "Y", "Z"].contains(&component),
            Rank::Voigt => tensor_components(6).contains(&component),
            Rank::Tensor => tensor_components(9).contains(&component),
        };
        match registry.find_variable(stem).filter(|variable| is_component(variable.rank)) {
            Some(variable) => Ok(Self { variable, component: Some(component.into()) }),
            None => Err(registry.unknown_variable(place.error(format!("the variable {name:?} is unknown")), name)),
        }
    }

    /// Names of its numbers, of which there are `width`.
    pub fn names(&self, width: usize) -> Vec<String> {
        let of = |components: &[&str]| components.iter().map(|c| format!("{}_{c}", self.variable.name)).collect();
        match (&self.component, self.variable.rank) {
            (Some(_), _) | (None, Rank::Scalar) => vec![self.to_string()],
            (None, Rank::Vector) => of(&["X", "Y", "Z"]),
            (None, Rank::Voigt | Rank::Tensor) => of(tensor_components(width)),
        }
    }

    /// How many numbers it has, where that does not depend on the kinematics.
    pub fn width(&self) -> Option<usize> {
        match (&self.component, self.variable.rank) {
            (Some(_), _) | (None, Rank::Scalar) => Some(1),
            (None, Rank::Vector) => Some(3),
            (None, Rank::Tensor) => Some(9),
            (None, Rank::Voigt) => None,
        }
    }

    /// Index of the component of a vector.
    pub fn axis(&self) -> Option<usize> {
        self.component.as_deref().and_then(|component| ["X", "Y", "Z"].iter().position(|axis| *axis == component))
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.component {
            Some(component) => write!(f, "{}_{component}", self.variable.name),
            None => f.write_str(self.variable.name),
        }
    }
}

/// What a field should be.
pub trait ReferenceSolution: Send {
    /// Appends the numbers of the field at a place and time; what is not finite shows up in the error.
    fn append(&self, place: &Place, out: &mut Vec<f64>);
}

/// Builds a reference solution for a field.
pub type BuildReference = fn(Building, &Compared) -> Result<Box<dyn ReferenceSolution>, InputErrors>;

/// A reference solution and how to build it.
#[derive(Clone, Copy)]
pub struct ReferenceEntry {
    /// Its `type`.
    pub name: &'static str,
    /// Keys beside `type`.
    pub keys: &'static [Key],
    /// What it is, with its source.
    pub help: &'static str,
    /// Builds it.
    pub build: BuildReference,
}

/// All reference solutions that a project can name.
#[derive(Default)]
pub struct References(Vec<ReferenceEntry>);

impl References {
    /// Adds one; a name that is there already is kept, as several applications may share solutions.
    pub fn add(&mut self, entry: ReferenceEntry) {
        if !self.0.iter().any(|known| known.name == entry.name) {
            self.0.push(entry);
        }
    }
}

/// Registers the reference solutions of the kernel.
pub fn register(registry: &mut Registry) {
    registry.kind(crate::registry::Kinds { title: "reference solutions", describe });
    let references = registry.catalogue_mut::<References>();
    references.add(formula::ENTRY);
    references.add(table::ENTRY);
}

fn describe(registry: &Registry) -> Vec<Description> {
    let entries = registry.catalogue::<References>().map_or(&[][..], |references| &references.0);
    let row = |key: &Key| [key.name, "", "", key.help].map(String::from);
    let describe = |entry: &ReferenceEntry| Description {
        name: entry.name.into(),
        aliases: Vec::new(),
        help: entry.help.into(),
        values: entry.keys.iter().map(row).collect(),
    };
    entries.iter().map(describe).collect()
}

/// The solution that an object like `{"type": "formula", …}` names, for a field.
///
/// # Errors
/// An unknown type, faults of its settings, a field that it does not give.
pub fn build(
    parameters: &Parameters,
    compared: &Compared,
    registry: &Registry,
    options: &RunOptions,
    project: &Parameters,
) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
    let name = parameters.text("type")?;
    let entries = registry.catalogue::<References>().map_or(&[][..], |references| &references.0);
    let Some(entry) = entries.iter().find(|entry| entry.name == name) else {
        let place = parameters.child("type").unwrap_or_else(|| parameters.clone());
        let message = format!("there is no reference solution {name:?}");
        return Err(place.error(message).allowed(&name, entries.iter().map(|entry| entry.name)).into());
    };
    let settings = parameters.clone().without("/type").read(entry.keys)?;
    (entry.build)(Building { settings, registry, options, project }, compared)
}
