//! What a wave finds.

use crate::collections::keyed::Keyed;
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

/// A found thing that waits until nothing can be nearer: by the bits of its length, then by number.
pub(super) type Ready = Keyed<(u64, u64), Found>;
