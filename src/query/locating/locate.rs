//! Which triangle contains a point.

use super::location::Location;
use super::walk::{Locate, Step};
use crate::geometry::Point;
use crate::query::request::representable;
use crate::store::{ReadError, TileReader};

impl TileReader {
    /// Where a point lies. Reads the tile of its cell, and others where the walk to the point enters them. A coordinate closer
    /// to 0 than [`Point::MIN_MAGNITUDE`] counts as 0.
    ///
    /// # Errors
    /// If a tile cannot be read, or tiles contradict each other. A point that is not finite lies outside.
    pub async fn locate(&self, x: f64, y: f64) -> Result<Location, ReadError> {
        let target = Point::new(representable(x), representable(y));
        let directory = self.directory();
        let Some(mut id) = directory.tree.tile_at(target) else {
            return Ok(Location::Outside);
        };
        if !directory.metadata.bounds.contains(target) {
            return Ok(Location::Outside);
        }
        let mut walk = Locate::new(target, directory.metadata.triangles);
        loop {
            let tile = self.tile(id).await?;
            match walk
                .step(&tile)
                .map_err(|contradiction| self.damaged(id, contradiction.to_string()))?
            {
                Step::Need(other) => id = other,
                Step::Done(walked) => return Ok(walked.location),
            }
        }
    }
}
