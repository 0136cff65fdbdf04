//! Numbers that formulas are written for: one, or several in step ([`Lanes`]), such as the same
//! component of neighbouring material points. Compiled for the machine's widest vectors (see the
//! `pulp` crate), a formula over lanes runs as vector instructions.
//!
//! Formulas over lanes are written with loops and `#[inline(always)]`: what is not inlined, closures
//! in `array::map` among them, is compiled for the baseline machine.
//!
//! Products and sums are rounded one by one (no fused multiply-add), so that all machines and all
//! widths give the same bits.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number, or several in step.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// The same number in all lanes.
    fn splat(value: f64) -> Self;

    /// ln(1 + x), accurate for small x. Not a number for x < −1.
    fn ln_1p(self) -> Self;

    /// √x.
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn ln_1p(self) -> Self {
        f64::ln_1p(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
}

/// `W` numbers in step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const W: usize>(pub [f64; W]);

macro_rules! operator {
    ($trait:ident, $function:ident, $assign_trait:ident, $assign:ident, $op:tt) => {
        impl<const W: usize> $trait for Lanes<W> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                let mut out = self;
                for l in 0..W {
                    out.0[l] = self.0[l] $op other.0[l];
                }
                out
            }
        }

        impl<const W: usize> $trait<f64> for Lanes<W> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                let mut out = self;
                for l in 0..W {
                    out.0[l] = self.0[l] $op other;
                }
                out
            }
        }

        impl<const W: usize> $assign_trait for Lanes<W> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                *self = *self $op other;
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign, +);
operator!(Sub, sub, SubAssign, sub_assign, -);
operator!(Mul, mul, MulAssign, mul_assign, *);
operator!(Div, div, DivAssign, div_assign, /);

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        let mut out = self;
        for l in 0..W {
            out.0[l] = -self.0[l];
        }
        out
    }
}

impl<const W: usize> Real for Lanes<W> {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; W])
    }

    /// 2 artanh(s), s = x/(2 + x), by its series, exact to rounding for |s| ≤ 1/3, −1/2 ≤ x ≤ 1;
    /// beyond that lane by lane.
    #[inline(always)]
    fn ln_1p(self) -> Self {
        const TERMS: usize = 17;
        let s = self / (self + 2.0);
        let square = s * s;
        let mut sum = Self::splat(1.0 / (2 * TERMS + 1) as f64);
        for k in (1..TERMS).rev() {
            sum = sum * square + 1.0 / (2 * k + 1) as f64;
        }
        let mut out = s * 2.0 + s * square * sum * 2.0;
        let mut near = true;
        for l in 0..W {
            near &= self.0[l] >= -0.5 && self.0[l] <= 1.0;
        }
        if !near {
            for l in 0..W {
                out.0[l] = self.0[l].ln_1p();
            }
        }
        out
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let mut out = self;
        for l in 0..W {
            out.0[l] = self.0[l].sqrt();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_compute_what_numbers_compute() {
        let (a, b) = ([1.5, -2.0, 3.25, 0.1], [0.3, 7.0, -1.0, 2.0]);
        let (x, y) = (Lanes(a), Lanes(b));
        let formula = |a: f64, b: f64| -(a * b - b / a) * 2.0 + a;
        let of_lanes = -(x * y - y / x) * 2.0 + x;
        assert_eq!(of_lanes.0, std::array::from_fn(|l| formula(a[l], b[l])));
    }

    #[test]
    fn logarithms_are_those_of_the_standard_library() {
        let mut x = -0.99;
        while x < 4.0 {
            let lanes = Lanes([x, 1e-3 * x, 1e-9 * x, 1e-20 * x]).ln_1p();
            for (l, scale) in [1.0, 1e-3, 1e-9, 1e-20].into_iter().enumerate() {
                let (found, expected) = (lanes.0[l], (scale * x).ln_1p());
                assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{x} {found} {expected}");
            }
            x += 0.01;
        }
        assert!(Lanes([-1.5, 0.0]).ln_1p().0[0].is_nan());
    }
}
