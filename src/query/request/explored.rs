//! The triangles that a search passed, for pictures of it.

use std::sync::Arc;

use foldhash::HashSet;
use parking_lot::Mutex;

use crate::geometry::Point;

/// Collects the triangles that searches pass: see
/// [`QueryOptions::explored`](crate::query::request::options::QueryOptions::explored). Its memory
/// grows with the number of triangles.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, Default)]
pub struct Explored(Arc<Mutex<HashSet<[u64; 6]>>>);

/// Returns a key of a triangle that does not depend on which corner comes first.
pub(crate) fn key(corners: [Point; 3]) -> [u64; 6] {
    let first = (0..3).min_by(|&a, &b| corners[a].lex_cmp(corners[b])).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|i| corners[(first + i) % 3]);
    [a.x, a.y, b.x, b.y, c.x, c.y].map(f64::to_bits)
}

impl Explored {
    /// Returns the triangles, each once, in no order.
    #[must_use]
    pub fn triangles(&self) -> Vec<[Point; 3]> {
        let triangles = self.0.lock();
        let corners = |key: &[u64; 6]| {
            let [ax, ay, bx, by, cx, cy] = key.map(f64::from_bits);
            [Point::new(ax, ay), Point::new(bx, by), Point::new(cx, cy)]
        };
        triangles.iter().map(corners).collect()
    }

    pub(crate) fn add(&self, triangles: impl Iterator<Item = [Point; 3]>) {
        self.0.lock().extend(triangles.map(key));
    }
}
