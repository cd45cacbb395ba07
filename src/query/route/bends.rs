//! The points of a path, and the edges that it bends around.

use super::certify::certify;
use crate::geometry::{HalfEdge, Orientation, Point, VertexIndex, orient2d};
use crate::query::answer::{Bend, Distance, Path, WayPoint};
use crate::query::free_space::{FreeSpace, QueryPoint, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles, half_edge_towards};
use crate::store::{EdgeSource, Tile, Vertex};

/// Converts a shortest path between two points, or from a point to a vertex, to a [`Path`].
pub(crate) async fn path(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&QueryPoint; 2],
    length: f64,
    is_certified: bool,
) -> Result<Path, QueryError> {
    let distance = Distance::of_legs(length, way.len());
    path_with(tiles, way, ends, distance, [is_certified, true]).await
}

/// Converts a path with known bounds, which need not be a shortest one, to a [`Path`].
pub(crate) async fn path_with(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&QueryPoint; 2],
    distance: Distance,
    [is_certified, is_shortest]: [bool; 2],
) -> Result<Path, QueryError> {
    let way = bent(way);
    if is_certified {
        certify(tiles, &way, ends).await?;
    }
    let mut bends = Vec::new();
    for around in way.windows(3) {
        if let [(before, _), (point, Some(id)), (after, _)] = *around {
            let turns_left = orient2d(before, point, after) == Orientation::CounterClockwise;
            let around = (!is_shortest).then_some([before, after]);
            bends.push(bend(tiles, Vertex { id, point }, turns_left, around).await?);
        }
    }
    Ok(Path {
        distance,
        points: way.into_iter().map(|(point, _)| point).collect(),
        bends,
        is_certified,
    })
}

/// Returns the path without points at which it does not bend.
fn bent(way: &[WayPoint]) -> Vec<WayPoint> {
    let mut bent: Vec<WayPoint> = Vec::new();
    for (index, &point) in way.iter().enumerate() {
        let is_straight = match (bent.last(), way.get(index + 1)) {
            (Some(before), Some(after)) => {
                orient2d(before.0, point.0, after.0) == Orientation::Collinear
                    && before.0.lex_cmp(point.0) == point.0.lex_cmp(after.0)
            }
            _ => false,
        };
        if !is_straight {
            bent.push(point);
        }
    }
    bent
}

/// Returns what a path bends around at a vertex. `around` has the points before and after it if the
/// path need not be a shortest one.
async fn bend(
    tiles: &mut Tiles,
    vertex: Vertex,
    turns_left: bool,
    around: Option<[Point; 2]>,
) -> Result<Bend, QueryError> {
    let tile = tiles.get(vertex.id.tile).await?;
    let edge = bound(FreeSpace::of(tiles, &tile), vertex.id.index, turns_left);
    let edge = tiles.checked(tile.id(), edge)?;
    let free = Bend {
        vertex,
        turns_left,
        edge_to: None,
        sources: Vec::new(),
    };
    let edge = match (edge, around) {
        (Some(edge), _) => edge,
        (None, Some(_)) => return Ok(free),
        (None, None) => {
            return Err(tiles.damaged(tile.id(), Contradiction::IdleBend(vertex.id.index)));
        }
    };
    let [from, to] = tile.ends(edge);
    let edge_to = if from.id == vertex.id { to } else { from };
    let away = if turns_left {
        Orientation::Clockwise
    } else {
        Orientation::CounterClockwise
    };
    let is_in_the_way = |[before, after]: [Point; 2]| {
        orient2d(vertex.point, after, edge_to.point) != away && orient2d(before, vertex.point, edge_to.point) != away
    };
    if around.is_some_and(|around| !is_in_the_way(around)) {
        return Ok(free);
    }
    let sources = sources_from(tiles, &tile, edge, [vertex, edge_to]).await?;
    Ok(Bend {
        vertex,
        turns_left,
        edge_to: Some(edge_to),
        sources,
    })
}

/// Returns the half-edge of a vertex's tile, from or to the vertex, at the left or right end of the
/// sector in which paths turn, if there is one.
fn bound(space: FreeSpace<'_>, vertex: VertexIndex, on_left: bool) -> Result<Option<HalfEdge>, Contradiction> {
    let Some(wedge) = space.turning_sector(vertex)? else {
        return Ok(None);
    };
    let half_edge = match (space.end_of_sector(vertex, wedge, on_left)?, on_left) {
        (Wedge::Triangle(half_edge), true) => half_edge.prev(),
        (Wedge::Triangle(half_edge), false) => half_edge,
        (Wedge::Outside, true) => space.first(vertex)?,
        (Wedge::Outside, false) => space.last(vertex)?.prev(),
    };
    Ok(Some(half_edge))
}

/// Returns the lines along the edge between two vertices, in the direction from the first to the
/// second. `half_edge` is a half-edge of `tile` at this edge.
async fn sources_from(
    tiles: &mut Tiles,
    tile: &Tile,
    half_edge: HalfEdge,
    [from, to]: [Vertex; 2],
) -> Result<Vec<EdgeSource>, QueryError> {
    // The tile of the lexicographically smaller end stores the sources.
    let owner = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
    if owner.id.tile == tile.id() {
        let [start, _] = tile.ends(half_edge);
        return Ok(sources(tile, half_edge, start.id == from.id));
    }
    let there = tiles.get(to.id.tile).await?;
    let towards = half_edge_towards(&there, to.id.index, from.id);
    if let Some(half_edge) = tiles.checked(to.id.tile, towards)? {
        return Ok(sources(&there, half_edge, true));
    }
    // The hull is on the left of the path, so the edge is found from its other side.
    let edge = FreeSpace::of(tiles, &there).first(to.id.index);
    Ok(sources(&there, tiles.checked(to.id.tile, edge)?, false))
}

/// Returns the lines along a half-edge, in its direction or against it.
fn sources(tile: &Tile, half_edge: HalfEdge, along: bool) -> Vec<EdgeSource> {
    let sources = tile.edge_sources(half_edge);
    sources
        .map(|source| if along { source } else { source.reversed() })
        .collect()
}
