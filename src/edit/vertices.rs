//! Insertion of new vertices into the triangulation.
//!
//! The triangles whose circumdisc contains a vertex, and from which no constraint hides it, are
//! removed: its *cavity*. The edges around the cavity and the vertex form the triangles that
//! replace them (Bowyer, Watson, both in The Computer Journal 24, 1981). With constraints too, the
//! result is the triangulation of all vertices and constraints, whatever the order. A vertex on a
//! constraint splits it.
//!
//! A vertex outside the hull sees some of its edges. They are edges around the cavity, too, unless
//! their triangles are removed, which the vertex reaches through them:
//!
//! ```text
//!       d ────── c             d ────── c
//!       │      ╱ │             │      ╱ │╲
//!       │    ╱   │      →      │    ╱   │  p     p sees bc alone. If p were in the
//!       │  ╱     │             │  ╱     │╱       circle of a, b and c, the new triangles
//!       a ────── b             a ────── b        were abp and acp.
//! ```

use foldhash::{HashMap, HashSet};

use crate::edit::contradiction::Contradiction;
use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::hull::{HullEdge, visible_from};
use crate::edit::patch::{NewTriangle, OldTriangle, Patch, PatchTwin};
use crate::edit::tile::NewVertex;
use crate::edit::tiles::{Pin, Tiles};
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::{HalfEdge, MortonSquare, Orientation, Point, Rect, TriangleId, VertexIndex, in_circle, orient2d};
use crate::mesh::{Embedded, EndlessWalk, Topology, Twin, WALLS};
use crate::store::{LinePart, TileId, VertexId};

/// Adds vertices to a tile. None of them exists yet. Returns the number of constraint edges that they
/// split.
pub(crate) fn add(tiles: &mut Tiles, id: TileId, mut new: Vec<NewVertex>) -> Result<u64, EditError> {
    let has_z = tiles.metadata().has_z;
    // In the order of a curve, so that the walk from each to the next is short.
    let square = MortonSquare::around(Rect::around(new.iter().map(|vertex| vertex.point)));
    new.sort_by_key(|vertex| square.key(vertex.point));
    let mut from = near(tiles, id, new[0].point)?;
    let first = tiles.change(id)?.add_vertices(&new, has_z);
    tiles.count_new_vertices(new.len());
    let mut inserter = VertexInserter::default();
    for (&NewVertex { point, z, .. }, index) in new.iter().zip((first..).map(VertexIndex)) {
        let vertex = EditVertex {
            id: VertexId { tile: id, index },
            point,
            // As the tile's own z: without z in the file, that of an end is left out.
            z: if has_z { z } else { 0.0 },
        };
        let place = locate(tiles, from, point)?;
        inserter.add(tiles, vertex, place)?;
        from = vertex.id;
    }
    Ok(inserter.split)
}

/// Returns a vertex near a point: the nearest of some of a tile, or, if this one has none yet, of the
/// tile that it was cut from.
fn near(tiles: &Tiles, id: TileId, point: Point) -> Result<VertexId, EditError> {
    let mut tile = tiles.get(id)?;
    while let (true, Some(former)) = (tile.points().is_empty(), tiles.former(tile.id)) {
        tile = tiles.get(former)?;
    }
    let distance = |p: &Point| (p.x - point.x).abs() + (p.y - point.y).abs();
    // The walk from there is about as long as the search.
    let step = (tile.points().len() / 512).max(1);
    let some = tile.points().iter().zip((0..).map(VertexIndex)).step_by(step);
    let nearest = some.min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b)));
    match nearest {
        Some((_, index)) => Ok(VertexId { tile: tile.id, index }),
        None => Err(tiles.damaged(id, Contradiction::NoVertices)),
    }
}

/// The place of a point, with a tile that has the half-edge.
enum Place {
    /// In the closed triangle of this half-edge.
    Inside(Pin, HalfEdge),
    /// Outside the hull, beyond this half-edge.
    Outside(Pin, HalfEdge),
}

/// Finds the place of a point.
///
/// This is not a [`Walk`](crate::mesh::Walk): the order of the triangles in the file depends on the
/// half-edge through which the walk enters the last triangle, which a `Walk` does not return.
fn locate(tiles: &Tiles, from: VertexId, to: Point) -> Result<Place, EditError> {
    let mut tile = tiles.get(from.tile)?;
    let Some(mut half_edge) = tile.leaving(from.index) else {
        return Err(tiles.damaged(from.tile, Contradiction::LoneVertex(from.index)));
    };
    // With constraints, a walk may cycle if it always examines the half-edges in the same order.
    let mut steps = tiles.most_triangles().saturating_mul(4).saturating_add(1000);
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
            return Ok(Place::Inside(tile, half_edge));
        };
        if tile.twin(exit) == Twin::Hull {
            return Ok(Place::Outside(tile, exit));
        }
        let ends = [exit, exit.next()].map(|half_edge| tile.origin_vertex(half_edge).id);
        match tiles.twin(tile, exit)? {
            Some(there) => (tile, half_edge) = there,
            None => {
                // The edge is on the hull, which the tile of an end knows.
                tile = tiles.get(ends[0].tile)?;
                return match tile.half_edge_between(ends[0], ends[1]) {
                    Some(exit) => Ok(Place::Outside(tile, exit)),
                    None => Err(tiles.damaged(ends[0].tile, Contradiction::MissingTriangle)),
                };
            }
        }
    }
}

/// An inserter of vertices, which reuses its buffers.
#[derive(Default)]
struct VertexInserter {
    /// Number of constraint edges that were split.
    split: u64,
    cavity: Patch,
    seen: HashSet<[VertexId; 3]>,
    /// Edges around the cavity, which is on their left.
    boundary: Vec<CavityEdge>,
    /// The ends of the hull edge on which the vertex lies, or of the part of the hull that it sees,
    /// if any: the edges around the cavity lead from the second to the first.
    on_hull: Option<[u32; 2]>,
}

/// An edge around a cavity: its ends, by numbers of the patch, the bits of a half-edge, and the twin
/// of the new half-edge on it.
#[derive(Clone, Copy)]
struct CavityEdge {
    ends: [u32; 2],
    bits: u8,
    twin: PatchTwin,
}

/// An edge on which a vertex lies: its ends, and the bits of a half-edge.
type SplitEdge = ([EditVertex; 2], u8);

impl VertexInserter {
    /// Inserts a vertex at its place.
    fn add(&mut self, tiles: &mut Tiles, vertex: EditVertex, place: Place) -> Result<(), EditError> {
        self.cavity.clear();
        self.seen.clear();
        self.boundary.clear();
        self.on_hull = None;
        let split = match place {
            Place::Inside(tile, half_edge) => {
                let start = tile.triangle(half_edge).0.map(|corner| corner.id);
                drop(tile);
                self.seen.insert(turned(start));
                self.find_cavity(tiles, vertex.point, vec![start])?
            }
            Place::Outside(tile, half_edge) => {
                self.find_cavity_outside(tiles, vertex.point, (tile, half_edge))?;
                None
            }
        };
        let on_constraint = split.filter(|(_, bits)| bits & 1 == 1);
        if !self.fill(vertex, on_constraint) {
            return Err(tiles.damaged(vertex.id.tile, Contradiction::UnfitCavity));
        }
        // A tile that is evicted between has no sources of edges that it does not have.
        let split = match on_constraint {
            Some((ends, _)) => Some((ends, sources_of(tiles, ends)?)),
            None => None,
        };
        exchange(&mut self.cavity, tiles)?;
        if let Some((ends, sources)) = split {
            self.split += 1;
            give_to_parts(tiles, ends, vertex, &sources)?;
        }
        Ok(())
    }

    /// Joins a vertex to the edges around its cavity. Returns false if they do not fit together.
    fn fill(&mut self, vertex: EditVertex, on_constraint: Option<SplitEdge>) -> bool {
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
        for &CavityEdge { ends, bits, twin } in &*boundary {
            let [from, to] = ends;
            let [from_point, to_point] = ends.map(|end| cavity.vertices[end as usize].point);
            let [before, after] = [arriving.get(&from), leaving.get(&to)];
            let is_sound = orient2d(from_point, to_point, vertex.point) == Orientation::CounterClockwise
                && leaving.len() == boundary.len()
                && (before.is_some() || on_hull.is_some_and(|[_, end]| end == from))
                && (after.is_some() || on_hull.is_some_and(|[end, _]| end == to));
            if !is_sound {
                return false;
            }
            let bits_to = |end: u32, corner: u8| match on_constraint {
                Some((ends, bits)) if ends.iter().any(|split| split.id == cavity.vertices[end as usize].id) => {
                    bits << corner
                }
                _ => 0,
            };
            let twin_in = |next: Option<&TriangleId>, corner: u32| {
                next.map_or(PatchTwin::Hull, |&next| PatchTwin::New(HalfEdge::new(next, corner)))
            };
            cavity.new.push(NewTriangle {
                corners: [from, to, middle],
                bits: bits | bits_to(to, 1) | bits_to(from, 2),
                twins: [twin, twin_in(after, 2), twin_in(before, 1)],
            });
        }
        true
    }

    /// Finds the cavity of a point outside the hull, given a half-edge on the hull that the point
    /// sees.
    fn find_cavity_outside(&mut self, tiles: &Tiles, point: Point, seen: (Pin, HalfEdge)) -> Result<(), EditError> {
        let visible = visible_from(tiles, point, seen)?;
        let mut open = Vec::new();
        for HullEdge { corners, bits } in &visible {
            let [a, b, c] = corners.map(|corner| corner.point);
            let ids = corners.map(|corner| corner.id);
            if bits & 1 == 0 && in_circle(a, b, c, point) && self.seen.insert(turned(ids)) {
                open.push(ids);
            }
        }
        self.find_cavity(tiles, point, open)?;
        let ends = visible
            .iter()
            .map(|edge| [edge.corners[0], edge.corners[1]].map(|end| self.cavity.number(end).0));
        let ends: Vec<[u32; 2]> = ends.collect();
        for (&[from, to], HullEdge { corners, bits }) in ends.iter().zip(&visible) {
            if bits & 1 == 0 && self.seen.contains(&turned(corners.map(|corner| corner.id))) {
                continue;
            }
            self.boundary.push(CavityEdge {
                ends: [to, from],
                bits: bits & (1 | 1 << WALLS),
                twin: PatchTwin::Stays,
            });
        }
        self.on_hull = ends.first().zip(ends.last()).map(|(first, last)| [first[0], last[1]]);
        Ok(())
    }

    /// Finds the cavity of a point, given triangles of it, in `open` and among those seen. Returns
    /// the edge on which the point lies, if any.
    fn find_cavity(
        &mut self,
        tiles: &Tiles,
        point: Point,
        mut open: Vec<[VertexId; 3]>,
    ) -> Result<Option<SplitEdge>, EditError> {
        let mut split: Option<SplitEdge> = None;
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
                    twin: PatchTwin::Old(HalfEdge::new(old, s as u32)),
                };
                let side = orient2d(ends[0].point, ends[1].point, point);
                let is_split = side == Orientation::Collinear;
                if is_split {
                    split = Some((ends, bits));
                } else if bits & 1 == 1 {
                    self.boundary.push(boundary);
                    continue;
                }
                let tile = tiles.get(ids[0].tile)?;
                let Some((there, other)) = tiles.twin(tile, half_edge)? else {
                    match side {
                        Orientation::Collinear => self.on_hull = Some(boundary.ends),
                        Orientation::CounterClockwise => self.boundary.push(boundary),
                        // The point sees the edge from outside the hull.
                        Orientation::Clockwise => {}
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

/// Takes the sources from an edge that is to be split, as seen from its first end.
fn sources_of(tiles: &mut Tiles, ends: [EditVertex; 2]) -> Result<Vec<LinePart>, EditError> {
    let tile = owner(ends);
    let sources = tiles.change(tile)?.take_sources(ends.map(|end| end.id));
    sources.ok_or_else(|| tiles.damaged(tile, Contradiction::NoSource))
}

/// Gives both parts of a split edge its sources. Their segments pass the new vertex.
fn give_to_parts(
    tiles: &mut Tiles,
    [a, b]: [EditVertex; 2],
    vertex: EditVertex,
    sources: &[LinePart],
) -> Result<(), EditError> {
    for (part, [has_start, has_end]) in [([a, vertex], [true, false]), ([vertex, b], [false, true])] {
        let tile = owner(part);
        let sources: Vec<LinePart> = sources.iter().map(|source| source.cut(has_start, has_end)).collect();
        let put = tiles.change(tile)?.give_sources(part.map(|end| end.id), &sources);
        put.ok_or_else(|| tiles.damaged(tile, Contradiction::NoSource))?;
    }
    Ok(())
}
