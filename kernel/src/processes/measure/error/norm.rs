//! Norms over entities, and how they are joined over the time.

use crate::io::checkpoint::{Archive, CheckpointError};

/// How errors are joined to one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Norm {
    /// Σ w |e|.
    L1,
    /// √(Σ w |e|²).
    L2,
    /// max |e|.
    Max,
    /// √(Σ w |e|² / Σ w).
    Rms,
}

impl Norm {
    const ALL: [(&'static str, Norm); 4] = [("L1", Norm::L1), ("L2", Norm::L2), ("max", Norm::Max), ("rms", Norm::Rms)];

    /// The norm of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, norm)| *norm)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, norm)| *norm == self).map_or("", |(name, _)| name)
    }

    /// Unit of the norm of a field with this unit; probes have no volume.
    pub fn unit(self, unit: &str, is_probe: bool) -> String {
        match self {
            Self::L1 if !is_probe => format!("{unit} m³"),
            Self::L2 if !is_probe => format!("{unit} √m³"),
            _ => unit.into(),
        }
    }
}

/// Sums over entities.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    weight: f64,
    absolute: f64,
    square: f64,
    /// Not a number once a value was.
    largest: f64,
}

impl Sums {
    /// Adds an entity's |e| ≥ 0 with its weight.
    pub fn add(&mut self, size: f64, weight: f64) {
        self.weight += weight;
        self.absolute += weight * size;
        self.square += weight * size * size;
        // An entity without weight, such as a node that no point reaches, does not count.
        if weight > 0.0 {
            self.largest = if size.is_nan() || self.largest.is_nan() { f64::NAN } else { self.largest.max(size) };
        }
    }

    /// The norm; not a number without entities.
    pub fn norm(&self, norm: Norm) -> f64 {
        match norm {
            _ if self.weight <= 0.0 => f64::NAN,
            Norm::L1 => self.absolute,
            Norm::L2 => self.square.sqrt(),
            Norm::Max => self.largest,
            Norm::Rms => (self.square / self.weight).sqrt(),
        }
    }
}

/// The norms of the error and of the reference over the times measured so far: last, largest, sum, sum of
/// squares of each.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OverTime {
    count: f64,
    error: [f64; 4],
    reference: [f64; 4],
}

/// Takes another time into account.
fn take([_, largest, sum, square]: [f64; 4], x: f64) -> [f64; 4] {
    let largest = if x.is_nan() || largest.is_nan() { f64::NAN } else { largest.max(x) };
    [x, largest, sum + x, square + x * x]
}

impl OverTime {
    /// Adds the norms at a time.
    pub fn add(&mut self, error: f64, reference: f64) {
        self.count += 1.0;
        self.error = take(self.error, error);
        self.reference = take(self.reference, reference);
    }

    /// Named numbers for the summary; relative ones are not a number where the reference is zero.
    pub fn numbers(&self, norm: Norm) -> [(&'static str, f64); 6] {
        let joined = |[_, largest, sum, square]: [f64; 4]| match norm {
            Norm::L1 => sum / self.count,
            Norm::L2 | Norm::Rms => (square / self.count).sqrt(),
            Norm::Max => largest,
        };
        let nothing = |x: f64| if self.count > 0.0 { x } else { f64::NAN };
        let (error, reference) = (self.error, self.reference);
        [
            ("at_end", nothing(error[0])),
            ("largest", nothing(error[1])),
            ("over_time", joined(error)),
            ("relative_at_end", error[0] / reference[0]),
            ("relative_largest", error[1] / reference[1]),
            ("relative_over_time", joined(error) / joined(reference)),
        ]
    }

    /// Saves or loads all of it.
    ///
    /// # Errors
    /// The checkpoint does not fit.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.number("count", &mut self.count)?;
        archive.slice("error", &mut self.error)?;
        archive.slice("reference", &mut self.reference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_are_those_of_the_definitions() {
        let mut sums = Sums::default();
        for (size, weight) in [(3.0, 1.0), (4.0, 3.0), (9.0, 0.0)] {
            sums.add(size, weight);
        }
        assert_eq!([Norm::L1, Norm::Max].map(|norm| sums.norm(norm)), [15.0, 4.0]);
        assert_eq!(sums.norm(Norm::L2), 57.0_f64.sqrt());
        assert_eq!(sums.norm(Norm::Rms), (57.0_f64 / 4.0).sqrt());
        sums.add(f64::NAN, 1.0);
        assert!([Norm::L1, Norm::L2, Norm::Max, Norm::Rms].iter().all(|norm| sums.norm(*norm).is_nan()));
        assert!(Sums::default().norm(Norm::Max).is_nan(), "nothing is no error of 0");
    }

    #[test]
    fn times_are_joined_as_the_norm_says() {
        let mut over = OverTime::default();
        for (error, reference) in [(1.0, 2.0), (7.0, 10.0), (5.0, 4.0)] {
            over.add(error, reference);
        }
        let value = |norm: Norm, name: &str| over.numbers(norm).iter().find(|(n, _)| *n == name).unwrap().1;
        assert_eq!(value(Norm::Rms, "at_end"), 5.0);
        assert_eq!(value(Norm::Rms, "over_time"), 5.0, "√(75/3)");
        assert_eq!(value(Norm::Rms, "relative_over_time"), 5.0 / 40.0_f64.sqrt());
        assert_eq!(value(Norm::L1, "over_time"), 13.0 / 3.0);
        assert_eq!(value(Norm::Max, "relative_largest"), 0.7);
        assert_eq!(value(Norm::Max, "relative_at_end"), 1.25);
    }
}
