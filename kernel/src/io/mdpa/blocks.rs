//! First pass: the structure of blocks, and what they hold as raw lists of ids.

use super::cells::RawCells;
use super::data::RawData;
use super::faults::{Faults, Says};
use super::parts::RawPart;
use super::values::{id, real};
use super::words::{Word, Words};
use super::{Category, CellNames};
use crate::model::{Properties, Table};
use std::collections::BTreeMap;

/// Blocks of the outermost level.
const ROOT: [&str; 13] = [
    "ModelPartData",
    "Properties",
    "Table",
    "Nodes",
    "Elements",
    "Conditions",
    "Geometries",
    "NodalData",
    "ElementalData",
    "ConditionalData",
    "Mesh",
    "Constraints",
    "SubModelPart",
];

/// How deep blocks that are passed over are followed.
const DEEPEST: usize = 200;

/// Nodes as read, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct RawNodes {
    pub ids: Vec<u32>,
    pub coordinates: Vec<[f64; 3]>,
    pub lines: Vec<u32>,
    /// A row or block was lost to a fault: a missing id may be its consequence.
    pub incomplete: bool,
}

/// All that a file holds, with ids in place of indices.
#[derive(Debug, Default)]
pub(super) struct Raw<'a> {
    pub nodes: RawNodes,
    pub elements: RawCells,
    pub conditions: RawCells,
    pub geometries: RawCells,
    pub properties: BTreeMap<u32, Properties>,
    pub tables: BTreeMap<u32, Table>,
    pub data: Vec<RawData<'a>>,
    pub parts: Vec<RawPart<'a>>,
    /// A block was lost to a fault: an undeclared id may be its consequence.
    pub incomplete: bool,
}

/// What comes next inside a block.
pub(super) enum Item<'a> {
    /// A word that is neither `Begin` nor `End`.
    Word(Word<'a>),
    /// The word `Begin`.
    Begin(Word<'a>),
    /// The block is over, by its `End` or by a fault that was reported.
    Closed,
}

/// Reader of the first pass.
pub(super) struct Reader<'a, 'f> {
    pub words: Words<'a>,
    pub faults: &'f mut Faults<'a>,
    pub kinds: &'f dyn CellNames,
    pub raw: Raw<'a>,
    /// Names of the blocks around the cursor, outermost first.
    pub open: Vec<Word<'a>>,
    truncated: bool,
}

impl<'a, 'f> Reader<'a, 'f> {
    pub fn new(text: &'a str, kinds: &'f dyn CellNames, faults: &'f mut Faults<'a>) -> Self {
        let (words, raw) = (Words::new(text), Raw::default());
        Self { words, faults, kinds, raw, open: Vec::new(), truncated: false }
    }

    /// Reads all blocks of the file.
    pub fn read(mut self) -> Raw<'a> {
        while let Some(word) = self.words.next() {
            match word.text {
                "Begin" => self.root_block(),
                "End" => {
                    let name = self.words.next_on_line().map_or("", |name| name.text);
                    self.faults.word(word, |d| d.says(format!("`End {name}` closes no block: none is open here")));
                }
                found => {
                    self.faults.word(word, |d| {
                        d.says(format!("{found:?} stands outside of all blocks"))
                            .help("a block begins with `Begin NAME`")
                    });
                    self.words.skip_line();
                }
            }
        }
        if let Some(line) = self.words.open_comment() {
            self.faults.line(line, |d| d.says("the comment that begins here is never closed").help("close it with */"));
        }
        self.raw
    }

    fn root_block(&mut self) {
        let Some(name) = self.block_name() else { return };
        self.open.push(name);
        match name.text {
            "ModelPartData" => self.variables_block(),
            "Properties" => self.properties_block(),
            "Table" => self.table_block(),
            "Nodes" => self.nodes_block(),
            "Elements" => self.cells_block(Category::Element),
            "Conditions" => self.cells_block(Category::Condition),
            "Geometries" => self.cells_block(Category::Geometry),
            "NodalData" | "ElementalData" | "ConditionalData" => self.data_block(name),
            "Mesh" => self.pass_over_block(),
            "Constraints" => self.empty_block(),
            "SubModelPart" => {
                let part = self.sub_model_part();
                self.raw.parts.extend(part);
            }
            _ => self.unknown_block(name, &ROOT),
        }
    }

    /// The name after `Begin`.
    pub fn block_name(&mut self) -> Option<Word<'a>> {
        let line = self.words.line();
        let name = self.words.next_on_line();
        if name.is_none() {
            self.faults.line(line, |d| d.says("`Begin` without the name of a block"));
        }
        name
    }

    /// A word of a block's first line.
    pub fn header(&mut self, what: &str) -> Option<Word<'a>> {
        let word = self.words.next_on_line();
        if word.is_none() {
            let block = self.open.last().copied();
            self.faults.line(self.words.line(), |d| {
                d.says(format!("`Begin {}` needs {what} on its line", block.map_or("", |b| b.text)))
            });
        }
        word
    }

    /// Refuses further words on the line.
    pub fn end_of_line(&mut self, what: &str) {
        if let Some(word) = self.words.next_on_line() {
            self.faults.word(word, |d| d.says(format!("{:?} is one word too many: {what}", word.text)));
            self.words.skip_line();
        }
    }

    /// The next item of the innermost open block; closes the block where it ends.
    pub fn item(&mut self) -> Item<'a> {
        let Some(&block) = self.open.last() else { return Item::Closed };
        let Some(word) = self.words.next() else {
            if !self.truncated {
                self.faults.word(block, |d| {
                    d.says(format!("the file ends inside the block {} that begins here", block.text))
                        .help(format!("`End {}` is missing, or the file is cut off", block.text))
                });
            }
            self.truncated = true;
            self.open.pop();
            return Item::Closed;
        };
        match word.text {
            "Begin" => return Item::Begin(word),
            "End" => {}
            _ => return Item::Word(word),
        }
        let name = self.words.next_on_line().map_or("", |name| name.text);
        self.open.pop();
        if name != block.text {
            self.faults.word(word, |d| {
                d.says(format!("`End {name}` does not close the block {} of line {}", block.text, block.line))
                    .help(format!("`End {}` is allowed here", block.text))
            });
            // An outer block's end is left to that block; any other is taken as a misspelt one.
            if self.open.iter().any(|outer| outer.text == name) {
                self.words.back_to(word);
            }
        }
        Item::Closed
    }

    /// Rows of a block that holds no other blocks; `row` gets the first word of each.
    pub fn rows(&mut self, mut row: impl FnMut(&mut Self, Word<'a>)) {
        loop {
            match self.item() {
                Item::Word(word) => row(self, word),
                Item::Begin(begin) => return self.not_closed(begin),
                Item::Closed => return,
            }
        }
    }

    /// A `Begin` where the open block allows none: it is taken as closed before.
    pub fn not_closed(&mut self, begin: Word<'a>) {
        self.words.back_to(begin);
        if let Some(block) = self.open.pop() {
            self.words.next();
            let inner = self.words.next_on_line().map_or("", |name| name.text);
            self.faults.word(begin, |d| {
                d.says(format!("`Begin {inner}` stands inside the block {} of line {}", block.text, block.line))
                    .help(format!("`End {}` is missing before it", block.text))
            });
        }
        self.words.back_to(begin);
    }

    /// Reports the open block as unknown and passes over it.
    pub fn unknown_block(&mut self, name: Word<'a>, allowed: &[&'static str]) {
        self.faults.word(name, |d| {
            d.says(format!("the block {:?} is unknown here", name.text)).allowed(name.text, allowed.iter().copied())
        });
        self.lose_all();
        self.pass_over_block();
    }

    /// A block was lost: whatever is missing later may have stood in it.
    pub fn lose_all(&mut self) {
        let raw = &mut self.raw;
        raw.incomplete = true;
        raw.nodes.incomplete = true;
        for cells in [&mut raw.elements, &mut raw.conditions, &mut raw.geometries] {
            cells.incomplete = true;
        }
    }

    /// Passes over the open block with all blocks in it.
    pub fn pass_over_block(&mut self) {
        let depth = self.open.len();
        while self.open.len() >= depth {
            // Deeper nesting than any file has is not followed, lest a search in `open` grow long.
            if let Item::Begin(_) = self.item()
                && let Some(name) = self.block_name()
                && self.open.len() < DEEPEST
            {
                self.open.push(name);
            }
        }
    }

    /// A block that may stand in files of Kratos but must hold nothing.
    pub fn empty_block(&mut self) {
        self.words.skip_line();
        let Some(&block) = self.open.last() else { return };
        let first = self.words.next();
        match first {
            Some(word) if word.text != "End" => {
                self.faults.word(word, |d| d.says(format!("the block {} is not supported unless empty", block.text)));
                self.words.back_to(word);
                self.pass_over_block();
            }
            Some(end) => {
                self.words.back_to(end);
                self.item();
            }
            None => {
                self.item();
            }
        }
    }

    fn nodes_block(&mut self) {
        self.end_of_line("nodes stand on the following lines as `id x y z`");
        self.rows(Self::node);
    }

    fn node(&mut self, first: Word<'a>) {
        let Some(id) = self.checked(first, id(first.text)) else {
            self.raw.nodes.incomplete = true;
            return self.words.skip_line();
        };
        let mut coordinates = [0.0; 3];
        for (axis, coordinate) in coordinates.iter_mut().enumerate() {
            let Some(word) = self.words.next_on_line() else {
                self.faults.word(first, |d| {
                    d.says(format!("node {id} has {axis} coordinates on its line"))
                        .help("a node is `id x y z` on one line")
                });
                break;
            };
            match self.checked(word, real(word.text)) {
                Some(number) => *coordinate = number,
                None => {
                    self.words.skip_line();
                    break;
                }
            }
        }
        self.end_of_line("a node is `id x y z`");
        self.raw.nodes.ids.push(id);
        self.raw.nodes.coordinates.push(coordinates);
        self.raw.nodes.lines.push(first.line);
    }

    /// The value, or none after its fault was reported at `word`.
    #[inline]
    pub fn checked<T>(&mut self, word: Word<'a>, value: Result<T, String>) -> Option<T> {
        match value {
            Ok(value) => Some(value),
            Err(message) => {
                self.faults.word(word, |d| d.says(message));
                None
            }
        }
    }
}
