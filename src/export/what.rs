//! Which elements of the triangulation an export consists of.

use std::fmt;
use std::str::FromStr;

/// The elements that formats of features (GeoJSON, FlatGeobuf, GeoParquet) export. The other formats
/// export whole meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum What {
    /// A polygon for each triangle, with the numbers of its vertices and the number of its region.
    Triangles,
    /// A point for each vertex, with its number and the number of its input record.
    Vertices,
    /// A line for each constraint edge, with the numbers of its ends, the kinds of the lines along it
    /// and the number of one of them, the first.
    Edges,
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Triangles => "triangles",
            Self::Vertices => "vertices",
            Self::Edges => "edges",
        })
    }
}

/// The error of a name that stands for no elements.
#[derive(Clone, Debug, thiserror::Error)]
#[error("what is exported is triangles, vertices or edges, not '{0}'")]
pub struct UnknownWhat(String);

impl FromStr for What {
    type Err = UnknownWhat;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = [Self::Triangles, Self::Vertices, Self::Edges];
        let found = all.into_iter().find(|what| what.to_string() == name);
        found.ok_or_else(|| UnknownWhat(name.to_owned()))
    }
}

/// The elements by which tiles are cut into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CutBy {
    /// All vertices, as those of a mesh.
    Vertices,
    /// The vertices that are written as features.
    Points,
    Triangles,
    /// The constraint edges that belong to the tile.
    Edges,
}

impl What {
    /// Returns the elements by which tiles are cut for these features.
    pub(super) fn cut(self) -> CutBy {
        match self {
            Self::Triangles => CutBy::Triangles,
            Self::Vertices => CutBy::Points,
            Self::Edges => CutBy::Edges,
        }
    }
}
