//! Insertion of a segment into the tiles that it crosses.
//!
//! The segment is followed from one vertex on it to the next, from tile to tile. Only the triangles
//! that it crosses, a *strip*, change (Wu, Lemma 3.3.6). They are triangulated anew by themselves,
//! as in core. Each tile with a vertex of the strip removes the old triangles and adds the new
//! ones.

use foldhash::HashMap;

use crate::edit::chain::{Chain, constraint_bits};
use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::leaving::{Leaving, is_shorter_from_end, leave};
use crate::edit::marks::mark;
use crate::edit::patch::{OldTriangle, Patch, PatchTwin};
use crate::edit::tile::EditTile;
use crate::edit::tiles::{Pin, Tiles};
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use crate::mesh::{Cavity, Topology};
use crate::store::{EdgeSource, LinePart, VertexId};

/// A segment between two vertices of the file, to become constraint edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocatedSegment {
    pub(crate) ends: [EditVertex; 2],
    pub(crate) source: LinePart,
}

impl LocatedSegment {
    /// Returns the part of the segment from one vertex on it to another, in its direction.
    fn part(&self, ends: [EditVertex; 2]) -> LinePart {
        let id = |vertex: EditVertex| vertex.id;
        self.source.between(ends.map(id), self.ends.map(id))
    }
}

/// The way from a vertex to the next vertex on a line.
enum Reached {
    /// Along an edge, of these triangles, to this vertex.
    Along(EditVertex, Vec<[VertexId; 3]>),
    /// Through the triangles of the strip, to this vertex.
    Through(EditVertex),
}

/// An inserter of segments, which reuses its buffers.
#[derive(Default)]
pub(crate) struct SegmentInserter {
    cavity: Cavity,
    /// The triangles that a segment crosses, in order.
    strip: Patch,
    /// The boundary of the strip on both sides of the segment.
    left: Chain,
    right: Chain,
    /// Whether the boundary may pass an edge twice, because it passes a vertex twice.
    is_passed_twice: bool,
    /// How often lines of this edit run along an edge as rings of obstacles. Each time counts.
    times: HashMap<(EdgeKey, EdgeSource), usize>,
    /// Number of edges that became constraints.
    pub(crate) edges: u64,
    /// Number of triangles that were examined to follow the segments.
    pub(crate) examined: u64,
}

type EdgeKey = [VertexId; 2];

impl SegmentInserter {
    /// Makes a segment a chain of constraint edges.
    pub(crate) fn insert(&mut self, tiles: &mut Tiles, segment: LocatedSegment) -> Result<(), EditError> {
        let [mut at, mut to] = segment.ends;
        while at.id != to.id {
            let is_back = is_shorter_from_end(tiles, [at, to])?;
            let [start, end] = if is_back { [to, at] } else { [at, to] };
            let next = match self.follow(tiles, start, end.point, segment)? {
                Reached::Along(next, triangles) => {
                    let bits = constraint_bits(segment.source.is_wall());
                    mark(tiles, &triangles, |set| set | bits)?;
                    next
                }
                Reached::Through(next) => {
                    self.replace(tiles, segment.source.is_wall())?;
                    next
                }
            };
            let part = if is_back { [next, to] } else { [at, next] };
            self.note(tiles, part, segment.part(part))?;
            *(if is_back { &mut to } else { &mut at }) = next;
        }
        Ok(())
    }

    /// Follows a line from a vertex to the next one on it, and collects the triangles that it
    /// crosses.
    fn follow(
        &mut self,
        tiles: &mut Tiles,
        from: EditVertex,
        to: Point,
        segment: LocatedSegment,
    ) -> Result<Reached, EditError> {
        let tile = tiles.get(from.id.tile)?;
        match leave(&tile, from, to, &mut self.examined) {
            Some(Leaving::Along(edge, next)) => {
                let half_edges = [Some(edge), tile.twin(edge).half_edge()].into_iter().flatten();
                let corners = |half_edge| tile.triangle(half_edge).0.map(|vertex| vertex.id);
                Ok(Reached::Along(next, half_edges.map(corners).collect()))
            }
            Some(Leaving::Into(half_edge)) => self.cross(tiles, tile, half_edge, [from.point, to], segment),
            None => Err(tiles.damaged(from.id.tile, Contradiction::NoWay)),
        }
    }

    /// Follows a line through the triangle of a half-edge that starts where the line starts, up to
    /// the next vertex on the line.
    fn cross(
        &mut self,
        tiles: &Tiles,
        mut tile: Pin,
        half_edge: HalfEdge,
        line: [Point; 2],
        segment: LocatedSegment,
    ) -> Result<Reached, EditError> {
        // The half-edge through which the line leaves a triangle, and the numbers of its ends, the
        // right one first.
        let (mut gate, mut ends) = (half_edge.next(), self.begin(&tile, half_edge));
        loop {
            if tile.is_constraint(gate) {
                let ends = [gate, gate.next()].map(|half_edge| tile.origin_vertex(half_edge));
                return Err(crossed(tiles, line, ends, segment));
            }
            let id = tile.id;
            let Some((there, entered)) = tiles.twin(tile, gate)? else {
                return Err(tiles.damaged(id, Contradiction::LineLeaves));
            };
            tile = there;
            self.examined += 1;
            let triangle = self.strip.old.len() as u32;
            if u64::from(triangle) > tiles.most_triangles() {
                return Err(tiles.damaged(id, Contradiction::EndlessLine));
            }
            let apex = tile.origin_vertex(entered.prev());
            let number = self.push(&tile, entered, ends, apex);
            let [_, right, left] = HalfEdge::of_triangle(TriangleId(triangle));
            match orient2d(line[0], line[1], apex.point) {
                Orientation::CounterClockwise => {
                    self.left.push(number, left);
                    (gate, ends[1]) = (entered.next(), number);
                }
                Orientation::Clockwise => {
                    self.right.push(number, right);
                    (gate, ends[0]) = (entered.prev(), number);
                }
                Orientation::Collinear => {
                    self.left.push(number, left);
                    self.right.push(number, right);
                    return Ok(Reached::Through(apex));
                }
            }
        }
    }

    /// Begins a strip with the triangle of a half-edge that starts where the segment starts.
    /// Returns the numbers of the other two corners.
    fn begin(&mut self, tile: &EditTile, half_edge: HalfEdge) -> [u32; 2] {
        self.strip.clear();
        self.is_passed_twice = false;
        let (corners, bits) = tile.triangle(half_edge);
        let [from, right, left] = corners.map(|corner| self.strip.number(corner).0);
        self.strip
            .old
            .push(OldTriangle::new([from, right, left], bits, (tile.id, half_edge)));
        let [on_right, _, on_left] = HalfEdge::of_triangle(TriangleId(0));
        for (chain, vertex, half_edge) in [(&mut self.right, right, on_right), (&mut self.left, left, on_left)] {
            chain.clear();
            chain.vertices.push(from);
            chain.push(vertex, half_edge);
        }
        [right, left]
    }

    /// Adds the triangle that the segment enters through a half-edge, given the numbers of its
    /// ends. Returns the number of the apex.
    fn push(&mut self, tile: &EditTile, entered: HalfEdge, [right, left]: [u32; 2], apex: EditVertex) -> u32 {
        let (apex, is_new) = self.strip.number(apex);
        self.is_passed_twice |= !is_new;
        let bits = tile.bits_from(entered);
        self.strip
            .old
            .push(OldTriangle::new([left, right, apex], bits, (tile.id, entered)));
        apex
    }

    /// Triangulates the strip anew on both sides of a segment between two of its vertices, in all
    /// tiles that have some of its triangles.
    fn replace(&mut self, tiles: &mut Tiles, is_wall: bool) -> Result<(), EditError> {
        let Self {
            cavity,
            strip,
            left,
            right,
            ..
        } = self;
        // Both chains have their polygon on the left of the line between their ends.
        right.vertices.reverse();
        right.half_edges.reverse();
        let mut on_segment = [HalfEdge(0); 2];
        for (chain, on_segment) in [left, right].into_iter().zip(&mut on_segment) {
            let points = chain
                .vertices
                .iter()
                .map(|&vertex| strip.vertices[vertex as usize].point);
            if !cavity.triangulate(points) {
                return Err(EditError::Internal("a line does not cross what it crossed".to_owned()));
            }
            *on_segment = chain.fill(strip, cavity, self.is_passed_twice);
        }
        for [half_edge, twin] in [on_segment, [on_segment[1], on_segment[0]]] {
            strip.new[half_edge.triangle().index()].set(half_edge, PatchTwin::New(twin), constraint_bits(is_wall));
        }
        exchange(strip, tiles)
    }

    /// Adds the source of an edge in the tile that the edge belongs to.
    fn note(&mut self, tiles: &mut Tiles, ends: [EditVertex; 2], part: LinePart) -> Result<(), EditError> {
        self.edges += 1;
        let [a, b] = ends;
        let (ends, part) = match a.point.lex_cmp(b.point).is_lt() {
            true => ([a.id, b.id], part),
            false => ([b.id, a.id], part.reversed()),
        };
        let times = match part.depth_change() {
            0 => 1,
            _ => {
                let times = self.times.entry((ends, part.source())).or_default();
                *times += 1;
                *times
            }
        };
        let noted = tiles.change(ends[0].tile)?.add_source(ends, part, times);
        noted.ok_or_else(|| tiles.damaged(ends[0].tile, Contradiction::MissingEdge))
    }
}

/// Returns the error for a line that crosses a constraint.
fn crossed(tiles: &Tiles, line: [Point; 2], edge: [EditVertex; 2], segment: LocatedSegment) -> EditError {
    // The tile that the edge belongs to knows its lines.
    let edge = match edge[0].point.lex_cmp(edge[1].point).is_lt() {
        true => edge,
        false => [edge[1], edge[0]],
    };
    let by = tiles.get(edge[0].id.tile).ok().and_then(|tile| {
        let half_edge = tile.half_edge_between(edge[0].id, edge[1].id);
        let half_edge = half_edge.or_else(|| tile.half_edge_between(edge[1].id, edge[0].id))?;
        tile.sources_of(half_edge).first().map(|part| part.source())
    });
    EditError::Crossed {
        line: segment.source.source(),
        other: by,
        subsegment: line,
        edge: edge.map(|vertex| vertex.point),
    }
}
