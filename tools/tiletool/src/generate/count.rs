//! Parses numbers as people write them: `1000000`, `1_000_000`, `1e6`, `1.5M`.

use anyhow::{Context, bail};

/// Parses a count such as 1000000, 1_000_000, 1e6 or 1.5M. The result is computed without rounding.
///
/// # Errors
/// Fails if the text is not a whole number from 0 to 2^64 - 1.
pub fn parse_count(text: &str) -> anyhow::Result<u64> {
    const SUFFIXES: [(char, u32); 5] = [('k', 3), ('K', 3), ('M', 6), ('G', 9), ('T', 12)];
    let suffix = SUFFIXES
        .into_iter()
        .find_map(|(c, power)| Some((text.strip_suffix(c)?, power)));
    let (number, power) = match (suffix, text.split_once(['e', 'E'])) {
        (Some(suffix), _) => suffix,
        (None, Some((number, power))) => (number, power.parse().context("the exponent is not a number")?),
        (None, None) => (text, 0),
    };
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    if !number.contains(|c: char| c.is_ascii_digit()) {
        bail!("not a number");
    }
    let fraction = fraction.trim_end_matches('0');
    let zeros = power.checked_sub(fraction.len() as u32).context("not a whole number")?;
    let digits = whole.chars().filter(|&c| c != '_').chain(fraction.chars());
    // More than 20 zeros do not fit, except after 0, which stays 0.
    let mut count: u64 = 0;
    for c in digits.chain(std::iter::repeat_n('0', zeros.min(20) as usize)) {
        let digit = c.to_digit(10).with_context(|| format!("'{c}' is not a digit"))?;
        let next = count.checked_mul(10).and_then(|count| count.checked_add(digit.into()));
        count = next.context("the number is 2^64 or more")?;
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_parsed_exactly_or_rejected() {
        for (text, count) in [
            ("0", 0),
            ("1000000", 1_000_000),
            ("1_000_000", 1_000_000),
            ("1e6", 1_000_000),
            ("2.5E3", 2500),
            ("10k", 10_000),
            ("10M", 10_000_000),
            ("1.5M", 1_500_000),
            (".5k", 500),
            ("2G", 2_000_000_000),
            ("7.0", 7),
            ("0e4000000000", 0),
            ("18446744073709551615", u64::MAX),
        ] {
            assert_eq!(parse_count(text).unwrap(), count, "{text}");
        }
        let wrong = [
            "",
            "M",
            ".",
            "_",
            "1.5",
            "-1",
            "1e-3",
            "1e",
            "1 000",
            "1m",
            "1.2345k",
            "1e20",
            "99999999999G",
        ];
        for text in wrong {
            assert!(parse_count(text).is_err(), "{text}");
        }
    }
}
