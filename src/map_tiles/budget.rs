//! The tiles of a file that a drawing needs, counted before any is read.

use crate::geometry::Rect;
use crate::map_tiles::drawn::{DrawError, DrawLimits};
use crate::store::{TileId, TileReader};

/// How many tiles a drawing needs, and how many it may.
pub(super) struct Budget {
    allowed: u32,
    used: u32,
}

impl Budget {
    pub(super) fn new(limits: DrawLimits) -> Self {
        Self {
            allowed: limits.max_tiles,
            used: 0,
        }
    }

    /// Returns the number of tiles needed so far.
    pub(super) fn used(&self) -> u32 {
        self.used
    }

    /// Returns the tiles of a level that meet a rectangle, and counts them.
    ///
    /// # Errors
    /// If there are more than the drawing may need.
    pub(super) async fn claim(&mut self, level: &TileReader, rect: Rect) -> Result<Vec<TileId>, DrawError> {
        match self.try_claim(level, rect).await? {
            Ok(tiles) => Ok(tiles),
            Err(needed) => Err(DrawError::OutOfBudget {
                needed,
                allowed: self.allowed,
            }),
        }
    }

    /// Returns the same as [`claim`](Self::claim), or, if there are too many, a number of tiles
    /// that are needed at least, and counts nothing.
    pub(super) async fn try_claim(
        &mut self,
        level: &TileReader,
        rect: Rect,
    ) -> Result<Result<Vec<TileId>, u32>, DrawError> {
        let left = self.allowed - self.used;
        // All tiles are known to be needed without reading the directory.
        let all = level.metadata().tiles;
        let bounds = level.metadata().bounds;
        let is_whole = contains(rect, bounds);
        if is_whole && all > left {
            return Ok(Err(self.used.saturating_add(all)));
        }
        let tiles = level.tiles_in(rect, left as usize).await?;
        let count = u32::try_from(tiles.len()).unwrap_or(u32::MAX);
        if count > left {
            return Ok(Err(self.used.saturating_add(count)));
        }
        self.used += count;
        Ok(Ok(tiles))
    }
}

/// Returns whether a rectangle contains another one.
fn contains(outer: Rect, inner: Rect) -> bool {
    outer.min_x <= inner.min_x && outer.min_y <= inner.min_y && inner.max_x <= outer.max_x && inner.max_y <= outer.max_y
}
