//! Blocks `Elements`, `Conditions` and `Geometries`.

use super::Category;
use super::blocks::Reader;
use super::faults::Says;
use super::values::{id, id_or_zero};
use super::words::Word;
use crate::geometry::Shape;
use crate::model::Cells;

/// Names of geometries with their shapes.
pub(super) const GEOMETRIES: [(&str, Shape); 10] = [
    ("Point2D", Shape::Point1),
    ("Point3D", Shape::Point1),
    ("Line2D2", Shape::Line2),
    ("Line3D2", Shape::Line2),
    ("Triangle2D3", Shape::Triangle3),
    ("Triangle3D3", Shape::Triangle3),
    ("Quadrilateral2D4", Shape::Quadrilateral4),
    ("Quadrilateral3D4", Shape::Quadrilateral4),
    ("Tetrahedra3D4", Shape::Tetrahedron4),
    ("Hexahedra3D8", Shape::Hexahedron8),
];

/// The most nodes that a shape has.
const MOST_NODES: usize = 8;

/// Cells as read, in the order of the file; `cells.nodes` holds ids, not yet indices.
#[derive(Debug, Default)]
pub(super) struct RawCells {
    pub cells: Cells,
    pub lines: Vec<u32>,
    /// A row or block was lost to a fault: a missing id may be its consequence.
    pub incomplete: bool,
}

/// What the rows of one block have in common.
#[derive(Clone, Copy)]
struct Kind<'a> {
    category: Category,
    name: &'a str,
    index: u16,
    shape: Shape,
    nodes: usize,
}

fn node_count(shape: Shape) -> usize {
    match shape {
        Shape::Point1 => 1,
        Shape::Line2 => 2,
        Shape::Triangle3 => 3,
        Shape::Quadrilateral4 | Shape::Tetrahedron4 => 4,
        Shape::Hexahedron8 => 8,
    }
}

/// What one cell of a category is called in messages.
pub(super) fn singular(category: Category) -> &'static str {
    match category {
        Category::Element => "element",
        Category::Condition => "condition",
        Category::Geometry => "geometry",
    }
}

impl<'a> Reader<'a, '_> {
    fn raw_cells(&mut self, category: Category) -> &mut RawCells {
        match category {
            Category::Element => &mut self.raw.elements,
            Category::Condition => &mut self.raw.conditions,
            Category::Geometry => &mut self.raw.geometries,
        }
    }

    /// Reads an open block of cells.
    pub fn cells_block(&mut self, category: Category) {
        let Some(kind) = self.kind(category) else {
            self.raw_cells(category).incomplete = true;
            return self.pass_over_block();
        };
        self.end_of_line("the cells stand on the following lines");
        self.rows(|reader, first| {
            if reader.cell(kind, first).is_none() {
                reader.raw_cells(category).incomplete = true;
                reader.words.skip_line();
            }
        });
    }

    /// The name on the block's first line, if it is registered.
    fn kind(&mut self, category: Category) -> Option<Kind<'a>> {
        let word = self.header("the name of its cells")?;
        let built_in = if category == Category::Geometry { &GEOMETRIES[..] } else { &[] };
        let found = built_in.iter().find(|(name, _)| *name == word.text).map(|(_, shape)| *shape);
        let Some(shape) = found.or_else(|| self.kinds.shape(category, word.text)) else {
            let registered = self.kinds.names(category);
            let names = built_in.iter().map(|(name, _)| *name).chain(registered.iter().map(String::as_str));
            self.faults.word(word, |d| {
                d.says(format!("{:?} is no {} that is registered", word.text, singular(category)))
                    .allowed(word.text, names)
            });
            self.words.skip_line();
            return None;
        };
        let names = &mut self.raw_cells(category).cells.names;
        let index = names.iter().position(|name| name == word.text).unwrap_or_else(|| {
            names.push(word.text.to_string());
            names.len() - 1
        });
        Some(Kind { category, name: word.text, index: index as u16, shape, nodes: node_count(shape) })
    }

    /// Reads the row `id [properties] node1 … nodeN`; none after a fault that lost it.
    fn cell(&mut self, kind: Kind<'a>, first: Word<'a>) -> Option<()> {
        let id_of_cell = self.checked(first, id(first.text))?;
        let mut properties = 0;
        if kind.category != Category::Geometry {
            let Some(word) = self.words.next_on_line() else {
                return self.wrong_count(kind, first, 0);
            };
            properties = self.checked(word, id_or_zero(word.text))?;
        }
        let (mut nodes, mut count) = ([0; MOST_NODES], 0);
        while let Some(word) = self.words.next_on_line() {
            if count < kind.nodes {
                nodes[count] = self.checked(word, id(word.text))?;
            }
            count += 1;
        }
        if count != kind.nodes {
            return self.wrong_count(kind, first, count);
        }
        let raw = self.raw_cells(kind.category);
        raw.lines.push(first.line);
        let cells = &mut raw.cells;
        cells.ids.push(id_of_cell);
        cells.kinds.push(kind.index);
        cells.shapes.push(kind.shape);
        cells.properties.push(properties);
        if cells.starts.is_empty() {
            cells.starts.push(0);
        }
        cells.nodes.extend_from_slice(&nodes[..count]);
        cells.starts.push(cells.nodes.len() as u32);
        Some(())
    }

    /// Reports a row with `count` nodes, and whether it goes on on the next line.
    fn wrong_count(&mut self, kind: Kind<'a>, first: Word<'a>, count: usize) -> Option<()> {
        let wraps = count < kind.nodes && self.pass_over_words(kind.nodes - count);
        let properties = if kind.category == Category::Geometry { "" } else { "properties " };
        self.faults.word(first, |d| {
            let (what, id, name) = (singular(kind.category), first.text, kind.name);
            let counts = format!("{what} {id}: {name} has {} nodes, but its line holds {count}", kind.nodes);
            let wrapped = if wraps { "; it seems to go on on the next line" } else { "" };
            d.says(format!("{counts}{wrapped}"))
                .help(format!("a row is `id {properties}node1 … node{}`, all on one line", kind.nodes))
        });
        None
    }

    /// Passes over the next line if it holds exactly `count` words, none of them a keyword.
    fn pass_over_words(&mut self, count: usize) -> bool {
        let before = self.words.clone();
        let Some(first) = self.words.next() else { return false };
        let mut words = 1;
        while self.words.next_on_line().is_some() {
            words += 1;
        }
        let same = words == count && first.text != "End" && first.text != "Begin";
        if !same {
            self.words = before;
        }
        same
    }
}
