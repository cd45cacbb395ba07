//! What is near as the crow flies, through obstacles and all: vertices with sites, and obstacle edges that meet a disc or a segment.
//!
//! The triangulation is its own index: from a place on, triangles are entered over each side that is near enough, nearest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use foldhash::{HashSet, HashSetExt};

use super::obstacles::ObstacleEdge;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::mesh::Twin;
use crate::query::answer::distance;
use crate::query::free_space::{Ground, Place, Spot, Wedge, nearest_on};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, TileId, Vertex, VertexId};

/// What things are near to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Center {
    /// By their distance from a point.
    Point(Point),
    /// Only if they meet a segment.
    Segment([Point; 2]),
}

impl Center {
    /// The distance of a segment, rounded; infinite if it does not count.
    fn distance(self, [a, b]: [Point; 2]) -> f64 {
        match self {
            Self::Point(p) => distance_of_segment([a, b], p),
            Self::Segment(segment) if meet(segment, [a, b]) => 0.0,
            Self::Segment(_) => f64::INFINITY,
        }
    }
}

/// The distance of a point from a segment, rounded.
pub(super) fn distance_of_segment(ends: [Point; 2], p: Point) -> f64 {
    distance(nearest_on(ends, p), p)
}

/// Whether two closed segments have a point in common. Exact.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let are_apart = |turns: [Orientation; 2]| turns[0] == turns[1] && turns[0] != Orientation::Collinear;
    let turns = [orient2d(a, b, c), orient2d(a, b, d)];
    if are_apart(turns) || are_apart([orient2d(c, d, a), orient2d(c, d, b)]) {
        return false;
    }
    let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
    turns != [Orientation::Collinear; 2] || (overlap(a.x, b.x, c.x, d.x) && overlap(a.y, b.y, c.y, d.y))
}

/// What is to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Thing {
    /// What lies beyond a side of a tile's triangle.
    Beyond(TileId, HalfEdge),
    /// The triangle of a side, from outside the hull.
    Into(TileId, HalfEdge),
    Vertex(VertexId),
}

/// What was met.
#[derive(Clone, Debug)]
pub(super) enum Met {
    Edge(ObstacleEdge),
    /// A vertex with sites, with number and id of each, and its distance.
    Sites(Vertex, Vec<(u64, Option<String>)>, f64),
}

/// Things near a point or a segment, nearest first.
pub(super) struct Nearby {
    center: Center,
    /// By the bits of the distance.
    open: BinaryHeap<Reverse<(u64, Thing)>>,
    edges: HashSet<[VertexId; 2]>,
    vertices: HashSet<VertexId>,
    /// Obstacle edges that were looked at, near or not, by their ends in order.
    pub(super) walls: Vec<[VertexId; 2]>,
}

/// Rounding makes nothing farther than a limit by more than this part.
const MARGIN: f64 = 1.0 + 1e-12;

impl Nearby {
    /// Starts at a place, which lies at the center.
    pub(super) async fn start(tiles: &mut Tiles, place: &Place, center: Center) -> Result<Self, QueryError> {
        let mut this = Self {
            center,
            open: BinaryHeap::new(),
            edges: HashSet::new(),
            vertices: HashSet::new(),
            walls: Vec::new(),
        };
        match place.spot {
            Spot::Triangle(triangle) => {
                let tile = this.tile(tiles, triangle.tile).await?;
                this.take(&tile, triangle.triangle);
            }
            Spot::Edge { ends: [a, b] } => {
                for [from, to] in [[a, b], [b, a]] {
                    if let Some((tile, side)) = tiles.side_between(from.id, to.id).await? {
                        this.take(&tile, side.triangle());
                    }
                }
            }
            Spot::Vertex(vertex) => {
                let tile = this.tile(tiles, vertex.id.tile).await?;
                let ground = Ground::of(tiles, &tile);
                let wedges = tiles.checked(tile.id(), ground.wedges(vertex.id.index))?;
                for wedge in wedges {
                    if let Wedge::Triangle(side) = wedge {
                        this.take(&tile, side.triangle());
                    }
                }
            }
            Spot::Outside([from, to]) => {
                for (vertex, forward) in [(from, true), (to, false)] {
                    this.take_hull(tiles, place.point, vertex, forward).await?;
                }
            }
        }
        Ok(this)
    }

    async fn tile(&self, tiles: &mut Tiles, id: TileId) -> Result<Arc<Tile>, QueryError> {
        let tile = tiles.get(id).await?;
        let ground = Ground::of(tiles, &tile);
        if ground.has_break_lines() {
            return Err(tiles.break_lines());
        }
        Ok(tile)
    }

    /// The next thing that is not farther than a limit.
    pub(super) async fn next(&mut self, tiles: &mut Tiles, limit: f64) -> Result<Option<Met>, QueryError> {
        while let Some(&Reverse((bits, thing))) = self.open.peek() {
            let far = f64::from_bits(bits);
            if far > limit * MARGIN {
                return Ok(None);
            }
            self.open.pop();
            let (outside, found) = match thing {
                Thing::Vertex(vertex) => {
                    let tile = self.tile(tiles, vertex.tile).await?;
                    let sites = tile.sites_at(vertex.index);
                    let sites: Vec<_> = sites.map(|site| (site.number, site.id.map(str::to_owned))).collect();
                    if !sites.is_empty() {
                        return Ok(Some(Met::Sites(tile.vertex(vertex.index), sites, far)));
                    }
                    continue;
                }
                Thing::Into(id, side) => {
                    let tile = self.tile(tiles, id).await?;
                    self.take(&tile, side.triangle());
                    (Some(tiles.outside_is_free()), (tile, side))
                }
                Thing::Beyond(id, side) => (None, (self.tile(tiles, id).await?, side)),
            };
            let (tile, side) = found;
            let beyond = match outside {
                Some(is_free) => is_free,
                None => self.enter_beyond(tiles, &tile, side).await?,
            };
            if tile.is_wall(side) {
                return Ok(Some(Met::Edge(ObstacleEdge {
                    ends: tile.ends(side),
                    free: [!tile.is_hole(side.triangle()), beyond],
                })));
            }
        }
        Ok(None)
    }

    /// Enters what lies beyond a side, and says whether it is free.
    async fn enter_beyond(&mut self, tiles: &mut Tiles, tile: &Arc<Tile>, side: HalfEdge) -> Result<bool, QueryError> {
        let beyond = match tile.twin(side) {
            Twin::HalfEdge(other) => Some((Arc::clone(tile), other)),
            Twin::Hull => None,
            Twin::Elsewhere => {
                let [from, to] = tile.ends(side).map(|end| end.id);
                tiles.side_between(to, from).await?
            }
        };
        Ok(match beyond {
            Some((tile, side)) => {
                self.take(&tile, side.triangle());
                !tile.is_hole(side.triangle())
            }
            None => tiles.outside_is_free(),
        })
    }

    /// The distance of all that was not met is at least this.
    pub(super) fn front(&self) -> f64 {
        self.open.peek().map_or(f64::INFINITY, |open| f64::from_bits(open.0.0))
    }

    /// Puts what belongs to a triangle in the queue.
    fn take(&mut self, tile: &Tile, triangle: TriangleId) {
        for side in HalfEdge::of_triangle(triangle) {
            self.push_side(tile, side, Thing::Beyond(tile.id(), side));
            if let Center::Point(center) = self.center {
                let corner = tile.vertex(tile.origin(side));
                if self.vertices.insert(corner.id) {
                    let far = distance(corner.point, center);
                    self.open.push(Reverse((far.to_bits(), Thing::Vertex(corner.id))));
                }
            }
        }
    }

    fn push_side(&mut self, tile: &Tile, side: HalfEdge, thing: Thing) {
        let ends = [side, side.next()].map(|side| tile.vertex(tile.origin(side)));
        let [a, b] = ends.map(|end| end.id);
        let key = if a < b { [a, b] } else { [b, a] };
        if !self.edges.insert(key) {
            return;
        }
        if tile.is_wall(side) {
            self.walls.push(key);
        }
        let far = self.center.distance(ends.map(|end| end.point));
        if far.is_finite() {
            self.open.push(Reverse((far.to_bits(), thing)));
        }
    }

    /// The hull's edges that a point outside sees, from a vertex on.
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
            let ground = Ground::of(tiles, &tile);
            let edge = tiles.checked(vertex.tile, ground.along_hull(vertex.index, forward))?;
            let [from, to] = tile.ends(edge);
            if orient2d(from.point, to.point, at) != Orientation::Clockwise {
                break;
            }
            self.push_side(&tile, edge, Thing::Into(tile.id(), edge));
            vertex = if forward { to.id } else { from.id };
        }
        Ok(())
    }
}
