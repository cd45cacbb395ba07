//! The proof of a path: a walk along each of its legs through the triangles that it passes, by exact predicates.
//!
//! It shares with the wave what blocks the way ([`ground`](crate::query::free_space::ground)), and nothing else: each leg is walked from where
//! the last one ended. At a vertex that is in some wedges of the star, and goes on in the sectors of these.

use std::sync::Arc;

use crate::geometry::Orientation::{Clockwise, Collinear, CounterClockwise};
use crate::geometry::{HalfEdge, Point, TriangleId, orient2d};
use crate::query::answer::WayPoint;
use crate::query::free_space::{Beyond, Ground, Place, Spot, Wedge};
use crate::query::request::{Contradiction, QueryError, Tiles};
use crate::store::{Tile, VertexId};

/// A wedge of a vertex: that of the triangle on the right of the edge to the vertex `left`, or the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Corner {
    vertex: VertexId,
    left: Option<VertexId>,
}

/// A leg under way: from where it comes, where it goes, and how far it has got.
struct Leg<'t> {
    tiles: &'t mut Tiles,
    from: Point,
    to: Point,
    to_vertex: Option<VertexId>,
    to_is_outside: bool,
    /// Vertices that it has reached, and goes on from.
    open: Vec<Corner>,
    /// Whether it has arrived, and at a vertex the wedges in which it did.
    has_arrived: bool,
    arrived: Vec<Corner>,
}

/// Proves that a way can be walked; its ends lie in these places.
///
/// # Errors
/// If it cannot, which would be a fault of this library, or a tile cannot be read.
pub(crate) async fn certify(tiles: &mut Tiles, way: &[WayPoint], ends: [&Place; 2]) -> Result<(), QueryError> {
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
            let reason = format!("nothing leads from ({}, {}) to ({}, {})", from.x, from.y, to.x, to.y);
            return Err(QueryError::Uncertified { reason });
        }
        corners = Some(leg.arrived);
    }
    Ok(())
}

/// Whether a point lies in the direction of another one.
fn is_ahead(from: Point, there: Point, to: Point) -> bool {
    orient2d(from, there, to) == Collinear && from.lex_cmp(there) == from.lex_cmp(to)
}

/// Whether a point in the direction of another one is beyond it.
fn is_beyond(from: Point, there: Point, to: Point) -> bool {
    there.lex_cmp(to) == from.lex_cmp(there)
}

impl Leg<'_> {
    fn ground<'t>(&self, tile: &'t Tile) -> Ground<'t> {
        Ground::of(self.tiles, tile)
    }

    /// Starts at a place.
    async fn start(&mut self, place: &Place) -> Result<(), QueryError> {
        match place.spot {
            Spot::Vertex(vertex) => {
                let tile = self.tiles.get(vertex.id.tile).await?;
                let wedges = self
                    .tiles
                    .checked(tile.id(), self.ground(&tile).free_wedges(vertex.id.index))?;
                for wedge in wedges {
                    self.open.push(corner(&tile, vertex.id, wedge));
                }
            }
            Spot::Triangle(triangle) => {
                let tile = self.tiles.get(triangle.tile).await?;
                self.start_in(tile, triangle.triangle).await?;
            }
            Spot::Edge { ends } => {
                for [from, to] in [ends, [ends[1], ends[0]]] {
                    match self.tiles.side_between(from.id, to.id).await? {
                        Some((tile, side)) if tile.is_hole(side.triangle()) => {}
                        Some((tile, side)) => self.start_in(tile, side.triangle()).await?,
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
            Spot::Outside(edge) => self.start_outside(edge).await?,
        }
        Ok(())
    }

    /// Starts in a closed triangle.
    async fn start_in(&mut self, tile: Arc<Tile>, triangle: TriangleId) -> Result<(), QueryError> {
        if self.arrives_in(&tile, triangle) {
            return Ok(());
        }
        for side in HalfEdge::of_triangle(triangle) {
            let [right, left] = tile.ends(side);
            self.reach_by(&tile, side, self.from);
            let leaves = orient2d(right.point, left.point, self.from) == CounterClockwise
                && orient2d(self.from, right.point, self.to) == CounterClockwise
                && orient2d(self.from, left.point, self.to) == Clockwise;
            if leaves {
                self.cross(Arc::clone(&tile), side).await?;
            }
        }
        Ok(())
    }

    /// Starts outside the hull, in sight of an edge of it.
    async fn start_outside(&mut self, [first, second]: [VertexId; 2]) -> Result<(), QueryError> {
        let mut is_free = self.to_is_outside;
        for (vertex, forward) in [(first, true), (second, false)] {
            let mut vertex = vertex;
            for _ in 0..=self.tiles.hull_edges() {
                let tile = self.tiles.get(vertex.tile).await?;
                let ground = self.ground(&tile);
                let edge = self
                    .tiles
                    .checked(vertex.tile, ground.along_hull(vertex.index, forward))?;
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
                    if !tile.is_wall(edge) && ground.is_free(edge.triangle()) && !self.has_arrived {
                        self.through(Arc::clone(&tile), edge).await?;
                    }
                }
                vertex = if forward { right.id } else { left.id };
            }
        }
        // What goes through a vertex of the hull goes on from there.
        self.has_arrived |= is_free && self.open.is_empty();
        Ok(())
    }

    /// Goes on from vertices until there is none.
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

    /// All wedges of the sector of a wedge.
    fn sector(&self, tile: &Tile, corner: Corner) -> Result<Vec<Wedge>, Contradiction> {
        let (ground, vertex) = (self.ground(tile), corner.vertex.index);
        if !tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        let start = match corner.left {
            None => Some(Wedge::Outside),
            Some(left) => ground.right_of_edge(vertex, left)?,
        };
        let start = start.ok_or(Contradiction::LacksTriangle(vertex))?;
        Ok(ground.sector(vertex, start)?.0)
    }

    /// Leaves a vertex by a wedge, if the way leads there.
    async fn leave(&mut self, tile: &Arc<Tile>, vertex: VertexId, wedge: Wedge) -> Result<(), QueryError> {
        let at = tile.point(vertex.index);
        match wedge {
            Wedge::Triangle(side) => {
                if self.arrives_in(tile, side.triangle()) {
                    return Ok(());
                }
                for corner in [side.next(), side.prev()] {
                    self.reach_by(tile, corner, at);
                }
                let [right, left] = [side.next(), side.prev()].map(|side| tile.point(tile.origin(side)));
                if orient2d(at, right, self.to) == CounterClockwise && orient2d(at, left, self.to) == Clockwise {
                    self.cross(Arc::clone(tile), side.next()).await?;
                }
            }
            Wedge::Outside => {
                let ends = self
                    .tiles
                    .checked(tile.id(), self.ground(tile).neighbours(vertex.index, wedge))?;
                let ends = ends.map(|end| tile.vertex(end));
                for end in ends {
                    self.reach(end.id, end.point, None, at);
                    // The end may lie on the edge.
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

    /// Whether the leg ends in a closed triangle that it has come to.
    fn arrives_in(&mut self, tile: &Tile, triangle: TriangleId) -> bool {
        let corners = tile.triangle_points(triangle);
        if (0..3).any(|s| orient2d(corners[s], corners[(s + 1) % 3], self.to) == Clockwise) {
            return false;
        }
        let sides = HalfEdge::of_triangle(triangle);
        if let Some(side) = sides
            .into_iter()
            .zip(corners)
            .find(|(_, point)| *point == self.to)
            .map(|(side, _)| side)
        {
            let vertex = tile.vertex(tile.origin(side)).id;
            self.arrived.push(corner(tile, vertex, Wedge::Triangle(side)));
        }
        self.has_arrived = true;
        true
    }

    /// Reaches the vertex of a side that leaves it, if it lies on the way.
    fn reach_by(&mut self, tile: &Tile, side: HalfEdge, from: Point) {
        let vertex = tile.vertex(tile.origin(side));
        let left = tile.vertex(tile.origin(side.prev())).id;
        self.reach(vertex.id, vertex.point, Some(left), from);
    }

    /// Reaches a vertex by a wedge, if it lies on the way from a point.
    fn reach(&mut self, vertex: VertexId, point: Point, left: Option<VertexId>, from: Point) {
        let corner = Corner { vertex, left };
        if self.to_vertex == Some(vertex) && is_ahead(from, point, self.to) {
            self.has_arrived = true;
            self.arrived.push(corner);
        } else if point != from && is_ahead(from, point, self.to) && is_beyond(from, point, self.to) {
            self.open.push(corner);
        }
    }

    /// Crosses a side out of its triangle, and goes on through those behind it.
    async fn cross(&mut self, tile: Arc<Tile>, side: HalfEdge) -> Result<(), QueryError> {
        if let Some((tile, side)) = self.over(tile, side).await? {
            self.through(tile, side).await?;
        }
        Ok(())
    }

    /// Crosses a side out of its triangle: the side of the free triangle behind it, if there is one.
    async fn over(&mut self, tile: Arc<Tile>, side: HalfEdge) -> Result<Option<(Arc<Tile>, HalfEdge)>, QueryError> {
        match self.ground(&tile).beyond(side) {
            Beyond::Side(over) => {
                let [from, to] = tile.ends(side).map(|end| end.point);
                self.check_crossing(&tile, over, [to, from])?;
                return Ok(Some((tile, over)));
            }
            Beyond::Blocked => return Ok(None),
            Beyond::Outside => {}
            Beyond::Elsewhere => {
                let [from, to] = tile.ends(side);
                match self.tiles.side_between(to.id, from.id).await? {
                    Some((tile, side)) => {
                        self.check_crossing(&tile, side, [to.point, from.point])?;
                        return Ok((!tile.is_hole(side.triangle())).then_some((tile, side)));
                    }
                    None if self.tiles.outside_is_free() => {}
                    None => return Ok(None),
                }
            }
        }
        // Who leaves the hull does not come back on a straight line.
        self.has_arrived |= self.to_is_outside;
        Ok(None)
    }

    fn check_crossing(&self, tile: &Tile, side: HalfEdge, ends: [Point; 2]) -> Result<(), QueryError> {
        self.tiles
            .checked(tile.id(), self.ground(tile).check_crossing(side, ends))
    }

    /// Goes through the triangle of a side that it has crossed, and on.
    async fn through(&mut self, tile: Arc<Tile>, side: HalfEdge) -> Result<(), QueryError> {
        let (mut tile, mut side) = (tile, side);
        loop {
            if self.arrives_in(&tile, side.triangle()) {
                return Ok(());
            }
            let apex = tile.point(tile.origin(side.prev()));
            let exit = match orient2d(self.from, self.to, apex) {
                CounterClockwise => side.next(),
                Clockwise => side.prev(),
                Collinear => {
                    self.reach_by(&tile, side.prev(), self.from);
                    return Ok(());
                }
            };
            match self.over(tile, exit).await? {
                Some(there) => (tile, side) = there,
                None => return Ok(()),
            }
        }
    }
}

/// The wedge of a vertex, by vertices.
fn corner(tile: &Tile, vertex: VertexId, wedge: Wedge) -> Corner {
    let left = match wedge {
        Wedge::Triangle(side) => Some(tile.vertex(tile.origin(side.prev())).id),
        Wedge::Outside => None,
    };
    Corner { vertex, left }
}
