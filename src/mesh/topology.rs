//! Triangles side by side, whatever they are stored in: the traits, and walks round a vertex.
//!
//! ```text
//!        c ─────── b          star(v → a): v → a, v → b, v → c, counter-clockwise, one for each triangle.
//!       ╱ ╲   2   ╱ ╲         It ends with c → v, which has no triangle on the other side: the hull, or
//!      ╱ 3  ╲   ╱  1 ╲        the end of this part. rewind(v → c) goes back to v → a.
//!     d ───── v ───── a
//! ```
//!
//! [`Walk`](super::Walk) locates points.

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};

/// What lies on the other side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twin {
    /// The half-edge of the other triangle, which runs the other way.
    HalfEdge(HalfEdge),
    /// Nothing: the edge is on the hull.
    Hull,
    /// A triangle that is not in this part of the triangulation.
    Elsewhere,
}

impl Twin {
    /// The half-edge of the other triangle, if it is in this part.
    #[inline]
    #[must_use]
    pub const fn half_edge(self) -> Option<HalfEdge> {
        match self {
            Self::HalfEdge(half_edge) => Some(half_edge),
            Self::Hull | Self::Elsewhere => None,
        }
    }
}

/// A triangulation, or a part of one, whose triangles and vertices have numbers from 0 on.
///
/// # Example
///
/// ```
/// use delaunay_tiles::geometry::{Point, VertexIndex};
/// use delaunay_tiles::mesh::{EngineKind, StarEnd, Topology, Triangulation};
///
/// let points = [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y));
/// let mut mesh = Triangulation::default();
/// EngineKind::Native.create().triangulate(&points, &mut mesh);
/// // The last point lies within the triangle of the others.
/// let first = mesh.half_edges().find(|&half_edge| mesh.origin(half_edge) == VertexIndex(3)).unwrap();
/// let mut star = mesh.star(first);
/// assert_eq!(star.by_ref().count(), 3);
/// assert_eq!(star.end(), Some(StarEnd::Closed));
/// ```
pub trait Topology {
    /// The number of triangles.
    fn triangle_count(&self) -> u32;

    /// The vertex that a half-edge starts at.
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex;

    /// What lies on the other side of its edge.
    fn twin(&self, half_edge: HalfEdge) -> Twin;

    /// The vertex that a half-edge leads to.
    #[inline]
    fn destination(&self, half_edge: HalfEdge) -> VertexIndex {
        self.origin(half_edge.next())
    }

    /// The third vertex of the triangle of a half-edge.
    #[inline]
    fn apex(&self, half_edge: HalfEdge) -> VertexIndex {
        self.origin(half_edge.prev())
    }

    /// All triangles.
    #[inline]
    fn triangle_ids(&self) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + use<Self> {
        (0..self.triangle_count()).map(TriangleId)
    }

    /// All half-edges.
    fn half_edges(&self) -> impl Iterator<Item = HalfEdge> + use<Self> {
        (0..3 * self.triangle_count()).map(HalfEdge)
    }

    /// The half-edges that leave the same vertex as `first`, from this one on counter-clockwise.
    #[inline]
    fn star(&self, first: HalfEdge) -> Star<'_, Self> {
        Star {
            topology: self,
            first,
            next: first,
            end: None,
            left: self.triangle_count(),
        }
    }

    /// Goes clockwise round the vertex that `first` leaves, to the half-edge from which [`star`](Self::star) passes the
    /// most. Returns that, and why it goes no further; if the star is closed, `first` itself.
    fn rewind(&self, first: HalfEdge) -> (HalfEdge, StarEnd) {
        let mut leaving = first;
        for _ in 0..self.triangle_count() {
            leaving = match self.twin(leaving) {
                Twin::Hull => return (leaving, StarEnd::Hull(leaving)),
                Twin::Elsewhere => return (leaving, StarEnd::Elsewhere(leaving)),
                Twin::HalfEdge(arriving) => arriving.next(),
            };
            if leaving == first {
                return (first, StarEnd::Closed);
            }
        }
        (leaving, StarEnd::Endless)
    }

    /// The half-edge to the vertex that `first` leaves, from the one that `is_start` accepts. None if there is no such
    /// half-edge: the edge is on the hull, which lies on the left, or there is no edge.
    ///
    /// # Errors
    /// If it is not found, and the star is not complete or does not close.
    fn arriving_from(
        &self,
        first: HalfEdge,
        mut is_start: impl FnMut(VertexIndex) -> bool,
    ) -> Result<Option<HalfEdge>, StarError> {
        let vertex = self.origin(first);
        let mut star = self.star(first);
        if let Some(leaving) = star.find(|leaving| is_start(self.apex(*leaving))) {
            return Ok(Some(leaving.prev()));
        }
        let is_complete = match star.end() {
            Some(StarEnd::Hull(_)) => true,
            Some(StarEnd::Elsewhere(_)) => false,
            Some(StarEnd::Endless) => return Err(StarError::Endless { vertex }),
            Some(StarEnd::Closed) | None => return Ok(None),
        };
        // The rest of the star, clockwise.
        let mut leaving = first;
        for _ in 0..self.triangle_count() {
            let arriving = match self.twin(leaving) {
                Twin::HalfEdge(arriving) => arriving,
                Twin::Hull if is_complete => return Ok(None),
                Twin::Hull | Twin::Elsewhere => return Err(StarError::Incomplete { vertex }),
            };
            if is_start(self.origin(arriving)) {
                return Ok(Some(arriving));
            }
            leaving = arriving.next();
        }
        Err(StarError::Endless { vertex })
    }
}

/// A [`Topology`] that knows where its vertices are.
pub trait Embedded: Topology {
    /// Where a vertex is.
    fn point(&self, vertex: VertexIndex) -> Point;
}

/// Why a walk round a vertex ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StarEnd {
    /// It came round to where it started.
    Closed,
    /// The edge of this half-edge is on the hull.
    Hull(HalfEdge),
    /// The triangle on the other side of this half-edge is not in this part.
    Elsewhere(HalfEdge),
    /// It passed as many triangles as there are, and did not come round: the topology contradicts itself.
    Endless,
}

/// A star that is not what it must be: the topology contradicts itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StarError {
    /// Some of its triangles are not in this part.
    #[error("the star of vertex {vertex} is not complete")]
    Incomplete {
        /// The vertex in the middle.
        vertex: VertexIndex,
    },
    /// Whoever goes round does not come back.
    #[error("the star of vertex {vertex} does not close")]
    Endless {
        /// The vertex in the middle.
        vertex: VertexIndex,
    },
}

/// The half-edges that leave a vertex, counter-clockwise, as far as this part of the triangulation goes. Made by
/// [`Topology::star`].
///
/// It ends even if the topology contradicts itself, after as many half-edges as there are triangles.
#[derive(Debug)]
pub struct Star<'t, T: ?Sized> {
    topology: &'t T,
    first: HalfEdge,
    /// What comes next, unless this is the end.
    next: HalfEdge,
    end: Option<StarEnd>,
    /// Half-edges that may still come.
    left: u32,
}

impl<T: ?Sized> Star<'_, T> {
    /// Why there is no further half-edge; None as long as there is one.
    #[inline]
    #[must_use]
    pub fn end(&self) -> Option<StarEnd> {
        self.end
    }
}

impl<T: Topology + ?Sized> Iterator for Star<'_, T> {
    type Item = HalfEdge;

    #[inline]
    fn next(&mut self) -> Option<HalfEdge> {
        if self.end.is_some() {
            return None;
        }
        let leaving = self.next;
        let arriving = leaving.prev();
        self.left = self.left.wrapping_sub(1);
        match self.topology.twin(arriving) {
            Twin::HalfEdge(next) if next == self.first => self.end = Some(StarEnd::Closed),
            Twin::HalfEdge(_) if self.left == 0 => self.end = Some(StarEnd::Endless),
            Twin::HalfEdge(next) => self.next = next,
            Twin::Hull => self.end = Some(StarEnd::Hull(arriving)),
            Twin::Elsewhere => self.end = Some(StarEnd::Elsewhere(arriving)),
        }
        Some(leaving)
    }
}

#[cfg(test)]
mod tests;
