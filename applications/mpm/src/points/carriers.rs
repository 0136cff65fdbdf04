//! Loads that hang on material points.
//!
//! A load at the boundary of a body often stands in a cell whose nodes have hardly any mass: they fly
//! off, and the load with them. Here it acts through the functions of the cell of the material point
//! that was nearest at the start, continued to where the load is: the force works on the continued
//! motion of that cell, so that force and moment are kept.

use super::{Block, MaterialPoints};
use crate::space::Space;
use bia_kernel::error::{Error, Failure};
use bia_kernel::geometry::local_coordinates;

/// The point that carries a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Carrier {
    /// Its id.
    pub id: u32,
    /// Block and index where it stood last.
    pub place: (usize, usize),
}

/// Gives those conditions that want one the material point nearest to them, the first of several.
pub fn choose(points: &mut MaterialPoints) {
    for (first, end) in points.conditions.on_points.clone() {
        for i in first..end {
            let x = points.conditions.position[i];
            let distance = |y: [f64; 3]| (0..3).map(|a| (x[a] - y[a]).powi(2)).sum::<f64>();
            let of_block = |(b, block): (usize, &Block)| -> Vec<(f64, Carrier)> {
                let carrier = |p: usize| Carrier { id: block.ids[p], place: (b, p) };
                (0..block.len()).map(|p| (distance(block.coordinates(p)), carrier(p))).collect()
            };
            let all = points.blocks.iter().enumerate().flat_map(of_block);
            let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.id.cmp(&b.1.id)));
            points.conditions.carriers[i] = nearest.map(|(_, carrier)| carrier);
        }
    }
}

/// Block and index of a carrier; looked for only where it does not stand any more.
fn find(blocks: &[Block], carrier: Carrier) -> Option<(usize, usize)> {
    let (b, p) = carrier.place;
    if blocks.get(b).and_then(|block| block.ids.get(p)) == Some(&carrier.id) {
        return Some(carrier.place);
    }
    let of_block = |(b, block): (usize, &Block)| Some((b, block.ids.iter().position(|id| *id == carrier.id)?));
    blocks.iter().enumerate().find_map(of_block)
}

/// Puts a condition into the cell of its carrier.
///
/// # Errors
/// The carrier has left the grid, or is so far away that the cell does not reach the condition.
pub fn follow(points: &mut MaterialPoints, space: &Space, condition: usize, carrier: Carrier) -> Result<(), Error> {
    let conditions = &mut points.conditions;
    let x = conditions.position[condition];
    let found = find(&points.blocks, carrier).and_then(|place| {
        let cell = points.blocks[place.0].cell[place.1];
        let corners: Vec<[f64; 3]> =
            space.nodes_of(cell as usize).iter().map(|node| space.position(*node as usize)).collect();
        let local = match space.shape(cell as usize) {
            Some(shape) => local_coordinates(shape, &corners, x)?,
            None => space.local(cell as usize, x, [0.0; 3]),
        };
        Some((place, cell, local))
    });
    let Some((place, cell, local)) = found else {
        let advice = "a larger grid, or \"carrier\": \"grid\"";
        let message = format!("material point {}, which carries a load, has left the grid or its load", carrier.id);
        let name = format!("material-point condition {}", conditions.ids[condition]);
        return Err(Failure::new(message, advice).at(name, x).into());
    };
    conditions.carriers[condition] = Some(Carrier { place, ..carrier });
    (conditions.cell[condition], conditions.local[condition]) = (cell, local);
    Ok(())
}
