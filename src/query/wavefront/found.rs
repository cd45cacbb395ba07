//! The targets that a wavefront finds.

use crate::collections::keyed::Keyed;
use crate::store::Vertex;

/// A target that was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundTarget {
    pub(crate) target: Target,
    /// The length of the path to the target.
    pub(crate) length: f64,
    /// The root that sees the target.
    pub(crate) root: u32,
}

/// A thing that a wavefront looks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Target {
    /// A site: its number, its id if it has one, and its vertex.
    Site {
        number: u64,
        id: Option<String>,
        vertex: Vertex,
    },
    /// A vertex.
    Vertex(Vertex),
    /// The query point with this index.
    Point(u32),
}

/// A found target that waits until nothing nearer can be found, ordered by the bits of its length,
/// then by number.
pub(super) type Ready = Keyed<(u64, u64), FoundTarget>;
