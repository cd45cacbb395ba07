//! Whether a point is free.

use super::query_point::QueryPoint;
use crate::geometry::Point;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::TileReader;
use futures::future::FutureExt;

/// Whether a point is free, that is, not in an obstacle.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Footing {
    /// The point is free.
    Free,
    /// The point is in an obstacle.
    InsideObstacle {
        /// The nearest free point, rounded; `None` if no point is free.
        nearest_free: Option<Point>,
    },
}

/// Free and blocked points.
impl TileReader {
    /// Returns whether the point `at` is free, and the nearest free point if it is not.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// As [`shortest_path`](Self::shortest_path).
    pub fn footing(
        &self,
        at: Point,
        options: QueryOptions,
    ) -> impl Future<Output = Result<Footing, QueryError>> + Send {
        async move {
            let mut tiles = Tiles::new(self, &options);
            let query_point = QueryPoint::find(&mut tiles, at).await?;
            if query_point.is_free {
                return Ok(Footing::Free);
            }
            let nearest_free = query_point.nearest_free(&mut tiles).await?;
            Ok(Footing::InsideObstacle { nearest_free })
        }
        .boxed()
    }
}
