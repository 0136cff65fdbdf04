//! As much XML as `.vtu` files need: tags with attributes, comments, and the text between tags.

/// A tag; the name of a closing one begins with `/`.
#[derive(Debug)]
pub(super) struct Tag {
    pub name: String,
    attributes: Vec<(String, String)>,
    /// It closes itself.
    pub is_empty: bool,
}

impl Tag {
    /// The value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }
}

pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Longest tag: what is longer is no tag.
const LONGEST: usize = 1 << 16;

impl<'a> Scanner<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The next tag; none at the end.
    pub fn tag(&mut self) -> Result<Option<Tag>, String> {
        loop {
            let Some(begin) = self.rest().iter().position(|&byte| byte == b'<') else { return Ok(None) };
            self.at += begin;
            if self.rest().starts_with(b"<!--") {
                let end = self.rest().windows(3).position(|w| w == b"-->").ok_or("a comment does not end")?;
                self.at += end + 3;
                continue;
            }
            let tag = self.rest();
            let end = end_of_tag(&tag[..tag.len().min(LONGEST)]).ok_or("is cut off in a tag, or no XML")?;
            self.at += end + 1;
            let inner = &tag[1..end];
            if !matches!(inner.first(), Some(b'?' | b'!')) {
                return parse(inner).map(Some);
            }
        }
    }

    /// The text up to the next tag.
    pub fn text(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|&byte| byte == b'<').unwrap_or(rest.len());
        self.at += end;
        &rest[..end]
    }

    /// What follows the underscore of the appended data.
    pub fn appended(&mut self) -> Result<&'a [u8], String> {
        let rest = self.rest();
        let begin = rest.iter().position(|&byte| byte == b'_').ok_or("the appended data do not begin with _")?;
        let data = &rest[begin + 1..];
        // Raw data may hold anything, so the end is looked for from behind.
        let closing = data.windows(15).rposition(|w| w == b"</AppendedData>");
        Ok(&data[..closing.unwrap_or(data.len())])
    }
}

/// Position of the `>` that ends a tag; those inside quotes do not.
fn end_of_tag(bytes: &[u8]) -> Option<usize> {
    let mut quote = None;
    for (at, &byte) in bytes.iter().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

fn parse(inner: &[u8]) -> Result<Tag, String> {
    let text = std::str::from_utf8(inner).map_err(|_| "a tag is not UTF-8".to_string())?;
    let (text, is_empty) = match text.strip_suffix('/') {
        Some(text) => (text, true),
        None => (text, false),
    };
    let (name, mut rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let mut attributes = Vec::new();
    while let Some((attribute, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let fault = || format!("the attribute {:?} of <{name}> has no value in quotes", attribute.trim());
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\'')).ok_or_else(fault)?;
        let (value, behind) = after[1..].split_once(quote).ok_or_else(fault)?;
        attributes.push((attribute.trim().to_string(), unescaped(value)));
        rest = behind;
    }
    Ok(Tag { name: name.to_string(), attributes, is_empty })
}

fn unescaped(text: &str) -> String {
    let named = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    named.iter().fold(text.to_string(), |text, (from, to)| text.replace(from, to))
}
