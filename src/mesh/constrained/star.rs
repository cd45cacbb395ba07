//! What is around a vertex: by which triangle a line leaves it.
//!
//! Lines between two vertices are looked for at both, in turns. From a vertex with many edges to places that are no vertices there
//! may be as many lines: the sides around it are sorted once then, and each line is found by halving.

use std::cmp::Ordering;

use foldhash::HashMap;

use super::{Constrained, NONE, next_side, prev_side};
use crate::geometry::{Orientation, Point, orient2d};

/// How a piece leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Start {
    /// It is the edge of this side, and ends at this vertex.
    Edge(u32, u32),
    /// It enters the triangle of this side, which starts at the vertex.
    Triangle(u32),
}

/// Finds how the line between two vertices leaves one of them, and which. Both are searched in turns, so that it takes as
/// long as the one with fewer edges. None: no triangle at either is on it.
pub(super) fn begin(points: &[Point], mesh: &Constrained, ends: [u32; 2]) -> Option<(usize, Start)> {
    // Most pieces are edges already, which takes no predicate.
    let mut searches = ends.map(|vertex| Around::new(mesh, vertex));
    while searches.iter().all(|search| search.next != NONE) {
        for which in [0, 1] {
            let Some(side) = searches[which].next(mesh) else {
                continue;
            };
            for (edge, vertex) in [(side, next_side(side)), (prev_side(side), prev_side(side))] {
                if mesh.mesh.origin(vertex) == ends[1 - which] {
                    return Some((which, Start::Edge(edge, ends[1 - which])));
                }
            }
        }
    }
    let mut searches = [0, 1].map(|which| Search::new(mesh, ends[which], points[ends[1 - which] as usize]));
    while searches.iter().any(|search| search.around.next != NONE) {
        for (which, search) in searches.iter_mut().enumerate() {
            if let Some(Some(start)) = search.next(points, mesh) {
                return Some((which, start));
            }
        }
    }
    None
}

/// Looks around a vertex for the way that a line to another place leaves it by.
struct Search {
    around: Around,
    to: Point,
    /// The side that would come next if nothing is missing, and where the place lies from its right edge.
    known: (u32, Orientation),
}

impl Search {
    fn new(mesh: &Constrained, vertex: u32, to: Point) -> Self {
        Self {
            around: Around::new(mesh, vertex),
            to,
            known: (NONE, Orientation::Collinear),
        }
    }

    /// How the line leaves the vertex, if by the triangle of the next side; nothing if there is no other side.
    fn next(&mut self, points: &[Point], mesh: &Constrained) -> Option<Option<Start>> {
        let side = self.around.next(mesh)?;
        let topology = &mesh.mesh;
        let corners = [side, next_side(side), prev_side(side)].map(|side| topology.origin(side));
        let [from, right, left] = corners.map(|vertex| points[vertex as usize]);
        let is_ahead = |p: Point| p.lex_cmp(from) == self.to.lex_cmp(from);
        let on_right = match self.known {
            (next, turn) if next == side => turn,
            _ => orient2d(from, right, self.to),
        };
        let on_left = orient2d(from, left, self.to);
        self.known = (topology.twin(prev_side(side)), on_left);
        Some(match (on_right, on_left) {
            (Orientation::Collinear, _) if is_ahead(right) => Some(Start::Edge(side, corners[1])),
            (_, Orientation::Collinear) if is_ahead(left) => Some(Start::Edge(prev_side(side), corners[2])),
            (Orientation::CounterClockwise, Orientation::Clockwise) => Some(Start::Triangle(side)),
            _ => None,
        })
    }
}

/// The sides that start at a vertex, counter-clockwise; one fan after the other where parts are missing.
#[derive(Clone, Copy, Debug)]
struct Around {
    vertex: u32,
    first: u32,
    next: u32,
    /// Fans that were begun, of a vertex on the boundary.
    fans: usize,
}

impl Around {
    /// From a side on.
    fn at(vertex: u32, side: u32) -> Self {
        Self {
            vertex,
            first: side,
            next: side,
            fans: 0,
        }
    }

    fn new(mesh: &Constrained, vertex: u32) -> Self {
        let mut this = Self {
            vertex,
            first: mesh.sides[vertex as usize],
            next: mesh.sides[vertex as usize],
            fans: 0,
        };
        if mesh.boundary.has(vertex) {
            this.next_fan(mesh);
        }
        this
    }

    fn next_fan(&mut self, mesh: &Constrained) {
        self.next = mesh.boundary.side_from(self.vertex, self.fans).unwrap_or(NONE);
        self.first = self.next;
        self.fans += 1;
    }

    fn next(&mut self, mesh: &Constrained) -> Option<u32> {
        let side = self.next;
        if side == NONE {
            return None;
        }
        match mesh.mesh.twin(prev_side(side)) {
            NONE => self.next_fan(mesh),
            twin if twin == self.first => self.next = NONE,
            twin => self.next = twin,
        }
        Some(side)
    }
}

/// The stars of vertices from which many lines start, as long as the mesh is what it was.
#[derive(Debug, Default)]
pub(crate) struct Stars(HashMap<u32, Vec<u32>>);

impl Stars {
    /// Sides that are looked at before those of the vertex are sorted.
    const FEW: usize = 64;

    /// How the line to a place leaves a vertex. None: no triangle there is on it.
    pub(super) fn start(&mut self, points: &[Point], mesh: &Constrained, vertex: u32, to: Point) -> Option<Start> {
        if !self.0.contains_key(&vertex) {
            let mut search = Search::new(mesh, vertex, to);
            for _ in 0..Self::FEW {
                if let Some(start) = search.next(points, mesh)? {
                    return Some(start);
                }
            }
        }
        let star = self
            .0
            .entry(vertex)
            .or_insert_with(|| sorted_star(points, mesh, vertex));
        let around = Directions::from(points, mesh, vertex, *star.first()?);
        let end = star.partition_point(|&side| around.compare(around.of(side), to).is_le());
        // The first direction is before all others.
        let side = star[end.saturating_sub(1)];
        Search {
            around: Around::at(vertex, side),
            ..Search::new(mesh, vertex, to)
        }
        .next(points, mesh)?
    }
}

/// The sides that start at a vertex, counter-clockwise from one of them on.
fn sorted_star(points: &[Point], mesh: &Constrained, vertex: u32) -> Vec<u32> {
    let mut around = Around::new(mesh, vertex);
    let mut sides: Vec<u32> = std::iter::from_fn(|| around.next(mesh)).collect();
    if let Some(&first) = sides.first() {
        let around = Directions::from(points, mesh, vertex, first);
        sides.sort_by(|&a, &b| around.compare(around.of(a), around.of(b)));
    }
    sides
}

/// The directions around a vertex, from that of one of its sides on.
struct Directions<'a> {
    points: &'a [Point],
    mesh: &'a Constrained,
    vertex: Point,
    first: Point,
}

impl<'a> Directions<'a> {
    fn from(points: &'a [Point], mesh: &'a Constrained, vertex: u32, first: u32) -> Self {
        let mut this = Self {
            points,
            mesh,
            vertex: points[vertex as usize],
            first: points[vertex as usize],
        };
        this.first = this.of(first);
        this
    }

    /// Where a side leads to.
    fn of(&self, side: u32) -> Point {
        self.points[self.mesh.mesh.origin(next_side(side)) as usize]
    }

    /// Whether a place lies a half-turn behind the first direction, or more.
    fn is_behind(&self, place: Point) -> bool {
        match orient2d(self.vertex, self.first, place) {
            Orientation::CounterClockwise => false,
            Orientation::Clockwise => true,
            Orientation::Collinear => place.lex_cmp(self.vertex) != self.first.lex_cmp(self.vertex),
        }
    }

    /// Which of two places comes first counter-clockwise.
    fn compare(&self, a: Point, b: Point) -> Ordering {
        let turned = || match orient2d(self.vertex, a, b) {
            Orientation::CounterClockwise => Ordering::Less,
            Orientation::Collinear => Ordering::Equal,
            Orientation::Clockwise => Ordering::Greater,
        };
        self.is_behind(a).cmp(&self.is_behind(b)).then_with(turned)
    }
}

#[cfg(test)]
mod tests;
