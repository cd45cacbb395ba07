//! Sites and vertices that were found.

use super::distance::Distance;
use super::path::Path;
use crate::store::{Vertex, VertexId};

/// A site, found by walking distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SiteFound {
    /// The number of the site, counted from 0 over all inputs.
    pub number: u64,
    /// The id of the site, if the input gave it one.
    pub id: Option<String>,
    /// The vertex of the site.
    pub vertex: Vertex,
    /// The walking distance.
    pub distance: Distance,
    /// The path, if it was requested.
    pub path: Option<Path>,
}

/// A vertex, found by walking distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct VertexFound {
    /// The vertex.
    pub vertex: Vertex,
    /// The walking distance.
    pub distance: Distance,
    /// The vertex of the last bend on the path: the parent in the tree of shortest paths. `None` if
    /// the source sees the vertex.
    pub parent: Option<VertexId>,
}
