//! Numbers as text, in the forms that VTK's readers and Kratos's users expect.

use std::io::Write;

/// Below this magnitude a number is written as 0 into a text that is read as `f32`: near the
/// smallest normal number (1.18e-38) some readers refuse the whole file.
const SMALLEST_FLOAT: f64 = 1e-37;

/// Appends `value` in the form of C's `%.<precision>e` (`-1.5000000e+01`), to be read as `f32`.
///
/// The digits are rounded correctly (ties to even). Magnitudes under 1e-37 become 0, those beyond
/// `f32` become `inf`, and a number that is none becomes `nan`: VTK reads these three, and stops at others.
pub(super) fn push_float(text: &mut Vec<u8>, value: f64, precision: usize) {
    let value = if value.abs() < SMALLEST_FLOAT { 0.0 } else { value };
    if !(value as f32).is_finite() {
        push_special(text, value);
        return;
    }
    let start = text.len();
    push_formatted(text, format_args!("{value:.precision$e}"));
    widen_exponent(text, start);
}

/// Appends the shortest text that is read back as the same number; subnormal numbers become 0.
pub(super) fn push_shortest<T: ShortestText>(text: &mut Vec<u8>, value: T) {
    let double = value.to_f64();
    if !double.is_finite() {
        push_special(text, double);
    } else if double.abs() < T::SMALLEST_NORMAL {
        text.push(b'0');
    } else {
        push_formatted(text, format_args!("{value:e}"));
    }
}

/// Appends an integer.
pub(super) fn push_integer(text: &mut Vec<u8>, value: i64) {
    push_formatted(text, format_args!("{value}"));
}

/// `f32` and `f64`.
pub(super) trait ShortestText: Copy + std::fmt::LowerExp {
    /// Smallest normal number of the type.
    const SMALLEST_NORMAL: f64;
    /// The same number as `f64`.
    fn to_f64(self) -> f64;
}

impl ShortestText for f64 {
    const SMALLEST_NORMAL: f64 = f64::MIN_POSITIVE;
    fn to_f64(self) -> f64 {
        self
    }
}

impl ShortestText for f32 {
    const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

fn push_formatted(text: &mut Vec<u8>, arguments: std::fmt::Arguments<'_>) {
    // Writing into a vector cannot fail.
    let _ = text.write_fmt(arguments);
}

fn push_special(text: &mut Vec<u8>, value: f64) {
    text.extend_from_slice(match value {
        v if v.is_nan() => b"nan",
        v if v < 0.0 => b"-inf",
        _ => b"inf",
    });
}

/// Turns Rust's exponent (`e1`, `e-5`) at the end of `text[start..]` into C's: a sign and two digits at least.
fn widen_exponent(text: &mut Vec<u8>, start: usize) {
    let Some(e) = text[start..].iter().rposition(|&byte| byte == b'e') else { return };
    let mut digits = start + e + 1;
    if text[digits] != b'-' {
        text.insert(digits, b'+');
    }
    digits += 1;
    if text.len() - digits < 2 {
        text.insert(digits, b'0');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn float(value: f64, precision: usize) -> String {
        let mut text = b"before ".to_vec();
        push_float(&mut text, value, precision);
        String::from_utf8(text).unwrap().strip_prefix("before ").unwrap().to_string()
    }

    /// Expected texts from C's printf.
    #[test]
    fn floats_look_like_printf() {
        for (value, precision, expected) in [
            (0.0, 7, "0.0000000e+00"),
            (15.625, 7, "1.5625000e+01"),
            (-26177.113, 7, "-2.6177113e+04"),
            (1e-5, 7, "1.0000000e-05"),
            (9.99999996e9, 7, "1.0000000e+10"),
            (16777216.5, 7, "1.6777216e+07"),
            (16777217.5, 7, "1.6777218e+07"),
            (1.0 / 3.0, 16, "3.3333333333333331e-01"),
            (2.5, 0, "2e+00"),
            (-1e-37, 2, "-1.00e-37"),
            (f64::from(f32::MAX), 7, "3.4028235e+38"),
        ] {
            assert_eq!(float(value, precision), expected);
        }
    }

    #[test]
    fn numbers_that_readers_refuse_are_replaced() {
        assert_eq!(float(-9.9e-38, 7), "0.0000000e+00");
        assert_eq!(float(5e-324, 7), "0.0000000e+00");
        assert_eq!(float(-0.0, 1), "0.0e+00");
        assert_eq!(float(-1e300, 7), "-inf");
        assert_eq!(float(f64::INFINITY, 7), "inf");
        assert_eq!(float(-f64::NAN, 7), "nan");
    }

    #[test]
    fn shortest_text_is_read_back_exactly() {
        let text = |value: f64| {
            let mut text = Vec::new();
            push_shortest(&mut text, value);
            String::from_utf8(text).unwrap()
        };
        for value in [0.1, -1.0 / 3.0, 6.02e23, f64::MIN_POSITIVE, f64::MAX] {
            assert_eq!(text(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
        assert_eq!(text(f64::MIN_POSITIVE / 2.0), "0");
        let mut single = Vec::new();
        push_shortest(&mut single, 0.1f32);
        assert_eq!(single, b"1e-1");
    }
}
