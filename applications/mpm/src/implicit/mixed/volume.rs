//! Whether single points keep the volume that their pressure stands for: pressures of the order of the
//! displacements hold it in the mean over nodes alone, the better the finer the mesh.

use crate::points::MaterialPoints;

/// Change of volume, as a share of the volume before deformation, by which a point strays.
const FAR: f64 = 0.1;
/// Share of the material that is told if it strays: beside corners a few points always do.
const MUCH: f64 = 0.01;

/// That much of the material has another volume than its pressure says.
pub fn stray_volume(points: &MaterialPoints) -> Option<String> {
    let (mut strayed, mut all, mut farthest, mut worst) = (0.0, 0.0, 0.0, None);
    for block in points.blocks.iter().filter(|block| block.pressure.is_used()) {
        let Some(moduli) = block.law.mixed() else { continue };
        for point in block.in_order_of_id() {
            let point = point as usize;
            let meant = moduli.volumetric.jacobian(moduli.compressibility * block.pressure.row(point)[0]);
            let found = block.deformation_gradient(point).determinant();
            let (volume, off) = (block.mass.row(point)[0] / block.density, (found - meant).abs());
            all += volume;
            strayed += if off > FAR { volume } else { 0.0 };
            if off > farthest {
                (farthest, worst) = (off, Some((block, point, found, meant)));
            }
        }
    }
    let (block, point, found, meant) = worst.filter(|_| strayed > MUCH * all)?;
    Some(format!(
        "{:.0} % of the material has a volume that is off by more than a tenth of what its pressure stands for, farthest \
         material point {} at {:?}, with {found:.3} of its first volume instead of {meant:.3}: pressures hold volumes in \
         the mean over nodes alone, and single points stray where shear is large beside the cells; finer cells bring \
         them nearer",
        100.0 * strayed / all,
        block.ids[point],
        block.coordinates(point)
    ))
}
