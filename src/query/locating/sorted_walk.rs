//! Walks to many points of a tile, each from the end of the one before, along a space-filling curve.

use super::walk::{Locate, Spot, SpotStep};
use crate::geometry::{HalfEdge, MortonSquare, Point, Rect, VertexIndex};
use crate::mesh::{EndlessWalk, Walk, WalkEnd};
use crate::query::request::Contradiction;
use crate::store::{Tile, TileId};

/// What a walk has found.
pub(super) enum Arrival {
    There(Spot),
    /// The walk goes on in another tile. Boxed, because it is rare and would make
    /// all others larger.
    Leaves(Box<Locate>, TileId),
}

/// Walks to points in the cell of a tile, and passes each with its number to `take`, until that returns
/// false. `triangles` is the number of triangles of the file.
///
/// A walk that leaves the tile from the point before begins again as [`Locate`] does. So where it goes on
/// does not depend on the other points.
pub(super) fn visit(
    tile: &Tile,
    triangles: u64,
    points: &[Point],
    numbers: impl Iterator<Item = u32>,
    mut take: impl FnMut(u32, Point, Arrival) -> Result<bool, Contradiction>,
) -> Result<(), Contradiction> {
    let (sorted, places) = along_curve(points, numbers);
    let lone = (triangles == 0).then(|| LoneVertices::of(tile));
    let mut near = None;
    for (number, target) in sorted.into_iter().zip(places) {
        let arrival = match &lone {
            Some(lone) => Arrival::There(lone.at(target)),
            None => walk(tile, triangles, target, &mut near)?,
        };
        if !take(number, target, arrival)? {
            break;
        }
    }
    Ok(())
}

/// Returns points in the order of a space-filling curve: their numbers, and their positions as the exact
/// predicates take them.
fn along_curve(points: &[Point], numbers: impl Iterator<Item = u32>) -> (Vec<u32>, Vec<Point>) {
    let numbers: Vec<u32> = numbers.collect();
    // The points are far apart in memory. So each is read from there once.
    let near: Vec<Point> = numbers
        .iter()
        .map(|&number| points[number as usize].representable())
        .collect();
    let square = MortonSquare::around(Rect::around(near.iter().copied()));
    // A curve through 2¹⁶ squares along each axis is fine enough.
    let keys = near.iter().map(|&point| square.key(point) >> 32 << 32);
    let mut keys: Vec<u64> = keys.zip(0u64..).map(|(key, index)| key | index).collect();
    keys.sort_unstable();
    let index = |key: &u64| *key as u32 as usize;
    let places = keys.iter().map(|key| near[index(key)]).collect();
    (keys.iter().map(|key| numbers[index(key)]).collect(), places)
}

/// Walks to a point from the triangle of `near`, which moves to the end of the walk.
fn walk(tile: &Tile, triangles: u64, target: Point, near: &mut Option<HalfEdge>) -> Result<Arrival, Contradiction> {
    if let Some(near) = near
        && let Some(spot) = walk_from(tile, triangles, target, near)?
    {
        return Ok(Arrival::There(spot));
    }
    let mut locate = Locate::new(target, triangles);
    Ok(match locate.step_to_spot(tile)? {
        SpotStep::Need(other) => Arrival::Leaves(Box::new(locate), other),
        SpotStep::There(spot) => {
            *near = half_edge_at(tile, spot).or(*near);
            Arrival::There(spot)
        }
    })
}

/// Walks to a point from the triangle of `near`, which moves to the end of the walk. Returns `None` if
/// the walk leaves the tile.
pub(super) fn walk_from(
    tile: &Tile,
    triangles: u64,
    target: Point,
    near: &mut HalfEdge,
) -> Result<Option<Spot>, EndlessWalk> {
    let (end, spot) = match Walk::new(target, triangles).run(tile, *near)? {
        WalkEnd::Triangle(triangle) => (HalfEdge::new(triangle, 0), Some(Spot::Triangle(triangle))),
        WalkEnd::Edge(half_edge) => (half_edge, Some(Spot::Edge(half_edge))),
        WalkEnd::Vertex(half_edge) => (half_edge, Some(Spot::Vertex(tile.origin(half_edge)))),
        WalkEnd::Hull(exit) => (exit, Some(Spot::Outside(None))),
        WalkEnd::Elsewhere(exit) => (exit, None),
    };
    *near = end;
    Ok(spot)
}

/// Returns a half-edge of a triangle at a spot, if the tile has one.
pub(super) fn half_edge_at(tile: &Tile, spot: Spot) -> Option<HalfEdge> {
    match spot {
        Spot::Triangle(triangle) => Some(HalfEdge::new(triangle, 0)),
        Spot::Edge(half_edge) => Some(half_edge),
        Spot::Vertex(corner) if tile.has_vertex(corner) => tile.leaving(corner),
        Spot::Vertex(_) | Spot::Outside(_) => None,
    }
}

/// The vertices of a tile of a file without triangles, in order.
struct LoneVertices(Vec<(Point, VertexIndex)>);

impl LoneVertices {
    fn of(tile: &Tile) -> Self {
        let mut vertices: Vec<_> = tile.points().zip(tile.vertex_indices()).collect();
        vertices.sort_unstable_by(|(a, _), (b, _)| a.lex_cmp(*b));
        Self(vertices)
    }

    fn at(&self, target: Point) -> Spot {
        let found = self.0.binary_search_by(|(point, _)| point.lex_cmp(target));
        found.map_or(Spot::Outside(None), |index| Spot::Vertex(self.0[index].1))
    }
}
