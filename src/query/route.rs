//! A path as it is told: its points, and what it bends around.

use super::QueryError;
use super::certify::certify;
use super::ground::{Ground, Wedge};
use super::place::Place;
use super::proximity::Distance;
use super::star::{previous, side_towards};
use super::tiles::Tiles;
use crate::geometry::{Orientation, Point, orient2d};
use crate::store::{EdgeSource, Tile, Vertex, VertexId};

/// A shortest path.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// How long it is.
    pub distance: Distance,
    /// From its start by way of its bends to its end.
    pub points: Vec<Point>,
    /// Where it bends, in order: one for each point between start and end.
    pub bends: Vec<Bend>,
    /// Whether it was proved by a walk through the triangles that it passes.
    pub is_certified: bool,
}

/// A bend of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// The vertex at which it is.
    pub vertex: Vertex,
    /// Whether the path turns left there, with an obstacle on its left; otherwise right.
    pub turns_left: bool,
    /// The other end of the edge, from the vertex, that it bends around. None if nothing is in the way: the path is not a shortest one.
    pub edge_to: Option<Vertex>,
    /// The lines along that edge, as seen from the vertex; none if it only separates a hole that nothing drew.
    pub sources: Vec<EdgeSource>,
}

/// A point of a way: where it is, and the vertex if it is one.
pub(super) type WayPoint = (Point, Option<VertexId>);

/// Makes a path of a way from a place to another place or a vertex.
pub(super) async fn path(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&Place; 2],
    length: f64,
    is_certified: bool,
) -> Result<Path, QueryError> {
    let distance = Distance::of_legs(length, way.len());
    told(tiles, way, ends, distance, [is_certified, true]).await
}

/// The same with bounds that are known; it need not be a shortest one.
pub(super) async fn path_with(
    tiles: &mut Tiles,
    way: &[WayPoint],
    ends: [&Place; 2],
    distance: Distance,
    is_certified: bool,
) -> Result<Path, QueryError> {
    told(tiles, way, ends, distance, [is_certified, false]).await
}

async fn told(
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
    let ground = Ground {
        tile: &tile,
        outside_is_free: tiles.outside_is_free(),
    };
    let edge = bound(ground, vertex.id.index, turns_left).map_err(|reason| tiles.damaged(tile.id(), reason))?;
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
            let reason = format!(
                "a path bends at vertex {}, where nothing is in the way",
                vertex.id.index
            );
            return Err(tiles.damaged(tile.id(), reason));
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
    // The sources stand in the tile of the smaller end.
    let owner = if vertex.point.lex_cmp(edge_to.point).is_lt() {
        vertex.id
    } else {
        edge_to.id
    };
    let sources = if owner.tile == tile.id() {
        sources(&tile, edge, from.id == vertex.id)
    } else {
        let (from, to) = (vertex.id, edge_to.id);
        let there = tiles.get(to.tile).await?;
        let find = |a: VertexId, b: VertexId| side_towards(&there, a.index, b);
        match find(to, from).map_err(|reason| tiles.damaged(to.tile, reason))? {
            Some(side) => sources(&there, side, true),
            // The hull is on the left of the way: the edge is known from its other side.
            None => {
                let ground = Ground { tile: &there, ..ground };
                let edge = ground
                    .first(to.index)
                    .map_err(|reason| tiles.damaged(to.tile, reason))?;
                sources(&there, edge, false)
            }
        }
    };
    Ok(Bend {
        vertex,
        turns_left,
        edge_to: Some(edge_to),
        sources,
    })
}

/// The side of a vertex's tile, from or to the vertex, at the left or right end of the sector in which paths turn there, if there is one.
fn bound(ground: Ground<'_>, vertex: u32, on_left: bool) -> Result<Option<u32>, String> {
    let Some(wedge) = ground.turning_sector(vertex)? else {
        return Ok(None);
    };
    let side = match (ground.end_of_sector(vertex, wedge, on_left)?, on_left) {
        (Wedge::Triangle(side), true) => previous(side),
        (Wedge::Triangle(side), false) => side,
        (Wedge::Outside, true) => ground.first(vertex)?,
        (Wedge::Outside, false) => previous(ground.last(vertex)?),
    };
    Ok(Some(side))
}

/// The lines along a side, as seen in its direction or against it.
fn sources(tile: &Tile, side: u32, along: bool) -> Vec<EdgeSource> {
    let sources = tile.edge_sources(side);
    sources
        .map(|source| if along { source } else { source.reversed() })
        .collect()
}
