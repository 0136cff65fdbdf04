//! How much more volume points have than there is room: over blocks of cells, Σ max(0, Σ V_p − V_block)
//! divided by the volume of all points. An incompressible fluid whose points gather shows it.

use bia_kernel::geometry::Shape;
use bia_kernel::model::ModelPart;
use std::collections::BTreeMap;

/// Share of a block by which a cell may stick out of it.
const SLACK: f64 = 1e-6;

/// Boxes of one size that begin at the lowest corner of the grid.
pub struct Blocks {
    origin: [f64; 3],
    size: [f64; 3],
    /// Volume (m³), or area in the plane (m²), of the cells in each block.
    room: BTreeMap<[i64; 3], f64>,
    filled: BTreeMap<[i64; 3], f64>,
    total: f64,
}

impl Blocks {
    /// Blocks of this size (m) in a grid of this dimension.
    ///
    /// # Errors
    /// The id of a cell that does not lie in one block.
    pub fn new(grid: &ModelPart, size: [f64; 3], dimension: usize) -> Result<Self, u32> {
        let mut origin = [f64::INFINITY; 3];
        for x in &grid.nodes.coordinates {
            (0..3).for_each(|a| origin[a] = origin[a].min(x[a]));
        }
        let size = std::array::from_fn(|a| if a < dimension { size[a] } else { f64::INFINITY });
        let mut blocks = Self { origin, size, room: BTreeMap::new(), filled: BTreeMap::new(), total: 0.0 };
        for cell in 0..grid.elements.len() {
            let corners = grid.corners(&grid.elements, cell);
            let middle = std::array::from_fn(|a| corners.iter().map(|x| x[a]).sum::<f64>() / corners.len() as f64);
            let at = blocks.block_of(middle);
            let within = |x: &[f64; 3]| {
                (0..dimension).all(|a| {
                    let place = (x[a] - origin[a]) / blocks.size[a] - at[a] as f64;
                    (-SLACK..=1.0 + SLACK).contains(&place)
                })
            };
            if !corners.iter().all(within) {
                return Err(grid.elements.ids[cell]);
            }
            let shape: Shape = grid.elements.shapes[cell];
            *blocks.room.entry(at).or_default() += shape.measure(&corners).abs();
        }
        Ok(blocks)
    }

    fn block_of(&self, x: [f64; 3]) -> [i64; 3] {
        std::array::from_fn(|a| ((x[a] - self.origin[a]) / self.size[a]).floor() as i64)
    }

    /// Empties the blocks.
    pub fn clear(&mut self) {
        self.filled.clear();
        self.total = 0.0;
    }

    /// Puts the volume of a point at its place.
    pub fn fill(&mut self, x: [f64; 3], volume: f64) {
        *self.filled.entry(self.block_of(x)).or_default() += volume;
        self.total += volume;
    }

    /// The share of the volume that is too much where it is.
    pub fn overfill(&self) -> f64 {
        let room = |at: &[i64; 3]| self.room.get(at).copied().unwrap_or(0.0);
        let excess: f64 = self.filled.iter().map(|(at, volume)| (volume - room(at)).max(0.0)).sum();
        excess / self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 × 2 unit squares from (−1, 3) on.
    fn grid() -> ModelPart {
        let mut part = ModelPart::new("Grid");
        for j in 0..3 {
            for i in 0..5 {
                part.nodes.ids.push(5 * j + i + 1);
                part.nodes.coordinates.push([f64::from(i) - 1.0, f64::from(j) + 3.0, 0.0]);
            }
        }
        for cell in 0..8 {
            let a = cell / 4 * 5 + cell % 4;
            part.elements.push(cell + 1, "Square", Shape::Quadrilateral4, 0, &[a, a + 1, a + 6, a + 5]);
        }
        part
    }

    #[test]
    fn what_is_above_the_room_of_a_block_counts() {
        let mut blocks = Blocks::new(&grid(), [2.0, 2.0, 0.0], 2).unwrap();
        for (x, volume) in [(-0.9, 3.0), (0.9, 2.0), (1.1, 3.5)] {
            blocks.fill([x, 3.2, 0.0], volume);
        }
        // The first block has room for 4 of 5, the second for 4 of 3.5.
        assert!((blocks.overfill() - 1.0 / 8.5).abs() < 1e-15);
        blocks.clear();
        blocks.fill([0.0, 4.0, 0.0], 4.0);
        assert_eq!(blocks.overfill(), 0.0);
    }

    #[test]
    fn blocks_consist_of_whole_cells() {
        assert_eq!(Blocks::new(&grid(), [1.5, 2.0, 0.0], 2).err(), Some(2));
    }
}
