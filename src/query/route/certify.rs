//! The proof of a path: a walk along each of its legs through the triangles that it passes, by
//! exact predicates.
//!
//! The proof shares with the wavefront what blocks the way
//! ([`free_space`](crate::query::free_space)), and nothing else. Each leg starts where the last one
//! ended. At a vertex that is in some wedges of the star, and the leg continues in the sectors of
//! these wedges.

use std::sync::Arc;

use crate::geometry::Orientation::{Clockwise, Collinear, CounterClockwise};
use crate::geometry::{HalfEdge, Point, TriangleId, orient2d};
use crate::query::answer::WayPoint;
use crate::query::free_space::{FreeSpace, FreeTwin, Position, QueryPoint, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, VertexId};

/// A wedge of a vertex: that of the triangle on the right of the edge to the vertex `left`, or the
/// outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Corner {
    vertex: VertexId,
    left: Option<VertexId>,
}

/// A leg during the walk: its start, its end, and its progress.
struct Leg<'t> {
    tiles: &'t mut Tiles,
    from: Point,
    to: Point,
    to_vertex: Option<VertexId>,
    to_is_outside: bool,
    /// Vertices that the leg has reached, from which it continues.
    open: Vec<Corner>,
    /// Whether the leg has arrived. `arrived` has the wedges in which it arrived at a vertex.
    has_arrived: bool,
    arrived: Vec<Corner>,
}

/// Proves that a path between two points can be walked.
///
/// # Errors
/// If it cannot, which would be a bug in this library, or if a tile cannot be read.
pub(crate) async fn certify(tiles: &mut Tiles, way: &[WayPoint], ends: [&QueryPoint; 2]) -> Result<(), QueryError> {
    let mut corners: Option<Vec<Corner>> = None;
    for leg in way.windows(2) {
        let [(from, _), (to, to_vertex)] = [leg[0], leg[1]];
        let mut leg = Leg {
            tiles: &mut *tiles,
            from,
            to,
            to_vertex,
            to_is_outside: to_vertex.is_none() && ends[1].is_outside,
            open: Vec::new(),
            has_arrived: false,
            arrived: Vec::new(),
        };
        match corners.take() {
            Some(corners) => leg.open = corners,
            None => leg.start(ends[0]).await?,
        }
        leg.walk().await?;
        if !leg.has_arrived {
            let reason = format!("no leg connects ({}, {}) to ({}, {})", from.x, from.y, to.x, to.y);
            return Err(QueryError::Uncertified { reason });
        }
        corners = Some(leg.arrived);
    }
    Ok(())
}

/// Returns whether `there` is in the direction of `to`, seen from `from`.
fn is_ahead(from: Point, there: Point, to: Point) -> bool {
    orient2d(from, there, to) == Collinear && from.lex_cmp(there) == from.lex_cmp(to)
}

/// Returns whether `to` is beyond `there`, which is in its direction.
fn is_beyond(from: Point, there: Point, to: Point) -> bool {
    there.lex_cmp(to) == from.lex_cmp(there)
}

impl Leg<'_> {
    fn space<'t>(&self, tile: &'t Tile) -> FreeSpace<'t> {
        FreeSpace::of(self.tiles, tile)
    }

    /// Starts at a query point.
    async fn start(&mut self, query_point: &QueryPoint) -> Result<(), QueryError> {
        match query_point.position {
            Position::Vertex(vertex) => {
                let tile = self.tiles.get(vertex.id.tile).await?;
                let wedges = self
                    .tiles
                    .checked(tile.id(), self.space(&tile).free_wedges(vertex.id.index))?;
                for wedge in wedges {
                    self.open.push(corner(&tile, vertex.id, wedge));
                }
            }
            Position::Triangle(triangle) => {
                let tile = self.tiles.get(triangle.tile).await?;
                self.start_in(tile, triangle.triangle).await?;
            }
            Position::Edge { ends } => {
                for [from, to] in [ends, [ends[1], ends[0]]] {
                    match self.tiles.half_edge_between(from.id, to.id).await? {
                        Some((tile, half_edge)) if tile.is_hole(half_edge.triangle()) => {}
                        Some((tile, half_edge)) => self.start_in(tile, half_edge.triangle()).await?,
                        None if self.tiles.outside_is_free() => {
                            for end in ends {
                                self.reach(end.id, end.point, None, self.from);
                            }
                            let beyond = orient2d(from.point, to.point, self.to) != Clockwise;
                            self.has_arrived |= self.to_is_outside && beyond;
                        }
                        None => {}
                    }
                }
            }
            Position::Outside(edge) => self.start_outside(edge).await?,
        }
        Ok(())
    }

    /// Starts in a closed triangle.
    async fn start_in(&mut self, tile: Arc<Tile>, triangle: TriangleId) -> Result<(), QueryError> {
        if self.arrives_in(&tile, triangle) {
            return Ok(());
        }
        for half_edge in HalfEdge::of_triangle(triangle) {
            let [right, left] = tile.ends(half_edge);
            self.reach_by(&tile, half_edge, self.from);
            let leaves = orient2d(right.point, left.point, self.from) == CounterClockwise
                && orient2d(self.from, right.point, self.to) == CounterClockwise
                && orient2d(self.from, left.point, self.to) == Clockwise;
            if leaves {
                self.cross(Arc::clone(&tile), half_edge).await?;
            }
        }
        Ok(())
    }

    /// Starts outside the hull, in sight of one of its edges.
    async fn start_outside(&mut self, [first, second]: [VertexId; 2]) -> Result<(), QueryError> {
        let mut is_free = self.to_is_outside;
        for (vertex, forward) in [(first, true), (second, false)] {
            let mut vertex = vertex;
            for _ in 0..=self.tiles.hull_edges() {
                let tile = self.tiles.get(vertex.tile).await?;
                let space = self.space(&tile);
                let edge = self
                    .tiles
                    .checked(vertex.tile, space.along_hull(vertex.index, forward))?;
                let [left, right] = tile.ends(edge);
                self.reach(left.id, left.point, None, self.from);
                self.reach(right.id, right.point, None, self.from);
                if orient2d(left.point, right.point, self.from) != Clockwise {
                    break;
                }
                let enters = orient2d(self.from, right.point, self.to) == CounterClockwise
                    && orient2d(self.from, left.point, self.to) == Clockwise
                    && orient2d(left.point, right.point, self.to) == CounterClockwise;
                if enters {
                    is_free = false;
                    // The first edge comes twice.
                    if !tile.is_wall(edge) && space.is_free(edge.triangle()) && !self.has_arrived {
                        self.through(Arc::clone(&tile), edge).await?;
                    }
                }
                vertex = if forward { right.id } else { left.id };
            }
        }
        // A leg through a vertex of the hull continues from there.
        self.has_arrived |= is_free && self.open.is_empty();
        Ok(())
    }

    /// Continues from reached vertices until there are none left.
    async fn walk(&mut self) -> Result<(), QueryError> {
        let mut done: Vec<Corner> = Vec::new();
        while let Some(corner) = self.open.pop() {
            if done.contains(&corner) {
                continue;
            }
            done.push(corner);
            if self.to_vertex == Some(corner.vertex) {
                self.has_arrived = true;
                self.arrived.push(corner);
                continue;
            }
            let tile = self.tiles.get(corner.vertex.tile).await?;
            let sector = self.tiles.checked(corner.vertex.tile, self.sector(&tile, corner))?;
            for wedge in sector {
                self.leave(&tile, corner.vertex, wedge).await?;
            }
        }
        Ok(())
    }

    /// Returns all wedges in the sector of a wedge.
    fn sector(&self, tile: &Tile, corner: Corner) -> Result<Vec<Wedge>, Contradiction> {
        let (space, vertex) = (self.space(tile), corner.vertex.index);
        if !tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        let start = match corner.left {
            None => Some(Wedge::Outside),
            Some(left) => space.right_of_edge(vertex, left)?,
        };
        let start = start.ok_or(Contradiction::LacksTriangle(vertex))?;
        Ok(space.sector(vertex, start)?.0)
    }

    /// Leaves a vertex by a wedge, if the leg leads there.
    async fn leave(&mut self, tile: &Arc<Tile>, vertex: VertexId, wedge: Wedge) -> Result<(), QueryError> {
        let at = tile.point(vertex.index);
        match wedge {
            Wedge::Triangle(half_edge) => {
                if self.arrives_in(tile, half_edge.triangle()) {
                    return Ok(());
                }
                for corner in [half_edge.next(), half_edge.prev()] {
                    self.reach_by(tile, corner, at);
                }
                let [right, left] =
                    [half_edge.next(), half_edge.prev()].map(|half_edge| tile.point(tile.origin(half_edge)));
                if orient2d(at, right, self.to) == CounterClockwise && orient2d(at, left, self.to) == Clockwise {
                    self.cross(Arc::clone(tile), half_edge.next()).await?;
                }
            }
            Wedge::Outside => {
                let ends = self
                    .tiles
                    .checked(tile.id(), self.space(tile).neighbours(vertex.index, wedge))?;
                let ends = ends.map(|end| tile.vertex(end));
                for end in ends {
                    self.reach(end.id, end.point, None, at);
                    // The end of the leg may be on the edge.
                    let is_on_edge = is_ahead(at, end.point, self.to) && is_beyond(at, self.to, end.point);
                    self.has_arrived |= self.to_vertex.is_none() && is_on_edge;
                }
                let [right, left] = ends.map(|end| end.point);
                let is_inside =
                    orient2d(at, left, self.to) == CounterClockwise && orient2d(at, right, self.to) == Clockwise;
                self.has_arrived |= self.to_is_outside && !is_inside;
            }
        }
        Ok(())
    }

    /// Returns whether the leg ends in a closed triangle that it reached.
    fn arrives_in(&mut self, tile: &Tile, triangle: TriangleId) -> bool {
        let corners = tile.triangle_points(triangle);
        if (0..3).any(|s| orient2d(corners[s], corners[(s + 1) % 3], self.to) == Clockwise) {
            return false;
        }
        let half_edges = HalfEdge::of_triangle(triangle);
        if let Some(half_edge) = half_edges
            .into_iter()
            .zip(corners)
            .find(|(_, point)| *point == self.to)
            .map(|(half_edge, _)| half_edge)
        {
            let vertex = tile.vertex(tile.origin(half_edge)).id;
            self.arrived.push(corner(tile, vertex, Wedge::Triangle(half_edge)));
        }
        self.has_arrived = true;
        true
    }

    /// Reaches the origin of a half-edge, if it is on the leg.
    fn reach_by(&mut self, tile: &Tile, half_edge: HalfEdge, from: Point) {
        let vertex = tile.vertex(tile.origin(half_edge));
        let left = tile.vertex(tile.origin(half_edge.prev())).id;
        self.reach(vertex.id, vertex.point, Some(left), from);
    }

    /// Reaches a vertex by a wedge, if it is on the leg from `from`.
    fn reach(&mut self, vertex: VertexId, point: Point, left: Option<VertexId>, from: Point) {
        let corner = Corner { vertex, left };
        if self.to_vertex == Some(vertex) && is_ahead(from, point, self.to) {
            self.has_arrived = true;
            self.arrived.push(corner);
        } else if point != from && is_ahead(from, point, self.to) && is_beyond(from, point, self.to) {
            self.open.push(corner);
        }
    }

    /// Crosses a half-edge out of its triangle, and continues beyond it.
    async fn cross(&mut self, tile: Arc<Tile>, half_edge: HalfEdge) -> Result<(), QueryError> {
        if let Some((tile, half_edge)) = self.over(tile, half_edge).await? {
            self.through(tile, half_edge).await?;
        }
        Ok(())
    }

    /// Crosses a half-edge out of its triangle. Returns its twin if the triangle there is free.
    async fn over(
        &mut self,
        tile: Arc<Tile>,
        half_edge: HalfEdge,
    ) -> Result<Option<(Arc<Tile>, HalfEdge)>, QueryError> {
        match self.space(&tile).twin(half_edge) {
            FreeTwin::HalfEdge(over) => {
                let [from, to] = tile.ends(half_edge).map(|end| end.point);
                self.check_crossing(&tile, over, [to, from])?;
                return Ok(Some((tile, over)));
            }
            FreeTwin::Blocked => return Ok(None),
            FreeTwin::Outside => {}
            FreeTwin::Elsewhere => {
                let [from, to] = tile.ends(half_edge);
                match self.tiles.half_edge_between(to.id, from.id).await? {
                    Some((tile, half_edge)) => {
                        self.check_crossing(&tile, half_edge, [to.point, from.point])?;
                        return Ok((!tile.is_hole(half_edge.triangle())).then_some((tile, half_edge)));
                    }
                    None if self.tiles.outside_is_free() => {}
                    None => return Ok(None),
                }
            }
        }
        // A straight line that leaves the hull does not return.
        self.has_arrived |= self.to_is_outside;
        Ok(None)
    }

    fn check_crossing(&self, tile: &Tile, half_edge: HalfEdge, ends: [Point; 2]) -> Result<(), QueryError> {
        self.tiles
            .checked(tile.id(), self.space(tile).check_crossing(half_edge, ends))
    }

    /// Passes the triangle of a half-edge that the leg crossed, and continues.
    async fn through(&mut self, tile: Arc<Tile>, half_edge: HalfEdge) -> Result<(), QueryError> {
        let (mut tile, mut half_edge) = (tile, half_edge);
        loop {
            if self.arrives_in(&tile, half_edge.triangle()) {
                return Ok(());
            }
            let apex = tile.point(tile.origin(half_edge.prev()));
            let exit = match orient2d(self.from, self.to, apex) {
                CounterClockwise => half_edge.next(),
                Clockwise => half_edge.prev(),
                Collinear => {
                    self.reach_by(&tile, half_edge.prev(), self.from);
                    return Ok(());
                }
            };
            match self.over(tile, exit).await? {
                Some(there) => (tile, half_edge) = there,
                None => return Ok(()),
            }
        }
    }
}

/// Returns a wedge of a vertex, identified by vertices.
fn corner(tile: &Tile, vertex: VertexId, wedge: Wedge) -> Corner {
    let left = match wedge {
        Wedge::Triangle(half_edge) => Some(tile.vertex(tile.origin(half_edge.prev())).id),
        Wedge::Outside => None,
    };
    Corner { vertex, left }
}
