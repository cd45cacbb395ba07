//! A path as it is told: its points, and what it bends around.

use super::certify::certify;
use crate::geometry::{HalfEdge, Orientation, Point, VertexIndex, orient2d};
use crate::query::answer::{Bend, Distance, Path, WayPoint};
use crate::query::free_space::{Ground, Place, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles, side_towards};
use crate::store::{EdgeSource, Tile, Vertex};

/// Makes a path of a shortest way from a place to another place or a vertex.
pub(crate) async fn path(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&Place; 2],
    length: f64,
    is_certified: bool,
) -> Result<Path, QueryError> {
    let distance = Distance::of_legs(length, way.len());
    path_with(tiles, way, ends, distance, [is_certified, true]).await
}

/// The same with bounds that are known; it need not be a shortest one.
pub(crate) async fn path_with(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&Place; 2],
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

/// The way without points at which it does not bend.
fn bent(way: &[WayPoint]) -> Vec<WayPoint> {
    let mut bent: Vec<WayPoint> = Vec::new();
    for (place, &point) in way.iter().enumerate() {
        let is_straight = match (bent.last(), way.get(place + 1)) {
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

/// What a path bends around at a vertex; if it need not be a shortest one, between two points.
async fn bend(
    tiles: &mut Tiles,
    vertex: Vertex,
    turns_left: bool,
    around: Option<[Point; 2]>,
) -> Result<Bend, QueryError> {
    let tile = tiles.get(vertex.id.tile).await?;
    let edge = bound(Ground::of(tiles, &tile), vertex.id.index, turns_left);
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

/// The side of a vertex's tile, from or to the vertex, at the left or right end of the sector in which paths turn there, if there is one.
fn bound(ground: Ground<'_>, vertex: VertexIndex, on_left: bool) -> Result<Option<HalfEdge>, Contradiction> {
    let Some(wedge) = ground.turning_sector(vertex)? else {
        return Ok(None);
    };
    let side = match (ground.end_of_sector(vertex, wedge, on_left)?, on_left) {
        (Wedge::Triangle(side), true) => side.prev(),
        (Wedge::Triangle(side), false) => side,
        (Wedge::Outside, true) => ground.first(vertex)?,
        (Wedge::Outside, false) => ground.last(vertex)?.prev(),
    };
    Ok(Some(side))
}

/// The lines along an edge, as seen from a vertex to the other end of it, given a side of the vertex's tile that is on the edge.
async fn sources_from(
    tiles: &mut Tiles,
    tile: &Tile,
    side: HalfEdge,
    [from, to]: [Vertex; 2],
) -> Result<Vec<EdgeSource>, QueryError> {
    // The sources stand in the tile of the smaller end.
    let owner = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
    if owner.id.tile == tile.id() {
        let [start, _] = tile.ends(side);
        return Ok(sources(tile, side, start.id == from.id));
    }
    let there = tiles.get(to.id.tile).await?;
    let towards = side_towards(&there, to.id.index, from.id);
    if let Some(side) = tiles.checked(to.id.tile, towards)? {
        return Ok(sources(&there, side, true));
    }
    // The hull is on the left of the way: the edge is known from its other side.
    let edge = Ground::of(tiles, &there).first(to.id.index);
    Ok(sources(&there, tiles.checked(to.id.tile, edge)?, false))
}

/// The lines along a side, as seen in its direction or against it.
fn sources(tile: &Tile, side: HalfEdge, along: bool) -> Vec<EdgeSource> {
    let sources = tile.edge_sources(side);
    sources
        .map(|source| if along { source } else { source.reversed() })
        .collect()
}
