//! Lists of variables that an output or check process names.

use super::{Location, Requirements, Wanted};
use crate::diagnostic::InputErrors;
use crate::io::history::Series;
use crate::io::table::Heading;
use crate::parameters::{Parameters, Settings};
use crate::registry::Registry;
use crate::variables::{Column, Fields, Rank, Variable};

/// Components of a tensor with so many numbers, in their order; one in space of one dimension.
pub fn tensor_components(width: usize) -> &'static [&'static str] {
    match width {
        3 => &["XX", "YY", "XY"],
        4 => &["XX", "YY", "ZZ", "XY"],
        6 => &["XX", "YY", "ZZ", "XY", "YZ", "XZ"],
        9 => &["XX", "XY", "XZ", "YX", "YY", "YZ", "ZX", "ZY", "ZZ"],
        _ => &["XX"],
    }
}

/// A variable, or one component of a vector variable, that the input names.
#[derive(Debug, Clone)]
pub struct Quantity {
    /// Name in the input and in files, such as `DISPLACEMENT` or `DISPLACEMENT_Y`.
    pub name: String,
    /// The variable.
    pub variable: Variable,
    /// The component, if only one is meant.
    pub component: Option<usize>,
    /// Where the input names it.
    pub place: Parameters,
}

impl Quantity {
    /// The quantities that the list `settings[key]` names.
    ///
    /// # Errors
    /// Names that no variable has, each with the nearest one.
    pub fn read_list(settings: &Settings, key: &str, registry: &Registry) -> Result<Vec<Self>, InputErrors> {
        let mut errors = InputErrors::default();
        let entries = settings.get(key).map_or(Vec::new(), Parameters::entries);
        let list: Vec<Self> =
            entries.into_iter().filter_map(|entry| errors.absorb(Self::read(entry, registry))).collect();
        errors.or(list)
    }

    fn read(place: Parameters, registry: &Registry) -> Result<Self, InputErrors> {
        let name = place.value().as_str().unwrap_or_default().to_string();
        if let Some(variable) = registry.find_variable(&name) {
            return Ok(Self { name, variable, component: None, place });
        }
        let component = ["_X", "_Y", "_Z"].iter().position(|suffix| name.ends_with(suffix));
        let vector = component.and_then(|_| registry.find_variable(&name[..name.len() - 2]));
        match vector {
            Some(variable) if variable.rank == Rank::Vector => Ok(Self { name, variable, component, place }),
            _ => Err(registry.unknown_variable(place.error(format!("the variable {name:?} is unknown")), &name)),
        }
    }

    /// Declares that the quantities will be read at a location.
    pub fn require(list: &[Self], location: Location, requirements: &mut Requirements) {
        requirements.variables.extend(list.iter().map(|quantity| Wanted {
            location,
            variable: quantity.variable.name.into(),
            place: quantity.place.clone(),
        }));
    }

    /// The series of a history: vectors by component, tensors as lists of `tensor` numbers.
    pub fn series(&self, tensor: usize) -> Vec<Series> {
        let number = |name: String| Series { name, list: None };
        match (self.variable.rank, self.component) {
            (Rank::Vector, None) => ["X", "Y", "Z"].map(|axis| number(format!("{}_{axis}", self.name))).into(),
            (Rank::Voigt, _) => vec![Series { name: self.name.clone(), list: Some(tensor) }],
            (Rank::Tensor, _) => vec![Series { name: self.name.clone(), list: Some(9) }],
            _ => vec![number(self.name.clone())],
        }
    }

    /// The columns of a table that hold the `width` numbers of the quantity.
    pub fn headings(&self, width: usize) -> Vec<Heading> {
        let names: &[&str] = match (self.variable.rank, self.component, width) {
            (Rank::Scalar, ..) | (_, Some(_), _) => &[],
            (Rank::Vector, ..) => &["X", "Y", "Z"],
            (_, _, width) => tensor_components(width),
        };
        let unit = self.variable.unit;
        match names {
            [] => vec![Heading::new(self.name.clone(), unit)],
            _ => names.iter().map(|name| Heading::new(format!("{}_{name}", self.name), unit)).collect(),
        }
    }

    /// Numbers that the quantity has on a node (or condition); 1 for a tensor without a column.
    pub fn width(&self, fields: &Fields) -> usize {
        match (self.variable.rank, self.component) {
            (Rank::Vector, None) => 3,
            (Rank::Voigt | Rank::Tensor, _) => fields.rows(&self.variable).map_or(1, Column::width),
            _ => 1,
        }
    }

    /// Appends the value of a node (or cell); zero where the variable has no column.
    pub fn append(&self, fields: &Fields, index: usize, out: &mut Vec<f64>) {
        let components = match self.component {
            Some(component) => component..component + 1,
            None => 0..self.width(fields),
        };
        match (self.variable.rank, fields.vector(&self.variable), fields.scalar(&self.variable)) {
            (Rank::Vector, Some(column), _) => out.extend_from_slice(&column[index][components]),
            (Rank::Scalar, _, Some(column)) => out.push(column[index]),
            (Rank::Voigt | Rank::Tensor, ..) if let Some(column) = fields.rows(&self.variable) => {
                out.extend_from_slice(column.row(index));
            }
            _ => out.extend(components.map(|_| 0.0)),
        }
    }
}
