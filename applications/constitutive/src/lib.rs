//! Constitutive laws, each written once in three dimensions and shared by all applications.
//!
//! A law's author implements [`ConstitutiveLaw`]: constants in, Cauchy stress and spatial tangent
//! out. Elements see the object-safe [`Law`], one dynamic call per batch of points; a blanket
//! implementation joins the two. [`Kinematics`] picks the components that a plane or axisymmetric
//! element needs from the three-dimensional answer. The [`Catalogue`] finds a law by the name that
//! stands in a materials file and checks the material's constants.
//!
//! Voigt order throughout: xx, yy, zz, xy, yz, xz. SI units.

mod body_material;
mod catalogue;
mod error;
mod hypoelastic;
mod kinematics;
mod kirchhoff_bar;
mod law;
mod linear_elastic;
mod material;
mod mixed;
mod neo_hookean;
mod neo_hookean_mixed;
mod newtonian;
mod newtonian_mixed;
mod nominal_elastic;
mod plane_stress;
mod solutions;
pub mod tensor;
pub mod verify;

pub use body_material::{BodyMaterial, BuiltLaw, MATERIAL_IMPORT, MaterialSource};
pub use catalogue::{Build, Catalogue, DuplicateLaw, LawEntry, MaterialPlaces, catalogue, register};
pub use error::LawError;
pub use hypoelastic::Hypoelastic;
pub use kinematics::Kinematics;
pub use kirchhoff_bar::KirchhoffBar;
use law::mixed_pressure;
pub use law::{ConstitutiveLaw, Deformation, Group, Law, Response, Want};
pub use linear_elastic::{LinearElastic, LinearElasticPlaneStress};
pub use material::{
    DENSITY, Fault, LameParameters, Material, MaterialVariable, Options, POISSON_RATIO, Range, YOUNG_MODULUS, check,
};
pub use mixed::{MixedModuli, Shear, VolumetricLaw};
pub use neo_hookean::NeoHookean;
pub use neo_hookean_mixed::NeoHookeanMixed;
pub use newtonian::{BULK_MODULUS, DYNAMIC_VISCOSITY, NewtonianFluid};
pub use newtonian_mixed::NewtonianFluidMixed;
pub use nominal_elastic::NominalElastic;
pub use plane_stress::PlaneStress;
pub use tensor::{Tangent, Voigt};

#[cfg(test)]
mod tests;
