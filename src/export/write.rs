//! Writing a triangulation in one of the formats.

use std::io::Write;

use super::error::ExportError;
use super::format::Format;
use super::options::ExportOptions;
use super::output::{ExportJob, Output};
use super::{geojson, node, obj, ply};
use crate::store::TileReader;

/// The summary and the outputs of an export.
#[derive(Debug)]
#[non_exhaustive]
pub struct Exported<W> {
    /// The number of vertices.
    pub vertices: u64,
    /// The number of triangles exported.
    pub triangles: u64,
    /// The number of bytes of all outputs.
    pub bytes: u64,
    /// The outputs, flushed, in the order in which they were given.
    pub outputs: Vec<W>,
}

/// Writes a triangulation in another format. Must be awaited within a tokio runtime.
///
/// `outputs` must have one output for each of the format's [`suffixes`](Format::suffixes), in their
/// order. The outputs get chunks of one or two mebibytes, on threads for blocking work, so they
/// need no buffer. `progress` is called with the number of tiles done and the total. Formats that
/// list vertices before triangles count every tile twice. Dropping the future stops the export
/// after the chunk that is being written.
///
/// # Errors
/// Fails if the file cannot be read or is damaged, if an output fails, if the memory that the
/// reader may use does not suffice for a tile, or if the triangulation exceeds a limit of the
/// format.
///
/// # Panics
/// Panics if the number of outputs differs from the number of the format's suffixes.
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
    let mut job = ExportJob::new(reader.for_passes().await?, options, &mut progress);
    match (format, outputs.as_mut_slice()) {
        (Format::Ply, [output]) => ply::write(&mut job, output).await?,
        (Format::Node, [node, ele]) => node::write(&mut job, node, ele).await?,
        (Format::Obj, [output]) => obj::write(&mut job, output).await?,
        (Format::GeoJson, [output]) => geojson::write(&mut job, output).await?,
        _ => unreachable!("the number of outputs was checked"),
    }
    let mut exported = Exported {
        vertices: reader.metadata().vertices,
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
