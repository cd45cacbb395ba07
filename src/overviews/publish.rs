//! Puts levels into the file: behind all that is there, and then in force at once.

use std::io;
use std::path::Path;

use crate::edit::Target;
use crate::io::{ReadAt, ThreadsFile, WriteAt};
use crate::overviews::error::OverviewError;
use crate::store::{BLOCK, Directory, Overview, OverviewEntry, TileReader, TileWriter};

/// The bytes that are copied at once.
const CHUNK: u64 = 4 << 20;

/// A level to be put into the file.
pub(super) struct Level {
    pub(super) reader: TileReader,
    pub(super) file: ThreadsFile,
    /// The largest error, and the root mean square.
    pub(super) errors: [f64; 2],
}

/// Replaces the overviews of a file by these levels. Nothing that a reader may look at is overwritten; if
/// this fails, the file is in its former state. Returns the length of the file, and its overviews.
pub(super) async fn publish(
    target: &Target,
    base: &TileReader,
    levels: &[Level],
) -> Result<(u64, Vec<Overview>), OverviewError> {
    let generation = base.generation() + 1;
    let mut end = base.file_length();
    let mut entries = Vec::with_capacity(levels.len());
    for level in levels {
        let offset = end.next_multiple_of(BLOCK);
        let bytes = level.reader.file_length();
        let copied = copy(&level.file, bytes, &target.file, offset).await;
        copied.map_err(cannot(&target.path))?;
        let [largest_error, rms_error] = level.errors;
        entries.push(OverviewEntry {
            offset,
            generation,
            crc: level.reader.in_force().superblock.crc(),
            overview: Overview {
                vertices: level.reader.metadata().vertices,
                bytes,
                largest_error,
                rms_error,
            },
        });
        end = offset + bytes;
    }
    let overviews = entries.iter().map(|entry| entry.overview).collect();
    let mut directory = Directory::clone(&*base.directory().await?);
    directory.overviews = entries;
    let writer = TileWriter::behind(target.file.clone(), end);
    let published = writer.replace(&directory, base.in_force()).await;
    let length = published.map_err(cannot(&target.path))?;
    Ok((length, overviews))
}

fn cannot(path: &Path) -> impl FnOnce(io::Error) -> OverviewError {
    OverviewError::io(path, "write the overviews to it")
}

async fn copy(from: &ThreadsFile, bytes: u64, to: &ThreadsFile, offset: u64) -> io::Result<()> {
    let mut done = 0;
    while done < bytes {
        let end = (done + CHUNK).min(bytes);
        let chunk = from.read_at(done..end).await?;
        to.write_at(offset + done, chunk).await?;
        done = end;
    }
    Ok(())
}
