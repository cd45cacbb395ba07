//! One triangulation, written in one format.

use std::io::Write;

use super::error::ExportError;
use super::format::Format;
use super::options::ExportOptions;
use super::output::{Job, Output};
use super::{geojson, node, obj, ply};
use crate::store::TileReader;

/// What was exported.
#[derive(Debug)]
#[non_exhaustive]
pub struct Exported<W> {
    /// Vertices.
    pub vertices: u64,
    /// Triangles that were exported.
    pub triangles: u64,
    /// Bytes of all outputs.
    pub bytes: u64,
    /// The outputs, in the order in which they were given, flushed.
    pub outputs: Vec<W>,
}

/// Writes a triangulation in another format. Must be awaited within a tokio runtime.
///
/// There must be one output for each of the format's [`suffixes`](Format::suffixes), in their order. They get pieces of one or
/// two mebibytes, on threads for blocking work, so they need no buffer. `progress` is told how many tiles of how many
/// are done; formats that list vertices before triangles count every tile twice. Dropping the future stops the
/// export after the piece that is being written.
///
/// # Errors
/// If the file cannot be read or is damaged, an output fails, the memory that the reader may use does not suffice for a tile,
/// or the format has no room for the triangulation.
///
/// # Panics
/// If the number of outputs is not that of the format's suffixes.
pub async fn export<W: Write + Send + 'static>(
    reader: &TileReader,
    format: Format,
    options: ExportOptions,
    outputs: Vec<W>,
    mut progress: impl FnMut(u64, u64) + Send,
) -> Result<Exported<W>, ExportError> {
    let suffixes = format.suffixes();
    assert_eq!(outputs.len(), suffixes.len(), "outputs of {format}");
    let mut outputs: Vec<_> = outputs
        .into_iter()
        .zip(suffixes)
        .map(|(writer, suffix)| Output::new(writer, suffix))
        .collect();
    let mut job = Job::new(reader, options, &mut progress);
    match (format, outputs.as_mut_slice()) {
        (Format::Ply, [output]) => ply::write(&mut job, output).await?,
        (Format::Node, [node, ele]) => node::write(&mut job, node, ele).await?,
        (Format::Obj, [output]) => obj::write(&mut job, output).await?,
        (Format::GeoJson, [output]) => geojson::write(&mut job, output).await?,
        _ => unreachable!("the number of outputs was checked"),
    }
    let mut exported = Exported {
        vertices: reader.directory().metadata.vertices,
        triangles: job.numbering.triangles(),
        bytes: 0,
        outputs: Vec::new(),
    };
    for output in outputs {
        let (writer, bytes) = output.finish().await?;
        exported.bytes += bytes;
        exported.outputs.push(writer);
    }
    Ok(exported)
}
