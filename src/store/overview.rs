//! Coarser triangulations of the same surface, stored in the same file.

use crate::store::error::ReadError;
use crate::store::reader::TileReader;

/// A level of detail: the Delaunay triangulation of a subset of the vertices of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Overview {
    /// The number of vertices.
    pub vertices: u64,
    /// The largest difference of height between the overview and the file at a vertex of the file,
    /// in units of z; 0 without z.
    pub largest_error: f64,
    /// The root mean square of these differences over all vertices of the file; 0 without z.
    pub rms_error: f64,
}

impl TileReader {
    /// Returns the overviews of the file, from the finest to the coarsest; none if they are stale.
    #[must_use]
    pub fn overviews(&self) -> &[Overview] {
        &[]
    }

    /// Opens the overview at this place of [`overviews`](Self::overviews). It shares the cache of
    /// this reader.
    ///
    /// # Errors
    ///
    /// Returns an error if the overview cannot be read or is damaged.
    ///
    /// # Panics
    ///
    /// If there is no such overview.
    #[expect(clippy::unused_async, reason = "it will read")]
    pub async fn overview(&self, level: usize) -> Result<TileReader, ReadError> {
        let _ = self.overviews()[level];
        Ok(self.clone())
    }
}
