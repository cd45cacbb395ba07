//! glTF 2.0, binary (Khronos, <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html>): one mesh of
//! all vertices and triangles, and of constraint edges as lines if they are requested.
//!
//! Positions have 32 bits, which do not suffice for coordinates of maps. So they are relative to the
//! centre of the bounds, and the node that has the mesh is moved there: its `translation`, in full
//! precision, added to a position, is the vertex. At 10 km from the centre, positions are exact to a
//! millimetre. The y axis of glTF is up, so positions are x, z, -y of the file.
//!
//! The header has the sizes, and the least and greatest positions, of which validators demand that
//! they are exact. A pass over the vertices finds them.

use std::io::Write;

use super::error::ExportError;
use super::json::put_json_text;
use super::numbering::Numbering;
use super::output::{ExportJob, Output};
use super::survey::Bounds;
use super::text::put;
use super::tile_part::TilePart;
use super::what::CutBy;

/// The bytes of the header of the file, and of the header of each chunk.
const FILE_HEADER: u64 = 12;
const CHUNK_HEADER: u64 = 8;
/// The bytes of a position, of a triangle's indices and of an edge's indices.
const SIZES: [u64; 3] = [12, 12, 8];
/// The modes of primitives.
const POINTS: u8 = 0;
const LINES: u8 = 1;
const TRIANGLES: u8 = 4;

/// The numbers of vertices, triangles and edges, and the bounds of the vertices.
struct Mesh {
    counts: [u64; 3],
    bounds: Bounds,
    centre: [f64; 3],
}

pub(super) async fn write<W: Write + Send + 'static>(
    job: &mut ExportJob<'_>,
    output: &mut Output<W>,
) -> Result<(), ExportError> {
    job.passes(1);
    let survey = job.survey(CutBy::Vertices).await?;
    let triangles = job.counted(CutBy::Triangles, 2).await?;
    let edges = match job.numbering.has_edges() {
        true => job.counted(CutBy::Edges, 1).await?,
        false => 0,
    };
    let bounds = survey.bounds;
    let centre = [0, 1, 2].map(|axis| match survey.count {
        0 => 0.0,
        _ => bounds.min[axis] / 2.0 + bounds.max[axis] / 2.0,
    });
    let mesh = Mesh {
        counts: [survey.count, triangles, edges],
        bounds,
        centre,
    };
    output.push(mesh.header(&job.numbering)?).await?;
    let positions = move |_: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        for vertex in part.range.clone().map(crate::geometry::VertexIndex) {
            let p = part.tile.point(vertex);
            let z = part.tile.z(vertex).unwrap_or(0.0);
            for number in position([p.x, p.y, z], centre) {
                out.extend_from_slice(&number.to_le_bytes());
            }
        }
        Ok(())
    };
    job.pass(output, CutBy::Vertices, positions).await?;
    let triangles = |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
        part.for_each_triangle(numbering, |_, _, vertices| {
            put_indices(vertices, out);
            Ok(())
        })
    };
    job.pass(output, CutBy::Triangles, triangles).await?;
    if job.numbering.has_edges() {
        let edges = |numbering: &Numbering, part: &TilePart, out: &mut Vec<u8>| {
            part.edges(numbering).try_for_each(|edge| {
                put_indices(numbering.ends(&part.tile, edge)?, out);
                Ok(())
            })
        };
        job.pass(output, CutBy::Edges, edges).await?;
    }
    Ok(())
}

fn put_indices<const N: usize>(vertices: [u64; N], out: &mut Vec<u8>) {
    for vertex in vertices {
        // There are fewer than 2^32 vertices.
        out.extend_from_slice(&(vertex as u32).to_le_bytes());
    }
}

/// Returns the position of a vertex, relative to the centre.
fn position([x, y, z]: [f64; 3], centre: [f64; 3]) -> [f32; 3] {
    [x - centre[0], z - centre[2], centre[1] - y].map(|number| number as f32)
}

impl Mesh {
    /// Returns the bytes before the positions: the headers and the description in JSON.
    fn header(&self, numbering: &Numbering) -> Result<Vec<u8>, ExportError> {
        let lengths = [0, 1, 2].map(|i| self.counts[i].saturating_mul(SIZES[i]));
        let binary = lengths.iter().fold(0, |sum: u64, &length| sum.saturating_add(length));
        let mut json = self.json(numbering, lengths);
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunk = |length: u64| if length > 0 { CHUNK_HEADER + length } else { 0 };
        let total = (FILE_HEADER + chunk(json.len() as u64)).saturating_add(chunk(binary));
        // The index of all ones is reserved.
        if self.counts[0] >= u64::from(u32::MAX) || total > u64::from(u32::MAX) {
            let [vertices, triangles, _] = self.counts;
            return Err(ExportError::Limit(format!(
                "a .glb can have 4 GiB and 4294967294 vertices, but {vertices} vertices and {triangles} triangles \
                 would take {total} bytes; PLY has no such limit of bytes, and OBJ none of vertices"
            )));
        }
        let extent = [0, 1, 2].map(|axis| self.bounds.max[axis] / 2.0 - self.bounds.min[axis] / 2.0);
        if extent.iter().any(|&extent| extent > f64::from(f32::MAX)) {
            let why =
                "coordinates of glTF have 32 bits, but those of the file extend beyond 3.4e38; export PLY instead";
            return Err(ExportError::Limit(why.to_owned()));
        }
        let mut out = b"glTF".to_vec();
        for number in [2, total as u32, json.len() as u32] {
            out.extend_from_slice(&number.to_le_bytes());
        }
        out.extend_from_slice(b"JSON");
        out.extend_from_slice(&json);
        if binary > 0 {
            out.extend_from_slice(&(binary as u32).to_le_bytes());
            out.extend_from_slice(b"BIN\0");
        }
        Ok(out)
    }

    /// Returns the description of the mesh.
    fn json(&self, numbering: &Numbering, lengths: [u64; 3]) -> Vec<u8> {
        let mut out = Vec::new();
        let version = env!("CARGO_PKG_VERSION");
        put(
            &mut out,
            format_args!("{{\"asset\":{{\"version\":\"2.0\",\"generator\":\"delaunay-tiles {version}\""),
        );
        if let Some(crs) = &numbering.reader().directory().lists.crs {
            out.extend_from_slice(b",\"extras\":{\"crs\":");
            put_json_text(crs, &mut out);
            out.push(b'}');
        }
        out.extend_from_slice(b"},\"scene\":0,");
        let [vertices, triangles, edges] = self.counts;
        if vertices == 0 {
            out.extend_from_slice(b"\"scenes\":[{}]}");
            return out;
        }
        let [x, y, z] = self.centre;
        let bytes: u64 = lengths.iter().sum();
        put(
            &mut out,
            format_args!(
                "\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0,\"translation\":[{x:?},{z:?},{:?}]}}],\
                 \"buffers\":[{{\"byteLength\":{bytes}}}]",
                -y
            ),
        );
        self.put_parts(&mut out, lengths, [(triangles, TRIANGLES), (edges, LINES)]);
        out.push(b'}');
        out
    }

    /// Appends the views of the buffer, the accessors and the primitives of the mesh.
    fn put_parts(&self, out: &mut Vec<u8>, lengths: [u64; 3], indexed: [(u64, u8); 2]) {
        const VERTICES: u16 = 34962;
        const INDICES: u16 = 34963;
        let min = [self.bounds.min[0], self.bounds.max[1], self.bounds.min[2]];
        let max = [self.bounds.max[0], self.bounds.min[1], self.bounds.max[2]];
        // The nearest number of 32 bits never decreases with the number, so bounds become bounds.
        let [min, max] = [min, max].map(|corner| position(corner, self.centre).map(f64::from));
        let mut views = format!("{{\"buffer\":0,\"byteLength\":{},\"target\":{VERTICES}}}", lengths[0]);
        let mut accessors = format!(
            "{{\"bufferView\":0,\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":{min:?},\"max\":{max:?}}}",
            self.counts[0]
        );
        let mut primitives = Vec::new();
        let mut at = lengths[0];
        for ((count, mode), &length) in indexed
            .into_iter()
            .zip(&lengths[1..])
            .filter(|((count, _), _)| *count > 0)
        {
            let number = primitives.len() + 1;
            views += &format!(",{{\"buffer\":0,\"byteOffset\":{at},\"byteLength\":{length},\"target\":{INDICES}}}");
            let indices = count * if mode == TRIANGLES { 3 } else { 2 };
            accessors +=
                &format!(",{{\"bufferView\":{number},\"componentType\":5125,\"count\":{indices},\"type\":\"SCALAR\"}}");
            primitives.push(format!(
                "{{\"attributes\":{{\"POSITION\":0}},\"indices\":{number},\"mode\":{mode}}}"
            ));
            at += length;
        }
        if primitives.is_empty() {
            primitives.push(format!("{{\"attributes\":{{\"POSITION\":0}},\"mode\":{POINTS}}}"));
        }
        put(
            out,
            format_args!(
                ",\"bufferViews\":[{views}],\"accessors\":[{accessors}],\"meshes\":[{{\"primitives\":[{}]}}]",
                primitives.join(",")
            ),
        );
    }
}
