//! Options of several commands that limit the surface: lengths and polygons.

use std::path::Path;

use anyhow::ensure;
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::terrain::Clip;

use crate::common;

/// Parses a length.
pub fn length(text: &str) -> Result<f64, String> {
    let length = text
        .parse()
        .ok()
        .filter(|length: &f64| *length > 0.0 && length.is_finite());
    length.ok_or_else(|| "a length is a number above 0".to_owned())
}

/// Reads polygons to which an output is limited.
pub fn read_polygons(path: &Path) -> anyhow::Result<Clip> {
    let mut source = SegmentSource::open_obstacles(&[path.to_owned()])?;
    let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
    while source.next_batch(&mut batch)? {
        edges.extend_from_slice(&batch.ends);
        ensure!(
            edges.len() <= Clip::MAX_EDGES,
            "{}: the polygons can have {} edges; simplify them",
            common::shown(path),
            Clip::MAX_EDGES
        );
    }
    Ok(Clip::new(edges))
}
