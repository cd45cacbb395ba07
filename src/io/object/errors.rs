//! The errors of a store, for people.

use std::io;

use object_store::Error;

use crate::shown;

/// The number of characters of a server's text that a message quotes.
const LONGEST_ANSWER: usize = 400;

pub(super) fn changed(name: &str) -> io::Error {
    let message = format!("{name} has changed since it was opened; open it again");
    io::Error::new(io::ErrorKind::StaleNetworkFileHandle, message)
}

/// Returns a store's error with the object's name.
pub(super) fn explained(name: &str, error: Error) -> io::Error {
    let (kind, what, advice) = match &error {
        Error::Precondition { .. } => return changed(name),
        Error::NotFound { .. } => (
            io::ErrorKind::NotFound,
            "there is no such object",
            "; check the address",
        ),
        Error::NotSupported { .. } => (
            io::ErrorKind::Unsupported,
            "the server does not answer by byte range",
            "",
        ),
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => (
            io::ErrorKind::PermissionDenied,
            "the server refuses",
            "; check the address and the credentials",
        ),
        _ => (io::ErrorKind::Other, "the request failed", ""),
    };
    let text = whole(&error);
    let (text, advice) = match before_page(&text) {
        None => (shown::beginning(&text, LONGEST_ANSWER), advice),
        Some(before) => (
            shown::beginning(before, LONGEST_ANSWER),
            match advice {
                "" => "; the server sent a web page, which a browser shows; try again later",
                advice => advice,
            },
        ),
    };
    io::Error::new(kind, format!("{name}: {what}: {text}{advice}"))
}

/// Returns the text before a web page, if the text of an error ends with one. A page is for
/// browsers, and hides the status that precedes it.
fn before_page(text: &str) -> Option<&str> {
    let lower = text.to_ascii_lowercase();
    let is_page = lower.contains("<!doctype html") || lower.contains("<html");
    let (before, _) = text.split_once('<').filter(|_| is_page)?;
    Some(before.trim_end_matches([':', ' ', '\r', '\n']))
}

/// Returns the text of an error and of its sources, each text once.
fn whole(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        let more = error.to_string();
        if !text.contains(&more) {
            text += &format!(": {more}");
        }
        source = error.source();
    }
    text
}
