//! The messages of errors.

use std::error::Error;

/// Returns the message of an error, followed by those of its sources.
pub fn whole(error: &dyn Error) -> String {
    let behind = error.source().map(whole);
    behind.map_or_else(|| error.to_string(), |behind| format!("{error}: {behind}"))
}
