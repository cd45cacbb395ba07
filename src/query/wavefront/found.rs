//! What a wave finds.

use std::cmp::Ordering;

use crate::store::Vertex;

/// A thing that was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) what: What,
    /// The way to it.
    pub(crate) length: f64,
    /// The root that it is seen from.
    pub(crate) root: u32,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    /// A site: its number, its id if it has one, and where it is.
    Site {
        number: u64,
        id: Option<String>,
        vertex: Vertex,
    },
    /// A vertex.
    Vertex(Vertex),
    /// The place of this number.
    Place(u32),
}

/// A found thing that waits until nothing can be nearer: by length, then by number.
#[derive(Debug)]
pub(crate) struct Ready {
    pub(crate) length: u64,
    pub(crate) number: u64,
    pub(crate) found: Found,
}

impl PartialEq for Ready {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ready {}

impl Ord for Ready {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.length, self.number).cmp(&(other.length, other.number))
    }
}

impl PartialOrd for Ready {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
