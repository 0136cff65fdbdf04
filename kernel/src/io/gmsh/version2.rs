//! Sections of format 2.2.

use super::RawCell;
use super::cells::CellType;
use super::source::Source;
use crate::diagnostic::InputErrors;

/// A count stands on a line of its own, in binary files too.
fn count(source: &mut Source, least_size: u64) -> Result<usize, InputErrors> {
    let line = source.line()?;
    match line.trim().parse::<u64>() {
        Ok(count) => source.check_count(count, least_size),
        Err(_) => Err(source.fault(format!("{line:?} is no count")).into()),
    }
}

/// Ids and coordinates of nodes.
pub(super) fn nodes(source: &mut Source) -> Result<Vec<(u32, [f64; 3])>, InputErrors> {
    let count = count(source, 28)?;
    (0..count).map(|_| Ok((source.int_id()?, source.place()?))).collect()
}

/// Cells. Those of a binary file stand in blocks of one kind and number of tags.
pub(super) fn elements(source: &mut Source) -> Result<Vec<RawCell>, InputErrors> {
    let count = count(source, 8)?;
    let mut cells = Vec::with_capacity(count);
    while cells.len() < count {
        if source.is_text() {
            let id = source.int_id()?;
            let kind = source.int()?;
            let kind = CellType::read(source, kind)?;
            let tags = source.int()?;
            cells.push(cell(source, id, kind, tags)?);
            continue;
        }
        let kind = source.int()?;
        let kind = CellType::read(source, kind)?;
        let (in_block, tags) = (source.int()?, source.int()?);
        if in_block < 1 || in_block as usize > count - cells.len() {
            return Err(source.fault(format!("a block of {in_block} cells does not fit {count} cells")).into());
        }
        for _ in 0..in_block {
            let id = source.int_id()?;
            cells.push(cell(source, id, kind, tags)?);
        }
    }
    Ok(cells)
}

/// The first tag is the physical group, 0 for none.
fn cell(source: &mut Source, id: u32, kind: CellType, tags: i32) -> Result<RawCell, InputErrors> {
    if !(0..=1000).contains(&tags) {
        return Err(source.fault(format!("the cell {id} has {tags} tags")).into());
    }
    let mut group = 0;
    for tag in 0..tags {
        let value = source.int()?;
        if tag == 0 {
            group = value;
        }
    }
    let nodes = (0..kind.0.node_count()).map(|_| source.int_id()).collect::<Result<_, _>>()?;
    let groups = if group == 0 { Vec::new() } else { vec![group] };
    Ok(RawCell { id, kind, groups, nodes })
}
