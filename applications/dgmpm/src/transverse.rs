//! Corner transport upwind: what the faces of each axis see, corrected by what enters a cell through the
//! faces of its other axes.
//!
//! A face with the state U* changes a cell by Δt A/V (τ* − τ)/ρ₀ in its velocity and by
//! Δt A/V (v* − v) ⊗ N in its displacement gradient; a share of that, and the stress that follows, is
//! added to what the faces of the other axes see. In the interior of a linear body this is the mean of
//! the one-dimensional sweeps in all orders.
//!
//! Sources: LeVeque, Finite Volume Methods for Hyperbolic Problems, ch. 20; Colella, J. Comput. Phys. 87
//! (1990) 171-200; in space Saltzman, J. Comput. Phys. 115 (1994) 153-168.

use crate::chunk::{Chunk, Reason, Shared, Stop};
use crate::material::Material;
use crate::matrix::{Matrix, times};
use crate::riemann::Trace;
use bia_constitutive::LawError;

/// Which states at the faces correct which.
pub struct Transverse<'a, const D: usize> {
    /// What the faces see at the start of the step, by slot.
    pub base: &'a [Trace<D>],
    /// Share of the step.
    pub share: f64,
    /// What corrects.
    pub by: By<'a, D>,
}

/// States at the faces that correct those of other axes.
#[derive(Clone, Copy)]
pub enum By<'a, const D: usize> {
    /// All of the other axes'.
    Others(&'a [Trace<D>]),
    /// Those of the next axis, or with 1 of the one after it.
    Next(usize, &'a [Trace<D>]),
    /// Those of each other axis that were corrected by the third axis: the first where that is the next
    /// one after the corrected axis's.
    Corrected([&'a [Trace<D>]; 2]),
}

impl<'a, const D: usize> Transverse<'a, D> {
    /// The states at the faces of axis `other` that correct those of `axis`.
    #[inline(always)]
    fn states_for(&self, axis: usize, other: usize) -> Option<&'a [Trace<D>]> {
        match self.by {
            By::Others(stars) => Some(stars),
            By::Next(k, stars) => ((axis + 1 + k) % D == other).then_some(stars),
            By::Corrected(sets) => {
                let third = 3 - axis - other;
                Some(sets[usize::from((other + 1) % D != third)])
            }
        }
    }
}

impl<const D: usize> Chunk<D> {
    /// What the faces of each axis see, moved by a share of what enters through the faces of other axes.
    pub fn correct_transversely(
        &mut self,
        shared: &Shared<D>,
        transverse: &Transverse<D>,
        time_step: f64,
        traces: &mut [Trace<D>],
    ) {
        for (local, kind) in self.kinds.iter().enumerate() {
            let kind = &shared.kinds[*kind as usize];
            let material = &shared.materials[kind.material as usize];
            let cell = self.first + local;
            let base = &transverse.base[cell * 2 * D..(cell + 1) * 2 * D];
            let own = &mut traces[local * 2 * D..(local + 1) * 2 * D];
            let mean = if material.law.is_some() { self.mean_gradient(local, kind) } else { [[0.0; D]; D] };
            for axis in 0..D {
                let (mut velocity, mut gradient) = ([0.0; D], [[0.0; D]; D]);
                for other in (0..D).filter(|&other| other != axis) {
                    let Some(stars) = transverse.states_for(axis, other) else { continue };
                    for face in [2 * other, 2 * other + 1] {
                        let star = shared.star(stars, cell, face);
                        let rate = transverse.share * time_step * kind.areas[face] / kind.volume;
                        for i in 0..D {
                            velocity[i] += rate / material.density * (star.traction[i] - base[face].traction[i]);
                            let motion = rate * (star.velocity[i] - base[face].velocity[i]);
                            (0..D).for_each(|a| gradient[i][a] += motion * kind.normals[face][a]);
                        }
                    }
                }
                let stress = match stress_change(material, &mean, &gradient) {
                    Ok(stress) => stress,
                    Err(reason) => {
                        self.stop = Some(Stop { cell, gradient: mean, reason: Reason::Law(reason) });
                        return;
                    }
                };
                for face in [2 * axis, 2 * axis + 1] {
                    let traction = times(&stress, &kind.normals[face]);
                    for i in 0..D {
                        own[face].velocity[i] = base[face].velocity[i] + velocity[i];
                        own[face].traction[i] = base[face].traction[i] + traction[i];
                    }
                }
            }
        }
    }
}

/// Change of the stress by a small change of the displacement gradient.
fn stress_change<const D: usize>(
    material: &Material,
    gradient: &Matrix<D>,
    change: &Matrix<D>,
) -> Result<Matrix<D>, LawError> {
    if material.law.is_none() {
        return Ok(material.hooke.stress(change));
    }
    let (mut both, mut stresses) = ([*gradient; 2], [[[0.0; D]; D]; 2]);
    for i in 0..D {
        for a in 0..D {
            both[1][i][a] += change[i][a];
        }
    }
    material.stresses(&both, &mut stresses).map_err(|(_, error)| error)?;
    let [before, mut after] = stresses;
    for i in 0..D {
        for a in 0..D {
            after[i][a] -= before[i][a];
        }
    }
    Ok(after)
}
