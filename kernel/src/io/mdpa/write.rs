//! Writer of Kratos's mesh files: what a model part holds, in the order that Kratos reads.

use super::cells::GEOMETRIES;
use crate::geometry::Shape;
use crate::io::files::write_atomically;
use crate::model::{Cells, ModelPart, SubModelPart, Table, Value};
use std::io::{self, Write};
use std::path::Path;

/// A name of a sub model part as one word, which the format wants.
fn word(name: &str) -> String {
    name.replace(char::is_whitespace, "_")
}

/// What a model part holds and the format does not, in words: names with blanks.
pub fn losses(part: &ModelPart) -> Vec<String> {
    let paths = part.paths();
    let names = paths.iter().filter_map(|path| path.rsplit('.').next()).filter(|name| word(name) != *name);
    names.map(|name| format!("blanks in names: {name:?} is written as {:?}", word(name))).collect()
}

/// Writes a root model part to `path` and returns the size of the file in bytes. All that a model part holds
/// before a run has its place in the format, but for blanks in names ([`losses`]); numbers are exact.
///
/// # Errors
/// Those of the file system; no part of a file is left.
pub fn write(part: &ModelPart, path: &Path) -> io::Result<u64> {
    write_atomically(path, |out| {
        write_properties(part, out)?;
        for (id, table) in &part.tables {
            // The names of its variables are not kept by any reader; the format wants two.
            write_table(&format!("{id} TIME VALUE"), table, "", out)?;
        }
        writeln!(out, "Begin Nodes")?;
        for (id, [x, y, z]) in part.nodes.ids.iter().zip(&part.nodes.coordinates) {
            writeln!(out, "  {id} {x:?} {y:?} {z:?}")?;
        }
        writeln!(out, "End Nodes\n")?;
        for (block, cells) in
            [("Elements", &part.elements), ("Conditions", &part.conditions), ("Geometries", &part.geometries)]
        {
            write_cells(block, cells, &part.nodes.ids, out)?;
        }
        write_data(part, out)?;
        part.children.iter().try_for_each(|child| write_part(child, part, 0, out))
    })
}

fn write_properties(part: &ModelPart, out: &mut dyn Write) -> io::Result<()> {
    for (id, properties) in &part.properties {
        writeln!(out, "Begin Properties {id}")?;
        if let Some(law) = &properties.law {
            writeln!(out, "  CONSTITUTIVE_LAW {law}")?;
        }
        for (name, value) in &properties.values {
            writeln!(out, "  {name} {}", text(value))?;
        }
        for ((x, y), table) in &properties.tables {
            write_table(&format!("{x} {y}"), table, "  ", out)?;
        }
        writeln!(out, "End Properties\n")?;
    }
    Ok(())
}

fn write_table(header: &str, table: &Table, indent: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{indent}Begin Table {header}")?;
    for (x, y) in table.points() {
        writeln!(out, "{indent}  {x:?} {y:?}")?;
    }
    writeln!(out, "{indent}End Table\n")
}

/// One block for each run of cells of one name, so that the order of ids is kept.
fn write_cells(block: &str, cells: &Cells, node_ids: &[u32], out: &mut dyn Write) -> io::Result<()> {
    let mut open: Option<u16> = None;
    for cell in 0..cells.len() {
        let kind = cells.kinds[cell];
        if open != Some(kind) {
            if open.is_some() {
                writeln!(out, "End {block}\n")?;
            }
            let name = cells.name_of(cell);
            let name = if block == "Geometries" { geometry(name, cells.shapes[cell]) } else { name };
            writeln!(out, "Begin {block} {name}")?;
            open = Some(kind);
        }
        write!(out, "  {}", cells.ids[cell])?;
        if block != "Geometries" {
            write!(out, " {}", cells.properties[cell])?;
        }
        for &node in cells.nodes_of(cell) {
            write!(out, " {}", node_ids[node as usize])?;
        }
        writeln!(out)?;
    }
    if open.is_some() { writeln!(out, "End {block}\n") } else { Ok(()) }
}

/// A name of geometries that the format knows; there are none for spaces of one dimension.
fn geometry(name: &str, shape: Shape) -> &str {
    match GEOMETRIES.iter().any(|(known, _)| *known == name) {
        true => name,
        false => GEOMETRIES.iter().find(|(_, known)| *known == shape).map_or(name, |(known, _)| known),
    }
}

fn write_data(part: &ModelPart, out: &mut dyn Write) -> io::Result<()> {
    for (variable, rows) in &part.nodal_data {
        writeln!(out, "Begin NodalData {variable}")?;
        for (node, fixed, value) in rows {
            let id = part.nodes.ids[*node as usize];
            match value {
                // A flag: its row is an id alone.
                Value::Bool(true) => writeln!(out, "  {id}")?,
                value => writeln!(out, "  {id} {} {}", u8::from(*fixed), text(value))?,
            }
        }
        writeln!(out, "End NodalData\n")?;
    }
    for (block, data, cells) in [
        ("ElementalData", &part.elemental_data, &part.elements),
        ("ConditionalData", &part.conditional_data, &part.conditions),
    ] {
        for (variable, rows) in data {
            writeln!(out, "Begin {block} {variable}")?;
            for (cell, value) in rows {
                writeln!(out, "  {} {}", cells.ids[*cell as usize], text(value))?;
            }
            writeln!(out, "End {block}\n")?;
        }
    }
    Ok(())
}

fn write_part(part: &SubModelPart, root: &ModelPart, depth: usize, out: &mut dyn Write) -> io::Result<()> {
    let indent = "  ".repeat(depth);
    writeln!(out, "{indent}Begin SubModelPart {}", word(&part.name))?;
    let ids = |list: &[u32], ids: &[u32]| list.iter().map(|&i| ids[i as usize]).collect::<Vec<u32>>();
    for (block, list) in [
        ("Tables", part.tables.clone()),
        ("Properties", part.properties.clone()),
        ("Nodes", ids(&part.nodes, &root.nodes.ids)),
        ("Elements", ids(&part.elements, &root.elements.ids)),
        ("Conditions", ids(&part.conditions, &root.conditions.ids)),
        ("Geometries", ids(&part.geometries, &root.geometries.ids)),
    ] {
        if !list.is_empty() {
            writeln!(out, "{indent}  Begin SubModelPart{block}")?;
            list.iter().try_for_each(|id| writeln!(out, "{indent}    {id}"))?;
            writeln!(out, "{indent}  End SubModelPart{block}")?;
        }
    }
    part.children.iter().try_for_each(|child| write_part(child, root, depth + 1, out))?;
    writeln!(out, "{indent}End SubModelPart")
}

/// A value as the format writes it.
fn text(value: &Value) -> String {
    let row = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        format!("({})", numbers.join(","))
    };
    match value {
        Value::Bool(value) => value.to_string(),
        Value::Number(number) => format!("{number:?}"),
        Value::Text(text) => text.clone(),
        Value::Vector(numbers) => format!("[{}]{}", numbers.len(), row(numbers)),
        Value::Matrix(rows) => {
            let columns = rows.first().map_or(0, Vec::len);
            let rows: Vec<String> = rows.iter().map(|numbers| row(numbers)).collect();
            format!("[{},{columns}]({})", rows.len(), rows.join(","))
        }
    }
}
