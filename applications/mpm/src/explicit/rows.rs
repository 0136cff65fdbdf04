//! Rows of a point-major column as lanes, one neighbouring point in each.

use bia_constitutive::WIDTH;
use bia_kernel::lanes::Lanes;

/// Up to [`WIDTH`] consecutive points of one cell. Lanes beyond the last point repeat it.
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
    pub fn load<const C: usize>(self, column: &[f64]) -> [Lanes<WIDTH>; C] {
        let mut out = [Lanes([0.0; WIDTH]); C];
        if self.count == WIDTH {
            let rows = &column[self.first * C..(self.first + WIDTH) * C];
            for l in 0..WIDTH {
                for c in 0..C {
                    out[c].0[l] = rows[l * C + c];
                }
            }
        } else {
            let rows = &column[self.first * C..(self.first + self.count) * C];
            for l in 0..WIDTH {
                let row = l.min(self.count - 1);
                for c in 0..C {
                    out[c].0[l] = rows[row * C + c];
                }
            }
        }
        out
    }

    /// Writes rows of `C` entries.
    #[inline(always)]
    pub fn store<const C: usize>(self, column: &mut [f64], values: &[Lanes<WIDTH>; C]) {
        if self.count == WIDTH {
            let rows = &mut column[self.first * C..(self.first + WIDTH) * C];
            for l in 0..WIDTH {
                for c in 0..C {
                    rows[l * C + c] = values[c].0[l];
                }
            }
        } else {
            let rows = &mut column[self.first * C..(self.first + self.count) * C];
            for (l, row) in rows.chunks_exact_mut(C).enumerate() {
                for c in 0..C {
                    row[c] = values[c].0[l];
                }
            }
        }
    }

    /// Writes chosen components of a tensor: column entry k is `values[components[k]]`.
    #[inline(always)]
    pub fn store_components(self, column: &mut [f64], components: &[usize], values: &[Lanes<WIDTH>; 6]) {
        match *components {
            [a] => self.store(column, &[values[a]]),
            [a, b, c] => self.store(column, &[values[a], values[b], values[c]]),
            [a, b, c, d] => self.store(column, &[values[a], values[b], values[c], values[d]]),
            _ => self.store(column, values),
        }
    }

    /// Reads what [`store_components`](Self::store_components) wrote, with zeros elsewhere.
    #[inline(always)]
    pub fn load_components(self, column: &[f64], components: &[usize]) -> [Lanes<WIDTH>; 6] {
        let mut out = [Lanes([0.0; WIDTH]); 6];
        match *components {
            [a] => [out[a]] = self.load(column),
            [a, b, c] => [out[a], out[b], out[c]] = self.load(column),
            [a, b, c, d] => [out[a], out[b], out[c], out[d]] = self.load(column),
            _ => out = self.load(column),
        }
        out
    }

    /// The points.
    pub fn points(self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_lanes_whole_and_in_part() {
        let column: Vec<f64> = (0..60).map(f64::from).collect();
        for (first, count) in [(0, 8), (5, 8), (17, 3), (2, 1)] {
            let rows = Rows { first, count };
            let lanes = rows.load::<3>(&column);
            assert_eq!(lanes[1].0[0], column[3 * first + 1]);
            assert_eq!(lanes[2].0[7], column[3 * (first + count.min(8) - 1) + 2]);
            let mut out = vec![-1.0; 60];
            rows.store(&mut out, &lanes);
            let written = 3 * first..3 * (first + count);
            assert_eq!(out[written.clone()], column[written.clone()]);
            assert!(out.iter().enumerate().all(|(k, v)| written.contains(&k) || *v == -1.0));
            let components = [0, 1, 3];
            let six = rows.load_components(&column, &components);
            assert_eq!((six[3], six[2]), (lanes[2], Lanes([0.0; 8])));
        }
    }
}
