//! Base64 (RFC 4648, with padding) of data that lie in several parts.

use std::io::{self, Write};

/// Bytes encoded before they are handed on; a multiple of 3.
const PORTION: usize = 3 << 14;

/// Writes the concatenation of `parts`, encoded as one.
pub(super) fn write_base64<'a>(out: &mut dyn Write, parts: impl Iterator<Item = &'a [u8]>) -> io::Result<()> {
    let mut text = Vec::with_capacity(PORTION / 3 * 4);
    let mut pending: Vec<u8> = Vec::with_capacity(3);
    for part in parts {
        // Complete the three bytes that straddle two parts, then take whole threes.
        let head = part.len().min((3 - pending.len()) % 3);
        pending.extend_from_slice(&part[..head]);
        if pending.len() == 3 {
            out.write_all(&group(&pending))?;
            pending.clear();
        }
        let whole = (part.len() - head) / 3 * 3;
        for portion in part[head..head + whole].chunks(PORTION) {
            text.clear();
            text.extend(portion.chunks_exact(3).flat_map(group));
            out.write_all(&text)?;
        }
        pending.extend_from_slice(&part[head + whole..]);
    }
    if pending.is_empty() { Ok(()) } else { out.write_all(&group(&pending)) }
}

/// Four characters for one to three bytes.
fn group(bytes: &[u8]) -> [u8; 4] {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let byte = |i: usize| u32::from(bytes.get(i).copied().unwrap_or(0));
    let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    let mut group = [18, 12, 6, 0].map(|shift| ALPHABET[(bits >> shift & 63) as usize]);
    group[bytes.len() + 1..].fill(b'=');
    group
}

/// The bytes of a text, blanks passed over; none if it is no base64. Padding may stand between parts that
/// were encoded one after the other.
pub(super) fn read_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut digits, mut padding) = (0u32, 0, 0);
    for &character in text.iter().filter(|byte| !byte.is_ascii_whitespace()) {
        let digit = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if digits >= 2 => 0,
            _ => return None,
        };
        if character == b'=' {
            padding += 1;
        } else if padding > 0 {
            return None;
        }
        bits = bits << 6 | u32::from(digit);
        digits += 1;
        if digits == 4 {
            bytes.extend_from_slice(&bits.to_be_bytes()[1..4 - padding]);
            (bits, digits, padding) = (0, 0, 0);
        }
    }
    (digits == 0).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encode(parts: &[&[u8]]) -> String {
        let mut text = Vec::new();
        write_base64(&mut text, parts.iter().copied()).unwrap();
        String::from_utf8(text).unwrap()
    }

    /// The test vectors of RFC 4648, section 10, and one with the last two letters of the alphabet.
    #[test]
    fn agrees_with_the_standard() {
        for (plain, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(encode(&[plain.as_bytes()]), expected);
            assert_eq!(read_base64(expected.as_bytes()).unwrap(), plain.as_bytes());
        }
        assert_eq!(encode(&[&[0xfb, 0xff, 0xbf]]), "+/+/");
        assert_eq!(read_base64(b"Zg==\n Zm9v").unwrap(), b"ffoo");
        for wrong in ["Zg", "Z===", "Zg=a", "Zm9v!", "=Zm9"] {
            assert_eq!(read_base64(wrong.as_bytes()), None, "{wrong}");
        }
    }

    #[test]
    fn the_cut_into_parts_does_not_matter() {
        let bytes: Vec<u8> = (0..2 * PORTION + 11).map(|i| (i * i % 251) as u8).collect();
        let whole = encode(&[&bytes]);
        for lengths in [[1, 1], [0, 2], [2, 5], [1, 0], [PORTION - 1, PORTION + 2]] {
            let (first, rest) = bytes.split_at(lengths[0]);
            let (second, third) = rest.split_at(lengths[1]);
            assert_eq!(encode(&[first, second, third]), whole);
        }
    }
}
