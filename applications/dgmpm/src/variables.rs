//! The variables of the method, with Kratos's names where Kratos has them.

use bia_kernel::registry::Registry;
use bia_kernel::variables::Variable;

/// Declares the constants and the list of all of them.
macro_rules! variables {
    ($($rank:ident $name:ident, $unit:literal, $help:literal;)*) => {
        $(#[doc = concat!($help, " [", $unit, "].")]
        pub const $name: Variable = Variable::$rank(stringify!($name), $unit, $help);)*

        /// All of them.
        pub const ALL: &[Variable] = &[$($name),*];
    };
}

variables! {
    vector DISPLACEMENT, "m", "displacement of a boundary node, or mean over a cell's points";
    vector VELOCITY, "m/s", "velocity of a boundary node, or mean over a cell's points";
    vector VOLUME_ACCELERATION, "m/s²", "body force per mass";
    voigt CAUCHY_STRESS_VECTOR, "Pa", "Cauchy stress, mean over a cell's points";
    tensor DEFORMATION_GRADIENT, "1", "deformation gradient, mean over a cell's points";
    vector MP_COORD, "m", "position of a material point";
    vector MP_DISPLACEMENT, "m", "displacement of a material point";
    vector MP_VELOCITY, "m/s", "velocity of a material point";
    voigt MP_CAUCHY_STRESS_VECTOR, "Pa", "Cauchy stress of a material point";
    tensor MP_PK1_STRESS_TENSOR, "Pa", "first Piola-Kirchhoff stress of a material point";
    tensor MP_DEFORMATION_GRADIENT, "1", "deformation gradient of a material point";
    scalar MP_EQUIVALENT_STRESS, "Pa", "von Mises stress of a material point";
    scalar MP_MEAN_STRESS, "Pa", "mean of the normal Cauchy stresses of a material point, tension positive";
    scalar MP_STRAIN_ENERGY_DENSITY, "J/m³", "strain energy of a material point per volume before deformation";
    scalar MP_MASS, "kg", "mass of a material point";
    scalar MP_DETERMINANT_F, "1", "volume ratio of a material point";
    scalar MP_VOLUME, "m³", "volume of a material point at the start";
    scalar MP_MATERIAL_ID, "1", "id of the properties of a material point";
}

/// Registers them, and those of loads.
pub fn register(registry: &mut Registry) {
    bia_kernel::solving::loads::register(registry);
    ALL.iter().for_each(|variable| registry.variable(*variable));
}
