//! Inserts a piece into the tiles that it crosses.
//!
//! The piece is followed from one vertex to the next on it, from tile to tile. The triangles that it crosses, a *strip*, are all
//! that changes (Wu, Lemma 3.3.6); they are triangulated anew by themselves as in core, and each tile with a vertex of theirs
//! takes the old ones out and the new ones in.

use foldhash::HashMap;

use super::EditError;
use super::patch::Patch;
use super::tile::Incoming;
use super::tiles::Tiles;
use crate::build::constrain::glued;
use crate::geometry::{Orientation, Point, orient2d};
use crate::mesh::{Constrained, Inserter, Step, WALLS, next_side, prev_side};
use crate::store::{Across, EdgeSource, Vertex, VertexId};

/// A part of a line between two vertices of the file, to become constraint edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) ends: [Vertex; 2],
    pub(super) source: EdgeSource,
}

/// Where a line has come from a vertex.
enum Reached {
    /// Along an edge, of these triangles, to the next vertex.
    Along(Vertex, Vec<[VertexId; 3]>),
    /// Through the triangles of the strip, to this vertex.
    Through(Vertex),
}

/// Inserts pieces. Keeps its memory from one to the next.
#[derive(Default)]
pub(super) struct Inserting {
    inserter: Inserter,
    /// The triangles that a piece crosses, in order.
    strip: Patch,
    /// How often lines of this edit run along edges as the rings of obstacles, which count each time.
    times: HashMap<(EdgeKey, EdgeSource), usize>,
    /// Edges that became constraints.
    pub(super) edges: u64,
}

type EdgeKey = [VertexId; 2];

impl Inserting {
    /// Makes a piece a chain of constraint edges.
    pub(super) fn insert(&mut self, tiles: &mut Tiles, piece: Piece) -> Result<(), EditError> {
        let [mut at, to] = piece.ends;
        while at.id != to.id {
            let next = match self.follow(tiles, at, to.point, piece)? {
                Reached::Along(next, triangles) => {
                    mark(tiles, &triangles, piece.source.is_wall())?;
                    next
                }
                Reached::Through(next) => {
                    self.replace(tiles, [at, next], piece.source.is_wall())?;
                    next
                }
            };
            self.note(tiles, [at, next], piece.source)?;
            at = next;
        }
        Ok(())
    }

    /// Follows a line from a vertex to the next one on it, and collects what it crosses.
    fn follow(&mut self, tiles: &mut Tiles, from: Vertex, to: Point, piece: Piece) -> Result<Reached, EditError> {
        let line = [from.point, to];
        let tile = tiles.get(from.id.tile)?;
        let mut start = None;
        for side in tile.around(from.id.index) {
            let [right, left] = [next_side(side), prev_side(side)].map(|side| tile.from(side));
            let is_ahead = |p: Point| p.lex_cmp(from.point) == to.lex_cmp(from.point);
            let turns = [right, left].map(|vertex| orient2d(from.point, vertex.point, to));
            start = match turns {
                [Orientation::Collinear, _] if is_ahead(right.point) => Some((side, Some((side, right)))),
                [_, Orientation::Collinear] if is_ahead(left.point) => Some((side, Some((prev_side(side), left)))),
                [Orientation::CounterClockwise, Orientation::Clockwise] => Some((side, None)),
                _ => None,
            };
            if start.is_some() {
                break;
            }
        }
        let Some((side, along)) = start else {
            return Err(tiles.damaged(from.id.tile, "no triangle around a vertex is on the way of a line"));
        };
        if let Some((edge, next)) = along {
            let sides = match tile.across(edge) {
                Across::Side(other) => vec![edge, other],
                Across::Hull | Across::Elsewhere => vec![edge],
            };
            let corners = |side: u32| tile.triangle(side).0.map(|vertex| vertex.id);
            return Ok(Reached::Along(next, sides.into_iter().map(corners).collect()));
        }
        self.strip.clear();
        self.strip.push(tile.triangle(side));
        let mut tile = tile;
        let mut gate = next_side(side);
        loop {
            if tile.is_constraint(gate) {
                let ends = [gate, next_side(gate)].map(|side| tile.from(side));
                return Err(crossed(tiles, line, ends, piece));
            }
            let id = tile.id;
            let Some((there, entered)) = tiles.over(tile, gate)? else {
                return Err(tiles.damaged(id, "a line between two vertices leaves the triangulation"));
            };
            tile = there;
            self.strip.push(tile.triangle(entered));
            let apex = tile.from(prev_side(entered));
            gate = match orient2d(line[0], line[1], apex.point) {
                Orientation::CounterClockwise => next_side(entered),
                Orientation::Clockwise => prev_side(entered),
                Orientation::Collinear => return Ok(Reached::Through(apex)),
            };
        }
    }

    /// Triangulates the strip anew on both sides of a piece between two of its vertices, in all tiles that have some of it.
    fn replace(&mut self, tiles: &mut Tiles, ends: [Vertex; 2], is_wall: bool) -> Result<(), EditError> {
        let Self { inserter, strip, .. } = self;
        let points: Vec<Point> = strip.vertices.iter().map(|vertex| vertex.point).collect();
        let mesh = glued(strip.triangles.clone(), points.len());
        let mut mesh = Constrained::with_constraints(mesh, strip.bits.clone(), points.len());
        let ends = ends.map(|end| strip.places[&end.id]);
        match inserter.step_between(&points, &mesh, ends) {
            Ok((_, Step::Triangles(_))) => inserter.replace(&points, &mut mesh, is_wall),
            _ => return Err(EditError::Internal("a line does not cross what it crossed".to_owned())),
        }
        let vertex = |place: u32| strip.vertices[place as usize];
        let new: Vec<Incoming> = (0u32..)
            .zip(&mesh.mesh().triangles)
            .map(|(t, corners)| (corners.map(vertex), mesh.side_bits(t)))
            .collect();
        strip.exchange(tiles, &new, &[])
    }

    /// Notes the source of an edge in the tile that it belongs to.
    fn note(&mut self, tiles: &mut Tiles, ends: [Vertex; 2], source: EdgeSource) -> Result<(), EditError> {
        self.edges += 1;
        let [a, b] = ends;
        let (ends, source) = match a.point.lex_cmp(b.point).is_lt() {
            true => ([a.id, b.id], source),
            false => ([b.id, a.id], source.reversed()),
        };
        let times = match source.depth_change() {
            0 => 1,
            _ => {
                let times = self.times.entry((ends, source)).or_default();
                *times += 1;
                *times
            }
        };
        let noted = tiles.change(ends[0].tile)?.add_source(ends, source, times);
        noted.ok_or_else(|| tiles.damaged(ends[0].tile, "an edge is missing that was just put there"))
    }
}

/// Makes the first sides of these triangles constraints, in all tiles that have them.
fn mark(tiles: &mut Tiles, triangles: &[[VertexId; 3]], is_wall: bool) -> Result<(), EditError> {
    let bits = 1 | u8::from(is_wall) << WALLS;
    for corners in triangles {
        let mut of_tiles = corners.map(|id| id.tile);
        of_tiles.sort_unstable();
        for id in of_tiles
            .into_iter()
            .enumerate()
            .filter(|&(i, id)| i == 0 || of_tiles[i - 1] != id)
        {
            if !tiles.change(id.1)?.fix(*corners, bits) {
                return Err(tiles.damaged(id.1, "a triangle is missing that another tile has"));
            }
        }
    }
    Ok(())
}

/// The error for a line that crosses a constraint.
fn crossed(tiles: &Tiles, line: [Point; 2], edge: [Vertex; 2], piece: Piece) -> EditError {
    // The tile that the edge belongs to knows its lines.
    let edge = match edge[0].point.lex_cmp(edge[1].point).is_lt() {
        true => edge,
        false => [edge[1], edge[0]],
    };
    let by = tiles.get(edge[0].id.tile).ok().and_then(|tile| {
        let side = tile.side_between(edge[0].id, edge[1].id);
        let side = side.or_else(|| tile.side_between(edge[1].id, edge[0].id))?;
        tile.sources_of(side).first().copied()
    });
    EditError::Crossed {
        line: piece.source,
        other: by,
        piece: line,
        edge: edge.map(|vertex| vertex.point),
    }
}
