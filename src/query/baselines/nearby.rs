//! Euclidean proximity, regardless of obstacles: vertices with sites, and obstacle edges that meet
//! a disc or a segment.
//!
//! The triangulation is its own index: starting at a point, the search enters triangles through
//! each edge that is near enough, nearest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use foldhash::{HashSet, HashSetExt};

use super::obstacles::ObstacleEdge;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::mesh::Twin;
use crate::query::answer::distance;
use crate::query::free_space::{FreeSpace, Position, QueryPoint, Wedge, nearest_on};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, TileId, Vertex, VertexId};

/// The center of a search.
#[derive(Clone, Copy, Debug)]
pub(super) enum Center {
    /// A point; things are ordered by their distance from it.
    Point(Point),
    /// A segment; only things that meet it count.
    Segment([Point; 2]),
}

impl Center {
    /// Returns the distance of a segment, rounded; infinite if it does not count.
    fn distance(self, [a, b]: [Point; 2]) -> f64 {
        match self {
            Self::Point(p) => distance_of_segment([a, b], p),
            Self::Segment(segment) if meet(segment, [a, b]) => 0.0,
            Self::Segment(_) => f64::INFINITY,
        }
    }
}

/// Returns the distance of a point from a segment, rounded.
pub(super) fn distance_of_segment(ends: [Point; 2], p: Point) -> f64 {
    distance(nearest_on(ends, p), p)
}

/// Returns whether two closed segments intersect. Exact.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let are_apart = |turns: [Orientation; 2]| turns[0] == turns[1] && turns[0] != Orientation::Collinear;
    let turns = [orient2d(a, b, c), orient2d(a, b, d)];
    if are_apart(turns) || are_apart([orient2d(c, d, a), orient2d(c, d, b)]) {
        return false;
    }
    let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
    turns != [Orientation::Collinear; 2] || (overlap(a.x, b.x, c.x, d.x) && overlap(a.y, b.y, c.y, d.y))
}

/// A thing to be examined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum QueueItem {
    /// What is beyond a half-edge of a tile's triangle.
    Twin(TileId, HalfEdge),
    /// The triangle of a half-edge, entered from outside the hull.
    Into(TileId, HalfEdge),
    Vertex(VertexId),
}

/// A thing that was found.
#[derive(Clone, Debug)]
pub(super) enum Met {
    Edge(ObstacleEdge),
    /// A vertex with sites: the number and id of each site, and the distance.
    Sites(Vertex, Vec<(u64, Option<String>)>, f64),
}

/// Things near a point or a segment, nearest first.
pub(super) struct Nearby {
    center: Center,
    /// The queue, by the bits of the distance.
    open: BinaryHeap<Reverse<(u64, QueueItem)>>,
    edges: HashSet<[VertexId; 2]>,
    vertices: HashSet<VertexId>,
    /// Obstacle edges that were examined, near or not, with sorted ends.
    pub(super) walls: Vec<[VertexId; 2]>,
}

/// The factor that covers the rounding errors of distances.
const MARGIN: f64 = 1.0 + 1e-12;

impl Nearby {
    /// Starts at a query point, which is at the center.
    pub(super) async fn start(tiles: &mut Tiles, query_point: &QueryPoint, center: Center) -> Result<Self, QueryError> {
        let mut this = Self {
            center,
            open: BinaryHeap::new(),
            edges: HashSet::new(),
            vertices: HashSet::new(),
            walls: Vec::new(),
        };
        match query_point.position {
            Position::Triangle(triangle) => {
                let tile = this.tile(tiles, triangle.tile).await?;
                this.take(&tile, triangle.triangle);
            }
            Position::Edge { ends: [a, b] } => {
                for [from, to] in [[a, b], [b, a]] {
                    if let Some((tile, half_edge)) = tiles.half_edge_between(from.id, to.id).await? {
                        this.take(&tile, half_edge.triangle());
                    }
                }
            }
            Position::Vertex(vertex) => {
                let tile = this.tile(tiles, vertex.id.tile).await?;
                let space = FreeSpace::of(tiles, &tile);
                let wedges = tiles.checked(tile.id(), space.wedges(vertex.id.index))?;
                for wedge in wedges {
                    if let Wedge::Triangle(half_edge) = wedge {
                        this.take(&tile, half_edge.triangle());
                    }
                }
            }
            Position::Outside([from, to]) => {
                for (vertex, forward) in [(from, true), (to, false)] {
                    this.take_hull(tiles, query_point.point, vertex, forward).await?;
                }
            }
        }
        Ok(this)
    }

    async fn tile(&self, tiles: &mut Tiles, id: TileId) -> Result<Arc<Tile>, QueryError> {
        let tile = tiles.get(id).await?;
        let space = FreeSpace::of(tiles, &tile);
        if space.has_break_lines() {
            return Err(tiles.break_lines());
        }
        Ok(tile)
    }

    /// Returns the next thing whose distance is at most `limit`.
    pub(super) async fn next(&mut self, tiles: &mut Tiles, limit: f64) -> Result<Option<Met>, QueryError> {
        while let Some(&Reverse((bits, thing))) = self.open.peek() {
            let far = f64::from_bits(bits);
            if far > limit * MARGIN {
                return Ok(None);
            }
            self.open.pop();
            let (outside, found) = match thing {
                QueueItem::Vertex(vertex) => {
                    let tile = self.tile(tiles, vertex.tile).await?;
                    let sites = tile.sites_at(vertex.index);
                    let sites: Vec<_> = sites.map(|site| (site.number, site.id.map(str::to_owned))).collect();
                    if !sites.is_empty() {
                        return Ok(Some(Met::Sites(tile.vertex(vertex.index), sites, far)));
                    }
                    continue;
                }
                QueueItem::Into(id, half_edge) => {
                    let tile = self.tile(tiles, id).await?;
                    self.take(&tile, half_edge.triangle());
                    (Some(tiles.outside_is_free()), (tile, half_edge))
                }
                QueueItem::Twin(id, half_edge) => (None, (self.tile(tiles, id).await?, half_edge)),
            };
            let (tile, half_edge) = found;
            let beyond = match outside {
                Some(is_free) => is_free,
                None => self.enter_twin(tiles, &tile, half_edge).await?,
            };
            if tile.is_wall(half_edge) {
                return Ok(Some(Met::Edge(ObstacleEdge {
                    ends: tile.ends(half_edge),
                    free: [!tile.is_hole(half_edge.triangle()), beyond],
                })));
            }
        }
        Ok(None)
    }

    /// Enters the twin of a half-edge. Returns whether the space there is free.
    async fn enter_twin(
        &mut self,
        tiles: &mut Tiles,
        tile: &Arc<Tile>,
        half_edge: HalfEdge,
    ) -> Result<bool, QueryError> {
        let beyond = match tile.twin(half_edge) {
            Twin::HalfEdge(other) => Some((Arc::clone(tile), other)),
            Twin::Hull => None,
            Twin::Elsewhere => {
                let [from, to] = tile.ends(half_edge).map(|end| end.id);
                tiles.half_edge_between(to, from).await?
            }
        };
        Ok(match beyond {
            Some((tile, half_edge)) => {
                self.take(&tile, half_edge.triangle());
                !tile.is_hole(half_edge.triangle())
            }
            None => tiles.outside_is_free(),
        })
    }

    /// Returns a lower bound of the distance of all things that were not found yet.
    pub(super) fn front(&self) -> f64 {
        self.open.peek().map_or(f64::INFINITY, |open| f64::from_bits(open.0.0))
    }

    /// Puts the edges and corners of a triangle in the queue.
    fn take(&mut self, tile: &Tile, triangle: TriangleId) {
        for half_edge in HalfEdge::of_triangle(triangle) {
            self.push_side(tile, half_edge, QueueItem::Twin(tile.id(), half_edge));
            if let Center::Point(center) = self.center {
                let corner = tile.vertex(tile.origin(half_edge));
                if self.vertices.insert(corner.id) {
                    let far = distance(corner.point, center);
                    self.open.push(Reverse((far.to_bits(), QueueItem::Vertex(corner.id))));
                }
            }
        }
    }

    fn push_side(&mut self, tile: &Tile, half_edge: HalfEdge, thing: QueueItem) {
        let ends = [half_edge, half_edge.next()].map(|half_edge| tile.vertex(tile.origin(half_edge)));
        let [a, b] = ends.map(|end| end.id);
        let key = if a < b { [a, b] } else { [b, a] };
        if !self.edges.insert(key) {
            return;
        }
        if tile.is_wall(half_edge) {
            self.walls.push(key);
        }
        let far = self.center.distance(ends.map(|end| end.point));
        if far.is_finite() {
            self.open.push(Reverse((far.to_bits(), thing)));
        }
    }

    /// Puts the hull edges that a point outside sees, starting at `vertex`, in the queue.
    async fn take_hull(
        &mut self,
        tiles: &mut Tiles,
        at: Point,
        vertex: VertexId,
        forward: bool,
    ) -> Result<(), QueryError> {
        let mut vertex = vertex;
        for _ in 0..=tiles.hull_edges() {
            let tile = self.tile(tiles, vertex.tile).await?;
            if !tile.has_vertex(vertex.index) {
                return Err(tiles.damaged(vertex.tile, Contradiction::NoVertex(vertex.index)));
            }
            let space = FreeSpace::of(tiles, &tile);
            let edge = tiles.checked(vertex.tile, space.along_hull(vertex.index, forward))?;
            let [from, to] = tile.ends(edge);
            if orient2d(from.point, to.point, at) != Orientation::Clockwise {
                break;
            }
            self.push_side(&tile, edge, QueueItem::Into(tile.id(), edge));
            vertex = if forward { to.id } else { from.id };
        }
        Ok(())
    }
}
