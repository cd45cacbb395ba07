//! Rewrites a file without the bytes that edits have left unused: cores, borders and the directory,
//! in the order of a new file.
//!
//! Tiles are copied unchanged after a check of their checksums. Nothing is computed, and readers
//! see the same tiles.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use futures::future::FutureExt;
use futures::stream;
use futures::stream::{StreamExt, TryStreamExt};

use crate::io::{OutputFile, Section, ThreadsFile, WriteAt, is_manifest};
use crate::shown;
use crate::store::directory_writer::{front_end_for, front_end_of_copy};
use crate::store::error::ReadError;
use crate::store::format::codec::StoredPart;
use crate::store::format::directory::Directory;
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::ids::TileId;
use crate::store::format::limits::BLOCK;
use crate::store::format::overview::{Overview, OverviewEntry};
use crate::store::format::superblock::Superblock;
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

/// The file that is written, for errors.
struct Cannot<'a>(&'a Path);

impl Cannot<'_> {
    fn to(&self, what: &'static str) -> impl FnOnce(io::Error) -> CompactError {
        move |source| CompactError::Io {
            file: self.0.to_owned(),
            what,
            source,
        }
    }
}

/// Returns the bytes of an extent, whose checksum was checked, to write them again as they are.
fn copied(bytes: Bytes, extent: Extent) -> StoredPart {
    StoredPart {
        bytes,
        crc: extent.crc,
        codec: extent.codec,
        decoded: extent.decoded as usize,
    }
}

impl TileReader {
    /// Writes a copy of the file to `output`, in the order of its tiles and without unused bytes. A
    /// file of that name is replaced atomically when all is written; it may be the file itself.
    /// [Overviews](Self::overviews) are copied too, unless they are stale. Returns the length of the
    /// new file in bytes.
    ///
    /// The file must not be edited meanwhile.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read or is damaged, or if the output cannot be
    /// written.
    pub async fn compact(&self, output: impl AsRef<Path>) -> Result<u64, CompactError> {
        self.compact_to(output.as_ref().to_owned()).await
    }

    fn compact_to(&self, output: PathBuf) -> impl Future<Output = Result<u64, CompactError>> + Send {
        async move {
            let output = &*output;
            let cannot = Cannot(output);
            if is_manifest(output) {
                let reason = "a name that ends with .parts is that of a file in parts; this makes one file";
                return Err(cannot.to("write it")(io::Error::new(
                    io::ErrorKind::InvalidInput,
                    reason,
                )));
            }
            let partial = OutputFile::create(output).map_err(cannot.to("write it"))?;
            let file = partial.file().try_clone().map_err(cannot.to("write"))?;
            let file = ThreadsFile::from(Arc::new(file));
            let (tiles, overviews) = (self.metadata().tiles, self.overviews().len());
            let mut writer = TileWriter::new(file.clone(), front_end_of_copy(tiles.into(), overviews));
            let mut directory = self.copy_tiles(&mut writer, &cannot).await?;
            for (level, &entry) in self.overview_entries().places.iter().enumerate() {
                let overview = self.overview(level).await?;
                let offset = writer.length().next_multiple_of(BLOCK);
                let copied = overview.copy_overview(file.clone(), offset, &cannot).await?;
                writer
                    .pass_over(offset + copied.file_length)
                    .await
                    .map_err(cannot.to("write"))?;
                directory.overviews.push(OverviewEntry {
                    offset,
                    crc: copied.crc(),
                    overview: Overview {
                        bytes: copied.file_length,
                        ..entry.overview
                    },
                    ..entry
                });
            }
            let finished = writer.finish_copy(&directory, self.in_force()).await;
            let length = finished.map_err(cannot.to("write"))?.file_length;
            if let Ok(before) = std::fs::metadata(output) {
                // Keep the permissions of the replaced file; a new partial file is readable by its
                // owner only.
                let _ = partial.file().set_permissions(before.permissions());
            }
            partial.publish().map_err(cannot.to("replace it"))?;
            Ok(length)
        }
        .boxed()
    }

    /// Copies an overview to `offset` in the copy of its file. Returns its superblock.
    async fn copy_overview(
        &self,
        file: ThreadsFile,
        offset: u64,
        cannot: &Cannot<'_>,
    ) -> Result<Superblock, CompactError> {
        let front_end = front_end_for(self.metadata().tiles.into());
        // What the whole file is synced with.
        let mut writer = TileWriter::new(Section::from(file, offset), front_end).draft(true);
        let directory = self.copy_tiles(&mut writer, cannot).await?;
        let finished = writer.finish_copy(&directory, self.in_force()).await;
        finished.map_err(cannot.to("write"))
    }

    /// Copies all tiles in their order. Returns the directory of the copy, without overviews.
    async fn copy_tiles<W: WriteAt>(
        &self,
        writer: &mut TileWriter<W>,
        cannot: &Cannot<'_>,
    ) -> Result<Directory, CompactError> {
        let before = self.directory().await?;
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
            entry.core = writer.append_core(core).await.map_err(cannot.to("write"))?;
        }
        let borders = used().map(|(id, entry)| self.border_and_table(id, entry));
        let mut borders = stream::iter(borders).buffered(AHEAD).boxed();
        for id in before.tile_ids() {
            let Some((border, table)) = borders.try_next().await? else {
                break;
            };
            let entry = &mut tiles[id.0 as usize];
            let border = copied(border, entry.border);
            entry.border = writer.append_border(border).await.map_err(cannot.to("write"))?;
            if let Some(table) = table {
                entry.table = writer.place_table(table.into()).await.map_err(cannot.to("write"))?;
            }
        }
        Ok(Directory::new(
            before.metadata.clone(),
            before.lists.clone(),
            before.tree.clone(),
            tiles,
        ))
    }

    /// Reads a border, and the component table if that lies apart, and checks their checksums.
    async fn border_and_table(&self, id: TileId, entry: TileEntry) -> Result<(Bytes, Option<Bytes>), CompactError> {
        let border = self.extent(id, entry, entry.border).await?;
        Ok(match entry.table.apart() {
            Some(extent) => (border, Some(self.extent(id, entry, extent).await?)),
            None => (border, None),
        })
    }

    /// Reads an extent of a tile and checks its checksum.
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
