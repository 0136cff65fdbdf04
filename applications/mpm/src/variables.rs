//! The variables of the material point method, with Kratos's names.

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
    vector DISPLACEMENT, "m", "displacement of a grid node in this step";
    vector VELOCITY, "m/s", "velocity of a grid node";
    vector ACCELERATION, "m/s²", "acceleration of a grid node";
    vector REACTION, "N", "force that holds a fixed grid node";
    vector NORMAL, "m or m²", "normal of the walls at a grid node, as long as its share of them";
    scalar NODAL_MASS, "kg", "mass gathered on a grid node";
    scalar PRESSURE, "Pa", "mean stress of a grid node, tension positive";
    scalar PRESSURE_REACTION, "m³", "change of volume that holds a fixed pressure of a grid node";
    vector MP_COORD, "m", "position of a material point";
    vector MP_DISPLACEMENT, "m", "displacement of a material point";
    vector MP_VELOCITY, "m/s", "velocity of a material point";
    vector MP_ACCELERATION, "m/s²", "acceleration of a material point";
    vector MP_VOLUME_ACCELERATION, "m/s²", "body force per mass of a material point";
    vector MP_BODY_ACCELERATION, "m/s²", "part of the body force per mass that functions give";
    voigt MP_CAUCHY_STRESS_VECTOR, "Pa", "Cauchy stress of a material point";
    voigt MP_ALMANSI_STRAIN_VECTOR, "1",
        "Euler-Almansi strain of a material point, or the strain that its law accumulates";
    voigt MP_GREEN_LAGRANGE_STRAIN_VECTOR, "1", "Green-Lagrange strain of a material point";
    voigt MP_HENCKY_STRAIN_VECTOR, "1", "logarithmic strain of a material point, in the deformed body's axes";
    voigt MP_PK2_STRESS_VECTOR, "Pa", "second Piola-Kirchhoff stress of a material point";
    tensor MP_PK1_STRESS_TENSOR, "Pa", "first Piola-Kirchhoff stress of a material point";
    scalar MP_EQUIVALENT_STRESS, "Pa", "von Mises stress of a material point";
    scalar MP_MEAN_STRESS, "Pa", "mean of the normal Cauchy stresses of a material point, tension positive";
    tensor MP_DEFORMATION_GRADIENT, "1", "deformation gradient of a material point";
    scalar MP_DETERMINANT_F, "1", "volume ratio of a material point";
    scalar MP_MASS, "kg", "mass of a material point";
    scalar MP_VOLUME, "m³", "volume of a material point";
    scalar MP_DENSITY, "kg/m³", "density of a material point";
    scalar MP_PRESSURE, "Pa", "mean stress of a material point from the nodes, tension positive";
    scalar MP_MATERIAL_ID, "1", "id of the properties of a material point";
    scalar MP_POTENTIAL_ENERGY, "J", "potential energy of a material point";
    scalar MP_KINETIC_ENERGY, "J", "kinetic energy of a material point";
    scalar MP_STRAIN_ENERGY, "J", "strain energy of a material point, by its law";
    scalar MP_TOTAL_ENERGY, "J", "sum of the energies of a material point";
    scalar MP_STRAIN_ENERGY_DENSITY, "J/m³", "strain energy of a material point per volume before deformation";
    vector MPC_COORD, "m", "position of a material-point condition";
    vector MPC_DISPLACEMENT, "m", "displacement of a material-point condition";
    vector MPC_VELOCITY, "m/s", "velocity of a material-point condition";
    vector MPC_ACCELERATION, "m/s²", "acceleration of a material-point condition";
    vector MPC_NORMAL, "1", "normal of a material-point condition";
    scalar MPC_AREA, "m²", "area of a material-point condition";
}

/// Registers them.
pub fn register(registry: &mut Registry) {
    bia_kernel::solving::loads::register(registry);
    for variable in ALL {
        registry.variable(*variable);
    }
}
