//! Regions that are covered by less than nothing, because rings of polygons are nested wrongly: the first of them.
//!
//! In: a file that is complete, and its tiles that have triangles of such regions. Out: a polygon whose ring takes the depth
//! below 0, and where. Hardly any file has them, so nothing is kept for it while tiles are made: they are read back.
//!
//! ```text
//!   ┌─────┐  ┌────┐      ┌───────────┐      ──────
//!   │  1  │  │ -1 │      │ 1 ┌─────┐ │      ╲ -1 ╱      A shell counts 1, a hole -1. Where holes are alone, the plane is
//!   │     │  └────┘      │   │ 0   │ │       ╲  ╱       covered -1 times; so is the smaller lobe of a ring that crosses
//!   └─────┘              │   │┌──┐ │ │        ╲╱        itself, since the larger one says which way it runs.
//!                        │   ││-1│ │ │       ╱  ╲
//!                        │   │└──┘ │ │      ╱    ╲
//!                        │   └─────┘ │     ╱   1  ╲
//!                        └───────────┘    ──────────
//! ```

use std::io;
use std::path::Path;

use futures::stream::StreamExt;

use super::BuildError;
use crate::geometry::Point;
use crate::store::{Across, Needs, OpenOptions, ReadError, Tile, TileId, TileReader};

/// Where a polygon is inside out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverted {
    /// The number of the polygon's record among all lines.
    pub obstacle: u64,
    /// A corner of the region.
    pub point: Point,
}

/// An edge around such a region from its smaller end on, and the smallest number of an obstacle that takes the depth down there.
pub(super) type Edge = ([Point; 2], u64);

/// The first region that is inside out, by place, of those in these tiles of a file: the same however it is cut into tiles.
pub(super) async fn first(path: &Path, tiles: &[TileId], memory: u64) -> Result<Option<Inverted>, BuildError> {
    if tiles.is_empty() {
        return Ok(None);
    }
    let cannot = |error: ReadError| match error {
        ReadError::Io { source, .. } => {
            BuildError::io(path, "read back", io::Error::new(source.kind(), source.to_string()))
        }
        other => BuildError::Internal(other.to_string()),
    };
    let reader = TileReader::open(path, OpenOptions::default().memory(memory));
    let reader = reader.await.map_err(cannot)?;
    let plan = reader.plan(Needs::default()).map_err(cannot)?;
    let tiles = tiles.iter().map(|&tile| (tile, ())).collect();
    let mut edges = reader.for_some_tiles(tiles, plan, |tile, ()| first_edge(&tile));
    let mut first: Option<Edge> = None;
    while let Some(edge) = edges.next().await {
        first = smaller(first, edge.map_err(cannot)?);
    }
    Ok(first.map(of))
}

/// What is told of such an edge.
pub(super) fn of(([point, _], obstacle): Edge) -> Inverted {
    Inverted { obstacle, point }
}

/// The first of two.
pub(super) fn smaller(one: Option<Edge>, other: Option<Edge>) -> Option<Edge> {
    let edges = one.into_iter().chain(other);
    edges.min_by(|([a, b], line), ([c, d], other)| {
        let ends = a.lex_cmp(*c).then_with(|| b.lex_cmp(*d));
        ends.then_with(|| line.cmp(other))
    })
}

/// The first edge that belongs to a tile and by which the depth falls below 0.
pub(super) fn first_edge(tile: &Tile) -> Option<Edge> {
    let mut first = None;
    for triangle in (0..tile.triangle_count()).filter(|&triangle| tile.depth(triangle) < 0) {
        for side in 3 * triangle..3 * triangle + 3 {
            let beyond = match tile.across(side) {
                Across::Side(other) => tile.depth(other / 3),
                Across::Hull => 0,
                Across::Elsewhere => continue,
            };
            if beyond <= tile.depth(triangle) {
                continue;
            }
            // The triangle is on the left.
            let falling = tile.edge_sources(side).filter(|source| source.depth_change() < 0);
            let [a, b] = tile.ends(side).map(|end| end.point);
            let ends = if a.lex_cmp(b).is_lt() { [a, b] } else { [b, a] };
            first = smaller(
                first,
                falling.map(|source| source.number()).min().map(|line| (ends, line)),
            );
        }
    }
    first
}
