//! Triangles by the positions of their corners, so that those of several triangulations
//! can be compared.

use std::collections::HashSet;

use delaunay_tiles::geometry::Point;

/// The corners of a triangle, counter-clockwise.
pub type Triangle = [Point; 3];

/// A set of triangles.
#[derive(Default)]
pub struct TriangleSet(HashSet<[[u64; 2]; 3]>);

impl TriangleSet {
    /// Returns whether the set has a triangle, whichever corner comes first.
    pub fn has(&self, triangle: &Triangle) -> bool {
        self.0.contains(&key(triangle))
    }

    /// Returns the number of triangles.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

impl<'a> FromIterator<&'a Triangle> for TriangleSet {
    fn from_iter<I: IntoIterator<Item = &'a Triangle>>(triangles: I) -> Self {
        Self(triangles.into_iter().map(key).collect())
    }
}

/// Returns a key of a point.
fn bits(point: Point) -> [u64; 2] {
    [point.x, point.y].map(f64::to_bits)
}

/// Returns a key of a triangle that does not depend on which corner comes first.
fn key(&[a, b, c]: &Triangle) -> [[u64; 2]; 3] {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let first = turns.into_iter().min_by(|one, other| one[0].lex_cmp(other[0]));
    first.unwrap_or(turns[0]).map(bits)
}
