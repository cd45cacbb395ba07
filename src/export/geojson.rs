//! GeoJSON (RFC 7946): a feature collection with a polygon for each triangle.
//!
//! Coordinates are written unchanged: RFC 7946 requires WGS 84 and cannot express another reference
//! system. The numbers of a triangle's vertices are in its property `vertices`, from which its
//! neighbours can be found. If there are no triangles (fewer than three points, or only collinear
//! ones), the vertices themselves are written as points, so that none is lost.

use std::io::Write;
use std::sync::Arc;

use futures::stream::StreamExt;

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{put, put_vertex};
use super::tile_part::{CHUNK_BYTES, CutBy, TilePart};
use crate::geometry::VertexIndex;
use crate::store::{Needs, spawn};

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let has_triangles = job.reader().metadata().triangles > 0;
    let plan = job.reader().plan(needs())?;
    let numbering = Arc::clone(&job.numbering);
    let tiles = job.reader().pass(job.reader().tile_ids(), plan).map(move |tile| {
        let numbering = Arc::clone(&numbering);
        async move {
            let tile = Arc::new(tile?);
            spawn(move || {
                let triangles = numbering.cut(&tile, CutBy::Triangles)?;
                // In a file without triangles, no tile may have any either.
                if has_triangles {
                    Ok(triangles)
                } else {
                    numbering.cut(&tile, CutBy::Vertices)
                }
            })
            .await?
        }
    });
    let features = move |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        out.reserve(CHUNK_BYTES as usize);
        if has_triangles {
            put_polygons(numbering, part, out)
        } else {
            put_points(numbering, part, out)
        }
    };
    output
        .push(b"{\"type\":\"FeatureCollection\",\"features\":[\n".to_vec())
        .await?;
    let written = job
        .write_parts(output, tiles.buffered(plan.threads), plan, b",\n", features)
        .await?;
    job.check_triangles(written)?;
    output.push(b"\n]}\n".to_vec()).await
}

/// Returns the memory that the pass needs.
fn needs() -> Needs {
    let needs = ExportJob::needs();
    // The positions of the texts of a part's vertices, and these texts.
    Needs {
        per_thread: needs.per_thread + CHUNK_BYTES / 2,
        per_vertex: size_of::<u32>() as u64,
        ..needs
    }
}

fn put_polygons(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    let tile = &part.tile;
    // A vertex is a corner of six triangles on average, and a polygon names one of its three
    // corners twice. So the text of a vertex is made only once per part.
    let mut texts = Vec::with_capacity(CHUNK_BYTES as usize / 2);
    // The position where the text of a vertex starts, counted from 1; the text ends with its
    // bracket. 0 if there is no text yet.
    let mut starts = vec![0u32; tile.vertex_count() as usize];
    let mut put_position = |corner: VertexIndex, out: &mut Vec<u8>| {
        if let Some(start) = starts.get_mut(corner.index()) {
            if *start == 0 {
                *start = texts.len() as u32 + 1;
                texts.push(b'[');
                put_vertex(tile, corner, b',', None, &mut texts);
                texts.push(b']');
            }
            let text = &texts[*start as usize - 1..];
            let end = text
                .iter()
                .position(|&byte| byte == b']')
                .map_or(text.len(), |end| end + 1);
            out.extend_from_slice(&text[..end]);
            return;
        }
        out.push(b'[');
        put_vertex(tile, corner, b',', None, out);
        out.push(b']');
    };
    part.for_each_triangle(numbering, |corners, [a, b, c]| {
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

fn put_points(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    for (vertex, number) in part.vertices(numbering) {
        let separator = if out.is_empty() { "" } else { ",\n" };
        let record = part.tile.record(vertex);
        put(
            out,
            format_args!(
                "{separator}{{\"type\":\"Feature\",\"properties\":{{\"vertex\":{number},\"record\":{record}}},\
                 \"geometry\":{{\"type\":\"Point\",\"coordinates\":["
            ),
        );
        put_vertex(&part.tile, vertex, b',', None, out);
        out.extend_from_slice(b"]}}");
    }
    Ok(())
}
