//! The nearest free point of a point in an obstacle.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use foldhash::HashSet;

use super::position::Position;
use super::space::FreeSpace;
use super::wedges::Wedge;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::query::answer::distance;
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, Vertex, VertexId};

/// Returns the free point nearest to `at`, which is not free; `None` if no point is free.
pub(crate) async fn nearest_free(
    tiles: &mut Tiles,
    at: Point,
    position: Position,
) -> Result<Option<Point>, QueryError> {
    let mut search = HoleSearch {
        at,
        open: BinaryHeap::new(),
        pushed: HashSet::default(),
    };
    match position {
        Position::Triangle(triangle) => search.push_edges(&*tiles.get(triangle.tile).await?, triangle.triangle),
        Position::Edge { ends: [a, b] } => {
            search.push([a, b]);
            search.push([b, a]);
        }
        Position::Vertex(vertex) => {
            let tile = tiles.get(vertex.id.tile).await?;
            let space = FreeSpace::of(tiles, &tile);
            let wedges = tiles.checked(tile.id(), space.wedges(vertex.id.index))?;
            for wedge in wedges {
                if let Wedge::Triangle(half_edge) = wedge {
                    search.push_edges(&tile, half_edge.triangle());
                }
            }
        }
        Position::Outside([from, _]) => {
            for forward in [true, false] {
                search.push_visible(tiles, from, forward).await?;
            }
        }
    }
    search.run(tiles).await
}

/// A search through holes, from a point that is not free, in the order of the distance of their
/// edges. The straight line to the nearest free point runs through space that is not free.
struct HoleSearch {
    at: Point,
    /// Edges, by the bits of their distance. The search examines the triangle on the left of each.
    open: BinaryHeap<Reverse<(u64, [VertexId; 2])>>,
    pushed: HashSet<[VertexId; 2]>,
}

impl HoleSearch {
    fn push(&mut self, [from, to]: [Vertex; 2]) {
        if self.pushed.insert([from.id, to.id]) {
            let nearest = nearest_on([from.point, to.point], self.at);
            let length = distance(self.at, nearest).to_bits();
            self.open.push(Reverse((length, [from.id, to.id])));
        }
    }

    /// Pushes the twins of a triangle's half-edges.
    fn push_edges(&mut self, tile: &Tile, triangle: TriangleId) {
        for half_edge in HalfEdge::of_triangle(triangle) {
            let [from, to] = tile.ends(half_edge);
            self.push([to, from]);
        }
    }

    /// Pushes the hull edges that a point outside sees, starting at `vertex`.
    async fn push_visible(&mut self, tiles: &mut Tiles, vertex: VertexId, forward: bool) -> Result<(), QueryError> {
        let mut vertex = vertex;
        loop {
            let tile = tiles.get(vertex.tile).await?;
            let space = FreeSpace::of(tiles, &tile);
            let edge = tiles.checked(vertex.tile, space.along_hull(vertex.index, forward))?;
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
            match tiles.half_edge_between(from, to).await? {
                Some((tile, half_edge)) if tile.is_hole(half_edge.triangle()) => {
                    self.push_edges(&tile, half_edge.triangle())
                }
                Some((tile, half_edge)) => {
                    let edges = HalfEdge::of_triangle(half_edge.triangle());
                    let triangle = edges.map(|edge| tile.ends(edge).map(|end| end.point));
                    let edge = tile.ends(half_edge).map(|end| end.point);
                    return Ok(Some(free_on(edge, &triangle, self.at)));
                }
                None if tiles.outside_is_free() => {
                    let tile = tiles.get(to.tile).await?;
                    let back = tiles.checked(to.tile, half_edge_along_hull(FreeSpace::of(tiles, &tile), to, from))?;
                    let [to, from] = tile.ends(back).map(|end| end.point);
                    return Ok(Some(free_on([from, to], &[[from, to]], self.at)));
                }
                None => {}
            }
        }
        Ok(None)
    }
}

/// Returns the half-edge along the hull from `from`, a vertex of the tile, to `to`.
fn half_edge_along_hull(space: FreeSpace<'_>, from: VertexId, to: VertexId) -> Result<HalfEdge, Contradiction> {
    let half_edge = space.first(from.index)?;
    let [_, end] = space.tile.ends(half_edge);
    (end.id == to)
        .then_some(half_edge)
        .ok_or(Contradiction::NoHullEdge(from, to))
}

/// Returns the point of the edge from `a` to `b` that is nearest to `p` and free. Points on the left of
/// all edges of `free`, or on them, are free; the edge is one of them.
///
/// Rounding can place the nearest point beside the edge, in the obstacle. Then it is moved off the edge
/// by some units in the last place, so that it is free by the exact predicates too.
fn free_on([a, b]: [Point; 2], free: &[[Point; 2]], p: Point) -> Point {
    /// The moves that are tried, in units in the last place. Rounding moves the point by less.
    const UNITS: [f64; 5] = [0.0, 1.0, 2.0, 4.0, 8.0];
    let nearest = nearest_on([a, b], p);
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let largest = [a.x, a.y, b.x, b.y]
        .into_iter()
        .fold(0.0, |most: f64, c| most.max(c.abs()));
    let unit = largest * f64::EPSILON / dx.hypot(dy);
    let moved = UNITS.map(|units| Point::new(nearest.x - units * unit * dy, nearest.y + units * unit * dx));
    let is_free = |point: &Point| {
        let mut edges = free.iter();
        point.is_valid() && edges.all(|&[from, to]| orient2d(from, to, *point) != Orientation::Clockwise)
    };
    // In a triangle that is too thin to have such a point, the ends of the edge are free.
    let end = if distance(a, p) < distance(b, p) { a } else { b };
    moved.into_iter().find(is_free).unwrap_or(end)
}

/// Returns the point of the segment that is nearest to `p`, rounded.
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
