//! Numbers that formulas are written for: one, or several in step ([`Lanes`]), such as the same
//! component of neighbouring material points, which fill the machine's vectors.
//!
//! Formulas over lanes are written with loops and `#[inline(always)]`: what is not inlined, closures
//! in `array::map` among them, is compiled for the baseline machine. Products and sums are rounded
//! one by one (no fused multiply-add): each lane holds the same bits on all machines. Sums over the
//! lanes are taken in the order of their number, so that machines with vectors of other widths differ
//! by round-off.

#[cfg(target_arch = "x86_64")]
mod avx512;

use pulp::Simd;
use std::any::Any;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Most lanes that any machine has.
pub const WIDTH: usize = 8;

/// The number of turns of a loop; where they are many, hidden from the compiler, which else writes
/// them all out and takes minutes for it.
#[inline(always)]
pub fn turns<const N: usize>() -> usize {
    if N > 8 { std::hint::black_box(N).min(N) } else { N }
}

/// Runs an operation with the widest vectors of the machine. A function of its own for each operation:
/// many of them inlined into one take the compiler minutes.
#[inline(never)]
pub fn dispatch<O: pulp::WithSimd>(arch: pulp::Arch, operation: O) -> O::Output {
    arch.dispatch(operation)
}

/// Asks for numbers ahead of their use: the memory brings them while the work goes on.
#[inline(always)]
pub fn prefetch(numbers: &[f64]) {
    #[cfg(target_arch = "x86_64")]
    for line in numbers.chunks(8) {
        safe_arch::prefetch_t0(&line[0]);
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = numbers;
}

/// A real number, or several in step.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// The same number in all lanes; `self` says of which kind.
    fn constant(self, value: f64) -> Self;

    /// ln(1 + x), accurate for small x. Not a number for x < −1.
    fn ln_1p(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn ln_1p(self) -> Self {
        f64::ln_1p(self)
    }
}

/// Numbers of lanes in memory; a machine with fewer than [`WIDTH`] uses the first ones.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Pack(pub [f64; WIDTH]);

/// As many numbers in step as a vector of the machine holds, at most [`WIDTH`].
#[derive(Debug, Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// Number of lanes.
    pub const COUNT: usize = {
        assert!(S::F64_LANES <= WIDTH, "packs are too short for this machine");
        S::F64_LANES
    };

    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, value: simd.splat_f64s(value) }
    }

    /// The numbers of a pack.
    #[inline(always)]
    pub fn load(simd: S, pack: &Pack) -> Self {
        Self::load_slice(simd, &pack.0)
    }

    /// Consecutive numbers.
    ///
    /// # Panics
    /// There are too few of them.
    #[inline(always)]
    pub fn load_slice(simd: S, numbers: &[f64]) -> Self {
        let (vectors, _) = S::as_simd_f64s(&numbers[..Self::COUNT]);
        Self { simd, value: vectors[0] }
    }

    /// Writes consecutive numbers.
    ///
    /// # Panics
    /// There is too little room.
    #[inline(always)]
    pub fn store_slice(self, numbers: &mut [f64]) {
        let (vectors, _) = S::as_mut_simd_f64s(&mut numbers[..Self::COUNT]);
        vectors[0] = self.value;
    }

    /// Rows of `C` numbers: entry c of row l in lane l of vector c.
    ///
    /// # Panics
    /// There are fewer rows than lanes.
    #[inline(always)]
    pub fn read_rows<const C: usize>(simd: S, rows: &[f64]) -> [Self; C] {
        let mut out = [Self::splat(simd, 0.0); C];
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = (&simd as &dyn Any).downcast_ref::<pulp::x86::V4>() {
            let columns = avx512::read_rows::<C>(*v4, rows);
            for c in 0..C {
                out[c].value = bytemuck::cast(columns[c]);
            }
            return out;
        }
        for c in 0..C {
            let mut column = Pack([0.0; WIDTH]);
            for l in 0..Self::COUNT {
                column.0[l] = rows[l * C + c];
            }
            out[c] = Self::load(simd, &column);
        }
        out
    }

    /// Writes what [`read_rows`](Self::read_rows) reads.
    ///
    /// # Panics
    /// There is too little room.
    #[inline(always)]
    pub fn write_rows<const C: usize>(values: &[Self; C], rows: &mut [f64]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = (&values[0].simd as &dyn Any).downcast_ref::<pulp::x86::V4>() {
            let mut columns = [bytemuck::cast(values[0].value); C];
            for c in 0..C {
                columns[c] = bytemuck::cast(values[c].value);
            }
            return avx512::write_rows(*v4, rows, &columns);
        }
        for c in 0..C {
            let column = values[c].pack();
            for l in 0..Self::COUNT {
                rows[l * C + c] = column.0[l];
            }
        }
    }

    /// The numbers of a pack, on the same machine as these.
    #[inline(always)]
    pub fn with(self, pack: &Pack) -> Self {
        Self::load(self.simd, pack)
    }

    /// The numbers as a pack, with zeros behind them.
    #[inline(always)]
    pub fn pack(self) -> Pack {
        let mut pack = Pack([0.0; WIDTH]);
        self.store(&mut pack);
        pack
    }

    /// Writes the numbers to a pack.
    #[inline(always)]
    pub fn store(self, pack: &mut Pack) {
        self.store_slice(&mut pack.0);
    }

    /// The larger number, lane by lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { value: self.simd.max_f64s(self.value, other.value), ..self }
    }

    /// The smaller number, lane by lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { value: self.simd.min_f64s(self.value, other.value), ..self }
    }

    /// Sum of all lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.value)
    }

    /// Sums of all lanes of eight vectors.
    #[inline(always)]
    pub fn sums(values: &[Self; 8]) -> Pack {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = (&values[0].simd as &dyn Any).downcast_ref::<pulp::x86::V4>() {
            let mut vectors = [bytemuck::cast(values[0].value); 8];
            for k in 0..8 {
                vectors[k] = bytemuck::cast(values[k].value);
            }
            return Pack(bytemuck::cast(avx512::sums(*v4, &vectors)));
        }
        let mut sums = Pack([0.0; WIDTH]);
        for k in 0..8 {
            sums.0[k] = values[k].sum();
        }
        sums
    }

    /// The columns of a matrix of eight rows.
    #[inline(always)]
    pub fn transposed(simd: S, rows: &[Pack; WIDTH]) -> [Pack; WIDTH] {
        let mut out = *rows;
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = (&simd as &dyn Any).downcast_ref::<pulp::x86::V4>() {
            let mut vectors = [bytemuck::cast(rows[0].0); WIDTH];
            for k in 0..WIDTH {
                vectors[k] = bytemuck::cast(rows[k].0);
            }
            let columns = avx512::transposed(*v4, &vectors);
            for k in 0..WIDTH {
                out[k] = Pack(bytemuck::cast(columns[k]));
            }
            return out;
        }
        let _ = simd;
        for k in 0..WIDTH {
            for l in 0..WIDTH {
                out[k].0[l] = rows[l].0[k];
            }
        }
        out
    }

    /// Whether all lanes lie between two numbers; none that is not a number does.
    #[inline(always)]
    pub fn all_within(self, low: f64, high: f64) -> bool {
        let above = self.simd.less_than_or_equal_f64s(self.constant(low).value, self.value);
        let below = self.simd.less_than_or_equal_f64s(self.value, self.constant(high).value);
        let outside = self.simd.not_m64s(self.simd.and_m64s(above, below));
        self.simd.first_true_m64s(outside) >= Self::COUNT
    }
}

macro_rules! operator {
    ($trait:ident, $function:ident, $assign_trait:ident, $assign:ident, $vector:ident, $op:tt) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self { value: self.simd.$vector(self.value, other.value), ..self }
            }
        }

        impl<S: Simd> $trait<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                self $op self.constant(other)
            }
        }

        impl<S: Simd> $assign_trait for Lanes<S> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                *self = *self $op other;
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign, add_f64s, +);
operator!(Sub, sub, SubAssign, sub_assign, sub_f64s, -);
operator!(Mul, mul, MulAssign, mul_assign, mul_f64s, *);
operator!(Div, div, DivAssign, div_assign, div_f64s, /);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: self.simd.neg_f64s(self.value), ..self }
    }
}

impl<S: Simd> Real for Lanes<S> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// 2 artanh(s), s = x/(2 + x), by its series, exact to rounding for |s| ≤ 1/3, −1/2 ≤ x ≤ 1;
    /// beyond that lane by lane.
    #[inline(always)]
    fn ln_1p(self) -> Self {
        const TERMS: usize = 17;
        if !self.all_within(-0.5, 1.0) {
            let mut pack = self.pack();
            for l in 0..Self::COUNT {
                pack.0[l] = pack.0[l].ln_1p();
            }
            return self.with(&pack);
        }
        let s = self / (self + 2.0);
        let square = s * s;
        let mut sum = self.constant(1.0 / (2 * TERMS + 1) as f64);
        for k in (1..TERMS).rev() {
            sum = sum * square + 1.0 / (2 * k + 1) as f64;
        }
        (s + s * square * sum) * 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    /// Computes formulas over packs of numbers on the machine's vectors.
    struct Compute<'a>(&'a [[f64; WIDTH]], &'a mut [Pack]);

    impl WithSimd for Compute<'_> {
        type Output = usize;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> usize {
            let Compute(numbers, out) = self;
            let (x, y) = (Lanes::load(simd, &Pack(numbers[0])), Lanes::load(simd, &Pack(numbers[1])));
            out[0] = (-(x * y - y / x) * 2.0 + x).pack();
            for (numbers, out) in numbers.iter().zip(out).skip(1) {
                *out = Lanes::load(simd, &Pack(*numbers)).ln_1p().pack();
            }
            Lanes::<S>::COUNT
        }
    }

    #[test]
    fn lanes_compute_what_numbers_compute() {
        let numbers = [[1.5, -2.0, 3.25, 0.1, 7.0, -1e-3, 2.0, 9.5], [0.3, 7.0, -1.0, 2.0, 1e5, 3.0, -0.5, 1.0]];
        let mut out = [Pack([0.0; WIDTH]); 2];
        let count = Arch::new().dispatch(Compute(&numbers, &mut out));
        for l in 0..count {
            let (a, b) = (numbers[0][l], numbers[1][l]);
            assert_eq!(out[0].0[l], -(a * b - b / a) * 2.0 + a);
        }
    }

    struct Sums;

    impl WithSimd for Sums {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let numbers: Vec<f64> = (0..64).map(|k| f64::from(k * k)).collect();
            let mut values = [Lanes::splat(simd, 0.0); 8];
            values.copy_from_slice(&Lanes::read_rows::<8>(simd, &numbers));
            let expected: [f64; 8] = std::array::from_fn(|k| (0..Lanes::<S>::COUNT).map(|l| numbers[8 * l + k]).sum());
            assert_eq!(Lanes::sums(&values).0, expected);
            assert_eq!(values.map(Lanes::sum), expected);
            let mut matrix = [Pack([0.0; WIDTH]); WIDTH];
            (0..64).for_each(|k| matrix[k / 8].0[k % 8] = numbers[k]);
            let columns = Lanes::transposed(simd, &matrix);
            (0..64).for_each(|k| assert_eq!(columns[k % 8].0[k / 8], numbers[k]));
            rows_survive::<S, 1>(simd);
            rows_survive::<S, 2>(simd);
            rows_survive::<S, 3>(simd);
            rows_survive::<S, 4>(simd);
            rows_survive::<S, 5>(simd);
            rows_survive::<S, 6>(simd);
            rows_survive::<S, 9>(simd);
            assert!(values[1].all_within(1.0, 3249.0) && !values[1].all_within(2.0, 4e3));
            assert!(!values[1].all_within(-1.0, 0.5) && !(values[1] * f64::NAN).all_within(0.0, f64::MAX));
        }
    }

    fn rows_survive<S: Simd, const C: usize>(simd: S) {
        let (count, numbers) = (Lanes::<S>::COUNT, (0..90).map(f64::from).collect::<Vec<f64>>());
        let columns = Lanes::read_rows::<C>(simd, &numbers);
        for (c, column) in columns.iter().enumerate() {
            (0..count).for_each(|l| assert_eq!(column.pack().0[l], numbers[l * C + c]));
        }
        let mut out = vec![-1.0; 90];
        Lanes::write_rows(&columns, &mut out);
        assert_eq!(out[..count * C], numbers[..count * C]);
        assert!(out[count * C..].iter().all(|n| *n == -1.0));
    }

    #[test]
    fn sums_run_over_all_lanes() {
        Arch::new().dispatch(Sums);
        Simd::vectorize(pulp::Scalar::new(), Sums);
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            Simd::vectorize(v3, Sums);
        }
    }

    #[test]
    fn logarithms_are_those_of_the_standard_library() {
        let mut numbers = vec![[1.0; WIDTH]];
        numbers.extend((0..500).map(|k| {
            let x = -0.99 + 0.01 * f64::from(k);
            [x, 1e-3 * x, 1e-9 * x, 1e-20 * x, 0.5 * x, 0.25 * x, -1e-6 * x, 0.1 * x]
        }));
        numbers.extend((0..500).map(|k| {
            let x = -0.499 + 0.0029 * f64::from(k);
            [x, 1e-3 * x, 1e-9 * x, 1e-20 * x, 0.5 * x, 0.25 * x, -1e-6 * x, 0.1 * x]
        }));
        let mut out = vec![Pack([0.0; WIDTH]); numbers.len()];
        let count = Arch::new().dispatch(Compute(&numbers, &mut out));
        for (numbers, out) in numbers.iter().zip(&out).skip(1) {
            for l in 0..count {
                let (found, expected) = (out.0[l], numbers[l].ln_1p());
                assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{} {found}", numbers[l]);
            }
        }
        let bad = [[1.0; WIDTH], [-1.5; WIDTH]];
        let mut out = [Pack([0.0; WIDTH]); 2];
        Arch::new().dispatch(Compute(&bad, &mut out));
        assert!(out[1].0[0].is_nan());
    }
}
