//! GeoJSON (RFC 7946): a feature collection with a polygon for each triangle.
//!
//! Coordinates are written as they are: RFC 7946 wants WGS 84 and has no place for another reference system. A triangle's
//! neighbours can be found by the numbers of its vertices, its property `vertices`. Without triangles (fewer than three
//! points, or all on a line) the vertices themselves are written, as points, so that none is lost.
//!
//! A tile knows where the corners are that other tiles own, but not their z. Those tiles are fetched through the reader's
//! cache; tiles lie in spatial order, so most of them are there.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::thread::available_parallelism;

use futures::stream::StreamExt;

use super::ExportError;
use super::numbering::Numbering;
use super::output::{Job, Output, blocking};
use super::text::{put, put_number, put_vertex};
use crate::store::{ReadError, Tile, VertexId};

/// The z of vertices of other tiles, by tile.
type ForeignZ = BTreeMap<VertexId, f64>;

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut Job<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let has_triangles = job.reader().directory().metadata.triangles > 0;
    let threads = available_parallelism().map_or(1, usize::from);
    let numbering = Arc::clone(&job.numbering);
    let features = job
        .reader()
        .tiles()
        .map(move |tile| {
            let numbering = Arc::clone(&numbering);
            async move {
                let tile = tile?;
                let foreign = foreign_z(&numbering, &tile).await?;
                blocking(move || {
                    let mut out = Vec::new();
                    let written = if has_triangles {
                        put_polygons(&numbering, &tile, &foreign, &mut out)
                    } else {
                        put_points(&numbering, &tile, &mut out)
                    };
                    let damaged = |reason| ExportError::Read(numbering.reader().damaged(tile.id(), reason));
                    written.map(|()| out).map_err(damaged)
                })
                .await?
            }
        })
        .buffered(threads);
    output
        .push(b"{\"type\":\"FeatureCollection\",\"features\":[\n".to_vec())
        .await?;
    job.write_all(output, features.boxed(), b",\n").await?;
    output.push(b"\n]}\n".to_vec()).await
}

/// The z of the corners of a tile's own triangles that other tiles own.
async fn foreign_z(numbering: &Numbering, tile: &Tile) -> Result<ForeignZ, ReadError> {
    let reader = numbering.reader();
    let mut foreign = ForeignZ::new();
    if !numbering.has_z() {
        return Ok(foreign);
    }
    for triangle in (tile.core_triangle_count()..tile.triangle_count()).filter(|&triangle| tile.owns(triangle)) {
        let corners = tile.corners(triangle).into_iter();
        for corner in corners.filter(|&corner| corner >= tile.vertex_count()) {
            let vertex = tile.vertex(corner).id;
            numbering
                .number(vertex)
                .map_err(|reason| reader.damaged(tile.id(), reason))?;
            foreign.insert(vertex, 0.0);
        }
    }
    let mut other: Option<Arc<Tile>> = None;
    for (vertex, z) in &mut foreign {
        let owner = match &other {
            Some(owner) if owner.id() == vertex.tile => owner,
            _ => other.insert(reader.tile(vertex.tile).await?),
        };
        let found = numbering.z(owner, vertex.index);
        *z = found
            .map_err(|reason| reader.damaged(vertex.tile, reason))?
            .unwrap_or(0.0);
    }
    Ok(foreign)
}

fn put_polygons(numbering: &Numbering, tile: &Tile, foreign: &ForeignZ, out: &mut Vec<u8>) -> Result<(), String> {
    // A vertex is a corner of six triangles on average, and stands twice in one of three: its text is made once.
    let mut text = Vec::new();
    let mut ends = Vec::with_capacity(tile.vertex_count() as usize + 1);
    ends.push(0);
    for vertex in 0..tile.vertex_count() {
        text.push(b'[');
        put_vertex(numbering, tile, vertex, b',', None, &mut text)?;
        text.push(b']');
        ends.push(text.len());
    }
    let put_position = |corner: u32, out: &mut Vec<u8>| {
        if corner < tile.vertex_count() {
            out.extend_from_slice(&text[ends[corner as usize]..ends[corner as usize + 1]]);
            return;
        }
        let vertex = tile.vertex(corner);
        out.push(b'[');
        put_number(out, vertex.point.x);
        out.push(b',');
        put_number(out, vertex.point.y);
        if let Some(&z) = foreign.get(&vertex.id) {
            out.push(b',');
            put_number(out, z);
        }
        out.push(b']');
    };
    numbering.for_each_triangle(tile, |corners, [a, b, c]| {
        let separator = if out.is_empty() { "" } else { ",\n" };
        put(
            out,
            format_args!(
                "{separator}{{\"type\":\"Feature\",\"properties\":{{\"vertices\":[{a},{b},{c}]}},\
                 \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[["
            ),
        );
        for corner in corners {
            put_position(corner, out);
            out.push(b',');
        }
        put_position(corners[0], out);
        out.extend_from_slice(b"]]}}");
        Ok(())
    })
}

fn put_points(numbering: &Numbering, tile: &Tile, out: &mut Vec<u8>) -> Result<(), String> {
    for (vertex, number) in (0..tile.vertex_count()).zip(numbering.start(tile)..) {
        let separator = if out.is_empty() { "" } else { ",\n" };
        let record = tile.record(vertex);
        put(
            out,
            format_args!(
                "{separator}{{\"type\":\"Feature\",\"properties\":{{\"vertex\":{number},\"record\":{record}}},\
                 \"geometry\":{{\"type\":\"Point\",\"coordinates\":["
            ),
        );
        put_vertex(numbering, tile, vertex, b',', None, out)?;
        out.extend_from_slice(b"]}}");
    }
    // The counts of triangles must be right here too.
    numbering.for_each_triangle(tile, |_, _| Ok(()))
}
