//! Exact solutions of bodies under simple loads, as reference solutions that projects name.
//!
//! All but the motion of a rigid body are functions of one initial coordinate s and the time; s grows from
//! `origin` along `axis`, or against it with `reversed`. Displacements and velocities are along `axis` unless
//! the solution says otherwise; stresses are Cauchy's along the axis, positive in tension.

mod bar;
mod rigid;
mod simple_wave;
mod standing_wave;
mod weight;

use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::reference::{Compared, Place, ReferenceSolution, References};
use bia_kernel::registry::Registry;
use bia_kernel::variables::Rank;

/// Registers the solutions; several applications may do so.
pub fn register(registry: &mut Registry) {
    let references = registry.catalogue_mut::<References>();
    for entry in [bar::ENTRY, standing_wave::ENTRY, weight::ENTRY, simple_wave::ENTRY, rigid::ENTRY] {
        references.add(entry);
    }
}

/// Where a solution of one coordinate stands in space.
const LINE: [Key; 3] = [
    Key::new("axis", Kind::Choice(&["X", "Y", "Z"]), "\"X\"", "axis along which the solution goes"),
    Key::new("origin", Kind::Number(Range::ANY), "0.0", "coordinate on the axis where s is 0 [m]"),
    Key::new("reversed", Kind::Bool, "false", "s grows against the axis"),
];

/// What is asked of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Field {
    Displacement,
    Velocity,
    Stress,
}

impl Field {
    /// The field of a variable, such as `MP_VELOCITY` or `DISPLACEMENT_X`.
    fn of(compared: &Compared) -> Option<Self> {
        let name = compared.variable.name;
        match name.strip_prefix("MP_").unwrap_or(name) {
            "DISPLACEMENT" => Some(Self::Displacement),
            "VELOCITY" => Some(Self::Velocity),
            // The mean stress of what has no shear.
            "PRESSURE" | "CAUCHY_STRESS_VECTOR" | "PK1_STRESS_TENSOR" => Some(Self::Stress),
            _ => None,
        }
    }
}

/// A solution of one coordinate: displacement (m), velocity (m/s) and stress (Pa) along the axis.
trait LineSolution: Send {
    /// The field at s (m) and time t (s); stress is not a number where the solution gives none.
    fn value(&self, field: Field, s: f64, t: f64) -> f64;
}

/// A [`LineSolution`] in space.
struct Line<S> {
    solution: S,
    field: Field,
    axis: usize,
    /// Along which displacement and velocity point.
    direction: usize,
    origin: f64,
    /// +1, or −1 where s grows against the axis.
    sign: f64,
    /// All components of a vector; else the one number.
    is_vector: bool,
}

impl<S: LineSolution + 'static> Line<S> {
    /// Puts a solution into space. `direction` is that of the displacement if it is not the axis.
    fn build(
        settings: &Settings,
        compared: &Compared,
        solution: S,
        direction: Option<usize>,
    ) -> Result<Box<dyn ReferenceSolution>, InputErrors> {
        let axes = ["X", "Y", "Z"];
        let axis = axes.iter().position(|axis| *axis == settings.text("axis")).unwrap_or(0);
        let direction = direction.unwrap_or(axis);
        let refused = |message: String, help: &str| Err(settings.parameters().error(message).help(help).into());
        let Some(field) = Field::of(compared) else {
            return refused(
                format!("this solution does not give {compared}"),
                "it gives displacements, velocities and stresses along its axis",
            );
        };
        let normal = format!("{0}{0}", axes[axis]);
        let fits = match (compared.variable.rank, compared.component.as_deref()) {
            (Rank::Vector, None) | (Rank::Scalar, _) => true,
            (Rank::Vector, Some(component)) => component == axes[direction],
            (_, component) => direction == axis && component == Some(normal.as_str()),
        };
        if !fits {
            let help = match compared.variable.rank {
                Rank::Vector => format!("compare the whole vector, or its component {}", axes[direction]),
                _ => format!("compare the component {normal}"),
            };
            return refused(format!("this solution does not give {compared}"), &help);
        }
        let is_vector = compared.variable.rank == Rank::Vector && compared.component.is_none();
        let sign = if settings.flag("reversed") { -1.0 } else { 1.0 };
        let origin = settings.number("origin");
        Ok(Box::new(Self { solution, field, axis, direction, origin, sign, is_vector }))
    }
}

impl<S: LineSolution> ReferenceSolution for Line<S> {
    fn append(&self, place: &Place, out: &mut Vec<f64>) {
        let s = self.sign * (place.initial[self.axis] - self.origin);
        let value = self.solution.value(self.field, s, place.time);
        // A motion along s points against a reversed axis; across the axis it stays, and so does a stress.
        let turns = self.field != Field::Stress && self.direction == self.axis;
        let value = if turns { self.sign * value } else { value };
        match self.is_vector {
            true => out.extend((0..3).map(|a| if a == self.direction { value } else { 0.0 })),
            false => out.push(value),
        }
    }
}

#[cfg(test)]
mod tests;
