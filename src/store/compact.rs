//! Writes a file anew without what edits have left behind: cores, borders and the directory, in the order of a new file.
//!
//! Tiles are copied as they are, checksums checked; so nothing is computed, and what a reader sees is the same.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::io::{OutputFile, ThreadsFile};
use crate::shown;
use crate::store::error::ReadError;
use crate::store::format::directory::{Extent, TileEntry};
use crate::store::format::ids::TileId;
use crate::store::reader::TileReader;
use crate::store::writer::TileWriter;

/// Extents that are read at a time.
const AHEAD: usize = 2;

/// Why a file could not be written anew. What was there is still there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompactError {
    /// The file cannot be read, or is damaged.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The system refused.
    #[error("{file}: cannot {what}", file = shown::path(file))]
    Io {
        /// The file that was to be written.
        file: PathBuf,
        /// What was to be done.
        what: &'static str,
        /// What the system says.
        source: io::Error,
    },
}

impl TileReader {
    /// Writes the file anew, under this name, in the order of its tiles and without unused bytes. What has the name is replaced at once
    /// when all is written; the file itself may be meant. Returns the length of the new file in bytes.
    ///
    /// Nobody must edit the file meanwhile.
    ///
    /// # Errors
    /// If the file cannot be read or is damaged, or the other cannot be written.
    pub async fn compact(&self, output: impl AsRef<Path>) -> Result<u64, CompactError> {
        let output = output.as_ref();
        let cannot = |what: &'static str| {
            move |source| CompactError::Io {
                file: output.to_owned(),
                what,
                source,
            }
        };
        let partial = OutputFile::create(output).map_err(cannot("write it"))?;
        let file = partial.file().try_clone().map_err(cannot("write"))?;
        let mut writer = TileWriter::new(ThreadsFile::from(Arc::new(file)));
        let mut directory = self.directory().clone();
        // The next ones are read while one is written.
        let tiles = || self.directory().tiles.iter().zip((0..).map(TileId));
        let mut cores = stream::iter(tiles().map(|(entry, id)| self.extent(id, entry, entry.core))).buffered(AHEAD);
        for entry in &mut directory.tiles {
            let Some(core) = cores.try_next().await? else { break };
            entry.core = writer.append_core(&core).await.map_err(cannot("write"))?;
        }
        let borders = tiles().map(|(entry, id)| self.extent(id, entry, entry.border));
        let mut borders = stream::iter(borders).buffered(AHEAD);
        for entry in &mut directory.tiles {
            let Some(border) = borders.try_next().await? else { break };
            entry.border = writer.append_border(&border).await.map_err(cannot("write"))?;
        }
        let finished = writer.finish_as(&directory, self.generation()).await;
        let length = finished.map_err(cannot("write"))?;
        if let Ok(before) = std::fs::metadata(output) {
            // As before, not for its owner's eyes only.
            let _ = partial.file().set_permissions(before.permissions());
        }
        partial.publish().map_err(cannot("replace it"))?;
        Ok(length)
    }

    /// The bytes of a core or a border, with the right checksum.
    async fn extent(&self, tile: TileId, entry: &TileEntry, extent: Extent) -> Result<Bytes, CompactError> {
        let bytes = self.read_extent(tile, entry, extent).await?;
        let found = crc32c::crc32c(&bytes);
        if found != extent.crc {
            let reason = format!(
                "the checksum at byte {} is {found:08x}, not {:08x}",
                extent.offset, extent.crc
            );
            return Err(self.damaged(tile, reason).into());
        }
        Ok(bytes)
    }
}
