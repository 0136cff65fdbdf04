//! How the deformation gradient of an element is lifted to three dimensions, and which Voigt
//! components it takes back.

use std::fmt;

/// The kinematic assumption of an element. Laws see a 3×3 deformation gradient F in every case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kinematics {
    /// Coordinates x, y, z; F is full.
    ThreeDimensional,
    /// Coordinates x, y; no strain across the plane, F33 = 1.
    PlaneStrain,
    /// Coordinates x, y; no stress across the plane. F33 = 1 is handed over, and the law answers
    /// for a thickness that it finds itself (see [`crate::PlaneStress`]).
    PlaneStress,
    /// Coordinates r, z, θ in the places of x, y, z; F33 = r/R.
    Axisymmetric,
    /// Coordinate x alone; no strain across it, F22 = F33 = 1.
    UniaxialStrain,
}

impl Kinematics {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::ThreeDimensional, Self::PlaneStrain, Self::PlaneStress, Self::Axisymmetric, Self::UniaxialStrain];

    /// Indices, into the three-dimensional Voigt order xx, yy, zz, xy, yz, xz, of the components
    /// that an element of this kind has, in the element's own order.
    pub const fn voigt(self) -> &'static [usize] {
        match self {
            Self::ThreeDimensional => &[0, 1, 2, 3, 4, 5],
            Self::PlaneStrain | Self::PlaneStress => &[0, 1, 3],
            Self::Axisymmetric => &[0, 1, 2, 3],
            Self::UniaxialStrain => &[0],
        }
    }

    /// Names of the components of [`voigt`](Self::voigt); `t` is the hoop direction θ.
    pub const fn component_names(self) -> &'static [&'static str] {
        match self {
            Self::ThreeDimensional => &["xx", "yy", "zz", "xy", "yz", "xz"],
            Self::PlaneStrain | Self::PlaneStress => &["xx", "yy", "xy"],
            Self::Axisymmetric => &["rr", "zz", "tt", "rz"],
            Self::UniaxialStrain => &["xx"],
        }
    }

    /// Number of space coordinates, which is also the number of displacement components.
    pub const fn dimension(self) -> usize {
        match self {
            Self::ThreeDimensional => 3,
            Self::UniaxialStrain => 1,
            _ => 2,
        }
    }

    /// Name for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ThreeDimensional => "three-dimensional",
            Self::PlaneStrain => "plane strain",
            Self::PlaneStress => "plane stress",
            Self::Axisymmetric => "axisymmetric",
            Self::UniaxialStrain => "uniaxial strain",
        }
    }
}

impl fmt::Display for Kinematics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::VOIGT_PAIRS;

    /// An element of dimension d has every component of its plane; axisymmetry adds the hoop.
    #[test]
    fn components_are_those_of_the_elements_coordinates() {
        for kinematics in Kinematics::ALL {
            let expected: Vec<usize> = (0..6)
                .filter(|&component| {
                    let (a, b) = VOIGT_PAIRS[component];
                    let hoop = kinematics == Kinematics::Axisymmetric && (a, b) == (2, 2);
                    hoop || (a < kinematics.dimension() && b < kinematics.dimension())
                })
                .collect();
            assert_eq!(kinematics.voigt(), expected, "{kinematics}");
            assert_eq!(kinematics.component_names().len(), expected.len(), "{kinematics}");
        }
    }
}
