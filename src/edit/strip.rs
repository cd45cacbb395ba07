//! Inserts a piece into the tiles that it crosses.
//!
//! The piece is followed from one vertex to the next on it, from tile to tile. The triangles that it crosses, a *strip*, are all
//! that changes (Wu, Lemma 3.3.6); they are triangulated anew by themselves as in core, and each tile with a vertex of theirs
//! takes the old ones out and the new ones in.

use foldhash::{HashMap, HashMapExt};

use crate::edit::error::EditError;
use crate::edit::exchange::exchange;
use crate::edit::patch::{Beside, New, Old, Patch};
use crate::edit::tile::EditTile;
use crate::edit::tile::hubs::MOST_AROUND;
use crate::edit::tiles::Tiles;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};
use crate::mesh::{Cavity, NONE, Twin, WALLS, next_side, prev_side};
use crate::store::{EdgeSource, Vertex, VertexId};

/// A part of a line between two vertices of the file, to become constraint edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) ends: [Vertex; 2],
    pub(crate) source: EdgeSource,
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
pub(crate) struct Inserting {
    cavity: Cavity,
    /// The triangles that a piece crosses, in order.
    strip: Patch,
    /// Their boundary on both sides of the piece.
    left: Chain,
    right: Chain,
    /// Whether it may pass an edge twice: it passes a vertex twice.
    is_passed_twice: bool,
    /// How often lines of this edit run along edges as the rings of obstacles, which count each time.
    times: HashMap<(EdgeKey, EdgeSource), usize>,
    /// Edges that became constraints.
    pub(crate) edges: u64,
    /// Triangles that were looked at to follow the pieces.
    pub(crate) looked_at: u64,
}

type EdgeKey = [VertexId; 2];

/// The boundary of a strip on one side of a piece, by the patch's numbers.
#[derive(Default)]
struct Chain {
    vertices: Vec<u32>,
    /// Between each vertex and the next, the side of the old triangle there.
    sides: Vec<u32>,
}

impl Chain {
    fn push(&mut self, vertex: u32, side: u32) {
        self.vertices.push(vertex);
        self.sides.push(side);
    }
}

impl Inserting {
    /// Makes a piece a chain of constraint edges.
    pub(crate) fn insert(&mut self, tiles: &mut Tiles, piece: Piece) -> Result<(), EditError> {
        let [mut at, mut to] = piece.ends;
        while at.id != to.id {
            let is_back = is_shorter_from_end(tiles, [at, to])?;
            let [start, end] = if is_back { [to, at] } else { [at, to] };
            let next = match self.follow(tiles, start, end.point, piece)? {
                Reached::Along(next, triangles) => {
                    mark(tiles, &triangles, piece.source.is_wall())?;
                    next
                }
                Reached::Through(next) => {
                    self.replace(tiles, piece.source.is_wall())?;
                    next
                }
            };
            let part = if is_back { [next, to] } else { [at, next] };
            self.note(tiles, part, piece.source)?;
            *(if is_back { &mut to } else { &mut at }) = next;
        }
        Ok(())
    }

    /// Follows a line from a vertex to the next one on it, and collects what it crosses.
    fn follow(&mut self, tiles: &mut Tiles, from: Vertex, to: Point, piece: Piece) -> Result<Reached, EditError> {
        let line = [from.point, to];
        let tile = tiles.get(from.id.tile)?;
        let mut start = None;
        for side in tile.around(from.id.index) {
            self.looked_at += 1;
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
                Twin::HalfEdge(HalfEdge(other)) => vec![edge, other],
                Twin::Hull | Twin::Elsewhere => vec![edge],
            };
            let corners = |side: u32| tile.triangle(side).0.map(|vertex| vertex.id);
            return Ok(Reached::Along(next, sides.into_iter().map(corners).collect()));
        }
        // The side by which the line leaves a triangle, and the numbers of its ends, the right one first.
        let (mut gate, mut ends) = (next_side(side), self.begin(&tile, side));
        let mut tile = tile;
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
            self.looked_at += 1;
            // A triangle takes more than a byte of the file.
            if self.strip.old.len() as u64 > tiles.length() {
                return Err(tiles.damaged(id, "a line goes in circles"));
            }
            let apex = tile.from(prev_side(entered));
            let number = self.push(&tile, entered, ends, apex);
            let triangle = 3 * (self.strip.old.len() as u32 - 1);
            let (right, left) = (triangle + 1, triangle + 2);
            match orient2d(line[0], line[1], apex.point) {
                Orientation::CounterClockwise => {
                    self.left.push(number, left);
                    (gate, ends[1]) = (next_side(entered), number);
                }
                Orientation::Clockwise => {
                    self.right.push(number, right);
                    (gate, ends[0]) = (prev_side(entered), number);
                }
                Orientation::Collinear => {
                    self.left.push(number, left);
                    self.right.push(number, right);
                    return Ok(Reached::Through(apex));
                }
            }
        }
    }

    /// Begins a strip with the triangle of a side, which starts where the piece does. Returns the numbers of the other two corners.
    fn begin(&mut self, tile: &EditTile, side: u32) -> [u32; 2] {
        self.strip.clear();
        self.is_passed_twice = false;
        let (corners, bits) = tile.triangle(side);
        let [from, right, left] = corners.map(|corner| self.strip.number(corner).0);
        self.strip
            .old
            .push(Old::new([from, right, left], bits, (tile.id, side)));
        for (chain, vertex, side) in [(&mut self.right, right, 0), (&mut self.left, left, 2)] {
            chain.vertices.clear();
            chain.sides.clear();
            chain.vertices.push(from);
            chain.push(vertex, side);
        }
        [right, left]
    }

    /// Adds the triangle that the piece enters by a side, between the numbers of its ends. Returns that of the apex.
    fn push(&mut self, tile: &EditTile, entered: u32, [right, left]: [u32; 2], apex: Vertex) -> u32 {
        let (apex, is_new) = self.strip.number(apex);
        self.is_passed_twice |= !is_new;
        let bits = tile.bits_from(entered);
        self.strip
            .old
            .push(Old::new([left, right, apex], bits, (tile.id, entered)));
        apex
    }

    /// Triangulates the strip anew on both sides of a piece between two of its vertices, in all tiles that have some of it.
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
        right.sides.reverse();
        let mut on_piece = [0; 2];
        for (chain, on_piece) in [left, right].into_iter().zip(&mut on_piece) {
            let points = chain
                .vertices
                .iter()
                .map(|&vertex| strip.vertices[vertex as usize].point);
            if !cavity.triangulate(points) {
                return Err(EditError::Internal("a line does not cross what it crossed".to_owned()));
            }
            *on_piece = fill(strip, chain, cavity, self.is_passed_twice);
        }
        for [side, twin] in [on_piece, [on_piece[1], on_piece[0]]] {
            let triangle = &mut strip.new[(side / 3) as usize];
            triangle.across[(side % 3) as usize] = Beside::New(twin);
            triangle.bits |= constraint_bits(is_wall) << (side % 3);
        }
        exchange(strip, tiles)
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

/// Whether a line is to be followed from its end: its start has many triangles, since thousands of lines may share it, and its end
/// has fewer.
fn is_shorter_from_end(tiles: &Tiles, [start, end]: [Vertex; 2]) -> Result<bool, EditError> {
    let around = |vertex: Vertex| tiles.get(vertex.id.tile).map(|tile| tile.degree(vertex.id.index));
    let at_start = around(start)?;
    Ok(at_start > MOST_AROUND && around(end)? < at_start)
}

/// Puts the triangles of a cavity into the patch. Returns the side on the piece.
fn fill(strip: &mut Patch, chain: &Chain, cavity: &Cavity, is_passed_twice: bool) -> u32 {
    let first = 3 * strip.new.len() as u32;
    for (corners, sides) in cavity.triangles.iter().zip((0u32..).step_by(3)) {
        // A side without a twin is on the chain, which says below what lies there, or on the piece.
        let across = |s: u32| Beside::New(cavity.twin(HalfEdge(sides + s)).map_or(NONE, |twin| first + twin.0));
        strip.new.push(New {
            corners: corners.map(|position| chain.vertices[position as usize]),
            bits: 0,
            across: [0, 1, 2].map(across),
        });
    }
    // An edge between two triangles of the strip that the piece does not cross is passed twice: a constraint that dangles into the cavity,
    // or an edge from which triangles hang that the piece does not cross.
    let mut positions: HashMap<[u32; 2], usize> = HashMap::new();
    if is_passed_twice {
        let edges = chain.vertices.array_windows().zip(0..);
        positions.extend(edges.map(|(&edge, position)| (edge, position)));
    }
    for (position, (&[from, to], &old)) in chain.vertices.array_windows().zip(&chain.sides).enumerate() {
        let side = first + cavity.sides[position].0;
        let twin = positions.get(&[to, from]).map(|&other| first + cavity.sides[other].0);
        let replaced = &strip.old[(old / 3) as usize];
        let bits = replaced.bits >> (old % 3) & constraint_bits(true);
        let triangle = &mut strip.new[(side / 3) as usize];
        triangle.across[(side % 3) as usize] = twin.map_or(Beside::Old(old), Beside::New);
        triangle.bits |= bits << (side % 3);
    }
    first + cavity.sides[chain.sides.len()].0
}

/// The bits of a triangle's first side, if that is a constraint.
fn constraint_bits(is_wall: bool) -> u8 {
    1 | u8::from(is_wall) << WALLS
}

/// Makes the first sides of these triangles constraints, in all tiles that have them.
fn mark(tiles: &mut Tiles, triangles: &[[VertexId; 3]], is_wall: bool) -> Result<(), EditError> {
    let bits = constraint_bits(is_wall);
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
