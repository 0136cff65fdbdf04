//! Riemann problems at the faces of cells.
//!
//! Each side has the velocity v and the traction τ = Π N on its own outward normal, and the impedance Z
//! of the waves that leave the face into it. The state at the face:
//!
//! (Z_L + Z_R) v* = Z_L v_L + Z_R v_R − τ_L − τ_R,  τ* = τ_L + Z_L (v* − v_L).
//!
//! With Z of the acoustic tensor this is exact for linear laws, for any pair of materials, and the
//! linearised (Roe) solver for others. With Z = ρ₀ c 1, c the fastest wave, it is that of Harten, Lax and
//! van Leer: two waves in place of all. At the boundary a component of v* or of τ* is given instead.
//!
//! Sources: Renaud and Heuzé, COMPDYN 2017, §4; Toro, Riemann Solvers and Numerical Methods for Fluid
//! Dynamics, ch. 10, 11.

use crate::matrix::{Matrix, Vector, inverse, minus, times};

/// State at a face as a cell sees it: velocity, and traction on the cell's outward normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trace<const D: usize> {
    /// Velocity (m/s).
    pub velocity: Vector<D>,
    /// Traction on the outward normal (Pa).
    pub traction: Vector<D>,
}

impl<const D: usize> Trace<D> {
    /// At rest, without stress.
    pub const REST: Self = Self { velocity: [0.0; D], traction: [0.0; D] };
}

/// Impedances of the sides of a face, and what they give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface<const D: usize> {
    /// Z_L (kg/(m² s)).
    pub left: Matrix<D>,
    /// Z_R; of no meaning at the boundary.
    pub right: Matrix<D>,
    /// (Z_L + Z_R)⁻¹.
    pub inverse: Matrix<D>,
}

impl<const D: usize> Interface<D> {
    /// From the impedances.
    #[inline]
    pub fn new(left: Matrix<D>, right: Matrix<D>) -> Self {
        let mut sum = left;
        for i in 0..D {
            for j in 0..D {
                sum[i][j] += right[i][j];
            }
        }
        Self { left, right, inverse: inverse(&sum) }
    }

    /// v*, and τ* on the outward normal of the left side.
    #[inline(always)]
    pub fn solve(&self, left: &Trace<D>, right: &Trace<D>) -> Trace<D> {
        let mut push = times(&self.right, &minus(&right.velocity, &left.velocity));
        for i in 0..D {
            push[i] -= left.traction[i] + right.traction[i];
        }
        let change = times(&self.inverse, &push);
        let jump = times(&self.left, &change);
        let mut star = *left;
        for i in 0..D {
            star.velocity[i] += change[i];
            star.traction[i] += jump[i];
        }
        star
    }
}

/// What acts on a face of the boundary, by component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition<const D: usize> {
    /// Components whose velocity is given; the others have a traction.
    pub held: [bool; D],
    /// Given velocity (m/s).
    pub velocity: Vector<D>,
    /// Given traction on the outward normal (Pa).
    pub traction: Vector<D>,
    /// Waves leave as if the body went on in the state that it has here.
    pub transmitting: bool,
}

impl<const D: usize> Condition<D> {
    /// Nothing acts.
    pub const FREE: Self = Self { held: [false; D], velocity: [0.0; D], traction: [0.0; D], transmitting: false };

    /// v* and τ* at a boundary face of a cell with this impedance.
    #[inline]
    pub fn solve(&self, impedance: &Matrix<D>, inner: &Trace<D>) -> Trace<D> {
        if self.transmitting {
            return *inner;
        }
        // Rows of the unknown change of velocity: Z (v* − v) = τ* − τ where τ* is given.
        let (mut matrix, mut right) = (*impedance, minus(&self.traction, &inner.traction));
        for i in 0..D {
            if self.held[i] {
                matrix[i] = [0.0; D];
                matrix[i][i] = 1.0;
                right[i] = self.velocity[i] - inner.velocity[i];
            }
        }
        let change = times(&inverse(&matrix), &right);
        let jump = times(impedance, &change);
        let mut star = *inner;
        for i in 0..D {
            star.velocity[i] = if self.held[i] { self.velocity[i] } else { inner.velocity[i] + change[i] };
            star.traction[i] = if self.held[i] { inner.traction[i] + jump[i] } else { self.traction[i] };
        }
        star
    }
}

/// How Riemann problems are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RiemannSolver {
    /// With the impedances of all waves: exact for linear laws.
    Linearized,
    /// With the fastest wave alone.
    Hll,
    /// With the shocks and fans of a nonlinear law, in one dimension.
    Exact,
}

impl RiemannSolver {
    /// Names in the input.
    pub const NAMES: &'static [&'static str] = &["linearized", "hll", "exact"];

    /// Its name in the input.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// From a name in the input.
    pub fn of(name: &str) -> Self {
        match name {
            "hll" => Self::Hll,
            "exact" => Self::Exact,
            _ => Self::Linearized,
        }
    }
}
