//! Triangle's `.node` and `.ele` (Shewchuk, <https://www.cs.cmu.edu/~quake/triangle.html>),
//! numbered from 0.

use std::io::Write;

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{comments, put, put_vertex};
use super::tile_part::TilePart;
use super::what::CutBy;

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    node: &mut Output<W>,
    ele: &mut Output<W>,
) -> Result<(), ExportError> {
    let triangles = job.counted(CutBy::Triangles, 2).await?;
    let metadata = job.reader().metadata();
    let vertices = metadata.vertices;
    let attributes = u8::from(metadata.has_z);
    node.push(header(job, &format!("{vertices} 2 {attributes} 0"))).await?;
    ele.push(header(job, &format!("{triangles} 3 0"))).await?;
    job.pass(node, CutBy::Vertices, put_nodes).await?;
    let elements = |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        // Triangles are also numbered over the whole file.
        let mut triangle = part.written_before;
        part.for_each_triangle(numbering, |_, _, [a, b, c]| {
            put(out, format_args!("{triangle} {a} {b} {c}\n"));
            triangle += 1;
            Ok(())
        })
    };
    job.pass(ele, CutBy::Triangles, elements).await
}

fn header(job: &ExportJob<'_>, counts: &str) -> Vec<u8> {
    let mut out = Vec::new();
    for comment in comments(&job.numbering) {
        put(&mut out, format_args!("# {comment}\n"));
    }
    put(&mut out, format_args!("{counts}\n"));
    out
}

fn put_nodes(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    for (vertex, number) in part.vertices(numbering) {
        put(out, format_args!("{number} "));
        put_vertex(&part.tile, vertex, b' ', None, out);
        out.push(b'\n');
    }
    Ok(())
}
