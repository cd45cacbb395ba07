//! Adjacent triangles, whatever stores them: the traits, and walks around a vertex.
//!
//! ```text
//!        c ─────── b        star(v → a): v → a, v → b, v → c, one for each
//!       ╱ ╲   2   ╱ ╲       triangle, counter-clockwise. It ends with c → v, which has
//!      ╱ 3  ╲   ╱  1 ╲      no twin: the hull, or the end of this part.
//!     d ───── v ───── a     rewind(v → c) goes back to v → a.
//! ```
//!
//! [`Walk`](super::Walk) locates points.

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};

/// The twin of a half-edge: what lies on the other side of its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twin {
    /// The half-edge of the other triangle, which runs in the opposite direction.
    HalfEdge(HalfEdge),
    /// Nothing: the edge is on the hull.
    Hull,
    /// A triangle that is not in this part of the triangulation.
    Elsewhere,
}

impl Twin {
    /// Returns the half-edge of the other triangle, if that triangle is in this part.
    #[inline]
    #[must_use]
    pub const fn half_edge(self) -> Option<HalfEdge> {
        match self {
            Self::HalfEdge(half_edge) => Some(half_edge),
            Self::Hull | Self::Elsewhere => None,
        }
    }
}

/// A triangulation, or a part of one. Its triangles and vertices are numbered from 0.
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
/// let leaves = |&half_edge: &_| mesh.origin(half_edge) == VertexIndex(3);
/// let first = mesh.half_edges().find(leaves).unwrap();
/// let mut star = mesh.star(first);
/// assert_eq!(star.by_ref().count(), 3);
/// assert_eq!(star.end(), Some(StarEnd::Closed));
/// ```
pub trait Topology {
    /// Returns the number of triangles.
    fn triangle_count(&self) -> u32;

    /// Returns the vertex at which a half-edge starts.
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex;

    /// Returns what lies on the other side of a half-edge.
    fn twin(&self, half_edge: HalfEdge) -> Twin;

    /// Returns the vertex at which a half-edge ends.
    #[inline]
    fn destination(&self, half_edge: HalfEdge) -> VertexIndex {
        self.origin(half_edge.next())
    }

    /// Returns the third vertex of the triangle of a half-edge.
    #[inline]
    fn apex(&self, half_edge: HalfEdge) -> VertexIndex {
        self.origin(half_edge.prev())
    }

    /// Returns all triangles, in order.
    #[inline]
    fn triangle_ids(&self) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + use<Self> {
        (0..self.triangle_count()).map(TriangleId)
    }

    /// Returns all half-edges, in order.
    fn half_edges(&self) -> impl Iterator<Item = HalfEdge> + use<Self> {
        (0..3 * self.triangle_count()).map(HalfEdge)
    }

    /// Returns the half-edges that leave the origin of `first`, counter-clockwise from `first`.
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

    /// Walks clockwise around the origin of `first`, to the half-edge from which
    /// [`star`](Self::star) passes the most. Returns that half-edge and why the walk ended there.
    /// If the star is closed, it returns `first` itself.
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

    /// Returns the half-edge to the origin of `first` from the vertex that `is_start` accepts.
    /// Returns `None` if there is no such half-edge: the hull's outside lies on the left of the
    /// edge, or there is no edge.
    ///
    /// # Errors
    /// If the half-edge is not found, and the star is not complete or does not close.
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

/// A [`Topology`] whose vertices have points.
pub trait Embedded: Topology {
    /// Returns the point of a vertex.
    fn point(&self, vertex: VertexIndex) -> Point;
}

/// Why a walk around a vertex ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StarEnd {
    /// The walk came back to its start.
    Closed,
    /// The edge of this half-edge is on the hull.
    Hull(HalfEdge),
    /// The triangle on the other side of this half-edge is not in this part.
    Elsewhere(HalfEdge),
    /// The walk passed as many half-edges as there are triangles, and did not come back to its
    /// start: the topology contradicts itself.
    Endless,
}

/// The error of a star that is incomplete or endless: the topology contradicts itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StarError {
    /// Some of the star's triangles are not in this part.
    #[error("the star of vertex {vertex} is not complete")]
    Incomplete {
        /// The vertex at the center of the star.
        vertex: VertexIndex,
    },
    /// A walk around the vertex does not come back to its start.
    #[error("the star of vertex {vertex} does not close")]
    Endless {
        /// The vertex at the center of the star.
        vertex: VertexIndex,
    },
}

/// The half-edges that leave a vertex, counter-clockwise, as far as this part of the triangulation
/// goes. Created by [`Topology::star`].
///
/// The iterator ends even if the topology contradicts itself: after as many half-edges as there are
/// triangles.
#[derive(Debug)]
pub struct Star<'t, T: ?Sized> {
    topology: &'t T,
    first: HalfEdge,
    /// The next half-edge, unless the star has ended.
    next: HalfEdge,
    end: Option<StarEnd>,
    /// The number of half-edges that may still come.
    left: u32,
}

impl<T: ?Sized> Star<'_, T> {
    /// Returns why there is no further half-edge, or `None` while there is one.
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
