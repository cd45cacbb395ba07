//! What verifying finds wrong, and what it says when it finds nothing.

use crate::geometry::{Point, TriangleId};
use crate::store::error::ReadError;
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::ids::TileId;
pub(crate) use crate::store::format::tile::edges::TileEdge;

/// What is wrong with a tile.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// The triangle of the tile, if it is one's fault.
    triangle: Option<TriangleId>,
    reason: String,
}

impl Fault {
    pub(super) fn new(reason: impl Into<String>) -> Self {
        Self {
            triangle: None,
            reason: reason.into(),
        }
    }

    pub(super) fn at(triangle: TriangleId, reason: impl Into<String>) -> Self {
        Self {
            triangle: Some(triangle),
            reason: reason.into(),
        }
    }

    /// It is the fault of an edge.
    pub(super) fn on(edge: TileEdge, reason: impl Into<String>) -> Self {
        match edge {
            TileEdge::HalfEdge(half_edge) => Self::at(half_edge.triangle(), reason),
            TileEdge::OnLine(_) => Self::new(reason),
        }
    }

    pub(super) fn of(self, tile: TileId) -> VerifyError {
        VerifyError::Tile {
            tile,
            triangle: self.triangle,
            reason: self.reason,
        }
    }
}

/// What is wrong with a file.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A part cannot be read, or is damaged.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A tile contradicts itself, or is no Delaunay triangulation.
    #[error("tile {tile}, {}: {reason}", triangle.map_or("as a whole".to_owned(), |t| format!("triangle {t}")))]
    Tile {
        /// The tile at fault.
        tile: TileId,
        /// The triangle at fault, by its number in the tile.
        triangle: Option<TriangleId>,
        /// What is wrong.
        reason: String,
    },
    /// The file as a whole contradicts itself.
    #[error("{0}")]
    File(String),
    /// The input cannot be read, or cannot be compared with the file.
    #[error("{0}")]
    Input(String),
    /// A point of the input is not in the file, or a vertex not in the input.
    #[error("{0}")]
    Points(String),
    /// A line of the input is not in the file, or one of the file not in the input.
    #[error(
        "{} {} from ({}, {}) to ({}, {}) {reason}",
        line.kind(), line.number(), ends[0].x, ends[0].y, ends[1].x, ends[1].y
    )]
    Line {
        /// The line, seen from the first end to the second.
        line: EdgeSource,
        /// The ends of a segment of it, or of an edge.
        ends: [Point; 2],
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A site of the input is not in the file, or one of the file not in the input.
    #[error("{0}")]
    Sites(String),
}

/// What was checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VerifyReport {
    /// Tiles.
    pub tiles: u64,
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Edges that are constraints or whose circle is empty; 0 unless the check was deep.
    pub edges: u64,
    /// Those that are constraints.
    pub constraint_edges: u64,
    /// Regions; 0 unless the check was deep and the file knows them.
    pub regions: u64,
    /// Those that are holes.
    pub hole_regions: u64,
    /// Segments of the input that were compared.
    pub segments: u64,
    /// Sites of the input that were compared.
    pub sites: u64,
}
