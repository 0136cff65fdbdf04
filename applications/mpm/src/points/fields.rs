//! The variables that material points and their conditions can show, and what each costs.

use super::block::{Block, Columns, MaterialPoints, Selection};
use super::conditions::PointConditions;
use super::measures;
use bia_constitutive::Deformation;
use bia_constitutive::tensor::{almansi_strain, green_lagrange_strain, strain_to_voigt};
use nalgebra::Matrix3;

/// Variables of points with the columns they need.
const POINT_VARIABLES: &[(&str, Columns)] = &[
    ("MP_COORD", NONE),
    ("MP_DISPLACEMENT", Columns { displacement: true, ..NONE }),
    ("MP_VELOCITY", VELOCITY),
    ("MP_ACCELERATION", Columns { acceleration: true, ..NONE }),
    ("MP_VOLUME_ACCELERATION", NONE),
    // Its functions may depend on the initial position, hence the displacement.
    (BODY_ACCELERATION, Columns { body_acceleration: true, displacement: true, ..NONE }),
    ("MP_CAUCHY_STRESS_VECTOR", STRESS),
    ("MP_PK1_STRESS_TENSOR", STRESS),
    ("MP_PK2_STRESS_VECTOR", STRESS),
    ("MP_EQUIVALENT_STRESS", STRESS),
    ("MP_MEAN_STRESS", STRESS),
    ("MP_ALMANSI_STRAIN_VECTOR", Columns { strain: true, ..NONE }),
    ("MP_GREEN_LAGRANGE_STRAIN_VECTOR", NONE),
    ("MP_HENCKY_STRAIN_VECTOR", NONE),
    ("MP_DEFORMATION_GRADIENT", NONE),
    ("MP_DETERMINANT_F", NONE),
    ("MP_MASS", NONE),
    ("MP_VOLUME", Columns { volume: true, ..NONE }),
    ("MP_DENSITY", Columns { volume: true, ..NONE }),
    ("MP_PRESSURE", Columns { pressure: true, ..NONE }),
    ("MP_MATERIAL_ID", NONE),
    ("MP_POTENTIAL_ENERGY", NONE),
    ("MP_KINETIC_ENERGY", KINETIC_ENERGY),
    ("MP_STRAIN_ENERGY", Columns { strain_energy: true, ..NONE }),
    ("MP_TOTAL_ENERGY", ENERGY),
    ("MP_STRAIN_ENERGY_DENSITY", Columns { strain_energy: true, ..NONE }),
];
/// Variable of the column that holds body accelerations given as functions.
pub const BODY_ACCELERATION: &str = "MP_BODY_ACCELERATION";
const NONE: Columns = Columns {
    displacement: false,
    velocity: false,
    acceleration: false,
    local: false,
    stress: false,
    strain: false,
    strain_energy: false,
    volume: false,
    pressure: false,
    body_acceleration: false,
    transfer: 0,
    affine: false,
    kinetic_energy: false,
};
const VELOCITY: Columns = Columns { velocity: true, ..NONE };
const KINETIC_ENERGY: Columns = Columns { kinetic_energy: true, ..VELOCITY };
const STRESS: Columns = Columns { stress: true, ..NONE };
/// What the energies need.
pub const ENERGY: Columns = Columns { strain_energy: true, ..KINETIC_ENERGY };
/// What the account of a run shows.
pub const RECORD: Columns = Columns {
    displacement: true,
    velocity: true,
    acceleration: true,
    stress: true,
    strain: true,
    strain_energy: true,
    volume: true,
    kinetic_energy: true,
    ..NONE
};

/// Variables of material-point conditions.
pub const CONDITION_VARIABLES: &[&str] =
    &["MPC_COORD", "MPC_DISPLACEMENT", "MPC_VELOCITY", "MPC_ACCELERATION", "MPC_NORMAL", "MPC_AREA", "POINT_LOAD"];

/// Names of the variables that points can show, in mixed formulations alone or not.
pub fn names_of(mixed: bool) -> Vec<&'static str> {
    POINT_VARIABLES.iter().filter(|(_, columns)| columns.pressure == mixed).map(|(name, _)| *name).collect()
}

/// Names of the variables that points can show.
pub fn names() -> impl Iterator<Item = &'static str> {
    POINT_VARIABLES.iter().map(|(name, _)| *name)
}

/// Columns that a variable needs; none if points do not have it.
pub fn columns_of(variable: &str) -> Option<Columns> {
    POINT_VARIABLES.iter().find(|(name, _)| *name == variable).map(|(_, columns)| *columns)
}

impl Columns {
    /// The columns of both.
    #[must_use]
    pub const fn or(self, other: Columns) -> Columns {
        Columns {
            displacement: self.displacement || other.displacement,
            velocity: self.velocity || other.velocity,
            acceleration: self.acceleration || other.acceleration,
            local: self.local || other.local,
            stress: self.stress || other.stress,
            strain: self.strain || other.strain,
            strain_energy: self.strain_energy || other.strain_energy,
            volume: self.volume || other.volume,
            pressure: self.pressure || other.pressure,
            body_acceleration: self.body_acceleration || other.body_acceleration,
            transfer: if self.transfer > other.transfer { self.transfer } else { other.transfer },
            affine: self.affine || other.affine,
            kinetic_energy: self.kinetic_energy || other.kinetic_energy,
        }
    }
}

/// Body force per mass with a zero third component in the plane, as Kratos shows it.
fn body_acceleration(block: &Block, point: usize) -> [f64; 3] {
    let own = block.body_acceleration.row(point);
    std::array::from_fn(|a| block.gravity[a] + own.get(a).copied().unwrap_or(0.0))
}

/// The values of a variable at a point, appended to `out`; false if points do not have it.
pub fn append(block: &Block, point: usize, variable: &str, out: &mut Vec<f64>) -> bool {
    let vector = |row: &[f64], out: &mut Vec<f64>| out.extend((0..3).map(|i| row.get(i).copied().unwrap_or(0.0)));
    let gradient = || block.deformation_gradient(point);
    let strain = |of: fn(&Matrix3<f64>) -> Matrix3<f64>, out: &mut Vec<f64>| {
        measures::append_voigt(block, &strain_to_voigt(&of(&gradient())), out);
    };
    match variable {
        "MP_COORD" => vector(block.position.row(point), out),
        "MP_DISPLACEMENT" => vector(block.displacement.row(point), out),
        "MP_VELOCITY" => vector(block.velocity.row(point), out),
        "MP_ACCELERATION" => vector(block.acceleration.row(point), out),
        "MP_VOLUME_ACCELERATION" => vector(&body_acceleration(block, point), out),
        BODY_ACCELERATION => vector(block.body_acceleration.row(point), out),
        "MP_CAUCHY_STRESS_VECTOR" => out.extend(block.stress.row(point)),
        "MP_PK1_STRESS_TENSOR" => {
            let stress = measures::cauchy_stress(block, point);
            measures::full(&measures::first_piola_kirchhoff(&stress, &gradient()), out);
        }
        "MP_PK2_STRESS_VECTOR" => {
            let stress = measures::cauchy_stress(block, point);
            measures::symmetric(block, &measures::second_piola_kirchhoff(&stress, &gradient()), out);
        }
        "MP_EQUIVALENT_STRESS" => out.push(measures::von_mises(&measures::cauchy_stress(block, point))),
        "MP_MEAN_STRESS" => out.push(measures::cauchy_stress(block, point).trace() / 3.0),
        "MP_STRAIN_ENERGY_DENSITY" => {
            out.push(energies(block, point).strain * block.density / block.mass.row(point)[0]);
        }
        "MP_ALMANSI_STRAIN_VECTOR" if block.strain.is_used() => out.extend(block.strain.row(point)),
        "MP_ALMANSI_STRAIN_VECTOR" => strain(almansi_strain, out),
        "MP_GREEN_LAGRANGE_STRAIN_VECTOR" => strain(green_lagrange_strain, out),
        "MP_HENCKY_STRAIN_VECTOR" => strain(measures::hencky_strain, out),
        "MP_DEFORMATION_GRADIENT" => measures::full(&gradient(), out),
        "MP_DETERMINANT_F" => out.push(gradient().determinant()),
        "MP_MASS" => out.extend(block.mass.row(point)),
        "MP_VOLUME" => out.extend(block.volume.row(point)),
        "MP_DENSITY" => out.push(block.mass.row(point)[0] / block.volume.row(point)[0]),
        "MP_PRESSURE" => out.extend(block.pressure.row(point)),
        "MP_MATERIAL_ID" => out.push(f64::from(block.material)),
        "MP_POTENTIAL_ENERGY" => out.push(energies(block, point).potential),
        "MP_KINETIC_ENERGY" => out.push(energies(block, point).kinetic),
        "MP_STRAIN_ENERGY" => out.push(energies(block, point).strain),
        "MP_TOTAL_ENERGY" => out.push(energies(block, point).total()),
        _ => return false,
    }
    true
}

/// The values of a variable at a condition, appended to `out`; false if conditions do not have it.
pub fn append_condition(conditions: &PointConditions, index: usize, variable: &str, out: &mut Vec<f64>) -> bool {
    match variable {
        "MPC_COORD" => out.extend(conditions.position[index]),
        "MPC_DISPLACEMENT" => out.extend(conditions.displacement[index]),
        "MPC_VELOCITY" => out.extend(conditions.velocity[index]),
        // Kratos never updates it.
        "MPC_ACCELERATION" => out.extend([0.0; 3]),
        "MPC_NORMAL" => out.extend(conditions.normal[index]),
        "MPC_AREA" => out.push(conditions.area[index]),
        "POINT_LOAD" => out.extend(conditions.load[index]),
        _ => return false,
    }
    true
}

/// Energies in joules.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    /// Σ m |g| x, componentwise as in Kratos; gravity alone has a potential.
    pub potential: f64,
    /// ½ m v², and the energy of an affine part of the velocity.
    pub kinetic: f64,
    /// V₀ W with the energy W per reference volume of the law, or ½ V σ:ε ([`Block::has_energy`]).
    pub strain: f64,
}

impl Energies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.potential + self.kinetic + self.strain
    }
}

/// Energies of a point; those whose columns are not used are zero.
pub fn energies(block: &Block, point: usize) -> Energies {
    let mass = block.mass.row(point)[0];
    let position = block.position.row(point);
    let velocity = block.velocity.row(point);
    let affine = block.affine_energy.row(point).first().copied().unwrap_or(0.0);
    Energies {
        potential: position.iter().zip(block.gravity).map(|(x, g)| mass * g.abs() * x).sum(),
        kinetic: mass * (0.5 * velocity.iter().map(|v| v * v).sum::<f64>() + affine),
        strain: strain_energy(block, point),
    }
}

/// Strain energy of a point in J; zero where neither the law nor the columns tell it.
fn strain_energy(block: &Block, point: usize) -> f64 {
    if block.has_energy {
        let mut deformation = Deformation::from_gradient(block.deformation_gradient(point));
        deformation.pressure = block.pressure_of(point);
        let density = block.law.energy(&deformation).unwrap_or(f64::NAN);
        return block.mass.row(point)[0] / block.density * density;
    }
    let work: f64 = block.stress.row(point).iter().zip(block.strain.row(point)).map(|(s, e)| s * e).sum();
    let volume = if block.volume.is_used() { block.volume.row(point)[0] } else { 0.0 };
    0.5 * volume * work
}

/// Energies of the selected points, summed in the order of their ids.
pub fn total_energies(points: &MaterialPoints, selection: Selection) -> Energies {
    let mut sum = Energies::default();
    for block in points.blocks.iter().filter(|block| selection.holds(block.body)) {
        for point in block.in_order_of_id() {
            let of_point = energies(block, point as usize);
            sum.potential += of_point.potential;
            sum.kinetic += of_point.kinetic;
            sum.strain += of_point.strain;
        }
    }
    sum
}
