//! Makes the overviews of a file, from its lock to its next generation.

use std::path::{Path, PathBuf};
use std::time::Instant;

use futures::future::FutureExt;

use crate::edit::Target;
use crate::io::ThreadsFile;
use crate::overviews::error::OverviewError;
use crate::overviews::errors::measure;
use crate::overviews::levels::build_levels;
use crate::overviews::options::OverviewOptions;
use crate::overviews::publish::{Level, publish};
use crate::overviews::work::{Work, clear};
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
    make_in(path.as_ref(), options).await
}

fn make_in(
    path: &Path,
    options: OverviewOptions,
) -> impl Future<Output = Result<OverviewSummary, OverviewError>> + Send {
    async move {
        let began = Instant::now();
        let target = Target::lock(path)?;
        // Also if there is nothing to do: whoever was killed may have published.
        let folder = clear(path)?;
        let before = target.read().await?;
        let length = before.file_length();
        let summary = |is_new, overviews, file_bytes| OverviewSummary {
            is_new,
            overviews,
            file_bytes: [length, file_bytes],
            seconds: began.elapsed().as_secs_f64(),
        };
        let is_fresh = !before.overviews().is_empty() && !options.again;
        let has_none = before.overviews().is_empty() && before.stale_overviews().is_empty();
        let build = build_options(&before).await?;
        let needs_none = before.metadata().triangles == 0 || before.metadata().vertices <= build.tile_vertices as u64;
        if is_fresh || (needs_none && has_none) {
            return Ok(summary(false, before.overviews().to_vec(), length));
        }
        drop(before);
        let work = Work::new(folder, &options, build)?;
        // Passes read each tile once, so none is kept.
        let open = OpenOptions::default().memory(work.shares.pass()).cache(&Cache::new(0));
        let base = target.open(open).await?;
        let paths = build_levels(&base, &work).await?;
        if paths.is_empty() && has_none {
            return Ok(summary(false, Vec::new(), length));
        }
        let levels = measured(&base, &paths, &work).await?;
        work.check()?;
        let (file_bytes, overviews) = publish(&target, &base, &levels).await?;
        Ok(summary(true, overviews, file_bytes))
    }
    .boxed()
}

/// Opens levels and measures their errors.
async fn measured(base: &TileReader, paths: &[PathBuf], work: &Work) -> Result<Vec<Level>, OverviewError> {
    let mut readers = Vec::with_capacity(paths.len());
    for path in paths {
        readers.push(work.open(path, paths.len()).await?);
    }
    work.progress.start(0, base.metadata().tiles.into());
    let measured = measure(base, &readers, work.threads, || {
        work.progress.advance();
        work.check()
    });
    let measured = measured.await?;
    let mut levels = Vec::with_capacity(paths.len());
    for ((reader, path), measured) in readers.into_iter().zip(paths).zip(measured) {
        levels.push(Level {
            reader,
            file: ThreadsFile::open(path).map_err(OverviewError::io(path, "open it"))?,
            errors: measured.errors(),
        });
    }
    Ok(levels)
}

/// Removes the overviews of a file from its directory, stale ones too. Their bytes stay in the file until
/// it is [compacted](TileReader::compact). What a killed attempt left beside the file is removed too. Returns
/// how many overviews there were.
///
/// # Errors
/// Returns an error if the file cannot be opened, is damaged, or is locked by another editor, or if it
/// cannot be written. The file is then as it was.
pub async fn remove(path: impl AsRef<Path>) -> Result<usize, OverviewError> {
    let target = Target::lock(path.as_ref())?;
    clear(path.as_ref())?;
    let base = target.read().await?;
    let count = base.overviews().len() + base.stale_overviews().len();
    if count > 0 {
        publish(&target, &base, &[]).await?;
    }
    Ok(count)
}

/// Returns the options with which levels of a file are built: its tiles are as large, and as compressed, if
/// this program can do so.
async fn build_options(reader: &TileReader) -> Result<BuildOptions, OverviewError> {
    let directory = reader.directory().await?;
    let first = directory.tile_ids().next().and_then(|id| directory.entry(id).copied());
    let is_compressed = first.is_some_and(|entry| entry.codec() == Codec::Zstandard);
    let tile_vertices = directory.metadata.tile_vertices as usize;
    let tile_vertices = tile_vertices.clamp(BuildOptions::MIN_TILE_VERTICES, BuildOptions::MAX_TILE_VERTICES);
    Ok(BuildOptions::default()
        .tile_vertices(tile_vertices)
        .compress(Codec::HAS_ZSTANDARD && is_compressed))
}
