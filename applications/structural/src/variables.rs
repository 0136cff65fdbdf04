//! The variables of structural mechanics, with Kratos's names.

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
    vector DISPLACEMENT, "m", "displacement of a node since the start";
    vector VELOCITY, "m/s", "velocity of a node";
    vector ACCELERATION, "m/s²", "acceleration of a node";
    vector REACTION, "N", "force that holds a fixed node";
    vector VOLUME_ACCELERATION, "m/s²", "body force per mass";
    voigt CAUCHY_STRESS_VECTOR, "Pa", "Cauchy stress, mean over an element's points";
    voigt PK2_STRESS_VECTOR, "Pa", "second Piola-Kirchhoff stress, mean over an element's points";
    scalar VON_MISES_STRESS, "Pa", "von Mises stress, mean over an element's points";
    scalar MEAN_STRESS, "Pa", "mean of the normal Cauchy stresses, tension positive, mean over an element's points";
    scalar DETERMINANT_F, "1", "volume ratio, mean over an element's points";
    scalar STRAIN_ENERGY_DENSITY, "J/m³", "strain energy per volume before deformation, mean over an element's points";
    voigt GREEN_LAGRANGE_STRAIN_VECTOR, "1", "Green-Lagrange strain, shear doubled, mean over an element's points";
}

/// Registers them, and those of loads.
pub fn register(registry: &mut Registry) {
    bia_kernel::solving::loads::register(registry);
    ALL.iter().for_each(|variable| registry.variable(*variable));
}
