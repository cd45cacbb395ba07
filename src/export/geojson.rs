//! GeoJSON (RFC 7946): a feature collection with a polygon for each triangle, a point for each vertex
//! or a line for each constraint edge.
//!
//! The numbers of a triangle's vertices are in its property `vertices`, from which its neighbours can
//! be found. If there are no triangles (fewer than three points, or only collinear ones), the vertices
//! themselves are written as points by default, so that none is lost.
//!
//! Coordinates are written unchanged. RFC 7946 requires WGS 84 and cannot express another reference
//! system. So if the EPSG code of another one is known, it is in the member `crs` of the older format
//! (GeoJSON 2008), which GDAL, QGIS and others still read.

use std::io::Write;

use super::error::{Contradiction, ExportError};
use super::feature::{Value, lines_of};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{put, put_vertex};
use super::tile_part::{CHUNK_BYTES, TilePart};
use super::what::What;
use crate::crs::Crs;
use crate::geometry::VertexIndex;
use crate::store::{Needs, PassReader};

/// The bytes behind the last feature.
pub(super) const FOOTER: &[u8] = b"\n]}\n";

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let what = job.numbering.what();
    output.push(header(job.reader())).await?;
    let features = move |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        out.reserve(CHUNK_BYTES as usize);
        match what {
            What::Triangles => put_polygons(numbering, part, out),
            What::Vertices => put_points(numbering, part, out),
            What::Edges => put_lines(numbering, part, out),
        }
    };
    job.pass_to(output, what.cut(), needs(), features).await?;
    output.push(FOOTER.to_vec()).await
}

/// Returns the bytes before the first feature.
pub(super) fn header(reader: &PassReader) -> Vec<u8> {
    let mut header = b"{\"type\":\"FeatureCollection\",".to_vec();
    let crs = reader.directory().lists.crs.as_deref().map(Crs::new);
    if let Some(urn) = crs.and_then(|crs| crs.urn()) {
        put(
            &mut header,
            format_args!("\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\"{urn}\"}}}},"),
        );
    }
    header.extend_from_slice(b"\"features\":[\n");
    header
}

/// Appends what separates a feature from the one before it.
fn put_separator(part: &TilePart, out: &mut Vec<u8>) {
    if part.written_before > 0 || !out.is_empty() {
        out.extend_from_slice(b",\n");
    }
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
    part.for_each_triangle(numbering, |_, corners, [a, b, c]| {
        put_separator(part, out);
        put(
            out,
            format_args!(
                "{{\"type\":\"Feature\",\"properties\":{{\"vertices\":[{a},{b},{c}]}},\
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
    for (vertex, number) in part.points(numbering) {
        put_separator(part, out);
        let record = part.tile.record(vertex);
        put(
            out,
            format_args!(
                "{{\"type\":\"Feature\",\"properties\":{{\"vertex\":{number},\"record\":{record}}},\
                 \"geometry\":{{\"type\":\"Point\",\"coordinates\":["
            ),
        );
        put_vertex(&part.tile, vertex, b',', None, out);
        out.extend_from_slice(b"]}}");
    }
    Ok(())
}

fn put_lines(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    for edge in part.edges(numbering) {
        put_separator(part, out);
        let [from, to] = numbering.ends(&part.tile, edge)?;
        put(
            out,
            format_args!("{{\"type\":\"Feature\",\"properties\":{{\"from\":{from},\"to\":{to}"),
        );
        for (key, value) in ["kind", "line"].into_iter().zip(lines_of(&part.tile, edge)) {
            match value {
                Value::Number(number) => put(out, format_args!(",\"{key}\":{number}")),
                Value::Text(text) => put(out, format_args!(",\"{key}\":\"{text}\"")),
                Value::Missing => put(out, format_args!(",\"{key}\":null")),
            }
        }
        out.extend_from_slice(b"},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[[");
        for (corner, end) in part.tile.corners_of_edge(edge).into_iter().zip([&b"],["[..], b"]]}}"]) {
            put_vertex(&part.tile, corner, b',', None, out);
            out.extend_from_slice(end);
        }
    }
    Ok(())
}
