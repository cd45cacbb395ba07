//! Covers of areas: whole triangles, and pieces of the others.

use foldhash::{HashMap, HashSet};

use super::piece::AreaPiece;
use super::rings::{AreaRings, PointKey, is_clockwise, point_key, rings_of};
use crate::geometry::Point;
use crate::query::wavefront::WholeTriangle;

/// The deviation with which outlines are compared. Only pieces whose difference is smaller may be
/// left out.
const TOLERANCE: f64 = 1e-4;

/// The corners of a triangle, in an order that does not depend on which of them comes first.
type TriangleKey = [PointKey; 3];

fn triangle_key(corners: [Point; 3]) -> TriangleKey {
    let mut keys = corners.map(point_key);
    keys.sort_unstable();
    keys
}

/// An area as the union of triangles, which do not overlap, and of pieces elsewhere.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default)]
pub struct AreaCover {
    /// The half-edges of whole triangles whose twins are not half-edges of whole triangles.
    boundary: HashSet<[PointKey; 2]>,
    /// The whole triangles that several tiles have. Each tile may report them.
    shared: HashSet<TriangleKey>,
    /// The pieces of triangles that are not known to be whole.
    partial: HashMap<TriangleKey, Vec<AreaPiece>>,
    outside: Vec<AreaPiece>,
    /// Whether no limit ended the query.
    is_complete: bool,
}

impl AreaCover {
    /// Adds a triangle that lies in the area as a whole.
    pub(super) fn add_whole(&mut self, triangle: WholeTriangle) {
        let key = triangle_key(triangle.corners);
        if triangle.is_shared && !self.shared.insert(key) {
            return;
        }
        self.partial.remove(&key);
        let keys = triangle.corners.map(point_key);
        for [from, to] in [[0, 1], [1, 2], [2, 0]].map(|ends| ends.map(|i| keys[i])) {
            if !self.boundary.remove(&[to, from]) {
                self.boundary.insert([from, to]);
            }
        }
    }

    /// Adds a piece, which lies in a triangle or outside the hull.
    pub(super) fn add_piece(&mut self, triangle: Option<[Point; 3]>, piece: AreaPiece) {
        match triangle.map(triangle_key) {
            Some(key) if self.shared.contains(&key) => {}
            Some(key) => self.partial.entry(key).or_default().push(piece),
            None => self.outside.push(piece),
        }
    }

    /// Says that the cover has the whole area.
    pub(super) fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Returns the rings around the whole triangles.
    #[must_use]
    pub fn rings(&self) -> AreaRings {
        let mut edges: Vec<[PointKey; 2]> = self.boundary.iter().copied().collect();
        edges.sort_unstable();
        let rings = rings_of(&edges);
        // Without the whole area, nobody knows what is in a hole.
        if !self.is_complete {
            return AreaRings::new(&rings, |_| false);
        }
        let partial = self.partial.keys().flatten();
        let outer = rings.iter().filter(|ring| !is_clockwise(ring)).flatten();
        let met: HashSet<&PointKey> = partial.chain(outer).collect();
        AreaRings::new(&rings, |ring| {
            is_clockwise(ring) && !ring.iter().any(|key| met.contains(key))
        })
    }

    /// Returns the pieces of the triangles that are not whole, and those outside the hull. Pieces
    /// that others contain are left out.
    #[must_use]
    pub fn pieces(&self) -> Vec<AreaPiece> {
        let mut triangles: Vec<_> = self.partial.iter().collect();
        triangles.sort_unstable_by_key(|(key, _)| **key);
        let groups = triangles.into_iter().map(|(_, pieces)| pieces).chain([&self.outside]);
        groups.flat_map(|pieces| maximal(pieces)).collect()
    }
}

/// Returns the pieces that no other one contains.
fn maximal(pieces: &[AreaPiece]) -> Vec<AreaPiece> {
    let mut kept: Vec<AreaPiece> = Vec::new();
    for piece in pieces {
        let outline = piece.outline(TOLERANCE);
        if kept.iter().any(|other| contains(other, &outline)) {
            continue;
        }
        kept.retain(|other| !contains(piece, &other.outline(TOLERANCE)));
        kept.push(piece.clone());
    }
    kept
}

fn contains(piece: &AreaPiece, outline: &[Point]) -> bool {
    outline.iter().all(|&point| piece.contains(point))
}
