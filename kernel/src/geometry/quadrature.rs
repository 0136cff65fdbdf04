//! Integration rules on the reference cells, with Kratos's order of points.
//!
//! The numbers are those Kratos uses, digit for digit, because they decide where material points
//! start: the tetrahedral rule with 4 points has 8 digits there, so it has 8 here.

use super::Shape;

/// A point of an integration rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraturePoint {
    /// Local coordinates; those beyond the shape's dimension are 0.
    pub xi: [f64; 3],
    /// Weight; the weights of a rule sum to [`Shape::reference_measure`].
    pub weight: f64,
}

/// No rule with this number of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no integration rule with {count} points for a {}: choose {}", shape.name(), choices(*shape))]
pub struct UnsupportedCount {
    /// The shape.
    pub shape: Shape,
    /// The number of points asked for.
    pub count: usize,
}

fn choices(shape: Shape) -> String {
    let counts: Vec<String> = allowed_counts(shape).iter().map(usize::to_string).collect();
    match counts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => counts.concat(),
    }
}

/// Numbers of points for which [`rule`] has a rule, ascending.
pub fn allowed_counts(shape: Shape) -> &'static [usize] {
    match shape {
        Shape::Point1 => &[1],
        Shape::Line2 => &[1, 2, 3, 4, 5],
        Shape::Triangle3 => &[1, 3, 6, 12],
        Shape::Quadrilateral4 => &[1, 4, 9, 16, 25],
        Shape::Tetrahedron4 => &[1, 4, 8, 14, 24],
        Shape::Hexahedron8 => &[1, 8, 27, 64, 125],
    }
}

/// The rule with `count` points for a shape.
///
/// Degrees of exactness — triangle: 1, 2, 4, 6; tetrahedron: 1, 2, 3, 5, 6; the others, with n
/// Gauss–Legendre points along each coordinate: 2n − 1 in each coordinate.
///
/// # Errors
/// A count that is not in [`allowed_counts`].
pub fn rule(shape: Shape, count: usize) -> Result<Vec<QuadraturePoint>, UnsupportedCount> {
    if !allowed_counts(shape).contains(&count) {
        return Err(UnsupportedCount { shape, count });
    }
    Ok(match shape {
        Shape::Point1 => vec![point([0.0; 3], 1.0)],
        Shape::Line2 => gauss_legendre(count).into_iter().map(|(x, w)| point([x, 0.0, 0.0], w)).collect(),
        Shape::Triangle3 => triangle(count),
        Shape::Quadrilateral4 => quadrilateral(count),
        Shape::Tetrahedron4 => tetrahedron(count),
        Shape::Hexahedron8 => hexahedron(count),
    })
}

/// A shape cannot be cut into this number of equal parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a {} has no {count} equal parts: choose {}", shape.name(), even_choices(*shape))]
pub struct UnevenCount {
    /// The shape.
    pub shape: Shape,
    /// The number of parts asked for.
    pub count: usize,
}

/// Numbers of parts that [`even_rule`] takes, in words.
pub fn even_choices(shape: Shape) -> &'static str {
    match shape {
        Shape::Point1 => "1",
        Shape::Line2 => "any number from 1 on",
        Shape::Triangle3 | Shape::Quadrilateral4 => "a square number: 1, 4, 9, 16, 25, and so on",
        Shape::Tetrahedron4 => "Gauss points, for which it has 1, 4, 8, 14 or 24",
        Shape::Hexahedron8 => "a cubic number: 1, 8, 27, 64, 125, and so on",
    }
}

/// The centres of `count` equal parts of a shape, each with an equal weight; ξ runs fastest.
///
/// Lines, quadrilaterals and hexahedra are cut n times along each coordinate, triangles into n²
/// similar ones. A sum over the points is exact for linear functions, and no more.
///
/// # Errors
/// A count that is no power of a whole n; tetrahedra, which are not made of similar ones.
pub fn even_rule(shape: Shape, count: usize) -> Result<Vec<QuadraturePoint>, UnevenCount> {
    let dimension = shape.dimension();
    let n = match dimension {
        0 => 1,
        1 => count,
        2 => count.isqrt(),
        _ => (count as f64).cbrt().round() as usize,
    };
    let fits = n > 0 && n.checked_pow(dimension as u32) == Some(count);
    if !fits || shape == Shape::Tetrahedron4 {
        return Err(UnevenCount { shape, count });
    }
    let weight = shape.reference_measure() / count as f64;
    if shape == Shape::Triangle3 {
        return Ok(triangle_parts(n).map(|xi| point(xi, weight)).collect());
    }
    // Middles of n intervals of [−1, 1], so that those of both halves mirror each other.
    let middle = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    let place = |index: usize| {
        let along = |axis: usize| if axis < dimension { middle(index / n.pow(axis as u32) % n) } else { 0.0 };
        [along(0), along(1), along(2)]
    };
    Ok((0..count).map(|index| point(place(index), weight)).collect())
}

/// Centroids of the n² similar triangles of a triangle, row by row: those that stand as the whole
/// does, each but the last of a row followed by the one turned upside down.
fn triangle_parts(n: usize) -> impl Iterator<Item = [f64; 3]> {
    let cells = (0..n).flat_map(move |j| (0..n - j).map(move |i| (i, j)));
    cells.flat_map(move |(i, j)| {
        let at = |third: f64| [(i as f64 + third) / n as f64, (j as f64 + third) / n as f64, 0.0];
        let turned = (i + j + 1 < n).then(|| at(2.0 / 3.0));
        std::iter::once(at(1.0 / 3.0)).chain(turned)
    })
}

fn point(xi: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { xi, weight }
}

/// Abscissae, ascending, and weights of Gauss and Legendre on [−1, 1], for 1 to 5 points.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    // From the middle outwards.
    let half: &[(f64, f64)] = match count {
        1 => &[(0.0, 2.0)],
        2 => &[(0.577_350_269_189_625_7, 1.0)],
        3 => &[(0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)],
        4 => &[(0.339_981_043_584_856_3, 0.652_145_154_862_546_2), (0.861_136_311_594_052_6, 0.347_854_845_137_453_85)],
        _ => &[
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        ],
    };
    let below = half.iter().rev().filter(|(x, _)| *x > 0.0).map(|&(x, w)| (-x, w));
    below.chain(half.iter().copied()).collect()
}

fn triangle(count: usize) -> Vec<QuadraturePoint> {
    let at = |x, y, weight| point([x, y, 0.0], weight);
    match count {
        1 => vec![at(1.0 / 3.0, 1.0 / 3.0, 0.5)],
        3 => {
            let (a, b, w) = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0);
            vec![at(a, a, w), at(b, a, w), at(a, b, w)]
        }
        6 => {
            let orbit = |a: f64, w| [at(a, a, w), at(1.0 - 2.0 * a, a, w), at(a, 1.0 - 2.0 * a, w)];
            let first = orbit(0.091576213509771, 0.054975871827661);
            let second = orbit(0.445948490915965, 0.1116907948390055);
            [first, second].concat()
        }
        _ => {
            let orbit = |a, b, w| [at(a, b, w), at(b, a, w), at(b, b, w)];
            let first = orbit(0.8738219710169955, 0.06308901449150223, 0.02542245318510341);
            let second = orbit(0.5014265096581791, 0.2492867451709104, 0.05839313786318968);
            let (p, q, r) = (0.05314504984481695, 0.3103524510337844, 0.6365024991213987);
            let pairs = [(p, q), (q, p), (p, r), (q, r), (r, p), (r, q)];
            let third = pairs.map(|(x, y)| at(x, y, 0.04142553780918679));
            [&first[..], &second, &third].concat()
        }
    }
}

fn quadrilateral(count: usize) -> Vec<QuadraturePoint> {
    // Kratos's orders: around the cell for 4 points, ξ fastest for 9, η fastest for 16 and 25.
    let line = gauss_legendre(count.isqrt());
    let product = |outer: &(f64, f64), inner: &(f64, f64)| ((outer.0, inner.0), outer.1 * inner.1);
    let tensor = line.iter().flat_map(|outer| line.iter().map(move |inner| product(outer, inner)));
    match count {
        4 => around(line[1].0, 0.0).to_vec(),
        9 => tensor.map(|((y, x), w)| point([x, y, 0.0], w)).collect(),
        _ => tensor.map(|((x, y), w)| point([x, y, 0.0], w)).collect(),
    }
}

/// Four points at (±s, ±s, z) with weight 1, counter-clockwise.
fn around(s: f64, z: f64) -> [QuadraturePoint; 4] {
    [[-s, -s, z], [s, -s, z], [s, s, z], [-s, s, z]].map(|xi| point(xi, 1.0))
}

fn tetrahedron(count: usize) -> Vec<QuadraturePoint> {
    let orbit = |a, b, w| [[a, b, b], [b, a, b], [b, b, a], [b, b, b]].map(|xi| point(xi, w));
    match count {
        1 => vec![point([0.25; 3], 1.0 / 6.0)],
        4 => orbit(0.58541020, 0.13819660, 1.0 / 24.0).to_vec(),
        8 => {
            let first = orbit(0.01583590986572006, 0.3280546967114267, 0.02308799441864369);
            let second = orbit(0.679143178201208, 0.1069522739329307, 0.01857867224802297);
            [first, second].concat()
        }
        14 => {
            let first = orbit(0.7217942490673264, 0.09273525031089122, 0.01224884051939366);
            let second = orbit(0.06734224221009817, 0.3108859192633006, 0.01878132095300264);
            let (c, d) = (0.04550370412564965, 0.4544962958743504);
            let edges = [[c, c, d], [c, d, c], [c, d, d], [d, c, c], [d, c, d], [d, d, c]];
            [&first[..], &second, &edges.map(|xi| point(xi, 0.007091003462846911))].concat()
        }
        _ => {
            let first = orbit(0.3561913862202544, 0.2146028712599152, 0.006653791709644939);
            let second = orbit(0.877978124396166, 0.04067395853461135, 0.00167953517589097);
            let third = orbit(0.03298632957317347, 0.3223378901422755, 0.009226196923987899);
            let (p, q, r) = (0.6030056647916492, 0.2696723314583158, 0.06366100187501753);
            #[rustfmt::skip]
            let twelve = [
                [p, q, r], [p, r, q], [p, r, r], [r, p, q], [r, p, r], [r, r, p],
                [q, p, r], [q, r, p], [q, r, r], [r, q, p], [r, q, r], [r, r, q],
            ];
            [&first[..], &second, &third, &twelve.map(|xi| point(xi, 0.008035714285714285))].concat()
        }
    }
}

fn hexahedron(count: usize) -> Vec<QuadraturePoint> {
    let order = match count {
        1 => 1,
        8 => 2,
        27 => 3,
        64 => 4,
        _ => 5,
    };
    let line = gauss_legendre(order);
    if order == 2 {
        return line.iter().flat_map(|&(z, _)| around(line[1].0, z)).collect();
    }
    let mut points = Vec::with_capacity(count);
    for &(z, wz) in &line {
        for &(y, wy) in &line {
            for &(x, wx) in &line {
                points.push(point([x, y, z], wx * wy * wz));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests;
