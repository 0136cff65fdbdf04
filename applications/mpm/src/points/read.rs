//! Material points as processes of the kernel read them.

use super::MaterialPoints;
use super::fields::append;
use bia_kernel::model::{Model, PointHandle, PointPlace, PointSet};
use bia_kernel::variables::Variable;

impl PointSet for MaterialPoints {
    fn select(&self, _: &Model, part: &str) -> Option<Vec<PointHandle>> {
        MaterialPoints::select(self, part).map(|selection| self.by_id(selection))
    }

    fn place(&self, (block, point): PointHandle) -> PointPlace {
        let (block, point) = (&self.blocks[block as usize], point as usize);
        let (position, moved) = (block.coordinates(point), block.displacement.row(point));
        let initial = std::array::from_fn(|a| position[a] - moved.get(a).copied().unwrap_or(0.0));
        PointPlace { id: block.ids[point], position, initial, volume: block.mass.row(point)[0] / block.density }
    }

    fn append(&self, (block, point): PointHandle, variable: &Variable, out: &mut Vec<f64>) {
        append(&self.blocks[block as usize], point as usize, variable.name, out);
    }
}
