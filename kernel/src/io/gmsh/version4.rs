//! Sections of format 4.1.

use super::RawCell;
use super::cells::CellType;
use super::source::Source;
use crate::diagnostic::InputErrors;
use std::collections::HashMap;

/// Tags of the physical groups of each entity, by dimension and tag.
pub(super) type EntityGroups = HashMap<(i32, i32), Vec<i32>>;

fn tags(source: &mut Source) -> Result<Vec<i32>, InputErrors> {
    let count = source.size()?;
    let count = source.check_count(count, 4)?;
    (0..count).map(|_| source.int()).collect()
}

/// Points, curves, surfaces and volumes with their groups.
pub(super) fn entities(source: &mut Source) -> Result<EntityGroups, InputErrors> {
    let counts = [source.size()?, source.size()?, source.size()?, source.size()?];
    let mut groups = EntityGroups::new();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..source.check_count(count, 28)? {
            let tag = source.int()?;
            source.place()?;
            if dimension > 0 {
                source.place()?;
            }
            let of_entity = tags(source)?;
            if dimension > 0 {
                tags(source)?;
            }
            // A negative tag only says that the orientation is turned.
            let of_entity: Vec<i32> = of_entity.into_iter().map(i32::saturating_abs).collect();
            groups.insert((dimension as i32, tag), of_entity);
        }
    }
    Ok(groups)
}

/// Ids and coordinates of nodes, block by block.
pub(super) fn nodes(source: &mut Source) -> Result<Vec<(u32, [f64; 3])>, InputErrors> {
    let [blocks, total, ..] = [source.size()?, source.size()?, source.size()?, source.size()?];
    let total = source.check_count(total, 32)?;
    let mut nodes = Vec::with_capacity(total);
    for _ in 0..source.check_count(blocks, 20)? {
        let (dimension, _, parametric) = (source.int()?, source.int()?, source.int()?);
        let count = source.size()?;
        let count = source.check_count(count, 32)?;
        let ids: Vec<u32> = (0..count).map(|_| source.size_id()).collect::<Result<_, _>>()?;
        for id in ids {
            nodes.push((id, source.place()?));
            for _ in 0..if parametric == 0 { 0 } else { dimension } {
                source.double()?;
            }
        }
    }
    if nodes.len() != total {
        return Err(source.fault(format!("{total} nodes are announced, and {} follow", nodes.len())).into());
    }
    Ok(nodes)
}

/// Cells, block by block.
pub(super) fn elements(source: &mut Source, groups: &EntityGroups) -> Result<Vec<RawCell>, InputErrors> {
    let [blocks, total, ..] = [source.size()?, source.size()?, source.size()?, source.size()?];
    let total = source.check_count(total, 16)?;
    let mut cells = Vec::with_capacity(total);
    for _ in 0..source.check_count(blocks, 20)? {
        let (dimension, entity, kind) = (source.int()?, source.int()?, source.int()?);
        let kind = CellType::read(source, kind)?;
        let of_entity = groups.get(&(dimension, entity)).cloned().unwrap_or_default();
        let count = source.size()?;
        for _ in 0..source.check_count(count, 16)? {
            let id = source.size_id()?;
            let nodes = (0..kind.0.node_count()).map(|_| source.size_id()).collect::<Result<_, _>>()?;
            cells.push(RawCell { id, kind, groups: of_entity.clone(), nodes });
        }
    }
    if cells.len() != total {
        return Err(source.fault(format!("{total} cells are announced, and {} follow", cells.len())).into());
    }
    Ok(cells)
}
