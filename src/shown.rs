//! Escaping of text from outside before it is shown: file names, ids, rows of input, answers of
//! servers.
//!
//! In: text that anyone may have written. Out: text of limited length, without control characters
//! and without characters that change the direction of writing, so that a terminal takes no part of
//! it for a command and no line of it looks like another message. The errors of this library are
//! escaped here, and so is everything that the tool prints for people. Output for programs (JSON,
//! CSV, GeoJSON) is not: its values are unchanged, quoted as the format requires.

use std::borrow::Cow;
use std::path::Path;

/// The number of bytes of input that a message quotes.
const LONGEST_EXCERPT: usize = 60;
/// The number of characters in a line of a message.
const LONGEST_LINE: usize = 4000;

/// Returns whether a character is more than a visible sign: a control character (Unicode's Cc), a
/// line or paragraph separator, or a character that changes the direction of writing (UAX 9).
fn is_hostile(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

/// Returns text on one line, with hostile characters replaced by escapes such as `\n` and `\u{1b}`.
#[must_use]
pub fn text(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// Returns a path on one line.
#[must_use]
pub fn path(path: &Path) -> String {
    text(&path.to_string_lossy()).into_owned()
}

/// Returns the beginning of `long` on one line: at most `most` characters.
#[must_use]
pub fn beginning(long: &str, most: usize) -> String {
    match long.char_indices().nth(most) {
        None => text(long).into_owned(),
        Some((end, _)) => format!("{}…", text(&long[..end])),
    }
}

/// Returns the beginning of bytes of input on one line: at most 60 bytes.
#[must_use]
pub fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_EXCERPT)]);
    let mut shown: String = text.escape_debug().collect();
    if bytes.len() > LONGEST_EXCERPT {
        shown.push('…');
    }
    shown
}

/// Returns the lines of a message, each cut where it is too long. Hostile characters other than
/// line ends are replaced by escapes.
#[must_use]
pub fn message(lines: &str) -> String {
    let mut shown = String::with_capacity(lines.len());
    for line in lines.split_inclusive('\n') {
        match line.char_indices().nth(LONGEST_LINE) {
            None => shown += &escaped(line, |c| c == '\n'),
            Some((end, _)) => {
                shown += &text(&line[..end]);
                shown += &format!("… ({} bytes more)", line.trim_end_matches('\n').len() - end);
                shown.extend(line.ends_with('\n').then_some('\n'));
            }
        }
    }
    shown
}

fn escaped(text: &str, is_kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_escaped = |c| is_hostile(c) && !is_kept(c);
    if !text.chars().any(is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match is_escaped(c) {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_outside_is_escaped_for_terminals_and_stays_on_its_line() {
        assert_eq!(text("é\"'\\ 🏠"), "é\"'\\ 🏠");
        assert_eq!(
            text("a\u{1b}[2J\n\u{9b}b\u{202e}c\0"),
            r"a\u{1b}[2J\n\u{9b}b\u{202e}c\u{0}"
        );
        assert_eq!(path(Path::new("a\nerror: b\t.csv")), r"a\nerror: b\t.csv");
        assert_eq!(message("one\r\n\u{1b}]0;two\x07\n"), "one\\r\n\\u{1b}]0;two\\u{7}\n");
    }

    #[test]
    fn long_lines_are_cut() {
        assert_eq!(beginning("abc\ndef", 4), "abc\\n…");
        assert_eq!(beginning("abc", 3), "abc");
        let shown = message(&format!("{}\nnext\n", "ä".repeat(5000)));
        assert!(
            shown.starts_with("ää") && shown.ends_with("ä… (2000 bytes more)\nnext\n"),
            "{shown}"
        );
        assert_eq!(excerpt(&[b'x'; 61]), format!("{}…", "x".repeat(60)));
    }
}
