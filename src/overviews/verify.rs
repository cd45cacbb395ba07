//! Proves that overviews are what they should be.

use std::thread::available_parallelism;

use crate::overviews::errors::{Measured, measure};
use crate::store::{Overview, ReadError, TileReader, VerifyError};

/// Checks the overviews of a file that are not stale: that each is a sound tile file. With `deep`, proves
/// that each is the Delaunay triangulation, without constraints, of vertices of the level below, with
/// their z, that the corners of the hull are among them, and that its errors are what the file says. The
/// file itself must have been [verified](TileReader::verify). Returns how many overviews there are.
///
/// # Errors
/// Returns the first fault, or an error if a tile does not fit into the memory that the reader may use.
pub async fn verify(reader: &TileReader, deep: bool) -> Result<usize, VerifyError> {
    let overviews = reader.overviews();
    let mut levels = Vec::with_capacity(overviews.len());
    for level in 0..overviews.len() {
        let opened = reader.overview(level).await?;
        opened.verify(deep).await.map_err(|error| in_level(level, &error))?;
        let metadata = opened.metadata();
        if metadata.constraint_edges > 0 || metadata.sites > 0 || metadata.ends > 0 {
            return Err(wrong(level, "has constraints or sites"));
        }
        levels.push(opened);
    }
    if deep && !levels.is_empty() {
        let threads = available_parallelism().map_or(1, usize::from);
        let measured = measure(reader, &levels, threads, || Ok::<(), ReadError>(())).await?;
        for (level, (measured, overview)) in measured.iter().zip(overviews).enumerate() {
            check(level, measured, overview)?;
        }
    }
    Ok(overviews.len())
}

fn check(level: usize, measured: &Measured, overview: &Overview) -> Result<(), VerifyError> {
    if let Some((tile, what)) = measured.wrong {
        return Err(wrong(level, &format!("does not fit the file: {what}, in tile {tile}")));
    }
    if measured.shared != overview.vertices {
        let others = overview.vertices.saturating_sub(measured.shared);
        return Err(wrong(
            level,
            &format!("has {others} vertices that the file does not have"),
        ));
    }
    if let Some(tile) = measured.not_nested {
        let reason = format!("has a vertex that the level before it lacks, in tile {tile} of the file");
        return Err(wrong(level, &reason));
    }
    let found = measured.errors();
    let said = [overview.largest_error, overview.rms_error];
    if found.map(f64::to_bits) != said.map(f64::to_bits) {
        let reason = format!("has errors of {found:?}, but the directory says {said:?}");
        return Err(wrong(level, &reason));
    }
    Ok(())
}

fn wrong(level: usize, what: &str) -> VerifyError {
    VerifyError::File(format!("overview {} {what}", level + 1))
}

fn in_level(level: usize, error: &VerifyError) -> VerifyError {
    match error {
        // It names the overview.
        VerifyError::Read(error) => VerifyError::Read(error.clone()),
        _ => wrong(level, &format!("is wrong: {error}")),
    }
}
