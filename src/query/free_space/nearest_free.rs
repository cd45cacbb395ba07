//! Where the nearest free point is.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use foldhash::HashSet;

use super::ground::Ground;
use super::spot::Spot;
use super::wedges::Wedge;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::query::answer::distance;
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, Vertex, VertexId};

/// The nearest point where one may be, of a point where one may not. None if there is no such point.
pub(crate) async fn nearest_free(tiles: &mut Tiles, at: Point, spot: Spot) -> Result<Option<Point>, QueryError> {
    let mut search = Search {
        at,
        open: BinaryHeap::new(),
        pushed: HashSet::default(),
    };
    match spot {
        Spot::Triangle(triangle) => search.push_sides(&*tiles.get(triangle.tile).await?, triangle.triangle),
        Spot::Edge { ends: [a, b] } => {
            search.push([a, b]);
            search.push([b, a]);
        }
        Spot::Vertex(vertex) => {
            let tile = tiles.get(vertex.id.tile).await?;
            let ground = Ground::of(tiles, &tile);
            let wedges = tiles.checked(tile.id(), ground.wedges(vertex.id.index))?;
            for wedge in wedges {
                if let Wedge::Triangle(side) = wedge {
                    search.push_sides(&tile, side.triangle());
                }
            }
        }
        Spot::Outside([from, _]) => {
            for forward in [true, false] {
                search.push_visible(tiles, from, forward).await?;
            }
        }
    }
    search.run(tiles).await
}

/// A search from a place that is not free through holes, by the distance of their edges: the straight way to the nearest
/// free point lies in what is not free.
struct Search {
    at: Point,
    /// Edges, by the bits of their distance; what lies on the left of each is to be looked at.
    open: BinaryHeap<Reverse<(u64, [VertexId; 2])>>,
    pushed: HashSet<[VertexId; 2]>,
}

impl Search {
    fn push(&mut self, [from, to]: [Vertex; 2]) {
        if self.pushed.insert([from.id, to.id]) {
            let nearest = nearest_on([from.point, to.point], self.at);
            let length = distance(self.at, nearest).to_bits();
            self.open.push(Reverse((length, [from.id, to.id])));
        }
    }

    /// What lies beyond the sides of a triangle.
    fn push_sides(&mut self, tile: &Tile, triangle: TriangleId) {
        for side in HalfEdge::of_triangle(triangle) {
            let [from, to] = tile.ends(side);
            self.push([to, from]);
        }
    }

    /// What lies behind the hull's edges that a point outside sees, from a vertex on.
    async fn push_visible(&mut self, tiles: &mut Tiles, vertex: VertexId, forward: bool) -> Result<(), QueryError> {
        let mut vertex = vertex;
        loop {
            let tile = tiles.get(vertex.tile).await?;
            let ground = Ground::of(tiles, &tile);
            let edge = tiles.checked(vertex.tile, ground.along_hull(vertex.index, forward))?;
            let [from, to] = tile.ends(edge);
            let is_seen = orient2d(from.point, to.point, self.at) == Orientation::Clockwise;
            if !is_seen || self.pushed.contains(&[from.id, to.id]) {
                return Ok(());
            }
            self.push([from, to]);
            vertex = if forward { to.id } else { from.id };
        }
    }

    async fn run(mut self, tiles: &mut Tiles) -> Result<Option<Point>, QueryError> {
        while let Some(Reverse((_, [from, to]))) = self.open.pop() {
            match tiles.side_between(from, to).await? {
                Some((tile, side)) if tile.is_hole(side.triangle()) => self.push_sides(&tile, side.triangle()),
                Some((tile, side)) => return Ok(Some(nearest_on(tile.ends(side).map(|end| end.point), self.at))),
                None if tiles.outside_is_free() => {
                    let tile = tiles.get(to.tile).await?;
                    let back = tiles.checked(to.tile, side_towards_hull(Ground::of(tiles, &tile), to, from))?;
                    return Ok(Some(nearest_on(tile.ends(back).map(|end| end.point), self.at)));
                }
                None => {}
            }
        }
        Ok(None)
    }
}

/// The side from a vertex of the tile along the hull to the next one.
fn side_towards_hull(ground: Ground<'_>, from: VertexId, to: VertexId) -> Result<HalfEdge, Contradiction> {
    let side = ground.first(from.index)?;
    let [_, end] = ground.tile.ends(side);
    (end.id == to)
        .then_some(side)
        .ok_or(Contradiction::NoHullEdge(from, to))
}

/// The point of a segment that is nearest to a point, rounded.
pub(crate) fn nearest_on([a, b]: [Point; 2], p: Point) -> Point {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let square = dx * dx + dy * dy;
    let along = ((p.x - a.x) * dx + (p.y - a.y) * dy) / square;
    if along <= 0.0 {
        a
    } else if along >= 1.0 {
        b
    } else {
        Point::new(a.x + along * dx, a.y + along * dy)
    }
}
