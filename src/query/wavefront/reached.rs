//! What the wave knows of a tile: how far its vertices are at most, and which of its dead ends goals lie in.
//!
//! A vertex with one free sector that was seen from a root is no farther away than over that root, and what lies on a side that ends there
//! no farther than by way of it, along the side. A cone that is longer for all that it holds of the side shows nothing that another one
//! does not show on a shorter way (Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", TOG 28(4),
//! 2009): it is *beaten*. With x on the side, between its end v and where the far ray b crosses it:
//!
//! ```text
//!        v ───── x ───── b     if root + |r b| > known(v) + |v b|, then root + |r x| + |x b| ≥ root + |r b| > known(v) + |v x| + |x b|,
//!               ╱      ╱       so the way by r is longer at x too: the far ray tells for all
//!             r ──────
//! ```

use super::cone::Crossing;
use super::roots::TIE;
use crate::geometry::{TriangleId, VertexIndex};
use crate::query::answer::distance;
use crate::query::free_space::Ground;

/// Vertices whose lengths stand together: near in the plane, as their numbers are.
const PAGE: usize = 32;

/// What the wave knows of a tile.
#[derive(Debug, Default)]
pub(crate) struct Reached {
    /// For each so many corners, the place of their lengths, in pages; 0 if none was reached.
    pages: Vec<u32>,
    /// The first page is one of infinite lengths.
    lengths: Vec<f64>,
    /// Triangles in dead ends by which one comes to goals, in order; none if it was not known where dead ends begin when the wave came here.
    /// It need not heed what was found out later.
    awake: Option<Vec<TriangleId>>,
}

impl Reached {
    /// Nothing yet, of a tile in or at whose triangles goals lie.
    pub(crate) fn new(ground: Ground<'_>, goals: impl Iterator<Item = TriangleId>) -> Self {
        let (tile, passages) = (ground.tile, ground.passages());
        let goals = goals.filter(|&triangle| triangle.0 < tile.triangle_count());
        let awake = passages.come().then(|| {
            let mut awake: Vec<TriangleId> = goals.flat_map(|triangle| passages.way_in(triangle)).collect();
            awake.sort_unstable();
            awake
        });
        Self {
            pages: vec![0; tile.corner_count().div_ceil(PAGE)],
            lengths: vec![f64::INFINITY; PAGE],
            awake,
        }
    }

    /// Whether a goal may lie in a dead end that begins with this triangle.
    pub(crate) fn may_enter(&self, triangle: TriangleId) -> bool {
        self.awake
            .as_ref()
            .is_none_or(|awake| awake.binary_search(&triangle).is_ok())
    }

    /// How far a corner is at most.
    #[inline]
    fn known(&self, corner: VertexIndex) -> f64 {
        let page = self.pages[corner.index() / PAGE];
        self.lengths[page as usize * PAGE + corner.index() % PAGE]
    }

    /// Whether a vertex is known to be nearer than this.
    #[inline]
    pub(crate) fn is_nearer(&self, vertex: VertexIndex, length: f64) -> bool {
        length > self.known(vertex) * TIE
    }

    /// A vertex of the tile with one free sector is no farther away than this: whether it was not known to be nearer.
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

    /// Whether a way of such a length to the root and through the crossing is longer, wherever it crosses the side, than one by an end of the side;
    /// ends as seen on the right and on the left.
    #[inline]
    pub(crate) fn beats(&self, length: f64, crossing: &Crossing, corners: [VertexIndex; 2]) -> bool {
        let [right, left] = corners.map(|corner| self.known(corner));
        let is_longer = |known: f64, far: usize, end: usize| {
            let by_end = known + distance(crossing.rays[far], crossing.ends[end]);
            length + crossing.lengths[far] > by_end * TIE + crossing.slack
        };
        // Both are computed, for nobody can foresee which one tells.
        is_longer(right, 1, 0) | is_longer(left, 0, 1)
    }
}
