//! What lies around the core of a tile: its late triangles and the open sides of its core, found side by side by their edges.

use crate::collections::bucket_sort::bucket_sort;
use crate::geometry::Rect;
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::WALLS;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{LateTriangle, OpenSide, SeamVertex, TileState};
use crate::store::{TileId, VertexId};

/// The late triangles of a tile and its open sides. It does not depend on the order in which these came.
#[derive(Debug)]
pub(crate) struct BorderMesh {
    tile: TileId,
    /// Vertices of the tile; corners from here on are foreign.
    pub(crate) vertices: u32,
    /// Triangles of the core; those from here on are late ones, in order.
    pub(crate) core_triangles: u32,
    pub(crate) open_sides: Vec<OpenSide>,
    /// The vertices of other tiles, in order.
    pub(crate) foreign: Vec<SeamVertex>,
    /// In order.
    pub(crate) late: Vec<Late>,
    /// By edge.
    pub(crate) sides: Vec<EdgeSide>,
    /// Around the corners of those that belong to the tile.
    pub(crate) bounds: Rect,
}

/// A late triangle, from its smallest corner on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Late {
    pub(crate) corners: [u32; 3],
    /// The bits of its sides: constraints, walls, and behind these whether the edge belongs to the tile.
    bits: u16,
    /// Its number in the log.
    pub(crate) number: u32,
    /// Whether it belongs to the tile.
    pub(crate) is_own: bool,
}

/// The place of the first bit that says whether an edge belongs to the tile.
const OWN: u32 = 2 * WALLS;

/// A side on an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeSide {
    /// Corners, the smaller first.
    pub(crate) edge: [u32; 2],
    /// Through core and late triangles.
    pub(crate) side: HalfEdge,
    /// Where the side is open: its place among open sides. Else of no meaning.
    open: u32,
}

impl Late {
    /// The bits of its sides, as in a triangulation with constraints.
    pub(crate) fn side_bits(&self) -> u8 {
        (self.bits & ((1 << OWN) - 1)) as u8
    }

    /// From the smallest corner on.
    fn smallest_first(mut self) -> Self {
        while self.corners[0] > self.corners[1] || self.corners[0] > self.corners[2] {
            self.corners.rotate_left(1);
            // The three bits of each kind go round too.
            let turned = |first: u32| {
                let three = self.bits >> first & 0b111;
                (three >> 1 | three << 2 & 0b100) << first
            };
            self.bits = turned(0) | turned(WALLS) | turned(OWN);
        }
        self
    }
}

impl BorderMesh {
    /// Of a tile, from what the border log has of its group.
    ///
    /// Without triangles, an edge may lead to a vertex of another tile: the next one on the line.
    pub(crate) fn of(tile: TileId, state: &TileState, group: &GroupBorders, next: Option<SeamVertex>) -> Self {
        let vertices = state.vertices;
        let triangles: Vec<LateTriangle> = group.triangles_of(tile).collect();
        let corners = triangles.iter().flat_map(|t| t.corners);
        let mut foreign: Vec<SeamVertex> = corners.filter(|v| v.id.tile != tile).chain(next).collect();
        foreign.sort_unstable_by_key(|v| v.id);
        foreign.dedup_by_key(|v| v.id);
        let mut this = Self {
            tile,
            vertices,
            core_triangles: state.core_triangles,
            open_sides: group.sides_of(tile),
            foreign,
            late: Vec::with_capacity(triangles.len()),
            sides: Vec::new(),
            bounds: Rect::EMPTY,
        };
        for triangle in &triangles {
            let corners = triangle.corners;
            let is_mine = |a: &SeamVertex, b: &SeamVertex| {
                let first = if a.point.lex_cmp(b.point).is_lt() { a } else { b };
                first.id.tile == tile
            };
            let own = [0, 1, 2].map(|s| u16::from(is_mine(&corners[s], &corners[(s + 1) % 3])) << s);
            let smallest = corners.iter().min_by(|a, b| a.point.lex_cmp(b.point));
            let is_own = smallest.is_some_and(|v| v.id.tile == tile);
            if is_own {
                this.bounds = this.bounds.union(Rect::around(corners.map(|v| v.point)));
            }
            let late = Late {
                corners: corners.map(|v| this.corner(v.id)),
                bits: u16::from(triangle.side_bits) | (own[0] | own[1] | own[2]) << OWN,
                number: triangle.number,
                is_own,
            };
            this.late.push(late.smallest_first());
        }
        let corners = (vertices as usize) + this.foreign.len();
        this.late = bucket_sort(&this.late, corners, |late| late.corners[0], |late| *late);
        this.sides = this.sides_by_edge();
        this
    }

    /// Bytes that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.open_sides)
            + size_of_val(&*self.foreign)
            + size_of_val(&*self.late)
            + size_of_val(&*self.sides);
        bytes as u64
    }

    fn sides_by_edge(&self) -> Vec<EdgeSide> {
        let on = |from: u32, to: u32, side, open| EdgeSide {
            edge: [from.min(to), from.max(to)],
            side,
            open,
        };
        let mut sides = Vec::with_capacity(self.open_sides.len() + 3 * self.late.len());
        let open = self.open_sides.iter().zip(0..);
        sides.extend(open.map(|(open, place)| on(open.from, open.to, open.side, place)));
        for (late, triangle) in self.late.iter().zip((self.core_triangles..).map(TriangleId)) {
            let [a, b, c] = late.corners;
            let [ab, bc, ca] = HalfEdge::of_triangle(triangle);
            sides.extend([(a, b, ab), (b, c, bc), (c, a, ca)].map(|(from, to, side)| on(from, to, side, 0)));
        }
        let corners = (self.vertices as usize) + self.foreign.len();
        bucket_sort(&sides, corners, |side| side.edge[0], |side| (side.edge[1], side.side))
    }

    /// The corner that a vertex is in the tile: its own, or one of a late triangle of it.
    pub(crate) fn corner(&self, id: VertexId) -> u32 {
        if id.tile == self.tile {
            return id.index.0;
        }
        self.vertices + self.foreign.partition_point(|f| f.id < id) as u32
    }

    /// The late triangle of a side, if it is one's, and the side's place in it.
    fn late_of(&self, side: HalfEdge) -> Option<(&Late, usize)> {
        let late = side.triangle().0.checked_sub(self.core_triangles)?;
        Some((&self.late[late as usize], side.corner() as usize))
    }

    /// The corner from which a side starts.
    pub(crate) fn from(&self, side: &EdgeSide) -> u32 {
        match self.late_of(side.side) {
            Some((late, s)) => late.corners[s],
            None => self.open_sides[side.open as usize].from,
        }
    }

    /// The late triangle of a side, or the component of the core that it is open to.
    pub(crate) fn within(&self, side: &EdgeSide) -> Result<u32, u32> {
        match self.late_of(side.side) {
            Some((late, _)) => Ok(late.number),
            None => Err(self.open_sides[side.open as usize].component),
        }
    }

    /// Whether a side is a constraint.
    pub(crate) fn is_constraint(&self, side: &EdgeSide) -> bool {
        match self.late_of(side.side) {
            Some((late, s)) => late.bits >> s & 1 == 1,
            None => self.open_sides[side.open as usize].is_constraint,
        }
    }

    /// Whether the edge of a side belongs to the tile.
    pub(crate) fn is_own_edge(&self, side: &EdgeSide) -> bool {
        self.late_of(side.side)
            .is_none_or(|(late, s)| late.bits >> (s as u32 + OWN) & 1 == 1)
    }

    /// The sides on each edge, in order.
    pub(crate) fn edges(&self) -> impl Iterator<Item = &[EdgeSide]> {
        self.sides.chunk_by(|a, b| a.edge == b.edge)
    }
}
