//! The errors and the report of verification.

use crate::geometry::{Point, TriangleId};
use crate::store::error::ReadError;
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::ids::TileId;
pub(crate) use crate::store::format::tile::edges::TileEdge;

/// A fault in a tile.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// The triangle at fault, if the fault is in one triangle.
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

    /// Creates a fault of an edge.
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

/// An error found by verifying a file.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A part of the file cannot be read, or is damaged.
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
    /// A polygon does not cover each point 0 or 1 times.
    #[error("obstacle {polygon}, line {line} (counted from 0) of {file}, {reason}")]
    Polygon {
        /// The number of the polygon, which is that of its first line.
        polygon: u64,
        /// The name of the file that it came from.
        file: String,
        /// The number of its first line in that file, from 0.
        line: u64,
        /// What is wrong with the polygon, and where.
        reason: String,
    },
    /// The file as a whole contradicts itself.
    #[error("{0}")]
    File(String),
    /// The input cannot be read, or cannot be compared with the file.
    #[error("{0}")]
    Input(String),
    /// A point of the input is not in the file, or a vertex is not in the input.
    #[error("{0}")]
    Points(String),
    /// A line of the input is not in the file, or a line of the file is not in the input.
    #[error(
        "{} {} from ({}, {}) to ({}, {}) {reason}",
        line.kind(), line.number(), ends[0].x, ends[0].y, ends[1].x, ends[1].y
    )]
    Line {
        /// The line, as seen from the first end to the second.
        line: EdgeSource,
        /// The ends of a segment of the line, or of an edge.
        ends: [Point; 2],
        /// What is wrong with the line.
        reason: &'static str,
    },
    /// A site of the input is not in the file, or a site of the file is not in the input.
    #[error("{0}")]
    Sites(String),
}

/// The amounts that were checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VerifyReport {
    /// The number of tiles.
    pub tiles: u64,
    /// The number of vertices.
    pub vertices: u64,
    /// The number of triangles.
    pub triangles: u64,
    /// The number of edges that are constraints or have an empty circle; 0 unless the check was
    /// deep.
    pub edges: u64,
    /// The number of edges that are constraints.
    pub constraint_edges: u64,
    /// The number of regions; 0 unless the check was deep and the file has regions.
    pub regions: u64,
    /// The number of regions that are holes.
    pub hole_regions: u64,
    /// The number of segments of the input that were compared.
    pub segments: u64,
    /// The number of sites of the input that were compared.
    pub sites: u64,
}
