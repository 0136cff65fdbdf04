//! Rows of a point-major column as lanes, one neighbouring point in each.

use bia_kernel::lanes::{Lanes, Pack, WIDTH};
use pulp::Simd;
use std::ops::Range;

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
    /// The first `C` entries of each row.
    #[inline(always)]
    pub fn load<S: Simd, const C: usize>(self, simd: S, column: &[f64]) -> [Lanes<S>; C] {
        let width = Lanes::<S>::COUNT;
        let mut packs = [Pack([0.0; WIDTH]); C];
        if self.count == width {
            let rows = &column[self.first * C..(self.first + width) * C];
            for l in 0..width {
                for c in 0..C {
                    packs[c].0[l] = rows[l * C + c];
                }
            }
        } else {
            let rows = &column[self.first * C..(self.first + self.count) * C];
            for l in 0..width {
                let row = l.min(self.count - 1);
                for c in 0..C {
                    packs[c].0[l] = rows[row * C + c];
                }
            }
        }
        let mut out = [Lanes::splat(simd, 0.0); C];
        for c in 0..C {
            out[c] = Lanes::load(simd, &packs[c]);
        }
        out
    }

    /// Writes rows of `C` entries.
    #[inline(always)]
    pub fn store<S: Simd, const C: usize>(self, column: &mut [f64], values: &[Lanes<S>; C]) {
        let width = Lanes::<S>::COUNT;
        let mut packs = [Pack([0.0; WIDTH]); C];
        for c in 0..C {
            values[c].store(&mut packs[c]);
        }
        if self.count == width {
            let rows = &mut column[self.first * C..(self.first + width) * C];
            for l in 0..width {
                for c in 0..C {
                    rows[l * C + c] = packs[c].0[l];
                }
            }
        } else {
            self.store_packs(column, &packs);
        }
    }

    /// Writes rows of `C` entries, a pack for each.
    #[inline(always)]
    pub fn store_packs<const C: usize>(self, column: &mut [f64], packs: &[Pack; C]) {
        let rows = &mut column[self.first * C..(self.first + self.count) * C];
        for (l, row) in rows.chunks_exact_mut(C).enumerate() {
            for c in 0..C {
                row[c] = packs[c].0[l];
            }
        }
    }

    /// Writes chosen components of a tensor: column entry k is `values[components[k]]`.
    #[inline(always)]
    pub fn store_components(self, column: &mut [f64], components: &[usize], values: &[Pack; 6]) {
        match *components {
            [a] => self.store_packs(column, &[values[a]]),
            [a, b, c] => self.store_packs(column, &[values[a], values[b], values[c]]),
            [a, b, c, d] => self.store_packs(column, &[values[a], values[b], values[c], values[d]]),
            _ => self.store_packs(column, values),
        }
    }

    /// Reads what [`store_components`](Self::store_components) wrote, with zeros elsewhere.
    #[inline(always)]
    pub fn load_components<S: Simd>(self, simd: S, column: &[f64], components: &[usize]) -> [Lanes<S>; 6] {
        let mut out = [Lanes::splat(simd, 0.0); 6];
        match *components {
            [a] => [out[a]] = self.load(simd, column),
            [a, b, c] => [out[a], out[b], out[c]] = self.load(simd, column),
            [a, b, c, d] => [out[a], out[b], out[c], out[d]] = self.load(simd, column),
            _ => out = self.load(simd, column),
        }
        out
    }

    /// The points.
    pub fn points(self) -> Range<usize> {
        self.first..self.first + self.count
    }
}

/// Points of a run in groups that fill the lanes.
#[inline(always)]
pub fn groups<S: Simd>(_: S, run: Range<usize>) -> impl Iterator<Item = Rows> {
    let width = Lanes::<S>::COUNT;
    run.clone().step_by(width).map(move |first| Rows { first, count: width.min(run.end - first) })
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
                let six = rows.load_components(simd, &column, &components);
                assert_eq!((six[3].pack(), six[2].pack()), (lanes[2].pack(), Pack([0.0; WIDTH])));
                let mut out = vec![-1.0; 60];
                rows.store_components(&mut out, &components, &six.map(Lanes::pack));
                assert_eq!(out[written.clone()], column[written.clone()]);
            }
        }
    }

    #[test]
    fn rows_survive_lanes_whole_and_in_part() {
        Arch::new().dispatch(RoundTrip);
    }
}
