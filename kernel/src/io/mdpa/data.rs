//! Blocks of values: `Properties`, `Table`, `ModelPartData`, `NodalData` and its relatives.

use super::blocks::{Item, Reader};
use super::faults::Says;
use super::values::{id, id_or_zero, real, value};
use super::words::Word;
use crate::model::{Properties, Table, Value};
use std::collections::btree_map::Entry;

/// Kratos's flags: in `NodalData` a row of theirs is an id alone.
const FLAGS: [&str; 31] = [
    "ACTIVE",
    "BLOCKED",
    "BOUNDARY",
    "CONTACT",
    "FLUID",
    "FREE_SURFACE",
    "INLET",
    "INSIDE",
    "INTERACTION",
    "INTERFACE",
    "ISOLATED",
    "MARKER",
    "MASTER",
    "MODIFIED",
    "MPI_BOUNDARY",
    "NEW_ENTITY",
    "OLD_ENTITY",
    "OUTLET",
    "PERIODIC",
    "RIGID",
    "SELECTED",
    "SLAVE",
    "SLIP",
    "SOLID",
    "STRUCTURE",
    "THERMAL",
    "TO_ERASE",
    "TO_REFINE",
    "TO_SPLIT",
    "VISITED",
    "WALL",
];

/// A block of data as read: `block` is its name (`NodalData`, …).
#[derive(Debug)]
pub(super) struct RawData<'a> {
    pub block: &'a str,
    pub variable: &'a str,
    pub rows: Vec<RawRow>,
}

/// One row: of which node or cell, on which line, fixed or free, and what.
#[derive(Debug)]
pub(super) struct RawRow {
    pub id: u32,
    pub line: u32,
    pub fixed: bool,
    pub value: Value,
}

impl<'a> Reader<'a, '_> {
    /// Reads `VAR value` rows into nothing: they are only checked.
    pub fn variables_block(&mut self) {
        self.end_of_line("the variables stand on the following lines");
        self.rows(|reader, name| {
            reader.variable(name);
        });
    }

    /// The value behind the name of a variable; the cursor ends at the end of its line.
    fn variable(&mut self, name: Word<'a>) -> Option<Value> {
        if !name.text.starts_with(|letter: char| letter.is_alphabetic() || letter == '_') {
            self.faults.word(name, |d| {
                d.says(format!("{:?} is not the name of a variable", name.text)).help("a row is `VARIABLE value`")
            });
            self.words.skip_line();
            return None;
        }
        let read = self.value(name);
        self.end_of_line("a row is `VARIABLE value`");
        read
    }

    /// The value of this row, of which `first` is the first word.
    fn value(&mut self, first: Word<'a>) -> Option<Value> {
        match value(&mut self.words) {
            Ok(value) => Some(value),
            Err((word, message)) => {
                self.faults.word(word.unwrap_or(first), |d| {
                    d.says(message).help("a value is a number, a word, `[3](a,b,c)` or `[2,2]((a,b),(c,d))`")
                });
                self.words.skip_line();
                None
            }
        }
    }

    /// Reads an open block `Properties ID`; a second block of the same id adds to the first.
    pub fn properties_block(&mut self) {
        let id = self.header("an id").and_then(|word| self.checked(word, id_or_zero(word.text)));
        let Some(id) = id else {
            self.raw.incomplete = true;
            return self.pass_over_block();
        };
        self.end_of_line("the variables stand on the following lines");
        let mut properties = self.raw.properties.remove(&id).unwrap_or_default();
        properties.id = id;
        loop {
            match self.item() {
                Item::Word(name) => self.property(name, &mut properties),
                Item::Begin(begin) => {
                    if !self.inner_table(begin, &mut properties) {
                        break;
                    }
                }
                Item::Closed => break,
            }
        }
        self.raw.properties.insert(id, properties);
    }

    fn property(&mut self, name: Word<'a>, properties: &mut Properties) {
        let Some(value) = self.variable(name) else { return };
        let twice = match (name.text, value) {
            ("CONSTITUTIVE_LAW" | "CONSTITUTIVE_LAW_NAME", Value::Text(law)) => properties.law.replace(law).is_some(),
            (variable, value) => properties.values.insert(variable.to_string(), value).is_some(),
        };
        if twice {
            let message = format!("{} stands twice in the properties {}", name.text, properties.id);
            self.faults.word(name, |d| d.says(message));
        }
    }

    /// Reads `Begin Table X Y` inside of properties; false when another block begins, which closes
    /// the properties.
    fn inner_table(&mut self, begin: Word<'a>, properties: &mut Properties) -> bool {
        let name = self.words.next_on_line();
        let Some(name) = name.filter(|name| name.text == "Table") else {
            self.not_closed(begin);
            return false;
        };
        self.open.push(name);
        let variables = self.header("two variables").and_then(|x| Some((x, self.header("two variables")?)));
        let Some((x, y)) = variables else {
            self.pass_over_block();
            return true;
        };
        if let Some(table) = self.table_rows(name) {
            let variables = (x.text.to_string(), y.text.to_string());
            if properties.tables.insert(variables, table).is_some() {
                let message = format!("the table of {} and {} stands twice in the properties", x.text, y.text);
                self.faults.word(name, |d| d.says(message));
            }
        }
        true
    }

    /// Reads an open block `Table ID X Y`.
    pub fn table_block(&mut self) {
        let Some(&name) = self.open.last() else { return };
        let Some(id) = self.table_header() else {
            self.raw.incomplete = true;
            self.words.skip_line();
            return self.pass_over_block();
        };
        let Some(table) = self.table_rows(name) else {
            self.raw.incomplete = true;
            return;
        };
        match self.raw.tables.entry(id) {
            Entry::Vacant(entry) => {
                entry.insert(table);
            }
            Entry::Occupied(_) => self.faults.word(name, |d| d.says(format!("the table {id} stands twice"))),
        }
    }

    /// The id of a table, which its two variables follow.
    fn table_header(&mut self) -> Option<u32> {
        let what = "an id and two variables";
        let id = self.header(what)?;
        self.header(what)?;
        self.header(what)?;
        self.checked(id, id_or_zero(id.text))
    }

    /// The pairs of an open table; none after a fault.
    fn table_rows(&mut self, name: Word<'a>) -> Option<Table> {
        self.end_of_line("the pairs of numbers stand on the following lines");
        let (mut pairs, mut whole) = (Vec::new(), true);
        self.rows(|reader, first| {
            let x = reader.checked(first, real(first.text));
            let y = reader.words.next_on_line().or_else(|| {
                reader.faults.word(first, |d| d.says("a second number is missing").help("a row of a table is `x y`"));
                None
            });
            match (x, y.and_then(|word| reader.checked(word, real(word.text)))) {
                (Some(x), Some(y)) => pairs.push((x, y)),
                _ => {
                    whole = false;
                    return reader.words.skip_line();
                }
            }
            reader.end_of_line("a row of a table is `x y`");
        });
        if !whole {
            return None;
        }
        self.checked(name, Table::new(pairs))
    }

    /// Reads an open block `NodalData VAR`, `ElementalData VAR` or `ConditionalData VAR`.
    pub fn data_block(&mut self, block: Word<'a>) {
        let Some(variable) = self.header("the name of a variable") else { return self.pass_over_block() };
        self.end_of_line("the values stand on the following lines");
        let nodal = block.text == "NodalData";
        let flag = nodal && FLAGS.contains(&variable.text);
        let mut rows = Vec::new();
        self.rows(|reader, first| match reader.data_row(first, nodal, flag) {
            Some(row) => rows.push(row),
            None => reader.words.skip_line(),
        });
        self.raw.data.push(RawData { block: block.text, variable: variable.text, rows });
    }

    /// `id`, `id fixed value` or `id value`; none after a fault.
    fn data_row(&mut self, first: Word<'a>, nodal: bool, flag: bool) -> Option<RawRow> {
        let row = match (nodal, flag) {
            (_, true) => "a row of a flag is an id alone",
            (true, false) => "a row is `id fixed value`, all on one line",
            (false, false) => "a row is `id value`, all on one line",
        };
        let id = self.checked(first, id(first.text))?;
        let mut fixed = false;
        if nodal && !flag {
            let word = self.words.next_on_line();
            fixed = match word.map(|word| word.text) {
                Some("0") => false,
                Some("1") => true,
                _ => {
                    self.faults.word(word.unwrap_or(first), |d| {
                        d.says("0 (free) or 1 (fixed) is expected between the id and the value").help(row)
                    });
                    return None;
                }
            };
        }
        let value = if flag { Value::Bool(true) } else { self.value(first)? };
        self.end_of_line(row);
        if fixed && !matches!(value, Value::Number(_)) {
            self.faults.word(first, |d| {
                d.says("only a number can be fixed").help("give the components one by one, each in a block of its own")
            });
            return None;
        }
        Some(RawRow { id, line: first.line, fixed, value })
    }
}
