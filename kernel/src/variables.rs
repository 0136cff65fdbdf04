//! Typed variables and the columns that hold their values, allocated on demand.

mod exchange;

use crate::io::json::JsonObject;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// How many numbers a value of a variable has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// One number.
    Scalar,
    /// Three numbers, also in the plane.
    Vector,
    /// As many as the stress of the scene: 3 in the plane, 4 axisymmetric, 6 in space.
    Voigt,
    /// Nine numbers, row by row, also in the plane.
    Tensor,
}

/// A named quantity with its unit. Applications declare theirs as constants and register them.
#[derive(Debug, Clone, Copy)]
pub struct Variable {
    /// Name in input and output files, Kratos's where Kratos has one.
    pub name: &'static str,
    /// Size of its values.
    pub rank: Rank,
    /// SI unit.
    pub unit: &'static str,
    /// Meaning.
    pub help: &'static str,
}

impl Variable {
    /// A scalar variable.
    pub const fn scalar(name: &'static str, unit: &'static str, help: &'static str) -> Self {
        Self { name, rank: Rank::Scalar, unit, help }
    }

    /// A vector variable.
    pub const fn vector(name: &'static str, unit: &'static str, help: &'static str) -> Self {
        Self { name, rank: Rank::Vector, unit, help }
    }

    /// A tensor of nine components.
    pub const fn tensor(name: &'static str, unit: &'static str, help: &'static str) -> Self {
        Self { name, rank: Rank::Tensor, unit, help }
    }

    /// A symmetric tensor in Voigt form.
    pub const fn voigt(name: &'static str, unit: &'static str, help: &'static str) -> Self {
        Self { name, rank: Rank::Voigt, unit, help }
    }
}

/// The names of variables.
pub fn names_of(variables: &[Variable]) -> Vec<&'static str> {
    variables.iter().map(|variable| variable.name).collect()
}

/// A node whose value of a vector variable has no component along the normal of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slide {
    /// Index of the node.
    pub node: u32,
    /// Unit normal of the wall, of either sign.
    pub normal: [f64; 3],
}

/// Values of variables on the nodes, elements or conditions of a model part. A variable that no component
/// of the scene asks for has no column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields {
    scalars: BTreeMap<&'static str, Vec<f64>>,
    vectors: BTreeMap<&'static str, Vec<[f64; 3]>>,
    rows: BTreeMap<&'static str, Column>,
    fixed: BTreeMap<&'static str, Vec<[bool; 3]>>,
    slides: BTreeMap<&'static str, Vec<Slide>>,
}

impl Fields {
    /// The column of a scalar, if it exists.
    pub fn scalar(&self, variable: &Variable) -> Option<&[f64]> {
        self.scalars.get(variable.name).map(Vec::as_slice)
    }

    /// The column of a vector, if it exists.
    pub fn vector(&self, variable: &Variable) -> Option<&[[f64; 3]]> {
        self.vectors.get(variable.name).map(Vec::as_slice)
    }

    /// The column of a scalar, made of zeros for `count` entities if it did not exist.
    pub fn scalar_mut(&mut self, variable: &Variable, count: usize) -> &mut [f64] {
        self.scalars.entry(variable.name).or_insert_with(|| vec![0.0; count])
    }

    /// The column of a vector, made of zeros for `count` entities if it did not exist.
    pub fn vector_mut(&mut self, variable: &Variable, count: usize) -> &mut [[f64; 3]] {
        self.vectors.entry(variable.name).or_insert_with(|| vec![[0.0; 3]; count])
    }

    /// The column of a tensor, if it exists.
    pub fn rows(&self, variable: &Variable) -> Option<&Column> {
        self.rows.get(variable.name)
    }

    /// The column of a tensor of `width` numbers, made of zeros for `count` entities if it did not
    /// exist.
    pub fn rows_mut(&mut self, variable: &Variable, width: usize, count: usize) -> &mut Column {
        self.rows.entry(variable.name).or_insert_with(|| Column::new(width, count))
    }

    /// Numbers of a symmetric tensor, which all have the same; 0 if there is none.
    pub fn symmetric_width(&self) -> usize {
        self.rows.values().map(Column::width).find(|&width| width != 9).unwrap_or(0)
    }

    /// Which components are fixed (a scalar uses the first), if any ever was.
    pub fn fixed(&self, variable: &Variable) -> Option<&[[bool; 3]]> {
        self.fixed.get(variable.name).map(Vec::as_slice)
    }

    /// The column of a vector, to be changed, and which components are fixed; either empty if there is none.
    pub fn vector_and_fixed(&mut self, variable: &Variable) -> (&mut [[f64; 3]], &[[bool; 3]]) {
        let vector = self.vectors.get_mut(variable.name).map_or(&mut [][..], Vec::as_mut_slice);
        (vector, self.fixed.get(variable.name).map_or(&[], Vec::as_slice))
    }

    /// Which components are fixed, to be changed.
    pub fn fixed_mut(&mut self, variable: &Variable, count: usize) -> &mut [[bool; 3]] {
        self.fixed.entry(variable.name).or_insert_with(|| vec![[false; 3]; count])
    }

    /// Walls along which the values of a vector slide; a node has one entry for each of its walls.
    pub fn slides(&self, variable: &Variable) -> &[Slide] {
        self.slides.get(variable.name).map_or(&[], Vec::as_slice)
    }

    /// Adds walls along which the values of a vector slide.
    pub fn add_slides(&mut self, variable: &Variable, slides: impl IntoIterator<Item = Slide>) {
        self.slides.entry(variable.name).or_default().extend(slides);
    }

    /// Writes every column to the account of a run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn record(&self, out: &mut JsonObject) -> std::io::Result<()> {
        for (name, column) in &self.scalars {
            out.numbers(name, column.iter().copied())?;
        }
        for (name, column) in &self.vectors {
            out.rows(name, column)?;
        }
        for (name, column) in &self.rows {
            out.rows(name, column.values().chunks_exact(column.width().max(1)))?;
        }
        Ok(())
    }

    /// Names of the columns that exist and the bytes they take.
    pub fn columns(&self) -> Vec<(&'static str, usize)> {
        let scalars = self.scalars.iter().map(|(name, column)| (*name, 8 * column.len()));
        let vectors = self.vectors.iter().map(|(name, column)| (*name, 24 * column.len()));
        let rows = self.rows.iter().map(|(name, column)| (*name, column.bytes()));
        scalars.chain(vectors).chain(rows).collect()
    }
}

/// One quantity of many points: `width` numbers a point, point after point. Width 0 means that
/// nothing is stored.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    width: usize,
    values: Vec<f64>,
}

impl Column {
    /// Zeros for `points` points.
    pub fn new(width: usize, points: usize) -> Self {
        // Zeros from the system are pages that fault when first written, in the midst of the first step.
        Self { width, values: (0..width * points).into_par_iter().with_min_len(4096).map(|_| 0.0).collect() }
    }

    /// The same numbers for `points` points.
    pub fn repeated(row: &[f64], points: usize) -> Self {
        Self { width: row.len(), values: row.repeat(points) }
    }

    /// Makes room for exactly so many more points.
    pub fn reserve(&mut self, points: usize) {
        self.values.reserve_exact(self.width * points);
    }

    /// Numbers a point.
    pub fn width(&self) -> usize {
        self.width
    }

    /// True when the column stores anything.
    pub fn is_used(&self) -> bool {
        self.width > 0
    }

    /// The numbers of a point.
    pub fn row(&self, point: usize) -> &[f64] {
        &self.values[point * self.width..(point + 1) * self.width]
    }

    /// The numbers of a point, to be changed.
    pub fn row_mut(&mut self, point: usize) -> &mut [f64] {
        &mut self.values[point * self.width..(point + 1) * self.width]
    }

    /// The first `W` numbers of a point.
    #[inline]
    pub fn get<const W: usize>(&self, point: usize) -> [f64; W] {
        let start = point * self.width;
        std::array::from_fn(|i| self.values[start + i])
    }

    /// Stores the first `W` numbers of a point.
    #[inline]
    pub fn set<const W: usize>(&mut self, point: usize, value: [f64; W]) {
        let start = point * self.width;
        self.values[start..start + W].copy_from_slice(&value);
    }

    /// All numbers, point after point.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All numbers, to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Appends a point.
    pub fn push(&mut self, row: &[f64]) {
        self.values.extend_from_slice(&row[..self.width]);
    }

    /// Keeps the points for which `keep` holds.
    pub fn retain(&mut self, keep: &[bool]) {
        let width = self.width;
        let mut to = 0;
        for (from, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            self.values.copy_within(from * width..(from + 1) * width, to * width);
            to += 1;
        }
        self.values.truncate(to * width);
    }

    /// Brings the points into another order: place k then holds what was at `order[k]`, a
    /// permutation. `scratch` keeps its memory from call to call.
    ///
    /// # Panics
    /// `order` is shorter than the column, or names a point beyond it.
    pub fn reorder(&mut self, order: &[u32], scratch: &mut Vec<f64>) {
        match self.width {
            0 => {}
            1 => reorder_rows::<1>(&mut self.values, order, scratch),
            2 => reorder_rows::<2>(&mut self.values, order, scratch),
            3 => reorder_rows::<3>(&mut self.values, order, scratch),
            6 => reorder_rows::<6>(&mut self.values, order, scratch),
            9 => reorder_rows::<9>(&mut self.values, order, scratch),
            width => {
                scratch.clear();
                scratch.extend_from_slice(&self.values);
                for (row, &from) in self.values.chunks_exact_mut(width).zip(order) {
                    row.copy_from_slice(&scratch[from as usize * width..(from as usize + 1) * width]);
                }
            }
        }
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        8 * self.values.len()
    }
}

/// Rows that one thread moves at a time.
const ROWS: usize = 4096;

/// Rows of a length that the compiler knows are moved without a call each.
fn reorder_rows<const W: usize>(values: &mut [f64], order: &[u32], scratch: &mut Vec<f64>) {
    scratch.resize(values.len(), 0.0);
    let copied = scratch.par_chunks_mut(ROWS * W).zip(values.par_chunks(ROWS * W));
    copied.for_each(|(to, from)| to.copy_from_slice(from));
    let (rows, old) = (values.as_chunks_mut::<W>().0, scratch.as_chunks::<W>().0);
    assert!(order.len() >= rows.len(), "an order for fewer points than there are");
    rows.par_chunks_mut(ROWS).zip(order.par_chunks(ROWS)).for_each(|(rows, order)| {
        for (row, &from) in rows.iter_mut().zip(order) {
            *row = old[from as usize];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_keep_the_chosen_points_in_order() {
        let mut column = Column::new(2, 0);
        for i in 0..5 {
            column.push(&[f64::from(i), -f64::from(i)]);
        }
        column.retain(&[true, false, false, true, true]);
        assert_eq!(column.values(), [0.0, 0.0, 3.0, -3.0, 4.0, -4.0]);
        assert_eq!(column.get::<2>(1), [3.0, -3.0]);
        let mut unused = Column::default();
        unused.retain(&[true, false]);
        assert!(!unused.is_used() && unused.bytes() == 0);
    }

    /// Each width, in an order without fixed points; the inverse order brings all back.
    #[test]
    fn columns_take_any_order_and_come_back() {
        let order = [3, 0, 4, 1, 2];
        let inverse = [1, 3, 4, 0, 2];
        let mut scratch = Vec::new();
        for width in 0..=10 {
            let mut column = Column::new(width, 5);
            column.values_mut().iter_mut().enumerate().for_each(|(i, value)| *value = i as f64);
            let before = column.clone();
            column.reorder(&order, &mut scratch);
            for (place, &from) in order.iter().enumerate() {
                assert_eq!(column.row(place), before.row(from as usize), "width {width}");
            }
            column.reorder(&inverse, &mut scratch);
            assert_eq!(column, before);
        }
    }

    #[test]
    fn fields_exist_only_when_asked_for() {
        const SPEED: Variable = Variable::scalar("SPEED", "m/s", "speed");
        let mut fields = Fields::default();
        assert!(fields.scalar(&SPEED).is_none() && fields.columns().is_empty());
        fields.scalar_mut(&SPEED, 3)[1] = 2.0;
        assert_eq!(fields.scalar(&SPEED), Some(&[0.0, 2.0, 0.0][..]));
        assert_eq!(fields.columns(), [("SPEED", 24)]);
        const SPIN: Variable = Variable::tensor("SPIN", "1/s", "spin");
        const STRAIN: Variable = Variable::voigt("STRAIN", "1", "strain");
        fields.rows_mut(&SPIN, 9, 3);
        assert_eq!((fields.rows(&STRAIN), fields.symmetric_width()), (None, 0));
        fields.rows_mut(&STRAIN, 4, 3).set(2, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(fields.rows(&STRAIN).map(|column| column.row(2)), Some(&[1.0, 2.0, 3.0, 4.0][..]));
        assert_eq!((fields.symmetric_width(), fields.columns().len()), (4, 3));
    }
}
