//! Whether one may be at a point.

use super::place::Place;
use crate::geometry::Point;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::TileReader;

/// Whether one may be at a point.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Footing {
    /// One may.
    Free,
    /// It lies in an obstacle.
    InsideObstacle {
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
}

/// Whether one may be somewhere.
impl TileReader {
    /// Whether one may be at a point, and where one may if not.
    ///
    /// [Examples](crate::query#examples).
    ///
    /// # Errors
    /// As [`shortest_path`](Self::shortest_path).
    pub async fn footing(&self, at: Point, options: QueryOptions) -> Result<Footing, QueryError> {
        let mut tiles = Tiles::new(self, &options);
        let place = Place::find(&mut tiles, at).await?;
        if place.is_free {
            return Ok(Footing::Free);
        }
        let nearest_free = place.nearest_free(&mut tiles).await?;
        Ok(Footing::InsideObstacle { nearest_free })
    }
}
