//! Wavefront OBJ, which numbers vertices from 1.

use std::io::Write;

use super::error::{Contradiction, ExportError};
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::text::{comments, put, put_vertex};
use super::tile_part::TilePart;
use super::what::CutBy;

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    let triangles = job.counted(CutBy::Triangles, 2).await?;
    let mut header = Vec::new();
    for comment in comments(&job.numbering) {
        put(&mut header, format_args!("# {comment}\n"));
    }
    let vertices = job.reader().metadata().vertices;
    put(
        &mut header,
        format_args!("# {vertices} vertices, {triangles} triangles\n"),
    );
    output.push(header).await?;
    job.pass(output, CutBy::Vertices, put_vertices).await?;
    job.pass(output, CutBy::Triangles, put_faces).await
}

fn put_vertices(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    for (vertex, _) in part.vertices(numbering) {
        out.extend_from_slice(b"v ");
        put_vertex(&part.tile, vertex, b' ', Some(0.0), out);
        out.push(b'\n');
    }
    Ok(())
}

fn put_faces(numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>) -> Result<(), Contradiction> {
    part.for_each_triangle(numbering, |_, _, vertices| {
        let [a, b, c] = vertices.map(|vertex| vertex + 1);
        put(out, format_args!("f {a} {b} {c}\n"));
        Ok(())
    })
}
