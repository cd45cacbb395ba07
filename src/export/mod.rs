//! The triangulation in formats that other programs read.
//!
//! In: an open tile file. Out: its vertices and triangles, tile by tile, to anything that takes bytes. Memory is bounded by
//! what the reader [may use](crate::store::OpenOptions::memory): a few tiles, a few parts of them as bytes, and eight bytes for
//! each tile of the file.
//!
//! ```text
//! reader ──▶ numbering ──▶ part ──▶ ply, node, obj, geojson ──▶ output ──▶ io::Write
//!            one number     of a     a part's bytes at a time,   order, buffer,
//!            per vertex     tile     on blocking threads          blocking thread
//! ```
//!
//! Vertices are numbered through the file: in the order of the tiles, and within each as they stand. All formats have them
//! in this order, and every vertex once. Triangles stand once each, counter-clockwise, in the order of the tiles that they
//! belong to; those in holes only if they are [asked for](ExportOptions::holes). Whatever a file holds, an export ends with a whole output or an error; what was written until an error must
//! be thrown away.

mod format;
mod geojson;
mod node;
mod numbering;
mod obj;
mod output;
mod part;
mod ply;
mod text;

#[cfg(test)]
mod edge_tests;
#[cfg(test)]
mod hole_tests;
#[cfg(test)]
mod tests;

use std::io::{self, Write};

use crate::store::{ReadError, TileReader};

pub use format::{Format, UnknownFormat};

use output::Job;

/// Why an export failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The tile file cannot be read, or is damaged, or a tile does not fit in the memory that its reader may use.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output does not take what is written; [`source`](std::error::Error::source) says why.
    #[error("cannot write the .{suffix} output")]
    Write {
        /// Which of the format's outputs.
        suffix: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The format has no room for the triangulation.
    #[error("{0}")]
    Limit(String),
    /// The runtime was shut down under the export.
    #[error("the export was cancelled, because the runtime is shutting down")]
    Cancelled,
}

/// What is exported.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExportOptions {
    /// Triangles in holes too, which are left out otherwise. Vertices are exported in any case.
    pub holes: bool,
}

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
        .map(|(writer, suffix)| output::Output::new(writer, suffix))
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
