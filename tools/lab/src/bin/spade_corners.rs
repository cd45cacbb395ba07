//! Triangulates a file of raw points with crate spade, and writes the corners of its triangles.
//!
//! It is what somebody who uses spade writes for this: `tools/lab/comparison/compare.py` measures the
//! whole process beside other programs, and counts its lines.

use std::fs;
use std::io::{BufWriter, Write};

use clap::Parser;
use spade::{ConstrainedDelaunayTriangulation, DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Triangulate raw points, and segments, in memory with crate spade, and write corners as raw u32.
#[derive(Parser)]
struct Arguments {
    /// Raw little-endian f64, x y x y ...
    points: String,
    /// File to write: three record numbers for each triangle, raw little-endian u32
    corners: String,
    /// Pairs of record numbers, raw little-endian u32
    segments: Option<String>,
}

struct Vertex {
    position: Point2<f64>,
    record: u32,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

fn write(mesh: &impl Triangulation<Vertex = Vertex>, path: &str) -> anyhow::Result<()> {
    let mut output = BufWriter::with_capacity(1 << 20, fs::File::create(path)?);
    for triangle in mesh.inner_faces() {
        for vertex in triangle.vertices() {
            output.write_all(&vertex.data().record.to_le_bytes())?;
        }
    }
    Ok(output.flush()?)
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let bytes = fs::read(&arguments.points)?;
    let (pairs, _) = bytes.as_chunks::<16>();
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    let vertices = pairs.iter().zip(0..).map(|(pair, record)| Vertex {
        position: Point2::new(number(&pair[..8]), number(&pair[8..])),
        record,
    });
    let vertices: Vec<_> = vertices.collect();
    drop(bytes);
    let Some(segments) = arguments.segments else {
        return write(
            &DelaunayTriangulation::<Vertex>::bulk_load(vertices)?,
            &arguments.corners,
        );
    };
    let bytes = fs::read(segments)?;
    let (ends, _) = bytes.as_chunks::<4>();
    let (pairs, _) = ends.as_chunks::<2>();
    let segments = pairs
        .iter()
        .map(|pair| pair.map(|end| u32::from_le_bytes(end) as usize));
    let mesh = ConstrainedDelaunayTriangulation::<Vertex>::bulk_load_cdt(vertices, segments.collect())?;
    write(&mesh, &arguments.corners)
}
