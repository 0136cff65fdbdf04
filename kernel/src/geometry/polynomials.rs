//! Piecewise polynomials on one axis of a regular grid, as coefficients in each interval.
//!
//! Intervals are mapped to ξ ∈ \[−1, 1\]. Lagrange polynomials interpolate at p + 1 evenly spaced
//! nodes of each interval. B-splines have the grid lines as knots, the first and the last p + 1
//! times, and follow from the recurrence of Cox and de Boor (de Boor, *A Practical Guide to
//! Splines*, 1978), carried out on polynomials instead of numbers.

use super::tensor::Family;

/// Intervals whose coefficients differ by less share them: the same place in an even grid.
const SAME: f64 = 1e-12;

/// Share of the spacing within which an anchor is on a grid line, whatever its mean was rounded to.
const ON_LINE: f64 = 1e-9;

/// The functions of one axis.
#[derive(Debug, Clone)]
pub(super) struct AxisBasis {
    family: Family,
    degree: usize,
    /// Coefficients of ξ^k of function a at `[k (p + 1) + a]`, one table after the other.
    tables: Vec<f64>,
    /// Table of each interval.
    kinds: Vec<u32>,
    /// Where each function is anchored: its node, or the mean of its inner knots (Greville).
    anchors: Vec<f64>,
    /// The last grid line that is not above each anchor, and how far the anchor is towards the next.
    between: Vec<(u32, f64)>,
}

impl AxisBasis {
    /// Functions of this degree between the grid lines.
    pub fn new(lines: &[f64], family: Family, degree: usize) -> Self {
        let intervals = lines.len() - 1;
        let (mut tables, mut kinds): (Vec<f64>, Vec<u32>) = (Vec::new(), Vec::with_capacity(intervals));
        let size = (degree + 1) * (degree + 1);
        for interval in 0..intervals {
            let table = match family {
                Family::Lagrange if interval > 0 => {
                    kinds.push(0);
                    continue;
                }
                Family::Lagrange => lagrange(degree),
                Family::BSpline => b_spline(lines, interval, degree),
            };
            let same = |known: &[f64]| known.iter().zip(&table).all(|(a, b)| (a - b).abs() <= SAME);
            // Those of the interval before, or the first ones.
            let last = kinds.last().copied();
            let known = last
                .into_iter()
                .chain(0..(2 * degree as u32))
                .find(|&kind| tables.chunks_exact(size).nth(kind as usize).is_some_and(same));
            kinds.push(known.unwrap_or((tables.len() / size) as u32));
            if known.is_none() {
                tables.extend(table);
            }
        }
        let anchors = match family {
            Family::Lagrange => nodes(lines, degree),
            Family::BSpline => greville(lines, degree),
        };
        let between = anchors.iter().map(|&x| between_lines(lines, x)).collect();
        Self { family, degree, tables, kinds, anchors, between }
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.anchors.len()
    }

    /// The first of the p + 1 functions of an interval; the others follow it.
    pub fn first(&self, interval: usize) -> usize {
        match self.family {
            Family::Lagrange => interval * self.degree,
            Family::BSpline => interval,
        }
    }

    /// Where the functions are anchored, in m, ascending.
    pub fn anchors(&self) -> &[f64] {
        &self.anchors
    }

    /// The last grid line that is not above a function's anchor, and the share of the spacing by which
    /// the anchor is above it: 0 on a line.
    pub fn between_lines(&self, function: usize) -> (usize, f64) {
        let (line, share) = self.between[function];
        (line as usize, share)
    }

    /// Coefficients of ξ^k of the functions of an interval as `[k][a]`; none for another degree.
    #[inline]
    pub fn table<const P1: usize>(&self, interval: usize) -> Option<&[[f64; P1]; P1]> {
        self.tables.as_chunks::<P1>().0.as_chunks::<P1>().0.get(self.kinds[interval] as usize)
    }

    /// The functions of an interval at ξ.
    pub fn values(&self, interval: usize, xi: f64) -> Vec<f64> {
        let count = self.degree + 1;
        let start = self.kinds[interval] as usize * count * count;
        let table = &self.tables[start..start + count * count];
        (0..count).map(|a| (0..count).rev().fold(0.0, |sum, k| sum * xi + table[k * count + a])).collect()
    }
}

/// Multiplies a polynomial, lowest power first, by a + b ξ; the highest power must be free.
fn times_linear(polynomial: &mut [f64], a: f64, b: f64) {
    for k in (0..polynomial.len()).rev() {
        polynomial[k] = a * polynomial[k] + if k > 0 { b * polynomial[k - 1] } else { 0.0 };
    }
}

/// Π_{b ≠ a} (ξ − ξ_b)/(ξ_a − ξ_b).
fn lagrange(degree: usize) -> Vec<f64> {
    let count = degree + 1;
    let node = |a: usize| 2.0 * a as f64 / degree as f64 - 1.0;
    let mut table = vec![0.0; count * count];
    for a in 0..count {
        let mut polynomial = vec![0.0; count];
        polynomial[0] = 1.0;
        for b in (0..count).filter(|&b| b != a) {
            let span = node(a) - node(b);
            times_linear(&mut polynomial, -node(b) / span, 1.0 / span);
        }
        (0..count).for_each(|k| table[k * count + a] = polynomial[k]);
    }
    table
}

/// N_{i,q} = (x − t_i)/(t_{i+q} − t_i) N_{i,q−1} + (t_{i+q+1} − x)/(t_{i+q+1} − t_{i+1}) N_{i+1,q−1}
/// for the functions that do not vanish in the interval; index a stands for i = interval + a.
fn b_spline(lines: &[f64], interval: usize, degree: usize) -> Vec<f64> {
    let count = degree + 1;
    let (low, high) = (lines[interval], lines[interval + 1]);
    // Knots in units of the interval's own coordinate.
    let knot = |i: usize| {
        let x = lines[i.saturating_sub(degree).min(lines.len() - 1)];
        ((x - low) + (x - high)) / (high - low)
    };
    let mut functions = vec![vec![0.0; count]; count + 1];
    functions[degree][0] = 1.0;
    for q in 1..=degree {
        for a in degree - q..=degree {
            let i = interval + a;
            let mut sum = vec![0.0; count];
            // The function before the first and the one after the last vanish in the interval.
            if a > degree - q {
                let (span, mut left) = (knot(i + q) - knot(i), functions[a].clone());
                times_linear(&mut left, -knot(i) / span, 1.0 / span);
                sum.iter_mut().zip(left).for_each(|(s, l)| *s += l);
            }
            if a < degree {
                let (span, mut right) = (knot(i + q + 1) - knot(i + 1), functions[a + 1].clone());
                times_linear(&mut right, knot(i + q + 1) / span, -1.0 / span);
                sum.iter_mut().zip(right).for_each(|(s, r)| *s += r);
            }
            functions[a] = sum;
        }
    }
    let mut table = vec![0.0; count * count];
    for a in 0..count {
        (0..count).for_each(|k| table[k * count + a] = functions[a][k]);
    }
    table
}

fn between_lines(lines: &[f64], x: f64) -> (u32, f64) {
    let line = lines.partition_point(|line| *line <= x).max(1) - 1;
    let Some(next) = lines.get(line + 1) else { return (line as u32, 0.0) };
    let share = (x - lines[line]) / (next - lines[line]);
    match share {
        _ if share < ON_LINE => (line as u32, 0.0),
        _ if share > 1.0 - ON_LINE => (line as u32 + 1, 0.0),
        _ => (line as u32, share),
    }
}

fn nodes(lines: &[f64], degree: usize) -> Vec<f64> {
    let mut nodes = vec![lines[0]];
    for pair in lines.windows(2) {
        let inner = (1..degree).map(|a| pair[0] + (pair[1] - pair[0]) * a as f64 / degree as f64);
        nodes.extend(inner);
        nodes.push(pair[1]);
    }
    nodes
}

/// Means of p consecutive knots, from the second knot on; the end knots stand there p times.
fn greville(lines: &[f64], degree: usize) -> Vec<f64> {
    let last = lines.len() - 1;
    let knot = |i: usize| lines[i.saturating_sub(degree).min(last)];
    (0..last + degree)
        .map(|function| {
            let (first, end) = (knot(function + 1), knot(function + degree));
            // Ends exactly, where the mean would round.
            if first == end { first } else { (1..=degree).map(|k| knot(function + k)).sum::<f64>() / degree as f64 }
        })
        .collect()
}
