//! GeoJSON (RFC 7946): a feature collection with a polygon for each triangle.
//!
//! Coordinates are written unchanged: RFC 7946 requires WGS 84 and cannot express another reference
//! system. The numbers of a triangle's vertices are in its property `vertices`, from which its
//! neighbours can be found. If there are no triangles (fewer than three points, or only collinear
//! ones), the vertices themselves are written as points, so that none is lost.
//!
//! A tile knows the coordinates of corners that other tiles own, but not their z. Those tiles are
//! fetched through the reader's cache. Tiles are in spatial order, so most of them are in the
//! cache.

use std::io::Write;
use std::sync::Arc;

use futures::stream::StreamExt;

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{put, put_number, put_vertex};
use super::tile_part::{CHUNK_BYTES, CutBy, ForeignZ, TilePart};
use crate::geometry::VertexIndex;
use crate::store::{Needs, ReadError, Tile, joined, spawn};

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let has_triangles = job.reader().metadata().triangles > 0;
    let plan = job.reader().plan(needs(&job.numbering))?;
    let numbering = Arc::clone(&job.numbering);
    let tiles = job.reader().pass(job.reader().tile_ids(), plan).map(move |tile| {
        let numbering = Arc::clone(&numbering);
        let task = tile.map(|tile| {
            tokio::spawn(async move {
                let foreign = Arc::new(foreign_z(&numbering, &tile).await?);
                spawn(move || {
                    let tile = Arc::new(tile);
                    let triangles = numbering.cut(&tile, CutBy::Triangles, &foreign)?;
                    // In a file without triangles, no tile may have any either.
                    if has_triangles {
                        Ok(triangles)
                    } else {
                        numbering.cut(&tile, CutBy::Vertices, &foreign)
                    }
                })
                .await?
            })
        });
        async move { joined(task?).await? }
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
fn needs(numbering: &Numbering) -> Needs {
    let needs = ExportJob::needs();
    // The positions of the texts of a part's vertices, and these texts.
    let mut needs = Needs {
        per_thread: needs.per_thread + CHUNK_BYTES / 2,
        per_vertex: size_of::<u32>() as u64,
        ..needs
    };
    if numbering.has_z() {
        // For each tile in use, another one, in the cache or on its way there.
        needs.fixed += numbering.reader().cache().capacity() as u64;
        needs.per_thread += numbering.reader().largest_tile();
    }
    needs
}

/// Returns the z of corners that other tiles own, for the triangles that this tile owns.
async fn foreign_z(numbering: &Numbering, tile: &Tile) -> Result<ForeignZ, ReadError> {
    let reader = numbering.reader();
    let mut foreign = ForeignZ::new();
    if !numbering.has_z() {
        return Ok(foreign);
    }
    for triangle in tile
        .border_triangle_ids()
        .filter(|&triangle| numbering.is_written(tile, triangle))
    {
        let corners = tile.corners(triangle).into_iter();
        for corner in corners.filter(|&corner| !tile.has_vertex(corner)) {
            let vertex = tile.vertex(corner).id;
            let number = numbering.number(vertex);
            number.map_err(|fault| numbering.damaged(tile.id(), fault))?;
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
        let found = found.map_err(|fault| numbering.damaged(vertex.tile, fault))?;
        *z = found.unwrap_or(0.0);
    }
    Ok(foreign)
}

fn put_polygons(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    let tile = &part.tile;
    // A vertex is a corner of six triangles on average, and a polygon names one of its three
    // corners twice. So the text of a vertex is made only once per part.
    let mut texts = Vec::with_capacity(CHUNK_BYTES as usize / 2);
    // The position where the text of a vertex starts, counted from 1; the text ends with its
    // bracket. 0 if there is no text yet.
    let mut starts = vec![0u32; tile.vertex_count() as usize];
    let mut put_position = |corner: VertexIndex, out: &mut Vec<u8>| -> Result<(), Contradiction> {
        if let Some(start) = starts.get_mut(corner.index()) {
            if *start == 0 {
                *start = texts.len() as u32 + 1;
                texts.push(b'[');
                put_vertex(numbering, tile, corner, b',', None, &mut texts)?;
                texts.push(b']');
            }
            let text = &texts[*start as usize - 1..];
            let end = text
                .iter()
                .position(|&byte| byte == b']')
                .map_or(text.len(), |end| end + 1);
            out.extend_from_slice(&text[..end]);
            return Ok(());
        }
        let vertex = tile.vertex(corner);
        out.push(b'[');
        put_number(out, vertex.point.x);
        out.push(b',');
        put_number(out, vertex.point.y);
        if let Some(&z) = part.foreign_z.get(&vertex.id) {
            out.push(b',');
            put_number(out, z);
        }
        out.push(b']');
        Ok(())
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
            put_position(corner, out)?;
            out.push(b',');
        }
        put_position(corners[0], out)?;
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
        put_vertex(numbering, &part.tile, vertex, b',', None, out)?;
        out.extend_from_slice(b"]}}");
    }
    Ok(())
}
