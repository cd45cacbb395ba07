//! Rewrites a file without the bytes that edits have left unused: cores, borders and the directory,
//! in the order of a new file.
//!
//! Tiles are copied unchanged after a check of their checksums. Nothing is computed, and readers
//! see the same tiles.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::io::{OutputFile, ThreadsFile};
use crate::shown;
use crate::store::directory_writer::front_end_for;
use crate::store::error::ReadError;
use crate::store::format::codec::StoredPart;
use crate::store::format::directory::Directory;
use crate::store::format::entry::{Extent, TileEntry};
use crate::store::format::ids::TileId;
use crate::store::reader::TileReader;
use crate::store::writer::TileWriter;

/// The number of extents that are read at a time.
const AHEAD: usize = 2;

/// The reason why a file could not be rewritten. The existing file is unchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompactError {
    /// The file cannot be read, or is damaged.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The operating system returned an error.
    #[error("{file}: cannot {what}", file = shown::path(file))]
    Io {
        /// The file to be written.
        file: PathBuf,
        /// The operation that failed.
        what: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Returns stored bytes to write again as they are.
fn copied(bytes: Bytes, extent: Extent) -> StoredPart {
    StoredPart {
        bytes,
        codec: extent.codec,
        decoded: extent.decoded as usize,
    }
}

impl TileReader {
    /// Writes a copy of the file to `output`, in the order of its tiles and without unused bytes. A
    /// file of that name is replaced atomically when all is written; it may be the file itself.
    /// Returns the length of the new file in bytes.
    ///
    /// The file must not be edited meanwhile.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read or is damaged, or if the output cannot be
    /// written.
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
        let before = self.directory().await?;
        let front_end = front_end_for(before.metadata.tiles.into());
        let mut writer = TileWriter::new(ThreadsFile::from(Arc::new(file)), front_end);
        let mut tiles = before.tiles.clone();
        // The next extents are read while one is written.
        let used = || before.tile_ids().map(|id| (id, before.tiles[id.0 as usize]));
        let mut cores = stream::iter(used().map(|(id, entry)| self.extent(id, entry, entry.core)))
            .buffered(AHEAD)
            .boxed();
        for id in before.tile_ids() {
            let Some(core) = cores.try_next().await? else { break };
            let entry = &mut tiles[id.0 as usize];
            let core = copied(core, entry.core);
            entry.core = writer.append_core(core).await.map_err(cannot("write"))?;
        }
        let borders = used().map(|(id, entry)| self.extent(id, entry, entry.border));
        let mut borders = stream::iter(borders).buffered(AHEAD).boxed();
        for id in before.tile_ids() {
            let Some(border) = borders.try_next().await? else { break };
            let entry = &mut tiles[id.0 as usize];
            let border = copied(border, entry.border);
            entry.border = writer.append_border(border).await.map_err(cannot("write"))?;
        }
        let directory = Directory::new(
            before.metadata.clone(),
            before.lists.clone(),
            before.tree.clone(),
            tiles,
        );
        let finished = writer.finish_copy(&directory, self.in_force()).await;
        let length = finished.map_err(cannot("write"))?;
        if let Ok(before) = std::fs::metadata(output) {
            // Keep the permissions of the replaced file; a new partial file is readable by its
            // owner only.
            let _ = partial.file().set_permissions(before.permissions());
        }
        partial.publish().map_err(cannot("replace it"))?;
        Ok(length)
    }

    /// Reads a core or a border and checks its checksum.
    async fn extent(&self, tile: TileId, entry: TileEntry, extent: Extent) -> Result<Bytes, CompactError> {
        let bytes = self.read_extent(tile, &entry, extent).await?;
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
