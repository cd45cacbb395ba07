//! Versions of answers, and what clients know of them.

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use xxhash_rust::xxh3::xxh3_64;

/// The version of all code that makes answers from files. A change of any answer raises it.
pub const RENDERER: u32 = 1;

/// A strong entity tag, in its quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tag(String);

impl Tag {
    /// Creates the tag of a resource, in words that say what it depends on besides the state of its file.
    pub fn new(version: &str, resource: &str) -> Self {
        Self(format!(
            "\"{version}-r{RENDERER}-{:016x}\"",
            xxh3_64(resource.as_bytes())
        ))
    }

    /// Returns the tag of the same resource, compressed.
    pub fn compressed(&self) -> Self {
        Self(format!("{}-gz\"", self.0.trim_end_matches('"')))
    }

    /// Returns the tag as the value of a header.
    pub fn value(&self) -> HeaderValue {
        HeaderValue::from_str(&self.0).unwrap_or(HeaderValue::from_static("\"\""))
    }

    /// Returns whether a header names this tag, or this resource in another compression, or `*`.
    /// `None` if there is no such header.
    pub fn is_in(&self, headers: &HeaderMap, name: &HeaderName) -> Option<bool> {
        let mut values = headers.get_all(name).iter().peekable();
        values.peek()?;
        let own = [self, &self.compressed()];
        let is_own = |tag: &str| {
            let tag = tag.trim();
            let tag = tag.strip_prefix("W/").unwrap_or(tag);
            tag == "*" || own.iter().any(|own| own.0 == tag)
        };
        let texts = values.filter_map(|value| value.to_str().ok());
        Some(texts.flat_map(|text| text.split(',')).any(is_own))
    }

    /// Returns whether the client has this answer.
    pub fn is_known(&self, headers: &HeaderMap) -> bool {
        self.is_in(headers, &header::IF_NONE_MATCH).unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_is_found_among_others_and_in_both_compressions() {
        let tag = Tag::new("abc-1", "x");
        let is_known = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::IF_NONE_MATCH, HeaderValue::from_str(value).unwrap());
            tag.is_known(&headers)
        };
        let text = tag.value().to_str().unwrap().to_owned();
        assert!(is_known(&text) && is_known(&format!("\"other\", W/{text}")) && is_known("*"));
        assert!(is_known(tag.compressed().value().to_str().unwrap()));
        assert!(!is_known("\"other\"") && !is_known(&text.replace('"', "")));
        assert!(!tag.is_known(&HeaderMap::new()));
        assert_ne!(tag, Tag::new("abc-1", "y"));
        assert_ne!(tag, Tag::new("abc-2", "x"));
    }
}
