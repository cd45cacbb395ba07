//! Writing a triangulation in one of the formats.

use std::io::Write;

use super::error::ExportError;
#[cfg(feature = "flatgeobuf")]
use super::flat_geobuf;
use super::format::Format;
#[cfg(feature = "parquet")]
use super::geo_parquet;
use super::options::ExportOptions;
use super::output::{ExportJob, Output};
use super::what::What;
use super::{geojson, glb, node, obj, ply};
use crate::store::TileReader;

/// The summary and the outputs of an export.
#[derive(Debug)]
#[non_exhaustive]
pub struct Exported<W> {
    /// The number of vertices: those of the file, or the points exported if
    /// [`What`](super::What) is vertices; 0 if it is edges.
    pub vertices: u64,
    /// The number of triangles exported.
    pub triangles: u64,
    /// The number of constraint edges exported.
    pub edges: u64,
    /// The number of bytes of all outputs.
    pub bytes: u64,
    /// What the user should know about the outputs, such as a reference system that the format cannot
    /// describe.
    pub notes: Vec<String>,
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
    if let Some(what) = options.what.filter(|_| !format.has_features()) {
        let why = format!(
            "format {format} consists of a whole mesh, not of {what}; GeoJSON, FlatGeobuf and GeoParquet have features"
        );
        return Err(ExportError::Limit(why));
    }
    let mut outputs: Vec<_> = outputs
        .into_iter()
        .zip(suffixes)
        .map(|(writer, suffix)| Output::new(writer, suffix))
        .collect();
    let mut job = ExportJob::new(reader.for_passes().await?, options, &mut progress).await?;
    match (format, outputs.as_mut_slice()) {
        (Format::Ply, [output]) => ply::write(&mut job, output).await?,
        (Format::Node, [node, ele]) => node::write(&mut job, node, ele).await?,
        (Format::Obj, [output]) => obj::write(&mut job, output).await?,
        (Format::Glb, [output]) => glb::write(&mut job, output).await?,
        (Format::GeoJson, [output]) => geojson::write(&mut job, output).await?,
        #[cfg(feature = "flatgeobuf")]
        (Format::FlatGeobuf, [output]) => flat_geobuf::write(&mut job, output).await?,
        #[cfg(feature = "parquet")]
        (Format::GeoParquet, [output]) => geo_parquet::write(&mut job, output).await?,
        #[cfg(not(feature = "flatgeobuf"))]
        (Format::FlatGeobuf, _) => return Err(not_compiled("flatgeobuf")),
        #[cfg(not(feature = "parquet"))]
        (Format::GeoParquet, _) => return Err(not_compiled("parquet")),
        _ => unreachable!("the number of outputs was checked"),
    }
    let vertices = match job.numbering.what() {
        What::Triangles => reader.metadata().vertices,
        What::Vertices | What::Edges if format.has_features() => job.written.points,
        What::Vertices | What::Edges => reader.metadata().vertices,
    };
    let mut exported = Exported {
        vertices,
        triangles: job.written.triangles,
        edges: job.written.edges,
        bytes: 0,
        notes: job.notes,
        outputs: Vec::new(),
    };
    for output in outputs {
        let (writer, bytes) = output.finish().await?;
        exported.bytes += bytes;
        exported.outputs.push(writer);
    }
    Ok(exported)
}

#[cfg(not(all(feature = "flatgeobuf", feature = "parquet", feature = "geotiff")))]
pub(super) fn not_compiled(feature: &str) -> ExportError {
    ExportError::Limit(format!("the library was compiled without feature '{feature}'"))
}
