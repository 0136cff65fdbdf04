//! Rows of a point-major column as lanes, one neighbouring point in each.

use bia_kernel::lanes::{Lanes, Pack, WIDTH, prefetch};
use pulp::Simd;
use std::ops::Range;

/// Points that are asked of the memory ahead of the work on them: what is asked for waits in the
/// first cache.
pub const AHEAD: usize = 64;

/// Widest rows.
const MOST: usize = 9;

/// Consecutive points of one cell, at most as many as there are lanes. Lanes beyond the last point
/// repeat it.
#[derive(Debug, Clone, Copy)]
pub struct Rows {
    /// First point.
    pub first: usize,
    /// Points.
    pub count: usize,
}

impl Rows {
    /// The `C` entries of each row.
    #[inline(always)]
    pub fn load<S: Simd, const C: usize>(self, simd: S, column: &[f64]) -> [Lanes<S>; C] {
        let rows = &column[self.first * C..(self.first + self.count) * C];
        if self.count == Lanes::<S>::COUNT {
            return Lanes::read_rows(simd, rows);
        }
        let mut padded = [0.0; WIDTH * MOST];
        pad::<C>(rows, &mut padded);
        Lanes::read_rows(simd, &padded)
    }

    /// Writes rows of `C` entries.
    #[inline(always)]
    pub fn store<S: Simd, const C: usize>(self, column: &mut [f64], values: &[Lanes<S>; C]) {
        let rows = &mut column[self.first * C..(self.first + self.count) * C];
        if self.count == Lanes::<S>::COUNT {
            return Lanes::write_rows(values, rows);
        }
        let mut padded = [0.0; WIDTH * MOST];
        Lanes::write_rows(values, &mut padded);
        rows.copy_from_slice(&padded[..rows.len()]);
    }

    /// Writes chosen components of a tensor in `D` dimensions: column entry k is `values[components[k]]`.
    #[inline(always)]
    pub fn store_components<S: Simd, const D: usize>(
        self,
        column: &mut [f64],
        components: &[usize],
        v: &[Lanes<S>; 6],
    ) {
        match *components {
            [a] if D == 1 => self.store(column, &[v[a]]),
            [a, b, c] if D == 2 => self.store(column, &[v[a], v[b], v[c]]),
            [a, b, c, d] if D == 2 => self.store(column, &[v[a], v[b], v[c], v[d]]),
            _ => self.store(column, v),
        }
    }

    /// Reads what [`store_components`](Self::store_components) wrote, with zeros elsewhere.
    #[inline(always)]
    pub fn load_components<S: Simd, const D: usize>(
        self,
        simd: S,
        column: &[f64],
        components: &[usize],
    ) -> [Lanes<S>; 6] {
        let mut out = [Lanes::splat(simd, 0.0); 6];
        match *components {
            [a] if D == 1 => [out[a]] = self.load(simd, column),
            [a, b, c] if D == 2 => [out[a], out[b], out[c]] = self.load(simd, column),
            [a, b, c, d] if D == 2 => [out[a], out[b], out[c], out[d]] = self.load(simd, column),
            _ => out = self.load(simd, column),
        }
        out
    }

    /// One in the lane of each point, zero beyond.
    #[inline(always)]
    pub fn counts<S: Simd>(self, simd: S) -> Lanes<S> {
        let mut counts = Pack([1.0; WIDTH]);
        if self.count < Lanes::<S>::COUNT {
            counts.0[self.count..].fill(0.0);
        }
        Lanes::load(simd, &counts)
    }

    /// The points.
    pub fn points(self) -> Range<usize> {
        self.first..self.first + self.count
    }
}

/// Fills lanes beyond the last row with copies of it.
#[inline(never)]
fn pad<const C: usize>(rows: &[f64], padded: &mut [f64; WIDTH * MOST]) {
    padded[..rows.len()].copy_from_slice(rows);
    for k in rows.len()..WIDTH * C {
        padded[k] = padded[k - C];
    }
}

/// Points of a run in groups that fill the lanes.
#[inline(always)]
pub fn groups<S: Simd>(_: S, run: Range<usize>) -> impl Iterator<Item = Rows> {
    let width = Lanes::<S>::COUNT;
    run.clone().step_by(width).map(move |first| Rows { first, count: width.min(run.end - first) })
}

/// Asks for rows of a column ahead of their use.
#[inline(always)]
pub fn prefetch_rows(column: &[f64], width: usize, points: Range<usize>) {
    prefetch(&column[(points.start * width).min(column.len())..(points.end * width).min(column.len())]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct RoundTrip;

    impl WithSimd for RoundTrip {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let column: Vec<f64> = (0..60).map(f64::from).collect();
            let width = Lanes::<S>::COUNT;
            for (first, count) in [(0, width), (5, width), (17, 3.min(width)), (2, 1)] {
                let rows = Rows { first, count };
                let lanes = rows.load::<S, 3>(simd, &column);
                assert_eq!(lanes[1].pack().0[0], column[3 * first + 1]);
                assert_eq!(lanes[2].pack().0[width - 1], column[3 * (first + count - 1) + 2]);
                let written = 3 * first..3 * (first + count);
                let mut out = vec![-1.0; 60];
                rows.store(&mut out, &lanes);
                assert_eq!(out[written.clone()], column[written.clone()]);
                assert!(out.iter().enumerate().all(|(k, v)| written.contains(&k) || *v == -1.0));
                let components = [0, 1, 3];
                let six = rows.load_components::<S, 2>(simd, &column, &components);
                assert_eq!((six[3].pack(), six[2].pack()), (lanes[2].pack(), Pack([0.0; WIDTH])));
                let mut out = vec![-1.0; 60];
                rows.store_components::<S, 2>(&mut out, &components, &six);
                assert_eq!(out[written.clone()], column[written.clone()]);
            }
        }
    }

    #[test]
    fn rows_survive_lanes_whole_and_in_part() {
        Arch::new().dispatch(RoundTrip);
    }
}
