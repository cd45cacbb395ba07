//! Numbers in URLs.
//!
//! The forms are narrower than those of the tool, so that a pattern in `/openapi.json` can say which
//! texts are taken: each of them is a coordinate that the library takes.

/// The pattern of a number: all numbers that programs write in full precision, from 10⁻⁴⁰ up to 10⁵⁴.
pub const NUMBER: &str = r"-?[0-9]{1,15}(\.[0-9]{1,40}|(\.[0-9]{1,20})?[eE](\+?[0-3]?[0-9]|-([01]?[0-9]|2[0-2])))?";

/// The smallest magnitude of a coordinate that is not 0.
pub const LEAST: f64 = 1e-40;
/// The largest magnitude of a coordinate.
pub const MOST: f64 = 1e54;

/// Returns whether a number may be a coordinate.
pub fn is_coordinate(value: f64) -> bool {
    value == 0.0 || (LEAST..=MOST).contains(&value.abs())
}

/// Parses a number of the [pattern](NUMBER).
pub fn number(text: &str) -> Option<f64> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let (mantissa, exponent) = match digits.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (digits, None),
    };
    let (whole, fraction) = match mantissa.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (mantissa, None),
    };
    let most = if exponent.is_some() { 20 } else { 40 };
    let is_number = is_digits(whole, 15)
        && fraction.is_none_or(|fraction| is_digits(fraction, most))
        && exponent.is_none_or(is_exponent);
    if is_number { text.parse().ok() } else { None }
}

fn is_exponent(text: &str) -> bool {
    let (digits, most) = match text.strip_prefix('-') {
        Some(digits) => (digits, 22),
        None => (text.strip_prefix('+').unwrap_or(text), 39),
    };
    is_digits(digits, 2) && digits.parse::<u32>().is_ok_and(|exponent| exponent <= most)
}

/// Returns whether the text is 1 to `most` digits.
fn is_digits(text: &str, most: usize) -> bool {
    (1..=most).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_programs_write_are_taken_and_others_are_not() {
        for (text, value) in [
            ("0", 0.0),
            ("-3.5", -3.5),
            ("4e2", 400.0),
            ("1e+21", 1e21),
            ("5.551115123125783e-17", 5.551_115_123_125_783e-17),
            ("0.000000000000000055511151231257827", 5.551_115_123_125_783e-17),
            ("999999999999999e39", 999_999_999_999_999e39),
        ] {
            assert_eq!(number(text), Some(value), "{text}");
        }
        for text in [
            "",
            "-",
            "+1",
            " 1",
            "1 ",
            ".5",
            "5.",
            "1e",
            "1e40",
            "1e-23",
            "1e999",
            "inf",
            "NaN",
            "0x1",
            "1_0",
            "1,2",
            "١",
            "1234567890123456",
        ] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn the_smallest_and_the_largest_number_are_points_of_the_library() {
        use delaunay_tiles::Point;
        for text in [
            "999999999999999e39",
            "-999999999999999.99999999999999999999e39",
            "0.0000000000000000000000000000000000000001",
            "0.00000000000000000001e-22",
        ] {
            let value = number(text).unwrap();
            assert!(Point::new(value, 0.0).is_valid(), "{text}");
        }
    }
}
