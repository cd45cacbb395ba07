//! Options of several commands that limit the surface: lengths and polygons.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
use delaunay_tiles::TileReader;
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::terrain::Clip;

use crate::common::{self, MemoryArgs, counted};
use crate::crs::CrsArgs;

/// The polygons of a file, and the text of their coordinate reference system.
type ClipFile = (Clip, Vec<(PathBuf, String)>);

/// Opens a tile file, and reads polygons to which an output is limited first, if there are any. They take
/// at most half of the memory.
///
/// # Errors
/// Fails if a file cannot be read, if the polygons take too much memory, or if they have another coordinate
/// reference system than the tile file.
pub async fn open_clipped(
    file: &Path,
    clip: Option<&Path>,
    crs: &CrsArgs,
    memory: &MemoryArgs,
) -> anyhow::Result<(TileReader, Option<Arc<Clip>>)> {
    let Some(path) = clip.map(Path::to_owned) else {
        return Ok((memory.open(file).await?, None));
    };
    let most = memory.bytes() / 2;
    let (clip, of_clip) = common::on_thread("reading polygons", move || read(&path, most)).await?;
    let reader = memory.open_beside(file, clip.bytes()).await?;
    let of_file = reader.lists().await?.crs.clone().map(|crs| (file.to_owned(), crs));
    crs.agree(of_file.iter().chain(&of_clip))?;
    Ok((reader, Some(Arc::new(clip))))
}

/// Reads the polygons of a file, which may take this many bytes of memory.
fn read(path: &Path, memory: u64) -> anyhow::Result<ClipFile> {
    let mut source = SegmentSource::open_obstacles(&[path.to_owned()])?;
    let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
    let most = Clip::MAX_EDGES.min(usize::try_from(memory / Clip::BYTES_PER_EDGE).unwrap_or(usize::MAX));
    while source.next_batch(&mut batch)? {
        edges.extend_from_slice(&batch.ends);
        ensure!(
            edges.len() <= most,
            "{}: the polygons can have {} with this memory, and {} with any; simplify them, or give more \
             --memory",
            common::shown(path),
            counted(most as u64, "edge", "edges"),
            common::thousands(Clip::MAX_EDGES as u64)
        );
    }
    Ok((Clip::new(edges), source.crs_of_files().to_vec()))
}
