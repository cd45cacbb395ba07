//! What is at many points: free ground, a hole, or nothing.

use std::sync::Arc;

use super::at_spot::{Found, Rest, find, find_rest};
use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::walk::Spot;
use crate::geometry::Point;
use crate::query::request::Contradiction;
use crate::store::{ReadError, Tile, TileId, TileReader};

/// What is at a point of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ground {
    /// Nothing: the point is outside the hull.
    Outside,
    /// A triangle in no hole. Its edges and corners count too.
    Free,
    /// Only triangles in holes.
    Hole,
}

impl TileReader {
    /// Returns what is at points, in their order. It depends on the triangulation alone, and not on
    /// its tiles. Points are located as by [`locate_many`](Self::locate_many).
    ///
    /// # Errors
    /// As [`locate_many`](Self::locate_many).
    ///
    /// # Panics
    /// If there are more than 2³² points.
    pub(crate) async fn ground_many(
        &self,
        points: Arc<[Point]>,
        options: BulkOptions,
    ) -> Result<Vec<Ground>, ReadError> {
        let all_free = self.metadata().triangles == 0;
        ask(self, points, options, WhatIsThere { all_free }, Ground::Outside).await
    }
}

/// The question what is at a point.
struct WhatIsThere {
    /// Whether all vertices are free, because there are no triangles.
    all_free: bool,
}

impl Question for WhatIsThere {
    type Answer = Ground;
    type Errand = Rest;
    type InTile = ();

    fn in_tile(&self, _: &Tile) {}

    fn answer(&self, at: &At<'_, ()>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        let found = match spot {
            Spot::Outside(_) => return Ok(Outcome::Answer(Ground::Outside)),
            _ if self.all_free => return Ok(Outcome::Answer(Ground::Free)),
            _ => find(at.tile, spot, |triangle| !at.tile.is_hole(triangle)),
        };
        Ok(match found {
            Found::In(_) => Outcome::Answer(Ground::Free),
            Found::None => Outcome::Answer(Ground::Hole),
            Found::Ask(tile, rest) => Outcome::Ask(tile, rest),
        })
    }

    fn finish(&self, at: &At<'_, ()>, rest: Rest) -> Result<Ground, Contradiction> {
        let found = find_rest(at.tile, &rest, |triangle| !at.tile.is_hole(triangle))?;
        Ok(found.map_or(Ground::Hole, |_| Ground::Free))
    }
}
