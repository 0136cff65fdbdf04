//! Whether single points keep the volume that their pressure stands for: pressures of the order of the
//! displacements hold it in the mean over nodes alone, the better the finer the mesh.

use crate::points::MaterialPoints;

/// Change of volume, as a share of the volume before deformation, that is told.
const FAR: f64 = 0.1;

/// That a point has another volume than its pressure says, by much.
pub fn stray_volume(points: &MaterialPoints) -> Option<String> {
    let (mut farthest, mut worst) = (FAR, None);
    for block in points.blocks.iter().filter(|block| block.pressure.is_used()) {
        let Some(moduli) = block.law.mixed() else { continue };
        for point in block.in_order_of_id() {
            let point = point as usize;
            let meant = moduli.volumetric.jacobian(moduli.compressibility * block.pressure.row(point)[0]);
            let found = block.deformation_gradient(point).determinant();
            if (found - meant).abs() > farthest {
                (farthest, worst) = ((found - meant).abs(), Some((block, point, found, meant)));
            }
        }
    }
    let (block, point, found, meant) = worst?;
    Some(format!(
        "material point {} at {:?} has {found:.3} of its first volume, where its pressure stands for {meant:.3}: \
         pressures hold volumes in the mean over nodes alone, and single points stray where shear is large beside \
         the cells; finer cells bring them nearer",
        block.ids[point],
        block.coordinates(point)
    ))
}
