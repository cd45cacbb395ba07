//! Overviews: coarser triangulations of the same surface, each a whole tile file within the file.

use crate::store::error::ReadError;
use crate::store::format::overview::{Overview, OverviewEntry};
use crate::store::reader::TileReader;
use futures::future::FutureExt;

impl TileReader {
    /// Returns the overviews of the file, from the finest to the coarsest. Each is the Delaunay
    /// triangulation of about a quarter of the vertices of the one before; the first one, of a quarter of
    /// the file's. There are none if none were [made](crate::overviews::make), or if the file was edited
    /// since.
    #[must_use]
    pub fn overviews(&self) -> &[Overview] {
        &self.overview_entries().fresh
    }

    /// Returns the overviews that were made before the last edit of the file, and must be
    /// [made](crate::overviews::make) anew.
    #[must_use]
    pub fn stale_overviews(&self) -> &[Overview] {
        &self.overview_entries().stale
    }

    /// Opens the overview at this place of [`overviews`](Self::overviews). Its reader is like that of any
    /// other file, and shares the cache of this one.
    ///
    /// # Errors
    ///
    /// Returns an error if the overview cannot be read or is damaged.
    ///
    /// # Panics
    ///
    /// If there is no such overview.
    pub fn overview(&self, level: usize) -> impl Future<Output = Result<TileReader, ReadError>> + Send {
        async move {
            let OverviewEntry {
                offset, crc, overview, ..
            } = self.overview_entries().places[level];
            let name = format!("{}, overview {}", self.name(), level + 1);
            let opened = self.open_section(offset..offset + overview.bytes, &name).await?;
            let found = opened.in_force().superblock;
            let is_as_said = found.crc() == crc
                && found.file_length == overview.bytes
                && opened.metadata().vertices == overview.vertices
                && opened.metadata().has_z == self.metadata().has_z;
            match is_as_said {
                true => Ok(opened),
                false => Err(ReadError::Invalid {
                    file: name.into(),
                    reason: "it is not the overview that the directory of the file describes".to_owned(),
                }),
            }
        }
        .boxed()
    }
}
