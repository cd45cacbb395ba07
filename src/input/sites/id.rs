//! The id of a site.

use std::fmt;

/// The id of a site, as its file has it. That ids differ is not checked.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteId {
    /// A number without a sign, fraction or leading zero.
    Number(u64),
    /// Anything else: at most [`SiteId::LONGEST`] bytes, and not empty.
    Text(String),
}

impl SiteId {
    /// The longest text, in bytes.
    pub const LONGEST: usize = 1024;

    /// The id in a field that may be a number, or what is wrong with it.
    pub(in crate::input) fn from_field(field: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(field).map_err(|_| "the id is not in UTF-8".to_owned())?;
        match text.parse::<u64>() {
            Ok(number) if number.to_string() == text => Ok(Self::Number(number)),
            _ => Self::from_text(text),
        }
    }

    /// The id as text, or what is wrong with it.
    pub(in crate::input) fn from_text(text: &str) -> Result<Self, String> {
        match text.len() {
            0 => Err("the id is empty".to_owned()),
            1..=Self::LONGEST => Ok(Self::Text(text.to_owned())),
            n => Err(format!("the id has {n} bytes, and may have {}", Self::LONGEST)),
        }
    }
}

impl fmt::Display for SiteId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}
