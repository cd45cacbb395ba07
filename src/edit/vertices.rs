//! Insertion of new vertices into the triangulation, at the ends of lines where the file has no
//! vertex yet.
//!
//! The triangles whose circumdisc contains a vertex, and from which no constraint hides it, are
//! removed: its *cavity*. The edges around the cavity and the vertex form the triangles that
//! replace them (Bowyer, Watson, both in The Computer Journal 24, 1981). With constraints too, the
//! result is the triangulation of all vertices and constraints, whatever the order. A vertex on a
//! constraint splits it.

use foldhash::{HashMap, HashSet};

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::patch::{NewTriangle, OldTriangle, Patch, PatchTwin};
use crate::edit::tile::NewVertex;
use crate::edit::tiles::{Pin, Tiles};
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, MortonSquare, Orientation, Point, Rect, TriangleId, VertexIndex, in_circle, orient2d};
use crate::mesh::{Embedded, EndlessWalk, Topology, WALLS};
use crate::store::{LinePart, MAX_TILE_VERTICES, TileId, VertexId};

/// Adds vertices to a tile. None of them exists yet.
pub(crate) fn add(tiles: &mut Tiles, id: TileId, mut new: Vec<NewVertex>) -> Result<(), EditError> {
    let has_z = tiles.metadata().has_z;
    // In the order of a curve, so that the walk from each to the next is short.
    let square = MortonSquare::around(Rect::around(new.iter().map(|vertex| vertex.point)));
    new.sort_by_key(|vertex| square.key(vertex.point));
    let tile = tiles.get(id)?;
    let near = tile
        .points()
        .iter()
        .zip((0..).map(VertexIndex))
        .min_by(|(a, _), (b, _)| {
            let to = |p: &Point| (p.x - new[0].point.x).abs() + (p.y - new[0].point.y).abs();
            to(a).total_cmp(&to(b))
        });
    let near = near.map(|(_, index)| index);
    let (vertices, most) = (tile.points().len() + new.len(), MAX_TILE_VERTICES);
    drop(tile);
    if vertices > most {
        let [vertices, most] = [vertices, most].map(|count| count as u64);
        return Err(EditError::TooMany { vertices, most });
    }
    let first = tiles.change(id)?.add_vertices(&new, has_z);
    let Some(mut from) = near else {
        return Err(tiles.damaged(id, Contradiction::NoVertices));
    };
    let mut inserter = VertexInserter::default();
    for (&NewVertex { point, z, line, .. }, index) in new.iter().zip((first..).map(VertexIndex)) {
        let vertex = EditVertex {
            id: VertexId { tile: id, index },
            point,
            // As the tile's own z: without z in the file, that of an end is left out.
            z: if has_z { z } else { 0.0 },
        };
        let Some(start) = locate(tiles, VertexId { tile: id, index: from }, point)? else {
            return Err(EditError::Outside { line, point });
        };
        inserter.add(tiles, vertex, start)?;
        from = index;
    }
    Ok(())
}

/// Finds the closed triangle that contains a point. Returns one of its half-edges, with a tile that
/// has it, or `None` if the point is outside the hull.
///
/// This is not a [`Walk`](crate::mesh::Walk): the order of the triangles in the file depends on the
/// half-edge through which the walk enters the last triangle, which a `Walk` does not return.
fn locate(tiles: &Tiles, from: VertexId, to: Point) -> Result<Option<(Pin, HalfEdge)>, EditError> {
    let mut tile = tiles.get(from.tile)?;
    let Some(mut half_edge) = tile.leaving(from.index) else {
        return Err(tiles.damaged(from.tile, Contradiction::LoneVertex(from.index)));
    };
    // With constraints, a walk may cycle if it always examines the half-edges in the same order.
    let mut steps = 4 * tiles.metadata().triangles + 1000;
    loop {
        steps = match steps.checked_sub(1) {
            Some(steps) => steps,
            None => return Err(tiles.damaged(tile.id, EndlessWalk.into())),
        };
        let half_edges = match steps.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62 {
            0 => [half_edge, half_edge.next(), half_edge.prev()],
            1 => [half_edge.next(), half_edge.prev(), half_edge],
            _ => [half_edge.prev(), half_edge, half_edge.next()],
        };
        let is_beyond = |&half_edge: &HalfEdge| {
            let [start, end] = [tile.origin(half_edge), tile.destination(half_edge)].map(|corner| tile.point(corner));
            orient2d(start, end, to) == Orientation::Clockwise
        };
        let Some(exit) = half_edges.into_iter().find(is_beyond) else {
            return Ok(Some((tile, half_edge)));
        };
        match tiles.twin(tile, exit)? {
            Some(there) => (tile, half_edge) = there,
            None => return Ok(None),
        }
    }
}

/// An inserter of vertices, which reuses its buffers.
#[derive(Default)]
struct VertexInserter {
    cavity: Patch,
    seen: HashSet<[VertexId; 3]>,
    /// Edges around the cavity, which is on their left.
    boundary: Vec<CavityEdge>,
    /// The ends of the hull edge on which the vertex lies, if any.
    on_hull: Option<[u32; 2]>,
}

/// An edge around a cavity, by numbers of the patch: its ends, the bits of a half-edge, and the old
/// half-edge.
#[derive(Clone, Copy)]
struct CavityEdge {
    ends: [u32; 2],
    bits: u8,
    half_edge: HalfEdge,
}

/// An edge on which a vertex lies: its ends, and the bits of a half-edge.
type SplitEdge = ([EditVertex; 2], u8);

impl VertexInserter {
    /// Inserts a vertex into the closed triangle of a half-edge.
    fn add(&mut self, tiles: &mut Tiles, vertex: EditVertex, start: (Pin, HalfEdge)) -> Result<(), EditError> {
        let split = self.find_cavity(tiles, vertex.point, start)?;
        let on_constraint = split.filter(|(_, bits)| bits & 1 == 1);
        let Self {
            cavity,
            boundary,
            on_hull,
            ..
        } = self;
        let (middle, _) = cavity.number(vertex);
        // The triangles by the start and by the end of their edge around the cavity.
        let leaving = triangles_by_end(boundary, 0);
        let arriving = triangles_by_end(boundary, 1);
        for &CavityEdge { ends, bits, half_edge } in &*boundary {
            let [from, to] = ends;
            let [from_point, to_point] = ends.map(|end| cavity.vertices[end as usize].point);
            let [before, after] = [arriving.get(&from), leaving.get(&to)];
            let is_sound = orient2d(from_point, to_point, vertex.point) == Orientation::CounterClockwise
                && leaving.len() == boundary.len()
                && (before.is_some() || on_hull.is_some_and(|[_, end]| end == from))
                && (after.is_some() || on_hull.is_some_and(|[end, _]| end == to));
            if !is_sound {
                return Err(tiles.damaged(vertex.id.tile, Contradiction::UnfitCavity));
            }
            let bits_to = |end: u32, corner: u8| match on_constraint {
                Some((ends, bits)) if ends.iter().any(|split| split.id == cavity.vertices[end as usize].id) => {
                    bits << corner
                }
                _ => 0,
            };
            let twin = |next: Option<&TriangleId>, corner: u32| {
                next.map_or(PatchTwin::Hull, |&next| PatchTwin::New(HalfEdge::new(next, corner)))
            };
            cavity.new.push(NewTriangle {
                corners: [from, to, middle],
                bits: bits | bits_to(to, 1) | bits_to(from, 2),
                twins: [PatchTwin::Old(half_edge), twin(after, 2), twin(before, 1)],
            });
        }
        exchange(cavity, tiles)?;
        if let Some((ends, _)) = on_constraint {
            split_sources(tiles, ends, vertex)?;
        }
        Ok(())
    }

    /// Finds the cavity of a point, given a half-edge of the closed triangle that contains the
    /// point. Returns the edge on which the point lies, if any.
    fn find_cavity(
        &mut self,
        tiles: &Tiles,
        point: Point,
        (tile, half_edge): (Pin, HalfEdge),
    ) -> Result<Option<SplitEdge>, EditError> {
        self.cavity.clear();
        self.seen.clear();
        self.boundary.clear();
        self.on_hull = None;
        let mut split: Option<SplitEdge> = None;
        let start = tile.triangle(half_edge).0.map(|corner| corner.id);
        self.seen.insert(turned(start));
        let mut open = vec![start];
        drop(tile);
        while let Some(ids) = open.pop() {
            let tile = tiles.get(ids[0].tile)?;
            let Some(first) = tile.half_edge_of(ids) else {
                return Err(tiles.damaged(ids[0].tile, Contradiction::MissingTriangle));
            };
            let (corners, bits) = tile.triangle(first);
            let numbers = corners.map(|corner| self.cavity.number(corner).0);
            let old = TriangleId(self.cavity.old.len() as u32);
            self.cavity.old.push(OldTriangle::new(numbers, bits, (tile.id, first)));
            for (s, half_edge) in [first, first.next(), first.prev()].into_iter().enumerate() {
                let ends = [corners[s], corners[(s + 1) % 3]];
                let bits = bits >> s & (1 | 1 << WALLS);
                let boundary = CavityEdge {
                    ends: [numbers[s], numbers[(s + 1) % 3]],
                    bits,
                    half_edge: HalfEdge::new(old, s as u32),
                };
                let is_split = orient2d(ends[0].point, ends[1].point, point) == Orientation::Collinear;
                if is_split {
                    split = Some((ends, bits));
                } else if bits & 1 == 1 {
                    self.boundary.push(boundary);
                    continue;
                }
                let tile = tiles.get(ids[0].tile)?;
                let Some((there, other)) = tiles.twin(tile, half_edge)? else {
                    match is_split {
                        true => self.on_hull = Some(boundary.ends),
                        false => self.boundary.push(boundary),
                    }
                    continue;
                };
                let corners = there.triangle(other).0;
                let ids = corners.map(|corner| corner.id);
                let [a, b, c] = corners.map(|corner| corner.point);
                if self.seen.contains(&turned(ids)) {
                    continue;
                }
                if is_split || in_circle(a, b, c, point) {
                    self.seen.insert(turned(ids));
                    open.push(ids);
                } else {
                    self.boundary.push(boundary);
                }
            }
        }
        Ok(split)
    }
}

/// Returns the new triangle at each edge around a cavity, by the start (0) or the end (1) of the
/// edge.
fn triangles_by_end(boundary: &[CavityEdge], end: usize) -> HashMap<u32, TriangleId> {
    let ends = boundary.iter().map(|edge| edge.ends[end]);
    ends.zip((0..).map(TriangleId)).collect()
}

/// Returns the corners of a triangle, rotated so that the smallest comes first.
fn turned(ids: [VertexId; 3]) -> [VertexId; 3] {
    let [a, b, c] = ids;
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or(ids)
}

/// Gives both parts of a split edge the sources of the edge. Their segments pass the new vertex.
fn split_sources(tiles: &mut Tiles, ends: [EditVertex; 2], vertex: EditVertex) -> Result<(), EditError> {
    let [a, b] = ends;
    let owner = |ends: [EditVertex; 2]| match ends[0].point.lex_cmp(ends[1].point).is_lt() {
        true => ends[0].id.tile,
        false => ends[1].id.tile,
    };
    let tile = owner(ends);
    let sources = tiles.change(tile)?.take_sources([a.id, b.id]);
    let sources = sources.ok_or_else(|| tiles.damaged(tile, Contradiction::NoSource))?;
    for (part, [has_start, has_end]) in [([a, vertex], [true, false]), ([vertex, b], [false, true])] {
        let tile = owner(part);
        let sources: Vec<LinePart> = sources.iter().map(|source| source.cut(has_start, has_end)).collect();
        let put = tiles.change(tile)?.give_sources(part.map(|end| end.id), &sources);
        put.ok_or_else(|| tiles.damaged(tile, Contradiction::NoSource))?;
    }
    Ok(())
}
