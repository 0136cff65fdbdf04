//! Tokens of an expression.

use super::{ExpressionError, ExpressionFault};

/// A piece of text with a meaning of its own; operators and brackets are symbols.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    /// A name or keyword.
    Name(&'a str),
    Symbol(&'static str),
    End,
}

/// Longer ones first, so that `**` is not read as `*`.
const SYMBOLS: [&str; 17] = ["**", "//", "<=", ">=", "==", "!=", "+", "-", "*", "/", "%", "<", ">", "(", ")", ",", "="];

/// What the writer may have meant by a character that Python uses otherwise or not at all.
pub(super) fn hint(found: char) -> &'static str {
    match found {
        '^' => "; a power is written **",
        '&' => "; write `and`",
        '|' => "; write `or`",
        '!' => "; write `not` or `!=`",
        '?' | ':' => "; write `a if condition else b`",
        _ => "",
    }
}

/// A cursor over the tokens of a text.
pub(super) struct Tokens<'a> {
    text: &'a str,
    at: usize,
    /// The token under the cursor.
    pub token: Token<'a>,
    /// Where it begins (byte).
    pub start: usize,
}

impl<'a> Tokens<'a> {
    pub fn new(text: &'a str) -> Result<Self, ExpressionError> {
        let mut tokens = Self { text, at: 0, token: Token::End, start: 0 };
        tokens.advance()?;
        Ok(tokens)
    }

    /// Goes to the next token.
    pub fn advance(&mut self) -> Result<(), ExpressionError> {
        let rest = self.text[self.at..].trim_start_matches([' ', '\t', '\r', '\n']);
        self.start = self.text.len() - rest.len();
        self.at = self.start;
        let Some(first) = rest.chars().next() else {
            self.token = Token::End;
            return Ok(());
        };
        let length = if first.is_ascii_digit() || first == '.' {
            let length = number_length(rest.as_bytes());
            self.token = Token::Number(self.number(&rest[..length], first)?);
            length
        } else if first.is_alphabetic() || first == '_' {
            let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.')).unwrap_or(rest.len());
            self.token = Token::Name(&rest[..length]);
            length
        } else if let Some(symbol) = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol)) {
            self.token = Token::Symbol(symbol);
            symbol.len()
        } else {
            return Err(self.error(ExpressionFault::Character(first)));
        };
        self.at += length;
        Ok(())
    }

    fn number(&self, digits: &str, first: char) -> Result<f64, ExpressionError> {
        match digits.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.error(ExpressionFault::Range(digits.to_string()))),
            // Only a lone point has no digits.
            Err(_) => Err(self.error(ExpressionFault::Character(first))),
        }
    }

    /// An error at the token under the cursor.
    pub fn error(&self, fault: ExpressionFault) -> ExpressionError {
        self.error_at(self.start, fault)
    }

    /// An error at a byte of the text.
    pub fn error_at(&self, byte: usize, fault: ExpressionFault) -> ExpressionError {
        const AROUND: usize = 40;
        let before = self.text.get(..byte).unwrap_or_default().chars().count();
        let skipped = before.saturating_sub(AROUND);
        let excerpt = self.text.chars().skip(skipped).take(2 * AROUND).collect();
        ExpressionError { position: before + 1, excerpt, fault }
    }

    /// The token under the cursor, for messages.
    pub fn shown(&self) -> String {
        match self.token {
            Token::Number(_) => format!("the number {}", &self.text[self.start..self.at]),
            Token::Name(name) => format!("`{name}`"),
            Token::Symbol(symbol) => format!("`{symbol}`"),
            Token::End => "the end of the text".to_string(),
        }
    }
}

/// Bytes of a number: digits, a point, digits, and an exponent only if it has digits.
fn number_length(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        let exponent = digits((length + 1 + sign).min(bytes.len()));
        length += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    length
}
