//! Draws the map tiles of an archive, and writes them in its order.

use std::collections::VecDeque;
use std::io::{Seek, Write};
use std::sync::atomic::Ordering;

use bytes::Bytes;
use futures::stream::{self, StreamExt, TryStreamExt};
use pmtiles::PmTilesStreamWriter;

use crate::map_archive::descent::Descent;
use crate::map_archive::drawing::draw;
use crate::map_archive::error::ArchiveError;
use crate::map_archive::header::writer;
use crate::map_archive::measured::Measured;
use crate::map_archive::plan::ArchivePlan;
use crate::map_tiles::{MapSource, TileCoord};
use crate::store::spawn;

/// The bytes of tiles that are written at once.
const BATCH: usize = 1 << 20;
/// The number of tiles that are written at once at most.
const MANY: usize = 256;

/// The summary of a written archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ArchiveSummary {
    /// The number of map tiles.
    pub tiles: u64,
    /// The number of bytes.
    pub bytes: u64,
}

/// Writes an archive. Must be awaited within a tokio runtime.
///
/// The output must be empty. It is written on threads for blocking work; the header comes last, so
/// an output that is not complete is no archive. `progress` is called with the number of map tiles done
/// and their total. If the future is dropped, nothing more is drawn.
///
/// Memory: [`DIRECTORY`](ArchivePlan::DIRECTORY) for each map tile, some mebibytes for each that is
/// drawn at once, and the cache of the source.
///
/// # Errors
/// If a map tile cannot be drawn, if the output fails or cannot be written out of order, or if no map
/// tile has content.
pub async fn write<W: Write + Seek + Send + 'static>(
    source: &MapSource,
    plan: &ArchivePlan,
    output: W,
    mut progress: impl FnMut(u64, u64) + Send,
) -> Result<ArchiveSummary, ArchiveError> {
    let (output, length) = Measured::new(output).map_err(ArchiveError::Write)?;
    let header = writer(source, plan).await?;
    let mut archive = Archive {
        writer: spawn(move || header.create(output)).await??,
        tiles: 0,
    };
    let descents = (plan.zooms.first()..=plan.zooms.last())
        .map(|zoom| Descent::new(source, plan.options.grid, plan.options.layer, zoom))
        .collect::<VecDeque<_>>();
    let drawn = stream::try_unfold(descents, next)
        .map_ok(|at| draw(source, &plan.options, plan.facts.min_zoom, at))
        .try_buffered(plan.options.at_once);
    let mut drawn = std::pin::pin!(drawn);
    let (mut batch, mut size, mut done) = (Vec::new(), 0, 0);
    while let Some((at, bytes)) = drawn.next().await.transpose()? {
        done += 1;
        progress(done, plan.tiles());
        size += bytes.len();
        batch.push((at, bytes));
        if size >= BATCH || batch.len() >= MANY {
            archive = archive.add(std::mem::take(&mut batch)).await?;
            size = 0;
        }
    }
    let Archive { writer, tiles } = archive.add(batch).await?;
    if tiles == 0 {
        return Err(ArchiveError::Nothing(plan.zooms));
    }
    spawn(move || writer.finalize()).await??;
    let bytes = length.load(Ordering::Relaxed);
    Ok(ArchiveSummary { tiles, bytes })
}

/// Returns the next tile of the first descent that has one, and the descents that are left.
async fn next(mut descents: VecDeque<Descent>) -> Result<Option<(TileCoord, VecDeque<Descent>)>, ArchiveError> {
    while let Some(descent) = descents.front_mut() {
        if let Some(at) = descent.next().await? {
            return Ok(Some((at, descents)));
        }
        descents.pop_front();
    }
    Ok(None)
}

/// An archive that is being written.
struct Archive<W: Write + Seek> {
    writer: PmTilesStreamWriter<Measured<W>>,
    tiles: u64,
}

impl<W: Write + Seek + Send + 'static> Archive<W> {
    /// Adds tiles but for empty ones. Tiles with the same bytes are stored once.
    async fn add(mut self, batch: Vec<(TileCoord, Bytes)>) -> Result<Self, ArchiveError> {
        let add = move || {
            for (at, bytes) in batch.iter().filter(|(_, bytes)| !bytes.is_empty()) {
                let at = pmtiles::TileCoord::new(at.z(), at.x(), at.y())?;
                self.writer.add_tile(at, bytes)?;
                self.tiles += 1;
            }
            Ok(self)
        };
        spawn(add).await?
    }
}
