//! Where a query begins or ends: on which vertex, edge or triangle, whether that is free, and where the nearest free point is if not.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use foldhash::HashSet;

use super::ground::{Ground, Wedge};
use super::locate::Walked;
use super::star::next;
use super::tiles::Tiles;
use super::wave::distance;
use super::{Location, QueryError, TriangleRef, representable};
use crate::geometry::{Orientation, Point, orient2d};
use crate::store::{Tile, TileId, Vertex, VertexId};

/// A point, and where it lies.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) point: Point,
    pub(super) spot: Spot,
    /// Whether one may be there.
    pub(super) is_free: bool,
    /// Whether it lies outside the hull or on its edge, and the outside is free.
    pub(super) is_outside: bool,
    /// The corners of the free triangles that it lies in or on the edge of; none for a vertex.
    pub(super) triangles: Vec<[Point; 3]>,
    /// The free triangles at the vertex or the edge that it is on, as far as they are known.
    pub(super) around: Vec<(TileId, u32)>,
}

/// Where a point lies.
#[derive(Clone, Copy, Debug)]
pub(super) enum Spot {
    /// Within a triangle.
    Triangle(TriangleRef),
    /// Within an edge.
    Edge { ends: [Vertex; 2] },
    /// On a vertex.
    Vertex(Vertex),
    /// Outside, where it sees this edge of the hull, which has the hull on its left.
    Outside([VertexId; 2]),
}

impl Place {
    /// Finds out where a point lies. A coordinate closer to 0 than any of a triangulation can be counts as 0.
    pub(super) async fn find(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let point = Point::new(representable(point.x), representable(point.y)).normalized();
        if !point.is_valid() {
            return Err(QueryError::NotAPoint { point });
        }
        let Walked { location, exit } = tiles.walk(point).await?;
        let spot = match (location, exit) {
            (Location::InTriangle(triangle), _) => Spot::Triangle(triangle),
            (Location::OnEdge { ends, .. }, _) => Spot::Edge { ends },
            (Location::OnVertex(vertex), _) => Spot::Vertex(vertex),
            (Location::Outside, Some(edge)) => Spot::Outside(edge),
            (Location::Outside, None) => return Err(tiles.no_triangles()),
        };
        let mut this = Self {
            point,
            spot,
            is_free: false,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        };
        this.look_round(tiles).await?;
        Ok(this)
    }

    /// The same for a point where one must be free.
    pub(super) async fn find_free(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let place = Self::find(tiles, point).await?;
        if place.is_free {
            return Ok(place);
        }
        let nearest_free = place.nearest_free(tiles).await?;
        Err(QueryError::InsideObstacle { point, nearest_free })
    }

    /// A vertex that is known to be free.
    pub(super) fn at(vertex: Vertex) -> Self {
        Self {
            point: vertex.point,
            spot: Spot::Vertex(vertex),
            is_free: true,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        }
    }

    /// The vertex that it is, if it is one.
    pub(super) fn vertex(&self) -> Option<VertexId> {
        match self.spot {
            Spot::Vertex(vertex) => Some(vertex.id),
            _ => None,
        }
    }

    /// A tile that a search from here needs first.
    pub(super) fn tile(&self) -> TileId {
        match self.spot {
            Spot::Triangle(triangle) => triangle.tile,
            Spot::Edge { ends: [_, end] } => end.id.tile,
            Spot::Vertex(vertex) => vertex.id.tile,
            Spot::Outside([from, _]) => from.tile,
        }
    }

    /// Finds out whether the place is free.
    async fn look_round(&mut self, tiles: &mut Tiles) -> Result<(), QueryError> {
        let outside_is_free = tiles.outside_is_free();
        match self.spot {
            Spot::Outside(_) => self.is_outside = outside_is_free,
            Spot::Triangle(TriangleRef { tile, triangle, .. }) => {
                let tile = tiles.get(tile).await?;
                if !tile.is_hole(triangle) {
                    self.triangles.push(tile.triangle_points(triangle));
                }
            }
            Spot::Vertex(vertex) => {
                let tile = tiles.get(vertex.id.tile).await?;
                if tile.side_leaving(vertex.id.index).is_none() {
                    return Err(tiles.no_triangles());
                }
                let ground = Ground {
                    tile: &tile,
                    outside_is_free,
                };
                let wedges = ground.free_wedges(vertex.id.index);
                let wedges = wedges.map_err(|reason| tiles.damaged(tile.id(), reason))?;
                self.is_free = !wedges.is_empty();
                for wedge in wedges {
                    if let Wedge::Triangle(side) = wedge {
                        self.around.push((tile.id(), side / 3));
                    }
                }
            }
            Spot::Edge { ends: [a, b] } => {
                for [from, to] in [[a, b], [b, a]] {
                    match tiles.side_between(from.id, to.id).await? {
                        Some((tile, side)) if tile.is_hole(side / 3) => {}
                        Some((tile, side)) => {
                            self.triangles.push(tile.triangle_points(side / 3));
                            self.around.push((tile.id(), side / 3));
                        }
                        None => self.is_outside |= outside_is_free,
                    }
                }
            }
        }
        self.is_free |= self.is_outside || !self.triangles.is_empty();
        Ok(())
    }

    /// The nearest point where one may be, of a place where one may not. None if there is no such point.
    pub(super) async fn nearest_free(&self, tiles: &mut Tiles) -> Result<Option<Point>, QueryError> {
        let mut search = Search {
            at: self.point,
            open: BinaryHeap::new(),
            pushed: HashSet::default(),
        };
        match self.spot {
            Spot::Triangle(triangle) => search.push_sides(&*tiles.get(triangle.tile).await?, triangle.triangle),
            Spot::Edge { ends: [a, b] } => {
                search.push([a, b]);
                search.push([b, a]);
            }
            Spot::Vertex(vertex) => {
                let tile = tiles.get(vertex.id.tile).await?;
                let ground = Ground {
                    tile: &tile,
                    outside_is_free: tiles.outside_is_free(),
                };
                let wedges = ground.wedges(vertex.id.index);
                for wedge in wedges.map_err(|reason| tiles.damaged(tile.id(), reason))? {
                    if let Wedge::Triangle(side) = wedge {
                        search.push_sides(&tile, side / 3);
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
    fn push_sides(&mut self, tile: &Tile, triangle: u32) {
        for side in 3 * triangle..3 * triangle + 3 {
            let [from, to] = tile.ends(side);
            self.push([to, from]);
        }
    }

    /// What lies behind the hull's edges that a point outside sees, from a vertex on.
    async fn push_visible(&mut self, tiles: &mut Tiles, vertex: VertexId, forward: bool) -> Result<(), QueryError> {
        let mut vertex = vertex;
        loop {
            let tile = tiles.get(vertex.tile).await?;
            let ground = Ground {
                tile: &tile,
                outside_is_free: false,
            };
            let edge = ground.along_hull(vertex.index, forward);
            let edge = edge.map_err(|reason| tiles.damaged(vertex.tile, reason))?;
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
                Some((tile, side)) if tile.is_hole(side / 3) => self.push_sides(&tile, side / 3),
                Some((tile, side)) => return Ok(Some(nearest_on(tile.ends(side).map(|end| end.point), self.at))),
                None if tiles.outside_is_free() => {
                    let tile = tiles.get(to.tile).await?;
                    let back = side_towards_hull(&tile, to, from).map_err(|reason| tiles.damaged(to.tile, reason))?;
                    return Ok(Some(nearest_on(tile.ends(back).map(|end| end.point), self.at)));
                }
                None => {}
            }
        }
        Ok(None)
    }
}

/// The side from a vertex of the tile along the hull to the next one.
fn side_towards_hull(tile: &Tile, from: VertexId, to: VertexId) -> Result<u32, String> {
    let ground = Ground {
        tile,
        outside_is_free: true,
    };
    let side = ground.first(from.index)?;
    let is_it = tile.vertex(tile.origin(next(side))).id == to;
    if is_it {
        Ok(side)
    } else {
        Err(format!("vertices {from} and {to} have no edge on the hull"))
    }
}

/// The point of a segment that is nearest to a point, rounded.
pub(super) fn nearest_on([a, b]: [Point; 2], p: Point) -> Point {
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
