//! PLY, binary, little-endian (Turk, "The PLY Polygon File Format", 1994).
//!
//! Elements: `vertex` with x, y, z as doubles and the number of its input record; `face`, one
//! triangle each; `edge`, constraint edges, if they are requested and there are any. Some readers
//! refuse an element that they do not know or that is empty, so there is no such element otherwise.
//!
//! PLY has no integers of 64 bits. Record numbers are `uint` if all of them fit, otherwise
//! `double`, which is exact up to 2^53. The header contains this type, so it must be known first.
//! The sizes of the sources in the directory bound the record numbers. Only if the directory has
//! none, or if the bound is too large, a pass over the tiles finds the largest number.

use std::io::Write;

use futures::stream::StreamExt;

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{comments, put};
use super::tile_part::TilePart;
use super::what::CutBy;
use crate::geometry::VertexIndex;
use crate::store::{Needs, Tile};

/// The number of vertices that a `uint` can number.
const MAX_VERTICES: u64 = 1 << 32;
/// The limit up to which a double represents all integers exactly.
const EXACT: u64 = 1 << 53;

/// The type of record numbers in the output.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RecordType {
    Uint,
    Double,
}

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    let metadata = job.reader().metadata();
    if metadata.vertices > MAX_VERTICES {
        return Err(ExportError::Limit(format!(
            "PLY can number {MAX_VERTICES} vertices, but there are {}; Triangle's format, OBJ and FlatGeobuf have no \
             such limit",
            metadata.vertices
        )));
    }
    let has_edges = job.numbering.has_edges();
    let records = record_type(job).await?;
    let triangles = job.counted(CutBy::Triangles, 2).await?;
    let edges = match has_edges {
        true => job.counted(CutBy::Edges, 1).await?,
        false => 0,
    };
    output.push(header(&job.numbering, [triangles, edges], records)).await?;
    let vertices = move |_: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        let mut vertices = part.range.clone().map(VertexIndex);
        vertices.try_for_each(|vertex| put_vertex(&part.tile, vertex, records, out))
    };
    job.pass(output, CutBy::Vertices, vertices).await?;
    job.pass(output, CutBy::Triangles, put_faces).await?;
    match has_edges {
        false => Ok(()),
        true => job.pass(output, CutBy::Edges, put_edges).await,
    }
}

/// Determines the type of record numbers, by a pass if need be.
async fn record_type(job: &mut ExportJob<'_>) -> Result<RecordType, ExportError> {
    let fits = |largest: u64| {
        if largest <= u64::from(u32::MAX) {
            RecordType::Uint
        } else {
            RecordType::Double
        }
    };
    let sources = &job.reader().directory().lists.sources;
    let sources = sources.iter().map(|source| source.records);
    let bound = sources.fold(0, u64::saturating_add);
    if bound > 0 && fits(bound - 1) == RecordType::Uint {
        return Ok(RecordType::Uint);
    }
    job.passes(1);
    let mut maxima = job.reader().for_each_tile(Needs::default(), |tile| {
        tile.vertex_indices()
            .map(|vertex| tile.record(vertex))
            .max()
            .unwrap_or(0)
    })?;
    let mut largest = 0;
    while let Some(maximum) = maxima.next().await {
        largest = largest.max(maximum?);
        job.advance();
    }
    if largest > EXACT {
        return Err(ExportError::Limit(format!(
            "PLY has no type for record numbers beyond {EXACT}, but there is {largest}; other formats do not need it"
        )));
    }
    Ok(fits(largest))
}

fn header(numbering: &Numbering, [triangles, edges]: [u64; 2], records: RecordType) -> Vec<u8> {
    let mut out = b"ply\nformat binary_little_endian 1.0\n".to_vec();
    for comment in comments(numbering) {
        put(&mut out, format_args!("comment {comment}\n"));
    }
    let record = match records {
        RecordType::Uint => "uint",
        RecordType::Double => "double",
    };
    put(
        &mut out,
        format_args!(
            "element vertex {}\n\
             property double x\n\
             property double y\n\
             property double z\n\
             property {record} record\n\
             element face {}\n\
             property list uchar uint vertex_indices\n",
            numbering.reader().metadata().vertices,
            triangles,
        ),
    );
    if edges > 0 {
        let edge = format_args!("element edge {edges}\nproperty uint vertex1\nproperty uint vertex2\n");
        put(&mut out, edge);
    }
    out.extend_from_slice(b"end_header\n");
    out
}

fn put_vertex(tile: &Tile, vertex: VertexIndex, records: RecordType, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    let p = tile.point(vertex);
    let z = tile.z(vertex).unwrap_or(0.0);
    for number in [p.x, p.y, z] {
        out.extend_from_slice(&number.to_le_bytes());
    }
    let record = tile.record(vertex);
    match records {
        RecordType::Uint => {
            let fits = u32::try_from(record);
            let record = fits.map_err(|_| Contradiction::NoSuchRecord { vertex, record })?;
            out.extend_from_slice(&record.to_le_bytes());
        }
        RecordType::Double => out.extend_from_slice(&(record as f64).to_le_bytes()),
    }
    Ok(())
}

fn put_faces(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    part.for_each_triangle(numbering, |_, _, vertices| {
        out.push(3);
        for vertex in vertices {
            // There are at most 2^32 vertices.
            out.extend_from_slice(&(vertex as u32).to_le_bytes());
        }
        Ok(())
    })
}

fn put_edges(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    for edge in part.edges(numbering) {
        for number in numbering.ends(&part.tile, edge)? {
            // There are at most 2^32 vertices.
            out.extend_from_slice(&(number as u32).to_le_bytes());
        }
    }
    Ok(())
}
