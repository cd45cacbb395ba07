//! Makes the overviews of a file, from its lock to its next generation.

use std::path::Path;
use std::time::Instant;

use crate::edit::Target;
use crate::io::ThreadsFile;
use crate::overviews::error::OverviewError;
use crate::overviews::errors::measure;
use crate::overviews::levels::build_levels;
use crate::overviews::options::OverviewOptions;
use crate::overviews::publish::{Level, publish};
use crate::overviews::work::Work;
use crate::pipeline::BuildOptions;
use crate::store::{Cache, Codec, OpenOptions, Overview, TileReader};

/// What was made.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct OverviewSummary {
    /// Whether anything was made. Nothing is if the file has overviews that are not stale, or if it has one
    /// tile only, or no triangles.
    pub is_new: bool,
    /// The overviews that the file has now, from the finest to the coarsest.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub overviews: Vec<Overview>,
    /// The length of the file in bytes before, and now.
    pub file_bytes: [u64; 2],
    /// How long it took.
    pub seconds: f64,
}

/// Makes the overviews of a file on disk. Those that it has are replaced if they are stale. Must be awaited
/// within a tokio runtime.
///
/// The file is locked against edits meanwhile. Readers may have it open, and see it as it was when they
/// opened it. Work is in the folder `FILE.overviews.partial` beside it, which takes about as many bytes as
/// the overviews do, and is removed at the end.
///
/// See the [module](super) for an example.
///
/// # Errors
/// Returns an error if the file cannot be opened, is damaged, or is locked by another editor, if there is
/// too little memory or room on the disk, or if it is cancelled. The file is then as it was.
pub async fn make(path: impl AsRef<Path>, options: OverviewOptions) -> Result<OverviewSummary, OverviewError> {
    let began = Instant::now();
    let target = Target::lock(path.as_ref())?;
    let before = target.read().await?;
    let (metadata, length) = (before.metadata().clone(), before.file_length());
    let is_fresh = !before.overviews().is_empty() && !options.again;
    let tile_vertices =
        (metadata.tile_vertices as usize).clamp(BuildOptions::MIN_TILE_VERTICES, BuildOptions::MAX_TILE_VERTICES);
    let needs_none = metadata.triangles == 0 || metadata.vertices <= tile_vertices as u64;
    let has_none = before.overviews().is_empty() && before.stale_overviews().is_empty();
    if is_fresh || (needs_none && has_none) {
        return Ok(OverviewSummary {
            is_new: false,
            overviews: before.overviews().to_vec(),
            file_bytes: [length; 2],
            seconds: began.elapsed().as_secs_f64(),
        });
    }
    let build = BuildOptions::default()
        .tile_vertices(tile_vertices)
        .compress(is_compressed(&before).await?);
    drop(before);
    let work = Work::new(path.as_ref(), &options, build)?;
    let cache = Cache::new(0);
    let base = target
        .open(OpenOptions::default().memory(work.shares.pass()).cache(&cache))
        .await?;
    let paths = build_levels(&base, &work).await?;
    let mut readers = Vec::with_capacity(paths.len());
    for path in &paths {
        let cache = Cache::new(work.shares.coarser(paths.len()) as usize);
        let options = OpenOptions::default().memory(work.shares.pass()).cache(&cache);
        readers.push(TileReader::open(path, options).await?);
    }
    work.progress.start(0, metadata.tiles.into());
    let measured = measure(&base, &readers, work.threads, || {
        work.progress.advance();
        work.check()
    });
    let measured = measured.await?;
    let mut levels = Vec::with_capacity(paths.len());
    for ((reader, path), measured) in readers.into_iter().zip(&paths).zip(measured) {
        levels.push(Level {
            reader,
            file: ThreadsFile::open(path).map_err(OverviewError::io(path, "open it"))?,
            errors: measured.errors(),
        });
    }
    work.check()?;
    let (file_bytes, overviews) = publish(&target, &base, &levels).await?;
    Ok(OverviewSummary {
        is_new: true,
        overviews,
        file_bytes: [length, file_bytes],
        seconds: began.elapsed().as_secs_f64(),
    })
}

/// Removes the overviews of a file from its directory, stale ones too. Their bytes stay in the file until
/// it is [compacted](TileReader::compact). Returns how many there were.
///
/// # Errors
/// Returns an error if the file cannot be opened, is damaged, or is locked by another editor, or if it
/// cannot be written. The file is then as it was.
pub async fn remove(path: impl AsRef<Path>) -> Result<usize, OverviewError> {
    let target = Target::lock(path.as_ref())?;
    let base = target.read().await?;
    let count = base.overviews().len() + base.stale_overviews().len();
    if count > 0 {
        publish(&target, &base, &[]).await?;
    }
    Ok(count)
}

/// Returns whether the tiles of a file are compressed, and this program can do so too.
async fn is_compressed(reader: &TileReader) -> Result<bool, OverviewError> {
    let directory = reader.directory().await?;
    let first = directory.tile_ids().next().and_then(|id| directory.entry(id).copied());
    Ok(Codec::HAS_ZSTANDARD && first.is_some_and(|entry| entry.codec() == Codec::Zstandard))
}
