//! Covers of areas: whole triangles, and pieces of the others.

use foldhash::{HashMap, HashSet};

use super::piece::AreaPiece;
use crate::geometry::Point;
use crate::query::wavefront::WholeTriangle;

/// The deviation with which outlines are compared. Only pieces whose difference is smaller may be
/// left out.
const TOLERANCE: f64 = 1e-4;

/// The bits of a point.
type PointKey = [u64; 2];

fn point_key(p: Point) -> PointKey {
    [p.x, p.y].map(|x| (x + 0.0).to_bits())
}

fn point_of(key: PointKey) -> Point {
    let [x, y] = key.map(f64::from_bits);
    Point::new(x, y)
}

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

    /// Returns rings round the whole triangles, which are on the left of each ring. The points are
    /// vertices, and the first one is not repeated at the end. A ring may touch itself and others.
    #[must_use]
    pub fn rings(&self) -> Vec<Vec<Point>> {
        let mut edges: Vec<[PointKey; 2]> = self.boundary.iter().copied().collect();
        edges.sort_unstable();
        let mut is_used = vec![false; edges.len()];
        let mut rings = Vec::new();
        for first in 0..edges.len() {
            let mut ring = Vec::new();
            let mut at = Some(first);
            while let Some(edge) = at.filter(|&edge| !is_used[edge]) {
                is_used[edge] = true;
                let [from, to] = edges[edge];
                ring.push(point_of(from));
                let next = edges.partition_point(|edge| edge[0] < to);
                let leaving = (next..edges.len()).take_while(|&edge| edges[edge][0] == to);
                at = leaving.into_iter().find(|&edge| !is_used[edge]);
            }
            if !ring.is_empty() {
                rings.push(ring);
            }
        }
        rings
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
