//! A material's constants: which a law takes, in which range, and every fault of them at once.

use std::fmt;

use bia_kernel::diagnostic::{Diagnostic, Place};
use bia_kernel::model::{Properties, Value};
use thiserror::Error;

use crate::VolumetricLaw;

/// The values that a constant may take. Ends are excluded unless named otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Every finite number.
    Any,
    /// Greater than this.
    Above(f64),
    /// This or greater.
    AtLeast(f64),
    /// Less than this.
    Below(f64),
    /// Greater than the first and less than the second.
    Between(f64, f64),
    /// Greater than the first and at most the second.
    AboveUpTo(f64, f64),
}

impl Range {
    /// Whether `value` lies in the range.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Any => value.is_finite(),
            Self::Above(low) => value > low,
            Self::AtLeast(low) => value >= low,
            Self::Below(high) => value < high,
            Self::Between(low, high) => low < value && value < high,
            Self::AboveUpTo(low, high) => low < value && value <= high,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => write!(f, "finite"),
            Self::Above(low) => write!(f, "> {low}"),
            Self::AtLeast(low) => write!(f, ">= {low}"),
            Self::Below(high) => write!(f, "< {high}"),
            Self::Between(low, high) => write!(f, "> {low} and < {high}"),
            Self::AboveUpTo(low, high) => write!(f, "> {low} and <= {high}"),
        }
    }
}

/// A constant that a law takes from a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialVariable {
    /// Name in materials files, Kratos's where it has one.
    pub name: &'static str,
    /// SI unit; `-` for none.
    pub unit: &'static str,
    /// What it is.
    pub help: &'static str,
    /// Allowed values.
    pub range: Range,
}

/// Mass per reference volume.
pub const DENSITY: MaterialVariable = MaterialVariable {
    name: "DENSITY",
    unit: "kg/m³",
    help: "mass per volume of the undeformed material",
    range: Range::Above(0.0),
};
/// Young's modulus.
pub const YOUNG_MODULUS: MaterialVariable = MaterialVariable {
    name: "YOUNG_MODULUS",
    unit: "Pa",
    help: "Young's modulus at small strain",
    range: Range::Above(0.0),
};
/// Poisson's ratio.
pub const POISSON_RATIO: MaterialVariable = MaterialVariable {
    name: "POISSON_RATIO",
    unit: "-",
    help: "Poisson's ratio at small strain; 0.5 would be incompressible",
    range: Range::Between(-1.0, 0.5),
};
/// Poisson's ratio of a law with nodal pressure.
pub const POISSON_RATIO_TO_HALF: MaterialVariable = MaterialVariable {
    help: "Poisson's ratio at small strain; 0.5 is incompressible",
    range: Range::AboveUpTo(-1.0, 0.5),
    ..POISSON_RATIO
};

/// One thing that is wrong with a material.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Fault {
    /// The law needs a constant that the material does not have.
    #[error("{} is missing", .variable.name)]
    Missing {
        /// The constant.
        variable: MaterialVariable,
    },
    /// The constant is not a number.
    #[error("{} is {found}, not a number", .variable.name)]
    WrongType {
        /// The constant.
        variable: MaterialVariable,
        /// What stands there.
        found: String,
    },
    /// The constant is infinite, not a number, or outside its range.
    #[error("{} is {value}", .variable.name)]
    OutOfRange {
        /// The constant.
        variable: MaterialVariable,
        /// Its value.
        value: f64,
    },
    /// Constants that are each in range do not go together.
    #[error("{problem}")]
    Inconsistent {
        /// What does not go together, in one sentence without a full stop.
        problem: String,
        /// What to do.
        advice: String,
    },
    /// A fault of the program: the law reads what its `VARIABLES` does not name.
    #[error("the law reads {name}, which it does not declare")]
    Undeclared {
        /// The constant.
        name: &'static str,
    },
}

impl Fault {
    /// For the user. `place` is the material; its pointer is followed by the constant's name.
    pub fn diagnostic(&self, place: &Place) -> Diagnostic {
        let help = match self {
            Self::Missing { variable } | Self::WrongType { variable, .. } | Self::OutOfRange { variable, .. } => {
                let MaterialVariable { unit, help, range, .. } = variable;
                format!("expected: {help}, a number {range} [{unit}]")
            }
            Self::Inconsistent { advice, .. } => advice.clone(),
            Self::Undeclared { .. } => "add it to the VARIABLES of the law".to_owned(),
        };
        let mut place = place.clone();
        if let (Some(pointer), Self::WrongType { variable, .. } | Self::OutOfRange { variable, .. }) =
            (&mut place.pointer, self)
        {
            *pointer = format!("{pointer}/{}", variable.name);
        }
        Diagnostic::error(place, self.to_string()).help(help)
    }
}

/// Choices that hold for all materials of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Repeat Kratos where it differs from the equations, so that iterations can be compared:
    /// linear elastic laws then return C/J for the tangent.
    pub kratos_exact: bool,
    /// The solver is explicit: names of linear elastic laws then mean [`crate::Hypoelastic`].
    pub explicit: bool,
    /// Elements have nodal pressures, held by this volumetric law: laws must be mixed ones.
    pub mixed: Option<VolumetricLaw>,
}

/// A material whose constants have been checked for one law.
#[derive(Debug, Clone, Copy)]
pub struct Material<'a> {
    properties: &'a Properties,
    options: &'a Options,
    variables: &'a [MaterialVariable],
    optional: &'a [MaterialVariable],
}

impl<'a> Material<'a> {
    /// Checks `properties` against `variables`, and against `optional` where they are given.
    ///
    /// # Errors
    /// All the faults of [`check`].
    pub fn new(
        properties: &'a Properties,
        options: &'a Options,
        variables: &'a [MaterialVariable],
        optional: &'a [MaterialVariable],
    ) -> Result<Self, Vec<Fault>> {
        let mut faults = check(properties, variables);
        let given = optional.iter().filter(|variable| properties.values.contains_key(variable.name));
        faults.extend(given.filter_map(|variable| fault_of(properties, *variable)));
        if faults.is_empty() { Ok(Self { properties, options, variables, optional }) } else { Err(faults) }
    }

    /// The value of a constant that the law declares.
    ///
    /// # Errors
    /// [`Fault::Undeclared`] for any other.
    pub fn get(&self, variable: MaterialVariable) -> Result<f64, Fault> {
        let declared = self.variables.iter().any(|other| other.name == variable.name);
        let value = self.properties.number(variable.name).filter(|_| declared);
        value.ok_or(Fault::Undeclared { name: variable.name })
    }

    /// The value of an optional constant that the law declares, if it is given.
    pub fn given(&self, variable: MaterialVariable) -> Option<f64> {
        let declared = self.optional.iter().any(|other| other.name == variable.name);
        self.properties.number(variable.name).filter(|_| declared)
    }

    /// Choices that hold for all materials.
    pub fn options(&self) -> &Options {
        self.options
    }
}

/// Everything that is wrong with `properties` for a law that takes `variables`, in their order.
/// Variables that the law does not take are not looked at: they may serve an element.
pub fn check(properties: &Properties, variables: &[MaterialVariable]) -> Vec<Fault> {
    variables.iter().filter_map(|variable| fault_of(properties, *variable)).collect()
}

fn fault_of(properties: &Properties, variable: MaterialVariable) -> Option<Fault> {
    let found = match properties.values.get(variable.name) {
        Some(Value::Number(value)) if value.is_finite() && variable.range.contains(*value) => return None,
        Some(Value::Number(value)) => return Some(Fault::OutOfRange { variable, value: *value }),
        None => return Some(Fault::Missing { variable }),
        Some(Value::Bool(truth)) => truth.to_string(),
        Some(Value::Text(text)) => format!("the text {text:?}"),
        Some(Value::Vector(_)) => "a vector".to_owned(),
        Some(Value::Matrix(_)) => "a matrix".to_owned(),
    };
    Some(Fault::WrongType { variable, found })
}

/// Lamé's parameters of an isotropic solid at small strain (Pa).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LameParameters {
    /// λ = E ν/((1 + ν)(1 − 2ν)).
    pub lambda: f64,
    /// μ = E/(2(1 + ν)), the shear modulus.
    pub mu: f64,
}

impl LameParameters {
    /// From [`YOUNG_MODULUS`] and [`POISSON_RATIO`].
    ///
    /// # Errors
    /// The law does not declare them, or λ is beyond the largest number.
    pub fn of(material: &Material) -> Result<Self, Fault> {
        let (young, poisson) = (material.get(YOUNG_MODULUS)?, material.get(POISSON_RATIO)?);
        let lame = Self::from_engineering(young, poisson);
        if lame.lambda.is_finite() && lame.mu.is_finite() {
            return Ok(lame);
        }
        Err(Fault::Inconsistent {
            problem: format!("YOUNG_MODULUS {young} and POISSON_RATIO {poisson} give an infinite stiffness"),
            advice: "use a smaller Young's modulus, or a Poisson's ratio farther from 0.5 and -1".to_owned(),
        })
    }

    /// From Young's modulus (Pa) and Poisson's ratio.
    pub fn from_engineering(young: f64, poisson: f64) -> Self {
        Self {
            lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
            mu: young / (2.0 * (1.0 + poisson)),
        }
    }

    /// λ* = 2λμ/(λ + 2μ) in the place of λ: Hooke's law in the plane of a solid without stress across.
    #[must_use]
    pub fn of_plane_stress(self) -> Self {
        let Self { lambda, mu } = self;
        Self { lambda: 2.0 * lambda * mu / (lambda + 2.0 * mu), mu }
    }

    /// Speed of pressure waves √((λ + 2μ)/ρ) (m/s); `density` in kg/m³.
    pub fn pressure_wave_speed(self, density: f64) -> f64 {
        ((self.lambda + 2.0 * self.mu) / density).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties(values: &[(&str, Value)]) -> Properties {
        Properties {
            values: values.iter().map(|(name, value)| ((*name).into(), value.clone())).collect(),
            ..Default::default()
        }
    }

    const ELASTIC: [MaterialVariable; 3] = [DENSITY, YOUNG_MODULUS, POISSON_RATIO];

    #[test]
    fn all_faults_are_listed_together() {
        let material =
            properties(&[("YOUNG_MODULUS", Value::Text("stiff".into())), ("POISSON_RATIO", Value::Number(0.5))]);
        let place = Place { pointer: Some("/properties/0/Material/Variables".into()), ..Place::default() };
        let shown: Vec<String> = check(&material, &ELASTIC).iter().map(|f| f.diagnostic(&place).to_string()).collect();
        assert_eq!(
            shown,
            [
                "/properties/0/Material/Variables: DENSITY is missing\n  expected: mass per volume of the undeformed \
                 material, a number > 0 [kg/m³]",
                "/properties/0/Material/Variables/YOUNG_MODULUS: YOUNG_MODULUS is the text \"stiff\", not a number\n  \
                 expected: Young's modulus at small strain, a number > 0 [Pa]",
                "/properties/0/Material/Variables/POISSON_RATIO: POISSON_RATIO is 0.5\n  expected: Poisson's ratio at \
                 small strain; 0.5 would be incompressible, a number > -1 and < 0.5 [-]",
            ]
        );
    }

    #[test]
    fn ends_of_ranges_and_non_finite_numbers_are_faults() {
        let good = [1000.0, 1e6, 0.3];
        let bad: [&[f64]; 3] =
            [&[0.0, -1.0, f64::NAN, f64::INFINITY], &[0.0, -2.0, f64::INFINITY], &[0.5, -1.0, 0.7, f64::NAN]];
        let with = |numbers: [f64; 3]| {
            let values: Vec<_> = (0..3).map(|i| (ELASTIC[i].name, Value::Number(numbers[i]))).collect();
            check(&properties(&values), &ELASTIC)
        };
        assert_eq!(with(good), []);
        for (variable, values) in bad.iter().enumerate() {
            for &value in *values {
                let mut numbers = good;
                numbers[variable] = value;
                let faults = with(numbers);
                assert_eq!(faults.len(), 1, "{faults:?}");
                assert!(faults[0].to_string().starts_with(ELASTIC[variable].name), "{faults:?}");
            }
        }
    }

    #[test]
    fn ranges_contain_what_they_say() {
        for (range, inside, outside) in [
            (Range::Any, -1e300, f64::INFINITY),
            (Range::Above(1.0), 1.5, 1.0),
            (Range::AtLeast(1.0), 1.0, 0.5),
            (Range::Below(0.0), -1.0, 0.0),
            (Range::Between(0.0, 1.0), 0.5, 1.0),
            (Range::AboveUpTo(0.0, 1.0), 1.0, 0.0),
        ] {
            assert!(range.contains(inside) && !range.contains(outside), "{range}");
        }
    }

    #[test]
    fn a_law_cannot_read_what_it_does_not_declare() {
        let material = properties(&[("DENSITY", Value::Number(1.0)), ("YOUNG_MODULUS", Value::Number(1.0))]);
        let checked = Material::new(&material, &Options::default(), &[DENSITY], &[]).map(|m| m.get(YOUNG_MODULUS));
        assert_eq!(checked, Ok(Err(Fault::Undeclared { name: "YOUNG_MODULUS" })));
    }

    #[test]
    fn moduli_in_range_can_still_overflow() {
        let material = properties(&[
            ("DENSITY", Value::Number(1.0)),
            ("YOUNG_MODULUS", Value::Number(1e300)),
            ("POISSON_RATIO", Value::Number(0.5 - 1e-16)),
        ]);
        let options = Options::default();
        let Ok(material) = Material::new(&material, &options, &ELASTIC, &[]) else { panic!("each is in range") };
        assert!(matches!(LameParameters::of(&material), Err(Fault::Inconsistent { .. })));
    }
}
