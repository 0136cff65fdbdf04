//! Words of an mdpa text, with their lines; comments count as blanks.

/// A word: its text, where it begins (byte) and on which line (from 1).
#[derive(Debug, Clone, Copy)]
pub(super) struct Word<'a> {
    pub text: &'a str,
    pub start: usize,
    pub line: u32,
}

/// A cursor over the words of a text.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    text: &'a str,
    at: usize,
    line: u32,
    open_comment: Option<u32>,
}

impl<'a> Words<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0, line: 1, open_comment: None }
    }

    /// The line of the cursor.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// The line on which a comment begins that nothing closes, if the cursor came over one.
    pub fn open_comment(&self) -> Option<u32> {
        self.open_comment
    }

    /// The next word on this or a later line.
    pub fn next(&mut self) -> Option<Word<'a>> {
        self.skip_blanks(true);
        self.word()
    }

    /// The next word, if one stands on this line.
    #[inline]
    pub fn next_on_line(&mut self) -> Option<Word<'a>> {
        self.skip_blanks(false);
        self.word()
    }

    /// Goes to the end of the line.
    pub fn skip_line(&mut self) {
        while self.next_on_line().is_some() {}
    }

    /// Goes back to the beginning of a word.
    pub fn back_to(&mut self, word: Word<'a>) {
        self.at = word.start;
        self.line = word.line;
    }

    /// The next byte that is not blank, which stays unread.
    pub fn peek(&mut self, over_lines: bool) -> Option<u8> {
        self.skip_blanks(over_lines);
        self.text.as_bytes().get(self.at).copied().filter(|&byte| byte != b'\n')
    }

    /// Passes over one byte that [`Words::peek`] showed.
    pub fn pass(&mut self) {
        self.at += 1;
    }

    /// An empty word where the next one begins, to give a place to a fault.
    pub fn here(&mut self) -> Word<'a> {
        self.skip_blanks(true);
        self.cut(self.at)
    }

    /// The text up to the next blank or one of `stops`, which may be empty.
    pub fn until(&mut self, stops: &[u8]) -> Word<'a> {
        self.skip_blanks(true);
        let start = self.at;
        let rest = self.text.as_bytes()[start..].iter();
        self.at += rest.take_while(|byte| !is_blank(**byte) && !stops.contains(byte)).count();
        self.cut(start)
    }

    #[inline]
    fn skip_blanks(&mut self, over_lines: bool) {
        let bytes = self.text.as_bytes();
        while let Some(&byte) = bytes.get(self.at) {
            match byte {
                b'\n' if !over_lines => return,
                b'\n' => {
                    self.line += 1;
                    self.at += 1;
                }
                b'/' if self.skip_comment() => {}
                _ if is_blank(byte) => self.at += 1,
                _ => return,
            }
        }
    }

    /// Passes over a comment that begins at the cursor; false when none does.
    fn skip_comment(&mut self) -> bool {
        let rest = &self.text.as_bytes()[self.at..];
        if rest.starts_with(b"//") {
            self.at += rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
            return true;
        }
        if !rest.starts_with(b"/*") {
            return false;
        }
        let length = match rest[2..].windows(2).position(|pair| pair == b"*/") {
            Some(inside) => inside + 4,
            None => {
                self.open_comment.get_or_insert(self.line);
                rest.len()
            }
        };
        self.line += rest[..length].iter().filter(|&&byte| byte == b'\n').count() as u32;
        self.at += length;
        true
    }

    #[inline]
    fn word(&mut self) -> Option<Word<'a>> {
        let bytes = self.text.as_bytes();
        let start = self.at;
        let mut end = start;
        while let Some(&byte) = bytes.get(end) {
            let comment = byte == b'/' && matches!(bytes.get(end + 1), Some(b'/' | b'*'));
            if is_blank(byte) || comment {
                break;
            }
            end += 1;
        }
        self.at = end;
        (end > start).then(|| self.cut(start))
    }

    /// Both ends stand beside an ASCII byte or an end of the text: they never split a character.
    #[inline]
    fn cut(&self, start: usize) -> Word<'a> {
        Word { text: self.text.get(start..self.at).unwrap_or_default(), start, line: self.line }
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_blanks_and_lines_are_counted() {
        let mut words = Words::new("a//b c\n/* x\n y */d/e /**/f\n//");
        let mut found = Vec::new();
        while let Some(word) = words.next() {
            found.push((word.text, word.line));
        }
        assert_eq!(found, [("a", 1), ("d/e", 3), ("f", 3)]);
        assert_eq!(words.open_comment(), None);
    }

    #[test]
    fn an_open_comment_reaches_to_the_end() {
        let mut words = Words::new("a\n/* b\nc /");
        assert_eq!(words.next().map(|word| word.text), Some("a"));
        assert!(words.next().is_none());
        assert_eq!(words.open_comment(), Some(2));
    }
}
