//! The triangles that intersect a rectangle.

use futures::stream;
use futures::stream::{Stream, StreamExt, TryStreamExt};

use super::location::TriangleRef;
use crate::geometry::{Orientation, Point, Rect, orient2d};
use crate::store::{ReadError, TileReader};

/// Triangles in a rectangle.
impl TileReader {
    /// Returns the triangles that intersect the closed rectangle `rect`, each once, in the order of
    /// the tiles. A bound closer to 0 than [`Point::MIN_MAGNITUDE`] counts as 0.
    ///
    /// The stream is `Send + 'static` and must be polled within a tokio runtime. The [example of
    /// the library](crate#examples) uses it.
    pub fn triangles_in(
        &self,
        rect: Rect,
    ) -> impl Stream<Item = Result<TriangleRef, ReadError>> + Send + Unpin + 'static + use<> {
        let least = Point::new(rect.min_x, rect.min_y).representable();
        let most = Point::new(rect.max_x, rect.max_y).representable();
        let rect = Rect::new(least.x, least.y, most.x, most.y);
        let reader = self.clone();
        let tiles = async move {
            let ids = reader.tiles_where(|bounds| bounds.intersects(rect)).await?;
            Ok(stream::iter(ids).then(move |id| {
                let reader = reader.clone();
                async move { reader.tile(id).await }
            }))
        };
        stream::once(tiles)
            .try_flatten()
            .flat_map(move |tile| match tile {
                Err(error) => stream::iter(vec![Err(error)]),
                Ok(tile) => {
                    let meeting = tile
                        .owned_triangles()
                        .filter(|&triangle| triangle_meets(tile.triangle_points(triangle), rect));
                    let found = meeting.map(|triangle| Ok(TriangleRef::of(&tile, triangle)));
                    stream::iter(found.collect::<Vec<_>>())
                }
            })
            .boxed()
    }
}

/// Returns whether a closed triangle, given counter-clockwise, and a closed rectangle intersect: no edge
/// of either separates them. Exact.
///
/// ```
/// use delaunay_tiles::query::triangle_meets;
/// use delaunay_tiles::{Point, Rect};
///
/// let triangle = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]].map(|[x, y]| Point::new(x, y));
/// assert!(triangle_meets(triangle, Rect::new(2.0, 2.0, 9.0, 9.0)));
/// assert!(!triangle_meets(triangle, Rect::new(2.1, 2.1, 9.0, 9.0)));
/// ```
#[must_use]
pub fn triangle_meets(triangle: [Point; 3], rect: Rect) -> bool {
    if rect.is_empty() || !Rect::around(triangle).intersects(rect) {
        return false;
    }
    // The sides of the rectangle are moved in to the triangle's bounds, which also makes them
    // finite.
    let around = Rect::around(triangle);
    let corners = [
        Point::new(rect.min_x.max(around.min_x), rect.min_y.max(around.min_y)),
        Point::new(rect.max_x.min(around.max_x), rect.min_y.max(around.min_y)),
        Point::new(rect.max_x.min(around.max_x), rect.max_y.min(around.max_y)),
        Point::new(rect.min_x.max(around.min_x), rect.max_y.min(around.max_y)),
    ];
    let [a, b, c] = triangle;
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let outside = |&corner: &Point| orient2d(from, to, corner) == Orientation::Clockwise;
        !corners.iter().all(outside)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touching_rectangle_meets_a_triangle_and_a_separate_one_does_not() {
        let triangle = [Point::new(0.0, 0.0), Point::new(4.0, 0.0), Point::new(0.0, 4.0)];
        let infinite = f64::INFINITY;
        for (rect, expected) in [
            (Rect::new(1.0, 1.0, 1.5, 1.5), true),
            (Rect::new(2.0, 2.0, 9.0, 9.0), true),
            (Rect::new(2.1, 2.1, 9.0, 9.0), false),
            (Rect::new(-1.0, -1.0, 0.0, 0.0), true),
            (Rect::new(-9.0, -9.0, 9.0, 9.0), true),
            (Rect::new(-infinite, 3.0, infinite, infinite), true),
            (Rect::new(-infinite, 4.5, infinite, infinite), false),
            (Rect::new(3.0, 0.5, 3.6, infinite), true),
            (Rect::new(3.6, 0.5, infinite, infinite), false),
            (Rect::PLANE, true),
            (Rect::EMPTY, false),
        ] {
            assert_eq!(triangle_meets(triangle, rect), expected, "{rect:?}");
        }
    }
}
