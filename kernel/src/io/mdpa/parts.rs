//! Block `SubModelPart`, which may hold others of its kind.

use super::blocks::{Item, Reader};
use super::faults::Says;
use super::values::{id, id_or_zero};
use super::words::Word;

/// How deep sub model parts may be nested.
const DEEPEST: usize = 32;

/// Blocks that list ids, in the order of [`RawPart::lists`].
const LISTS: [&str; 6] = [
    "SubModelPartNodes",
    "SubModelPartElements",
    "SubModelPartConditions",
    "SubModelPartGeometries",
    "SubModelPartTables",
    "SubModelPartProperties",
];

/// All blocks inside of a sub model part.
const INNER: [&str; 9] = [
    LISTS[0],
    LISTS[1],
    LISTS[2],
    LISTS[3],
    LISTS[4],
    LISTS[5],
    "SubModelPartData",
    "SubModelPartConstraints",
    "SubModelPart",
];

/// A sub model part as read: (id, line) of nodes, elements, conditions, geometries, tables and
/// properties, and its children.
#[derive(Debug)]
pub(super) struct RawPart<'a> {
    pub name: &'a str,
    pub line: u32,
    pub lists: [Vec<(u32, u32)>; 6],
    pub children: Vec<RawPart<'a>>,
}

impl<'a> Reader<'a, '_> {
    /// Reads an open sub model part; none when it has no usable name or stands too deep.
    pub fn sub_model_part(&mut self) -> Option<RawPart<'a>> {
        let Some(name) = self.part_name() else {
            self.pass_over_block();
            return None;
        };
        self.end_of_line("a sub model part has one name, without blanks");
        let mut part = RawPart { name: name.text, line: name.line, lists: Default::default(), children: Vec::new() };
        loop {
            match self.item() {
                Item::Word(word) => {
                    self.faults.word(word, |d| {
                        d.says(format!("{:?} stands in a sub model part, outside of its blocks", word.text))
                            .help(format!("ids stand inside blocks: {}", LISTS.join(", ")))
                    });
                    self.words.skip_line();
                }
                Item::Begin(begin) => {
                    if !self.inner_block(begin, &mut part) {
                        return Some(part);
                    }
                }
                Item::Closed => return Some(part),
            }
        }
    }

    fn part_name(&mut self) -> Option<Word<'a>> {
        let name = self.header("a name")?;
        if name.text.contains('.') {
            self.faults.word(name, |d| {
                d.says(format!("the name {:?} holds a dot, which parts the names of nested parts", name.text))
            });
            return None;
        }
        let depth = self.open.iter().filter(|block| block.text == "SubModelPart").count();
        if depth > DEEPEST {
            self.faults.word(name, |d| d.says(format!("sub model parts are nested more than {DEEPEST} deep")));
            return None;
        }
        Some(name)
    }

    /// Reads a block inside of `part`; false when the block belongs to the root, which closes the
    /// part.
    fn inner_block(&mut self, begin: Word<'a>, part: &mut RawPart<'a>) -> bool {
        let Some(name) = self.block_name() else { return true };
        let root = ["Properties", "Table", "Nodes", "Elements", "Conditions", "Geometries"];
        if root.contains(&name.text) {
            self.not_closed(begin);
            return false;
        }
        self.open.push(name);
        if let Some(list) = LISTS.iter().position(|block| *block == name.text) {
            self.end_of_line("the ids stand on the following lines");
            let read = if list < 4 { id } else { id_or_zero };
            self.rows(|reader, word| {
                let id = reader.checked(word, read(word.text));
                part.lists[list].extend(id.map(|id| (id, word.line)));
            });
            return true;
        }
        match name.text {
            "SubModelPart" => {
                let child = self.sub_model_part();
                part.children.extend(child);
            }
            "SubModelPartData" => self.variables_block(),
            "SubModelPartConstraints" => self.empty_block(),
            _ => self.unknown_block(name, &INNER),
        }
        true
    }
}
