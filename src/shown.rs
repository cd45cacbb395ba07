//! Text from outside, made fit to be shown: file names, ids, rows of input, what servers answer.
//!
//! In: text that anyone may have written. Out: text without control characters and without
//! characters that turn the direction of writing, so that a terminal takes nothing in it for a
//! command and no line of it passes for another; and not too much of it. The errors of this library
//! go through here, and so does all that the tool prints for people. Output for programs (JSON,
//! CSV, GeoJSON) does not: there values stay what they are, quoted as the format wants it.

use std::borrow::Cow;
use std::path::Path;

/// Bytes of input that a message quotes.
const LONGEST_EXCERPT: usize = 60;
/// Characters of a line of a message.
const LONGEST_LINE: usize = 4000;

/// Whether a character is more than a sign to be seen: control characters (Unicode's Cc), line and
/// paragraph separators, and those that turn the direction of writing (UAX 9).
fn is_hostile(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

/// Text on one line, with escapes in place of what is not to be shown: `\n`, `\u{1b}`.
#[must_use]
pub fn text(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// A path on one line.
#[must_use]
pub fn path(path: &Path) -> String {
    text(&path.to_string_lossy()).into_owned()
}

/// The beginning of a text, on one line: at most so many characters of it.
#[must_use]
pub fn beginning(long: &str, most: usize) -> String {
    match long.char_indices().nth(most) {
        None => text(long).into_owned(),
        Some((end, _)) => format!("{}…", text(&long[..end])),
    }
}

/// The beginning of bytes of input, on one line: at most 60 bytes of them.
#[must_use]
pub fn excerpt(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_EXCERPT)]);
    let mut shown: String = text.escape_debug().collect();
    if bytes.len() > LONGEST_EXCERPT {
        shown.push('…');
    }
    shown
}

/// Lines of a message, each cut where it is too long, with escapes in place of what is not to be
/// shown but for line ends.
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
    fn no_text_from_outside_commands_a_terminal_or_forges_a_line() {
        assert_eq!(text("é\"'\\ 🏠"), "é\"'\\ 🏠");
        assert_eq!(
            text("a\u{1b}[2J\n\u{9b}b\u{202e}c\0"),
            r"a\u{1b}[2J\n\u{9b}b\u{202e}c\u{0}"
        );
        assert_eq!(path(Path::new("a\nerror: b\t.csv")), r"a\nerror: b\t.csv");
        assert_eq!(message("one\r\n\u{1b}]0;two\x07\n"), "one\\r\n\\u{1b}]0;two\\u{7}\n");
    }

    #[test]
    fn no_message_has_a_line_without_bound() {
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
