//! The wavefront's knowledge of a tile: upper bounds of the distances of its vertices, and the dead
//! ends that contain goals.
//!
//! If a root sees a vertex with one free sector, the vertex is no farther than the path by way of
//! that root. A point on an edge at the vertex is no farther than the path by way of the vertex and
//! along the edge. A window whose paths are longer than that everywhere on its interval is
//! *beaten*: another window reaches all of it on a shorter path (Xin and Wang, "Improving Chen and
//! Han's algorithm on the discrete geodesic problem", TOG 28(4), 2009). Let x be on the edge,
//! between its end v and the point b where the far ray crosses it:
//!
//! ```text
//!        v ───── x ───── b     If root + |r b| > known(v) + |v b|, then
//!               ╱      ╱       root + |r x| + |x b| ≥ root + |r b| > known(v) + |v x| + |x b|,
//!             r ──────         so the path by r is longer at x too: testing the far ray suffices.
//! ```

use super::roots::TIE;
use super::window::Crossing;
use crate::geometry::{TriangleId, VertexIndex};
use crate::query::answer::distance;
use crate::query::free_space::FreeSpace;

/// The number of vertices whose lengths are stored together. They are near in the plane, because
/// their indices are near.
const PAGE: usize = 32;

/// The wavefront's knowledge of a tile.
#[derive(Debug, Default)]
pub(crate) struct Reached {
    /// For each [`PAGE`] corners, the page of their lengths; 0 if none of them was reached.
    pages: Vec<u32>,
    /// The lengths, in pages. Page 0 has infinite lengths.
    lengths: Vec<f64>,
    /// The triangles in dead ends that lead to goals, sorted. `None` if the dead ends of the tile
    /// were unknown when the wavefront arrived here. Dead ends that become known later need not be
    /// considered.
    open_dead_ends: Option<Vec<TriangleId>>,
    /// For each triangle up to some one, a bit: whether it is known to be within the limit.
    whole: Vec<u64>,
}

impl Reached {
    /// Creates the knowledge of a tile that was not reached yet; `goals` are the triangles that
    /// contain goals or touch them.
    pub(crate) fn new(space: FreeSpace<'_>, goals: impl Iterator<Item = TriangleId>) -> Self {
        let (tile, passages) = (space.tile, space.passages());
        let goals = goals.filter(|&triangle| triangle.0 < tile.triangle_count());
        let open_dead_ends = passages.knows_dead_ends().then(|| {
            let mut open_dead_ends: Vec<TriangleId> = goals.flat_map(|triangle| passages.way_in(triangle)).collect();
            open_dead_ends.sort_unstable();
            open_dead_ends
        });
        Self {
            pages: vec![0; tile.corner_count().div_ceil(PAGE)],
            lengths: vec![f64::INFINITY; PAGE],
            open_dead_ends,
            whole: Vec::new(),
        }
    }

    /// Returns whether a triangle was noted as being within the limit as a whole.
    pub(crate) fn is_whole(&self, triangle: TriangleId) -> bool {
        let bits = self.whole.get(triangle.index() / 64);
        bits.is_some_and(|bits| bits >> (triangle.index() % 64) & 1 == 1)
    }

    /// Notes that a triangle is within the limit as a whole.
    pub(crate) fn note_whole(&mut self, triangle: TriangleId) {
        let index = triangle.index() / 64;
        if self.whole.len() <= index {
            self.whole.resize(index + 1, 0);
        }
        self.whole[index] |= 1 << (triangle.index() % 64);
    }

    /// Returns whether the dead end that starts with this triangle may contain a goal.
    pub(crate) fn may_enter(&self, triangle: TriangleId) -> bool {
        self.open_dead_ends
            .as_ref()
            .is_none_or(|open_dead_ends| open_dead_ends.binary_search(&triangle).is_ok())
    }

    /// Returns an upper bound of the distance of a corner.
    #[inline]
    pub(crate) fn known(&self, corner: VertexIndex) -> f64 {
        let page = self.pages[corner.index() / PAGE];
        self.lengths[page as usize * PAGE + corner.index() % PAGE]
    }

    /// Returns whether a vertex is known to be nearer than `length`.
    #[inline]
    pub(crate) fn is_nearer(&self, vertex: VertexIndex, length: f64) -> bool {
        length > self.known(vertex) * TIE
    }

    /// Notes that a vertex of the tile with one free sector is at most `length` away. Returns
    /// whether it was not known to be nearer.
    #[inline]
    pub(crate) fn reach(&mut self, vertex: VertexIndex, length: f64) -> bool {
        let page = &mut self.pages[vertex.index() / PAGE];
        if *page == 0 {
            *page = (self.lengths.len() / PAGE) as u32;
            self.lengths.resize(self.lengths.len() + PAGE, f64::INFINITY);
        }
        let known = &mut self.lengths[*page as usize * PAGE + vertex.index() % PAGE];
        if length > *known * TIE {
            return false;
        }
        *known = known.min(length);
        true
    }

    /// Returns whether a path of `length` to the root and then through the crossing is, wherever it
    /// crosses the edge, longer than a path by way of an end of the edge. `corners` are the ends as
    /// seen on the right and on the left.
    #[inline]
    pub(crate) fn beats(&self, length: f64, crossing: &Crossing, corners: [VertexIndex; 2]) -> bool {
        let [right, left] = corners.map(|corner| self.known(corner));
        let is_longer = |known: f64, far: usize, end: usize| {
            let by_end = known + distance(crossing.rays[far], crossing.ends[end]);
            length + crossing.lengths[far] > by_end * TIE + crossing.slack
        };
        // Branch-free: which of the two decides is unpredictable.
        is_longer(right, 1, 0) | is_longer(left, 0, 1)
    }
}
