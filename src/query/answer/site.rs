//! Sites and vertices that were found.

use super::distance::Distance;
use super::path::Path;
use crate::store::{Vertex, VertexId};

/// A site, by walking distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SiteFound {
    /// Its number, from 0 over all inputs.
    pub number: u64,
    /// Its id, if the input gave it one.
    pub id: Option<String>,
    /// The vertex at which it lies.
    pub vertex: Vertex,
    /// How far it is.
    pub distance: Distance,
    /// The way there, if it was asked for.
    pub path: Option<Path>,
}

/// A vertex, by walking distance.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct VertexFound {
    /// The vertex.
    pub vertex: Vertex,
    /// How far it is.
    pub distance: Distance,
    /// The vertex round which the way to it bends last: its parent in the tree of shortest paths. None: it is seen from the source.
    pub parent: Option<VertexId>,
}
