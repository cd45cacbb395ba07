//! What is around a vertex: by which triangle a line leaves it.
//!
//! Lines between two vertices are looked for at both, in turns. From a vertex with many edges to places that are no vertices there
//! may be as many lines: the sides around it are sorted once then, and each line is found by halving.

use std::cmp::Ordering;

use foldhash::HashMap;

use super::constrained::Constrained;
use super::topology::{Star, StarEnd, Topology};
use super::triangulation::Triangulation;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};

/// How a piece leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaving {
    /// It is the edge of this half-edge, and ends at this vertex.
    Edge(HalfEdge, u32),
    /// It enters the triangle of this half-edge, which starts at the vertex.
    Triangle(HalfEdge),
}

/// Finds how the line between two vertices leaves one of them, and which. Both are searched in turns, so that it takes as
/// long as the one with fewer edges. None: no triangle at either is on it.
pub(super) fn leaving_towards(points: &[Point], mesh: &Constrained, ends: [u32; 2]) -> Option<(usize, Leaving)> {
    // Most pieces are edges already, which takes no predicate.
    let mut searches = ends.map(|vertex| Around::new(mesh, vertex));
    while searches.iter().all(|search| search.star.is_some()) {
        for which in [0, 1] {
            let Some(side) = searches[which].next() else {
                continue;
            };
            for (edge, vertex) in [(side, side.next()), (side.prev(), side.prev())] {
                if mesh.mesh.origin(vertex).0 == ends[1 - which] {
                    return Some((which, Leaving::Edge(edge, ends[1 - which])));
                }
            }
        }
    }
    let mut searches = [0, 1].map(|which| Search::new(mesh, ends[which], points[ends[1 - which] as usize]));
    while searches.iter().any(|search| search.around.star.is_some()) {
        for (which, search) in searches.iter_mut().enumerate() {
            if let Some(Some(leaving)) = search.next(points) {
                return Some((which, leaving));
            }
        }
    }
    None
}

/// Looks around a vertex for the way that a line to another place leaves it by.
struct Search<'m> {
    around: Around<'m>,
    to: Point,
    /// The half-edge that would come next if nothing is missing, and where the place lies from its right edge.
    known: Option<(HalfEdge, Orientation)>,
}

impl<'m> Search<'m> {
    fn new(mesh: &'m Constrained, vertex: u32, to: Point) -> Self {
        Self {
            around: Around::new(mesh, vertex),
            to,
            known: None,
        }
    }

    /// How the line leaves the vertex, if by the triangle of the next half-edge; nothing if there is no other.
    fn next(&mut self, points: &[Point]) -> Option<Option<Leaving>> {
        let side = self.around.next()?;
        let topology = &self.around.mesh.mesh;
        let corners = [topology.origin(side), topology.destination(side), topology.apex(side)];
        let [from, right, left] = corners.map(|vertex| points[vertex.index()]);
        let is_ahead = |p: Point| p.lex_cmp(from) == self.to.lex_cmp(from);
        let on_right = match self.known {
            Some((next, turn)) if next == side => turn,
            _ => orient2d(from, right, self.to),
        };
        let on_left = orient2d(from, left, self.to);
        self.known = topology.twin(side.prev()).half_edge().map(|next| (next, on_left));
        Some(match (on_right, on_left) {
            (Orientation::Collinear, _) if is_ahead(right) => Some(Leaving::Edge(side, corners[1].0)),
            (_, Orientation::Collinear) if is_ahead(left) => Some(Leaving::Edge(side.prev(), corners[2].0)),
            (Orientation::CounterClockwise, Orientation::Clockwise) => Some(Leaving::Triangle(side)),
            _ => None,
        })
    }
}

/// The half-edges that leave a vertex, counter-clockwise; one fan after the other where parts are missing.
#[derive(Debug)]
struct Around<'m> {
    mesh: &'m Constrained,
    vertex: u32,
    /// The rest of a fan; none at the end.
    star: Option<Star<'m, Triangulation>>,
    /// Fans that were begun, of a vertex on the boundary.
    fans: usize,
}

impl<'m> Around<'m> {
    fn new(mesh: &'m Constrained, vertex: u32) -> Self {
        let is_on_boundary = mesh.boundary.has(vertex);
        let first = match is_on_boundary {
            true => mesh.boundary.leaving(vertex, 0),
            false => mesh.leaving[vertex as usize].get(),
        };
        Self {
            mesh,
            vertex,
            star: first.map(|first| mesh.mesh.star(first)),
            fans: is_on_boundary.into(),
        }
    }
}

impl Around<'_> {
    /// After the end of a fan.
    #[inline(never)]
    fn next_fan(&mut self, end: StarEnd) {
        self.star = None;
        if let StarEnd::Hull(_) = end {
            let first = self.mesh.boundary.leaving(self.vertex, self.fans);
            self.star = first.map(|first| self.mesh.mesh.star(first));
            self.fans += 1;
        }
    }
}

impl Iterator for Around<'_> {
    type Item = HalfEdge;

    #[inline]
    fn next(&mut self) -> Option<HalfEdge> {
        let star = self.star.as_mut()?;
        let leaving = star.next();
        if let Some(end) = star.end() {
            self.next_fan(end);
        }
        leaving
    }
}

/// The stars of vertices from which many lines start, as long as the mesh is what it was.
#[derive(Debug, Default)]
pub(crate) struct Stars(HashMap<u32, Vec<HalfEdge>>);

impl Stars {
    /// Sides that are looked at before those of the vertex are sorted.
    const FEW: usize = 64;

    /// How the line to a place leaves a vertex. None: no triangle there is on it.
    pub(super) fn start(&mut self, points: &[Point], mesh: &Constrained, vertex: u32, to: Point) -> Option<Leaving> {
        if !self.0.contains_key(&vertex) {
            let mut search = Search::new(mesh, vertex, to);
            for _ in 0..Self::FEW {
                if let Some(leaving) = search.next(points)? {
                    return Some(leaving);
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
        let around = Around {
            mesh,
            vertex,
            star: Some(mesh.mesh.star(side)),
            fans: 0,
        };
        let known = None;
        Search { around, to, known }.next(points)?
    }
}

/// The half-edges that leave a vertex, counter-clockwise from one of them on.
fn sorted_star(points: &[Point], mesh: &Constrained, vertex: u32) -> Vec<HalfEdge> {
    let mut sides: Vec<HalfEdge> = Around::new(mesh, vertex).collect();
    if let Some(&first) = sides.first() {
        let around = Directions::from(points, mesh, vertex, first);
        sides.sort_by(|&a, &b| around.compare(around.of(a), around.of(b)));
    }
    sides
}

/// The directions around a vertex, from that of one of its half-edges on.
struct Directions<'a> {
    points: &'a [Point],
    mesh: &'a Constrained,
    vertex: Point,
    first: Point,
}

impl<'a> Directions<'a> {
    fn from(points: &'a [Point], mesh: &'a Constrained, vertex: u32, first: HalfEdge) -> Self {
        let mut this = Self {
            points,
            mesh,
            vertex: points[vertex as usize],
            first: points[vertex as usize],
        };
        this.first = this.of(first);
        this
    }

    /// Where a half-edge leads to.
    fn of(&self, side: HalfEdge) -> Point {
        self.points[self.mesh.mesh.destination(side).index()]
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
