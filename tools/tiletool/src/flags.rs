//! Names of flags in the library's messages. The library names its options; a user of the tool
//! types flags.

/// The advice of the library if an output exists already, and that of the tool.
const REPLACEMENT: [&str; 2] = ["or force its replacement", "or give --force to replace it"];

/// Returns a message of the library with the flag in place of each name of an option:
/// `` option `--skip-invalid` `` for `` option `skip_invalid` ``.
pub fn in_message(message: &str) -> String {
    const BEFORE: &str = "option `";
    let mut parts = message.split(BEFORE);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once('`').filter(|(name, _)| is_option(name)) {
            Some((name, rest)) => text += &format!("{BEFORE}--{}`{rest}", name.replace('_', "-")),
            None => text += &format!("{BEFORE}{part}"),
        }
    }
    text.replace(REPLACEMENT[0], REPLACEMENT[1])
}

fn is_option(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_')
}

#[cfg(test)]
mod tests {
    use super::in_message;

    #[test]
    fn options_become_flags_and_other_text_stays() {
        for (message, expected) in [
            (
                "is not a number (option `skip_invalid`)",
                "is not a number (option `--skip-invalid`)",
            ),
            (
                "choose others with the option `columns`",
                "choose others with the option `--columns`",
            ),
            ("a.csv: option `X y`; option `", "a.csv: option `X y`; option `"),
            (
                "a.tiles exists already; choose another name, or force its replacement",
                "a.tiles exists already; choose \
              another name, or give --force to replace it",
            ),
        ] {
            assert_eq!(in_message(message), expected);
        }
    }
}
