//! The polygons of `--clip`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
use delaunay_tiles::TileReader;
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::terrain::Clip;

use super::args::ExportArgs;
use crate::common::{self, counted};

/// The polygons of `--clip`, and the text of their coordinate reference system.
type ClipFile = (Clip, Vec<(PathBuf, String)>);

/// Opens the tile file, and reads the polygons of `--clip` first, which take at most half of the memory.
pub async fn open(args: &ExportArgs) -> anyhow::Result<(TileReader, Option<Arc<Clip>>)> {
    let Some(path) = args.clip.clone() else {
        return Ok((args.memory.open(&args.file).await?, None));
    };
    let memory = args.memory.bytes() / 2;
    let (clip, of_clip) = common::on_thread("reading polygons", move || read(&path, memory)).await?;
    let reader = args.memory.open_beside(&args.file, clip.bytes()).await?;
    let of_file = reader.lists().await?.crs.clone().map(|crs| (args.file.clone(), crs));
    args.crs.agree(of_file.iter().chain(&of_clip))?;
    Ok((reader, Some(Arc::new(clip))))
}

/// Reads the polygons of `--clip`, which may take this many bytes of memory.
fn read(path: &Path, memory: u64) -> anyhow::Result<ClipFile> {
    let mut source = SegmentSource::open_obstacles(&[path.to_owned()])?;
    let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
    let most = Clip::MAX_EDGES.min(usize::try_from(memory / Clip::BYTES_PER_EDGE).unwrap_or(usize::MAX));
    while source.next_batch(&mut batch)? {
        edges.extend_from_slice(&batch.ends);
        ensure!(
            edges.len() <= most,
            "{}: polygons to clip by can have {} with this memory, and {} with any; simplify them, or give more \
             --memory",
            common::shown(path),
            counted(most as u64, "edge", "edges"),
            common::thousands(Clip::MAX_EDGES as u64)
        );
    }
    Ok((Clip::new(edges), source.crs_of_files().to_vec()))
}
