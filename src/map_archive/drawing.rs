//! A map tile as an archive has it.

use std::io::Write;

use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::map_archive::error::ArchiveError;
use crate::map_archive::options::ArchiveOptions;
use crate::map_tiles::{Layer, MapSource, TileCoord};
use crate::store::spawn;

/// Draws a map tile, and compresses it if its format says so. It is empty where the file has nothing.
/// `first` is the first zoom that the layer proposes.
pub(super) async fn draw(
    source: &MapSource,
    options: &ArchiveOptions,
    first: u8,
    at: TileCoord,
) -> Result<(TileCoord, Bytes), ArchiveError> {
    let drawn = source.draw(options.grid, options.layer, at, options.limits()).await;
    let bytes = drawn
        .map_err(|source| ArchiveError::of_drawing(at, first, source))?
        .bytes;
    let bytes = match options.layer {
        Layer::Mesh if !bytes.is_empty() => spawn(move || gzip(&bytes)).await??,
        _ => bytes,
    };
    Ok((at, bytes))
}

/// Returns bytes compressed. The same bytes give the same result: there is no time in it.
fn gzip(bytes: &[u8]) -> Result<Bytes, ArchiveError> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.map(Bytes::from).map_err(ArchiveError::Write)
}
