//! Numbers and values: each is read whole or refused.

use super::words::{Word, Words};
use crate::model::Value;

/// A finite real number.
pub(super) fn real(text: &str) -> Result<f64, String> {
    let digit_first = text.trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit() || c == '.');
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) if digit_first => Err(format!("{text:?} is beyond the range of a double (about 1.8e308)")),
        Ok(_) => Err(format!("{text:?} is not a finite number")),
        Err(_) => Err(format!("{text:?} is not a number")),
    }
}

/// An id of a node or cell: 1 or more.
#[inline]
pub(super) fn id(text: &str) -> Result<u32, String> {
    match id_or_zero(text)? {
        0 => Err("the id 0 is not allowed; ids begin with 1".into()),
        id => Ok(id),
    }
}

/// An id that may be 0: of properties or a table.
#[inline]
pub(super) fn id_or_zero(text: &str) -> Result<u32, String> {
    let mut value = 0u32;
    for digit in text.bytes() {
        let next =
            digit.is_ascii_digit().then(|| value.checked_mul(10)?.checked_add(u32::from(digit - b'0'))).flatten();
        value = next.ok_or_else(|| no_id(text))?;
    }
    if text.is_empty() { Err(no_id(text)) } else { Ok(value) }
}

fn no_id(text: &str) -> String {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        format!("{text:?} is not an id, which is a whole number")
    } else if digits == text {
        format!("the id {text} is larger than {}", u32::MAX)
    } else {
        format!("the id {text} is negative")
    }
}

/// The value at the cursor: a word of this line, or a vector or matrix that may go on over lines.
///
/// # Errors
/// Where the fault stands (none: the line ends) and what it is.
pub(super) fn value<'a>(words: &mut Words<'a>) -> Result<Value, (Option<Word<'a>>, String)> {
    if words.peek(false) == Some(b'[') {
        return bracketed(words).map_err(|(word, message)| (Some(word), message));
    }
    let word = words.next_on_line().ok_or((None, "a value is missing".to_string()))?;
    plain(word.text).map_err(|message| (Some(word), message))
}

fn plain(text: &str) -> Result<Value, String> {
    match text {
        "true" | "True" | "TRUE" => return Ok(Value::Bool(true)),
        "false" | "False" | "FALSE" => return Ok(Value::Bool(false)),
        _ => {}
    }
    // What Rust would read as a number without being finite is never meant as a text.
    if text.starts_with(|c: char| c.is_alphabetic() || c == '_') && text.parse::<f64>().is_err() {
        return Ok(Value::Text(text.to_string()));
    }
    real(text).map(Value::Number)
}

type Fault<'a> = (Word<'a>, String);

/// `[3](a,b,c)` or `[2,2]((a,b),(c,d))`, with blanks anywhere.
fn bracketed<'a>(words: &mut Words<'a>) -> Result<Value, Fault<'a>> {
    expect(words, b'[')?;
    let rows = size(words)?;
    let columns = if words.peek(true) == Some(b',') {
        expect(words, b',')?;
        Some(size(words)?)
    } else {
        None
    };
    expect(words, b']')?;
    let begin = words.here();
    let Some(columns) = columns else {
        let vector = list(words, |words| number(words, real))?;
        return sized(vector.len(), rows, "numbers", begin).map(|()| Value::Vector(vector));
    };
    let matrix = list(words, |words| list(words, |words| number(words, real)))?;
    sized(matrix.len(), rows, "rows", begin)?;
    matrix.iter().try_for_each(|row| sized(row.len(), columns, "numbers in a row", begin))?;
    Ok(Value::Matrix(matrix))
}

fn sized<'a>(found: usize, announced: u32, what: &str, place: Word<'a>) -> Result<(), Fault<'a>> {
    if found == announced as usize {
        return Ok(());
    }
    Err((place, format!("the size in brackets announces {announced} {what}, but there are {found}")))
}

fn size<'a>(words: &mut Words<'a>) -> Result<u32, Fault<'a>> {
    number(words, |text| id_or_zero(text).map_err(|_| format!("{text:?} is not a size")))
}

fn number<'a, T>(words: &mut Words<'a>, read: impl Fn(&str) -> Result<T, String>) -> Result<T, Fault<'a>> {
    let word = words.until(b",()[]");
    read(word.text).map_err(|message| (word, message))
}

fn list<'a, T>(
    words: &mut Words<'a>,
    item: impl Fn(&mut Words<'a>) -> Result<T, Fault<'a>>,
) -> Result<Vec<T>, Fault<'a>> {
    let mut items = Vec::new();
    expect(words, b'(')?;
    if words.peek(true) == Some(b')') {
        words.pass();
        return Ok(items);
    }
    loop {
        items.push(item(words)?);
        if words.peek(true) == Some(b')') {
            words.pass();
            return Ok(items);
        }
        expect(words, b',')?;
    }
}

fn expect<'a>(words: &mut Words<'a>, byte: u8) -> Result<(), Fault<'a>> {
    if words.peek(true) == Some(byte) {
        words.pass();
        return Ok(());
    }
    let word = words.until(b"");
    let found = if word.text.is_empty() { "the end of the file".to_string() } else { format!("{:?}", word.text) };
    Err((word, format!("{:?} is expected, but {found} is found", char::from(byte))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Value, String> {
        value(&mut Words::new(text)).map_err(|(_, message)| message)
    }

    #[test]
    fn values_of_every_kind() {
        assert_eq!(read("1.5e-3"), Ok(Value::Number(1.5e-3)));
        assert_eq!(read(" .5"), Ok(Value::Number(0.5)));
        assert_eq!(read("-2. x"), Ok(Value::Number(-2.0)));
        assert_eq!(read("true"), Ok(Value::Bool(true)));
        assert_eq!(read("Law2D"), Ok(Value::Text("Law2D".into())));
        assert_eq!(read("[3] (1, 2,\n3)"), Ok(Value::Vector(vec![1.0, 2.0, 3.0])));
        assert_eq!(read("[0]()"), Ok(Value::Vector(Vec::new())));
        assert_eq!(read("[2,2]((1,2),(3,4))"), Ok(Value::Matrix(vec![vec![1.0, 2.0], vec![3.0, 4.0]])));
    }

    #[test]
    fn no_value_is_read_in_part() {
        for text in ["0.2x5", "nan", "-nan", "inf", "Infinity", "1e999", "1e", "--1", "", "[3](1,2)", "[2](1,2,3)"] {
            assert!(read(text).is_err(), "{text}");
        }
        for text in
            ["[2](1,2", "[2](1 2)", "[2](1,nan)", "[x](1)", "[2,2]((1,2),(3))", "[2,2](1,2,3,4)", "[", "[1]", "[1]x(1)"]
        {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ids_are_whole_positive_numbers_of_32_bits() {
        assert_eq!(id("4294967295"), Ok(u32::MAX));
        assert_eq!(id_or_zero("0"), Ok(0));
        for (text, part) in
            [("0", "begin with 1"), ("-3", "negative"), ("4294967296", "larger"), ("99999999999999999999", "larger")]
        {
            assert!(id(text).is_err_and(|message| message.contains(part)), "{text}");
        }
        for text in ["", "1.0", "+1", "-", "1e3", "x", "١"] {
            assert!(id(text).is_err_and(|message| message.contains("whole number")), "{text}");
        }
    }
}
