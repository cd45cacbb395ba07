//! Triangles that are within the limit as a whole.
//!
//! A point of a triangle is no farther than the path by way of a corner and straight on. So if the
//! farthest point from a corner is near enough, which is another corner, all of the triangle is.

use super::regions::{RegionShape, WholeTriangle};
use super::roots::TIE;
use super::state::Wavefront;
use crate::geometry::{Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::query::answer::distance;
use crate::query::free_space::FreeSpace;

/// What a root sees of a triangle of the current tile.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) triangle: TriangleId,
    pub(super) vertices: [VertexIndex; 3],
    /// The positions of the vertices, counter-clockwise.
    pub(super) corners: [Point; 3],
    /// The points on the bounding rays: right, then left.
    pub(super) between: Option<[Point; 2]>,
}

impl Wavefront {
    /// From now on keeps each triangle that is known to be within the limit as a whole once, and no
    /// regions of it after that.
    pub(crate) fn keep_whole(&mut self) {
        self.whole.get_or_insert_default();
    }

    /// Takes the triangles that were found to be within the limit since they were last taken.
    pub(crate) fn take_whole(&mut self) -> Vec<WholeTriangle> {
        self.whole.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Keeps what a root sees of a triangle, if regions are kept.
    pub(super) fn keep_part(&mut self, space: FreeSpace<'_>, root: u32, part: Part) {
        let Part { triangle, corners, .. } = part;
        if self.whole.is_some() {
            if self.here.is_whole(triangle) {
                return;
            }
            if self.is_within(root, part) {
                self.here.note_whole(triangle);
                let is_shared = !part.vertices.iter().all(|&vertex| space.tile.has_vertex(vertex));
                self.whole
                    .get_or_insert_default()
                    .push(WholeTriangle { corners, is_shared });
                return;
            }
        }
        let between = part.between;
        self.keep(root, RegionShape::Triangle { corners, between });
    }

    /// Returns whether all of a triangle is known to be within the limit.
    fn is_within(&self, root: u32, part: Part) -> bool {
        let root = &self.roots[root as usize];
        let sees = |p: Point| {
            part.between.is_none_or(|[right, left]| {
                orient2d(root.point, right, p) != Orientation::Clockwise
                    && orient2d(root.point, left, p) != Orientation::CounterClockwise
            })
        };
        let seen = part.corners.map(|corner| {
            let is_seen = sees(corner);
            is_seen.then(|| root.length + distance(root.point, corner))
        });
        if seen
            .iter()
            .all(|length| length.is_some_and(|length| length * TIE <= self.limit))
        {
            return true;
        }
        (0..3).any(|i| {
            let [at, next, last] = [0, 1, 2].map(|turn| part.corners[(i + turn) % 3]);
            let known = self.here.known(part.vertices[i]).min(seen[i].unwrap_or(f64::INFINITY));
            (known + distance(at, next).max(distance(at, last))) * TIE <= self.limit
        })
    }
}
