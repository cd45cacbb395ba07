//! Finds the triangle or the edge by which a line leaves a vertex.
//!
//! The line between two vertices is searched at both of them, alternately. A vertex with many edges
//! may have as many lines to points that are not vertices. Then the half-edges around the vertex
//! are sorted once, and each line is found by binary search.

use std::cmp::Ordering;

use foldhash::HashMap;

use super::constrained::Constrained;
use super::topology::{Star, StarEnd, Topology};
use super::triangulation::Triangulation;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};

/// How a subsegment leaves a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaving {
    /// Along the edge of this half-edge, to this vertex.
    Edge(HalfEdge, u32),
    /// Into the triangle of this half-edge, which starts at the vertex.
    Triangle(HalfEdge),
}

/// Finds how the line between two vertices leaves one of them, and returns the index of that vertex
/// in `ends`. Both vertices are searched alternately, so the time depends on the one with fewer
/// edges. Returns `None` if the line meets no triangle at either vertex.
pub(super) fn leaving_towards(points: &[Point], mesh: &Constrained, ends: [u32; 2]) -> Option<(usize, Leaving)> {
    // Most subsegments are edges already. Finding these takes no predicate.
    let mut searches = ends.map(|vertex| Fans::new(mesh, vertex));
    while searches.iter().all(|search| search.star.is_some()) {
        for which in [0, 1] {
            let Some(half_edge) = searches[which].next() else {
                continue;
            };
            for (edge, vertex) in [(half_edge, half_edge.next()), (half_edge.prev(), half_edge.prev())] {
                if mesh.mesh.origin(vertex).0 == ends[1 - which] {
                    return Some((which, Leaving::Edge(edge, ends[1 - which])));
                }
            }
        }
    }
    let mut searches = [0, 1].map(|which| LeavingSearch::new(mesh, ends[which], points[ends[1 - which] as usize]));
    while searches.iter().any(|search| search.fans.star.is_some()) {
        for (which, search) in searches.iter_mut().enumerate() {
            if let Some(Some(leaving)) = search.next(points) {
                return Some((which, leaving));
            }
        }
    }
    None
}

/// Searches the star of a vertex for the half-edge by which a line to the point `to` leaves it.
struct LeavingSearch<'m> {
    fans: Fans<'m>,
    to: Point,
    /// The half-edge that comes next unless triangles are missing, and on which side of it `to`
    /// lies.
    known: Option<(HalfEdge, Orientation)>,
}

impl<'m> LeavingSearch<'m> {
    fn new(mesh: &'m Constrained, vertex: u32, to: Point) -> Self {
        Self {
            fans: Fans::new(mesh, vertex),
            to,
            known: None,
        }
    }

    /// Examines the next half-edge. Returns `None` if there is none, and otherwise how the line
    /// leaves the vertex, if it leaves by the triangle of that half-edge.
    fn next(&mut self, points: &[Point]) -> Option<Option<Leaving>> {
        let half_edge = self.fans.next()?;
        let topology = &self.fans.mesh.mesh;
        let corners = [
            topology.origin(half_edge),
            topology.destination(half_edge),
            topology.apex(half_edge),
        ];
        let [from, right, left] = corners.map(|vertex| points[vertex.index()]);
        let is_ahead = |p: Point| p.lex_cmp(from) == self.to.lex_cmp(from);
        let on_right = match self.known {
            Some((next, turn)) if next == half_edge => turn,
            _ => orient2d(from, right, self.to),
        };
        let on_left = orient2d(from, left, self.to);
        self.known = topology.twin(half_edge.prev()).half_edge().map(|next| (next, on_left));
        Some(match (on_right, on_left) {
            (Orientation::Collinear, _) if is_ahead(right) => Some(Leaving::Edge(half_edge, corners[1].0)),
            (_, Orientation::Collinear) if is_ahead(left) => Some(Leaving::Edge(half_edge.prev(), corners[2].0)),
            (Orientation::CounterClockwise, Orientation::Clockwise) => Some(Leaving::Triangle(half_edge)),
            _ => None,
        })
    }
}

/// The half-edges that leave a vertex, counter-clockwise. Where parts of the mesh are missing, they
/// form several fans, one after the other.
#[derive(Debug)]
struct Fans<'m> {
    mesh: &'m Constrained,
    vertex: u32,
    /// The rest of the current fan, or `None` at the end.
    star: Option<Star<'m, Triangulation>>,
    /// The number of fans that were started, if the vertex is on the boundary.
    begun: usize,
}

impl<'m> Fans<'m> {
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
            begun: is_on_boundary.into(),
        }
    }
}

impl Fans<'_> {
    /// Starts the next fan after the end of one.
    #[inline(never)]
    fn next_fan(&mut self, end: StarEnd) {
        self.star = None;
        if let StarEnd::Hull(_) = end {
            let first = self.mesh.boundary.leaving(self.vertex, self.begun);
            self.star = first.map(|first| self.mesh.mesh.star(first));
            self.begun += 1;
        }
    }
}

impl Iterator for Fans<'_> {
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

/// The sorted stars of vertices from which many lines start. They are valid until the mesh changes.
#[derive(Debug, Default)]
pub(crate) struct Stars(HashMap<u32, Vec<HalfEdge>>);

impl Stars {
    /// The number of half-edges to examine before those of the vertex are sorted.
    const FEW: usize = 64;

    /// Returns how the line to the point `to` leaves a vertex, or `None` if it meets no triangle
    /// there.
    pub(super) fn start(&mut self, points: &[Point], mesh: &Constrained, vertex: u32, to: Point) -> Option<Leaving> {
        if !self.0.contains_key(&vertex) {
            let mut search = LeavingSearch::new(mesh, vertex, to);
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
        let directions = Directions::from(points, mesh, vertex, *star.first()?);
        let end = star.partition_point(|&half_edge| directions.compare(directions.of(half_edge), to).is_le());
        // The first direction precedes all others.
        let half_edge = star[end.saturating_sub(1)];
        let fans = Fans {
            mesh,
            vertex,
            star: Some(mesh.mesh.star(half_edge)),
            begun: 0,
        };
        let known = None;
        LeavingSearch { fans, to, known }.next(points)?
    }
}

/// Returns the half-edges that leave a vertex, sorted counter-clockwise from one of them on.
fn sorted_star(points: &[Point], mesh: &Constrained, vertex: u32) -> Vec<HalfEdge> {
    let mut half_edges: Vec<HalfEdge> = Fans::new(mesh, vertex).collect();
    if let Some(&first) = half_edges.first() {
        let directions = Directions::from(points, mesh, vertex, first);
        half_edges.sort_by(|&a, &b| directions.compare(directions.of(a), directions.of(b)));
    }
    half_edges
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

    /// Returns the destination of a half-edge.
    fn of(&self, half_edge: HalfEdge) -> Point {
        self.points[self.mesh.mesh.destination(half_edge).index()]
    }

    /// Returns whether `point` lies at least a half-turn counter-clockwise from the first
    /// direction.
    fn is_behind(&self, point: Point) -> bool {
        match orient2d(self.vertex, self.first, point) {
            Orientation::CounterClockwise => false,
            Orientation::Clockwise => true,
            Orientation::Collinear => point.lex_cmp(self.vertex) != self.first.lex_cmp(self.vertex),
        }
    }

    /// Compares the directions of two points, counter-clockwise from the first direction.
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
