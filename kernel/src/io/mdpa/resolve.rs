//! Second pass: ids become indices, everything is sorted by id, and references are checked.

use super::Category;
use super::blocks::{Raw, RawNodes};
use super::cells::{RawCells, singular};
use super::data::{RawData, RawRow};
use super::faults::{Faults, Says};
use super::parts::RawPart;
use crate::model::{Cells, ModelPart, Nodes, SubModelPart, Value};
use std::collections::{BTreeMap, HashMap};

/// Which containers lost rows to faults; what is missing in them is not reported again.
#[derive(Clone, Copy)]
struct Incomplete {
    /// Nodes, elements, conditions, geometries.
    entities: [bool; 4],
    /// Properties and tables.
    declared: bool,
}

/// Builds the model part of what was read.
pub(super) fn model_part(raw: Raw<'_>, name: &str, faults: &mut Faults<'_>) -> ModelPart {
    let incomplete = Incomplete {
        entities: [raw.nodes.incomplete, raw.elements.incomplete, raw.conditions.incomplete, raw.geometries.incomplete],
        declared: raw.incomplete,
    };
    let mut part = ModelPart { properties: raw.properties, tables: raw.tables, ..ModelPart::new(name) };
    part.nodes = nodes(raw.nodes, faults);
    let groups = [
        (Category::Element, raw.elements, &mut part.elements),
        (Category::Condition, raw.conditions, &mut part.conditions),
        (Category::Geometry, raw.geometries, &mut part.geometries),
    ];
    for (category, cells, target) in groups {
        if category != Category::Geometry && !incomplete.declared {
            let declared: Vec<u32> = part.properties.keys().copied().collect();
            check_properties(category, &cells, &declared, faults);
        }
        *target = resolve_cells(category, cells, &part.nodes, incomplete.entities[0], faults);
    }
    data(raw.data, incomplete, &mut part, faults);
    part.children = sub_model_parts(raw.parts, "", &part, incomplete, faults);
    part
}

/// Sorts nodes and merges those that stand twice with the same coordinates.
fn nodes(raw: RawNodes, faults: &mut Faults<'_>) -> Nodes {
    let RawNodes { ids, coordinates, lines, .. } = raw;
    if ids.is_sorted_by(|a, b| a < b) {
        return Nodes { ids, coordinates };
    }
    let mut order: Vec<usize> = (0..ids.len()).collect();
    order.sort_by_key(|&row| ids[row]);
    let mut sorted = Nodes { ids: Vec::with_capacity(ids.len()), coordinates: Vec::with_capacity(ids.len()) };
    let mut kept = 0;
    for row in order {
        if sorted.ids.last() != Some(&ids[row]) {
            sorted.ids.push(ids[row]);
            sorted.coordinates.push(coordinates[row]);
            kept = row;
        } else if coordinates[row] != coordinates[kept] {
            faults.line(lines[row], |d| {
                d.says(format!(
                    "node {} stands twice: here at {:?}, on line {} at {:?}",
                    ids[row], coordinates[row], lines[kept], coordinates[kept]
                ))
                .help("give one of them another id; the same id may only repeat the same coordinates")
            });
        }
    }
    sorted
}

/// Reports each properties id that cells use and nothing declares, once.
fn check_properties(category: Category, raw: &RawCells, declared: &[u32], faults: &mut Faults<'_>) {
    let mut missing: BTreeMap<u32, (u32, usize)> = BTreeMap::new();
    let mut known = None;
    for (&properties, &line) in raw.cells.properties.iter().zip(&raw.lines) {
        if known == Some(properties) {
            continue;
        }
        if declared.binary_search(&properties).is_ok() {
            known = Some(properties);
        } else {
            missing.entry(properties).or_insert((line, 0)).1 += 1;
        }
    }
    for (id, (line, count)) in missing {
        faults.line(line, |d| {
            let what = singular(category);
            let list: Vec<String> = declared.iter().map(u32::to_string).collect();
            let list = if list.is_empty() { "none".to_string() } else { list.join(", ") };
            d.says(format!("the properties {id} of {count} {what}(s), here the first, are not declared"))
                .help(format!("add `Begin Properties {id}` and `End Properties`; declared: {list}"))
        });
    }
}

fn resolve_cells(
    category: Category,
    raw: RawCells,
    nodes: &Nodes,
    nodes_incomplete: bool,
    faults: &mut Faults<'_>,
) -> Cells {
    let RawCells { mut cells, lines, .. } = raw;
    for cell in 0..cells.len() {
        for node in &mut cells.nodes[cells.starts[cell] as usize..cells.starts[cell + 1] as usize] {
            match nodes.index(*node) {
                Some(index) => *node = index,
                None if nodes_incomplete => {}
                None => faults.line(lines[cell], |d| {
                    d.says(format!(
                        "{} {} names the node {node}, which is missing",
                        singular(category),
                        cells.ids[cell]
                    ))
                    .help(range("nodes", &nodes.ids))
                }),
            }
        }
    }
    report_doubles(category, &cells.ids, &lines, faults);
    cells.sort_by_id();
    cells
}

fn report_doubles(category: Category, ids: &[u32], lines: &[u32], faults: &mut Faults<'_>) {
    if ids.is_sorted_by(|a, b| a < b) {
        return;
    }
    let mut rows: Vec<usize> = (0..ids.len()).collect();
    rows.sort_by_key(|&row| ids[row]);
    for pair in rows.windows(2).filter(|pair| ids[pair[0]] == ids[pair[1]]) {
        faults.line(lines[pair[1]], |d| {
            let what = singular(category);
            d.says(format!("{what} {} stands twice, first on line {}", ids[pair[1]], lines[pair[0]]))
        });
    }
}

/// What ids there are, in one sentence.
fn range(what: &str, ids: &[u32]) -> String {
    match (ids.first(), ids.last()) {
        (Some(first), Some(last)) => format!("the file holds {} {what} with ids from {first} to {last}", ids.len()),
        _ => format!("the file holds no {what}"),
    }
}

/// Hangs the data blocks on nodes, elements and conditions, ascending by index.
fn data(raw: Vec<RawData<'_>>, incomplete: Incomplete, part: &mut ModelPart, faults: &mut Faults<'_>) {
    let mut groups: BTreeMap<(&str, &str), Vec<RawRow>> = BTreeMap::new();
    for block in raw {
        groups.entry((block.block, block.variable)).or_default().extend(block.rows);
    }
    for ((block, variable), rows) in groups {
        let [nodes, elements, conditions, _] = incomplete.entities;
        let rows = match block {
            "NodalData" => indexed(rows, variable, nodes, |id| part.nodes.index(id), faults),
            "ElementalData" => indexed(rows, variable, elements, |id| part.elements.index(id), faults),
            _ => indexed(rows, variable, conditions, |id| part.conditions.index(id), faults),
        };
        let variable = variable.to_string();
        let free = |(index, _, value): (u32, bool, Value)| (index, value);
        match block {
            "NodalData" => drop(part.nodal_data.insert(variable, rows)),
            "ElementalData" => drop(part.elemental_data.insert(variable, rows.into_iter().map(free).collect())),
            _ => drop(part.conditional_data.insert(variable, rows.into_iter().map(free).collect())),
        }
    }
}

fn indexed(
    rows: Vec<RawRow>,
    variable: &str,
    lost: bool,
    find: impl Fn(u32) -> Option<u32>,
    faults: &mut Faults<'_>,
) -> Vec<(u32, bool, Value)> {
    let mut found: Vec<(u32, RawRow)> = Vec::with_capacity(rows.len());
    for row in rows {
        match find(row.id) {
            Some(index) => found.push((index, row)),
            None if lost => {}
            None => faults
                .line(row.line, |d| d.says(format!("{variable} is given for the id {}, which is missing", row.id))),
        }
    }
    found.sort_by_key(|(index, _)| *index);
    let mut out: Vec<(u32, bool, Value)> = Vec::with_capacity(found.len());
    let mut first_line = 0;
    for (index, row) in found {
        match out.last() {
            Some(last) if last.0 == index => {
                if (last.1, &last.2) != (row.fixed, &row.value) {
                    faults.line(row.line, |d| {
                        d.says(format!(
                            "{variable} is given twice for the id {}, otherwise on line {first_line}",
                            row.id
                        ))
                    });
                }
            }
            _ => {
                first_line = row.line;
                out.push((index, row.fixed, row.value));
            }
        }
    }
    out
}

/// Turns ids into indices and inserts what children hold into their parents.
fn sub_model_parts(
    raw: Vec<RawPart<'_>>,
    parent: &str,
    root: &ModelPart,
    incomplete: Incomplete,
    faults: &mut Faults<'_>,
) -> Vec<SubModelPart> {
    let mut names: HashMap<&str, u32> = HashMap::new();
    let mut parts = Vec::with_capacity(raw.len());
    for part in raw {
        if let Some(first) = names.insert(part.name, part.line) {
            faults.line(part.line, |d| {
                d.says(format!("the sub model part {:?} stands twice, first on line {first}", part.name))
                    .help("its ids belong into one block, or it needs another name")
            });
        }
        let path = if parent.is_empty() { part.name.to_string() } else { format!("{parent}.{}", part.name) };
        parts.push(sub_model_part(part, &path, root, incomplete, faults));
    }
    parts
}

fn sub_model_part(
    raw: RawPart<'_>,
    path: &str,
    root: &ModelPart,
    incomplete: Incomplete,
    faults: &mut Faults<'_>,
) -> SubModelPart {
    let mut part = SubModelPart { name: raw.name.to_string(), ..SubModelPart::default() };
    let [nodes, elements, conditions, geometries] = incomplete.entities;
    type Find<'r> = &'r dyn Fn(u32) -> Option<u32>;
    let sources: [(&str, bool, Find<'_>); 6] = [
        ("node", nodes, &|id| root.nodes.index(id)),
        ("element", elements, &|id| root.elements.index(id)),
        ("condition", conditions, &|id| root.conditions.index(id)),
        ("geometry", geometries, &|id| root.geometries.index(id)),
        ("table", incomplete.declared, &|id| root.tables.contains_key(&id).then_some(id)),
        ("properties", incomplete.declared, &|id| root.properties.contains_key(&id).then_some(id)),
    ];
    for ((target, (what, lost, find)), list) in lists(&mut part).into_iter().zip(sources).zip(raw.lists) {
        target.reserve(list.len());
        for (id, line) in list {
            match find(id) {
                Some(index) => target.push(index),
                None if lost => {}
                None => faults.line(line, |d| {
                    d.says(format!("the sub model part {path:?} names the {what} {id}, which is missing"))
                        .help(format!("the {what} must stand in a block of the root, outside of sub model parts"))
                }),
            }
        }
    }
    let mut children = sub_model_parts(raw.children, path, root, incomplete, faults);
    for child in &mut children {
        for (target, inner) in lists(&mut part).into_iter().zip(lists(child)) {
            target.extend_from_slice(inner);
        }
    }
    part.children = children;
    for target in lists(&mut part) {
        target.sort_unstable();
        target.dedup();
    }
    part
}

/// The lists of a sub model part in the order of [`RawPart::lists`].
fn lists(part: &mut SubModelPart) -> [&mut Vec<u32>; 6] {
    let SubModelPart { nodes, elements, conditions, geometries, tables, properties, .. } = part;
    [nodes, elements, conditions, geometries, tables, properties]
}
