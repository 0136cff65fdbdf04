//! When Newton's method has converged.

use super::ActiveDofs;
use std::ops::Range;

/// Relative and absolute bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Bound of the norm relative to its reference.
    pub relative: f64,
    /// Bound of the scaled norm itself.
    pub absolute: f64,
}

impl Tolerances {
    fn met(&self, ratio: f64, absolute: f64) -> bool {
        ratio <= self.relative || absolute < self.absolute
    }
}

/// A convergence criterion, with Kratos's formulas (spec 03 §6).
#[derive(Debug, Clone, PartialEq)]
pub enum Criterion {
    /// The residual after the correction, relative to the one at the start of the step; its
    /// absolute form is divided by the number of free dofs.
    Residual(Tolerances),
    /// The correction relative to the unknowns; its absolute form is divided by the square root
    /// of the number of free dofs.
    Displacement(Tolerances),
    /// Both.
    And(Tolerances, Tolerances),
    /// One of both (displacement, residual).
    Or(Tolerances, Tolerances),
}

impl Criterion {
    /// Whether the residual must be built again after each correction.
    pub fn needs_residual(&self) -> bool {
        !matches!(self, Criterion::Displacement(_))
    }

    /// Judges one iteration. `initial` is the norm of the residual at the start of the step; `round_off` of
    /// each dof is what its residual may be by round-off alone, below which no residual is asked to be. It is
    /// empty while the residual still falls.
    pub fn met(&self, dofs: &ActiveDofs, initial: f64, round_off: &[f64], vectors: [&[f64]; 3]) -> bool {
        let [residual, correction, values] = vectors;
        let by_residual = |tolerances: &Tolerances| {
            let now = free_norm(dofs, residual);
            let ratio = if initial == 0.0 { 0.0 } else { now / initial };
            tolerances.met(ratio, now / dofs.free().max(1) as f64)
                || at_round_off(dofs, &(0..dofs.block()), residual, round_off)
        };
        let by_displacement = |tolerances: &Tolerances| {
            let step = free_norm(dofs, correction);
            let size = free_norm(dofs, values);
            let ratio = if step == 0.0 { 0.0 } else { step / if size == 0.0 { step } else { size } };
            tolerances.met(ratio, step / (dofs.free().max(1) as f64).sqrt())
        };
        match self {
            Criterion::Residual(r) => by_residual(r),
            Criterion::Displacement(d) => by_displacement(d),
            Criterion::And(d, r) => by_displacement(d) && by_residual(r),
            Criterion::Or(d, r) => by_displacement(d) || by_residual(r),
        }
    }
}

/// Dofs of one kind, judged apart: forces and volumes, say, have units that cannot be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Their components among those of a node.
    pub components: Range<usize>,
    /// What their residual is measured by.
    pub reference: Reference,
}

/// What the residual of a field is measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference {
    /// Its norm at the start of the step, or the absolute tolerances.
    First,
    /// Its largest norm in the step so far: a constraint that holds at the start has no residual
    /// there. No less than 1e-10 of this scale counts, and 1e-15 of it is round-off.
    Largest(f64),
}

/// References of the fields in one step.
#[derive(Debug, Clone, Default)]
pub struct References {
    values: Vec<f64>,
}

impl References {
    /// Takes note of a residual of the step.
    pub fn note(&mut self, fields: &[Field], dofs: &ActiveDofs, residual: &[f64]) {
        let is_first = self.values.is_empty();
        self.values.resize(fields.len(), 0.0);
        for (value, field) in self.values.iter_mut().zip(fields) {
            let norm = || field_norm(dofs, &field.components, residual).0;
            match field.reference {
                Reference::First if is_first => *value = norm(),
                Reference::First => {}
                Reference::Largest(scale) => *value = value.max(norm()).max(1e-10 * scale),
            }
        }
    }
}

impl Criterion {
    /// As [`met`](Self::met), each field apart.
    pub fn met_by_fields(
        &self,
        fields: &[Field],
        references: &References,
        dofs: &ActiveDofs,
        round_off: &[f64],
        [residual, correction, values]: [&[f64]; 3],
    ) -> bool {
        let by_residual = |tolerances: &Tolerances| {
            fields.iter().zip(&references.values).all(|(field, reference)| {
                let (now, count) = field_norm(dofs, &field.components, residual);
                match field.reference {
                    Reference::First if *reference == 0.0 => true,
                    Reference::First => {
                        tolerances.met(now / reference, now / count.max(1) as f64)
                            || at_round_off(dofs, &field.components, residual, round_off)
                    }
                    Reference::Largest(scale) => now <= (tolerances.relative * reference).max(1e-15 * scale),
                }
            })
        };
        let by_displacement = |tolerances: &Tolerances| {
            fields.iter().all(|field| {
                let (step, count) = field_norm(dofs, &field.components, correction);
                let size = field_norm(dofs, &field.components, values).0;
                let ratio = if step == 0.0 { 0.0 } else { step / if size == 0.0 { step } else { size } };
                let is_first = field.reference == Reference::First;
                let absolute = if is_first { step / (count.max(1) as f64).sqrt() } else { f64::INFINITY };
                tolerances.met(ratio, absolute)
            })
        };
        match self {
            Criterion::Residual(r) => by_residual(r),
            Criterion::Displacement(d) => by_displacement(d),
            Criterion::And(d, r) => by_displacement(d) && by_residual(r),
            Criterion::Or(d, r) => by_displacement(d) || by_residual(r),
        }
    }
}

/// Whether each free dof of these components has at most the residual that round-off leaves. Each by itself:
/// what a stiff one may have hides all that a soft one has.
fn at_round_off(dofs: &ActiveDofs, components: &Range<usize>, residual: &[f64], round_off: &[f64]) -> bool {
    let block = dofs.block().max(1);
    let mut free =
        dofs.fixed().iter().enumerate().filter(|(dof, fixed)| !**fixed && components.contains(&(dof % block)));
    !round_off.is_empty() && free.all(|(dof, _)| residual[dof].abs() <= round_off[dof])
}

/// Euclidean norm over the free dofs of these components, and their number.
fn field_norm(dofs: &ActiveDofs, components: &Range<usize>, vector: &[f64]) -> (f64, usize) {
    let block = dofs.block().max(1);
    let (mut sum, mut count) = (0.0, 0);
    for (values, fixed) in vector.chunks_exact(block).zip(dofs.fixed().chunks_exact(block)) {
        for a in components.clone().filter(|&a| !fixed[a]) {
            sum += values[a] * values[a];
            count += 1;
        }
    }
    (sum.sqrt(), count)
}

/// Euclidean norm over the free dofs.
pub fn free_norm(dofs: &ActiveDofs, vector: &[f64]) -> f64 {
    vector.iter().zip(dofs.fixed()).filter(|(_, fixed)| !**fixed).map(|(x, _)| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_of_both_criteria() {
        let mut dofs = ActiveDofs::new(1, &[true; 5]);
        dofs.fixed_mut()[4] = true;
        let t = |relative, absolute| Tolerances { relative, absolute };
        let (r, dx, x) = ([3.0, 4.0, 0.0, 0.0, 99.0], [0.3, 0.4, 0.0, 0.0, 99.0], [3.0, 4.0, 0.0, 0.0, 99.0]);
        // |r| = 5, 4 free dofs: ratio 5/50, absolute 5/4.
        assert!(Criterion::Residual(t(0.1, 0.0)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        assert!(!Criterion::Residual(t(0.0999, 1.25)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        assert!(Criterion::Residual(t(0.0, 1.2501)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        // |dx| = 0.5, |x| = 5: ratio 0.1, absolute 0.5/2.
        assert!(Criterion::Displacement(t(0.1 + 1e-15, 0.0)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        assert!(!Criterion::Displacement(t(0.09, 0.25)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        assert!(!Criterion::And(t(0.2, 0.0), t(0.01, 0.0)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
        // Nothing below round-off is asked for, of each dof by itself.
        assert!(Criterion::Residual(t(0.0, 0.0)).met(&dofs, 50.0, &[3.0, 4.0, 0.0, 0.0, 0.0], [&r, &dx, &x]));
        assert!(!Criterion::Residual(t(0.0, 0.0)).met(&dofs, 50.0, &[99.0, 3.9, 9.0, 9.0, 9.0], [&r, &dx, &x]));
        assert!(Criterion::Or(t(0.2, 0.0), t(0.01, 0.0)).met(&dofs, 50.0, &[0.0; 5], [&r, &dx, &x]));
    }

    /// Forces of 100 N hide a volume of 1e-3 m³ in a common norm, but not in one of its own.
    #[test]
    fn fields_are_judged_apart() {
        let dofs = ActiveDofs::new(2, &[true; 2]);
        let fields = [
            Field { components: 0..1, reference: Reference::First },
            Field { components: 1..2, reference: Reference::Largest(1.0) },
        ];
        let criterion = Criterion::Residual(Tolerances { relative: 1e-3, absolute: 0.0 });
        let mut references = References::default();
        references.note(&fields, &dofs, &[60.0, 0.0, 80.0, 0.0]);
        let met = |references: &References, r: [f64; 4]| {
            criterion.met_by_fields(&fields, references, &dofs, &[0.0; 4], [&r, &[0.0; 4], &[0.0; 4]])
        };
        assert!(criterion.met(&dofs, 100.0, &[0.0; 4], [&[0.0, 1e-3, 0.0, 0.0], &[0.0; 4], &[0.0; 4]]));
        assert!(!met(&references, [0.0, 1e-3, 0.0, 0.0]));
        references.note(&fields, &dofs, &[0.0, 1e-3, 0.0, 0.0]);
        assert!(met(&references, [0.1, 1e-6, 0.0, 0.0]));
        assert!(!met(&references, [0.1, 1.01e-6, 0.0, 0.0]) && !met(&references, [0.101, 0.0, 0.0, 0.0]));
        // Without any residual of their own volumes are held to their scale.
        let mut quiet = References::default();
        quiet.note(&fields, &dofs, &[60.0, 0.0, 80.0, 0.0]);
        assert!(met(&quiet, [0.0, 0.9e-13, 0.0, 0.0]) && !met(&quiet, [0.0, 1.1e-13, 0.0, 0.0]));
    }
}
