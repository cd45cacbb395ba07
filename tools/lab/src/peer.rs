//! Other triangulators on the same files, each in a process of its own.
//!
//! `lab peer spade` is that process for crate spade, which works in memory. The program `triangle`
//! (Shewchuk 1996) is run if it is installed. Both keep their result in memory or write it as text,
//! without tiles; only the counts of their output are used.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use delaunay_tiles::peak_memory;
use serde::Serialize;
use spade::{ConstrainedDelaunayTriangulation, DelaunayTriangulation, Point2, Triangulation};

use tiletool::common;

/// Another triangulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Peer {
    /// Crate spade, in memory
    Spade,
    /// Shewchuk's program triangle, in memory, if it is installed
    Triangle,
}

impl Peer {
    /// Returns its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Spade => "spade",
            Self::Triangle => "triangle",
        }
    }
}

/// Triangulate raw points, and segments, in memory with crate spade. For the experiments.
#[derive(Args, Clone, Debug)]
pub struct PeerArgs {
    /// Raw little-endian f64, x y x y ...
    points: PathBuf,
    /// Raw little-endian u32, pairs of record numbers
    #[arg(long)]
    segments: Option<PathBuf>,
}

/// The result, which goes to `lab build` as JSON.
#[derive(Serialize)]
struct Report {
    vertices: u64,
    triangles: u64,
    constraint_edges: u64,
    read_seconds: f64,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Triangulates with spade.
pub fn run(args: PeerArgs) -> anyhow::Result<()> {
    let began = Instant::now();
    let points = read_points(&args.points)?;
    let segments = args.segments.as_deref().map(read_segments).transpose()?;
    let read_seconds = began.elapsed().as_secs_f64();
    let (vertices, triangles, constraint_edges) = match segments {
        None => {
            let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load(points)?;
            (mesh.num_vertices(), mesh.num_inner_faces(), 0)
        }
        Some(segments) => {
            let is_known = segments.iter().flatten().all(|&end| end < points.len());
            ensure!(
                is_known,
                "{}: a segment has an end that is no point",
                args.points.display()
            );
            let mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points, segments)?;
            (mesh.num_vertices(), mesh.num_inner_faces(), mesh.num_constraints())
        }
    };
    common::print_json(
        "the report",
        &Report {
            vertices: vertices as u64,
            triangles: triangles as u64,
            constraint_edges: constraint_edges as u64,
            read_seconds,
            seconds: began.elapsed().as_secs_f64() - read_seconds,
            peak_memory_bytes: peak_memory(),
        },
    )
}

fn read_points(path: &Path) -> anyhow::Result<Vec<Point2<f64>>> {
    records(path, |[x, y]: [[u8; 8]; 2]| {
        Point2::new(f64::from_le_bytes(x), f64::from_le_bytes(y))
    })
}

fn read_segments(path: &Path) -> anyhow::Result<Vec<[usize; 2]>> {
    records(path, |ends: [[u8; 4]; 2]| {
        ends.map(|end| u32::from_le_bytes(end) as usize)
    })
}

/// Reads all records of two numbers of `W` bytes.
fn records<const W: usize, T>(path: &Path, record: impl Fn([[u8; W]; 2]) -> T) -> anyhow::Result<Vec<T>> {
    let context = || format!("cannot read {}", path.display());
    let file = File::open(path).with_context(context)?;
    let length = file.metadata().with_context(context)?.len();
    let count = usize::try_from(length / (2 * W as u64)).with_context(context)?;
    let mut input = BufReader::with_capacity(1 << 20, file);
    let mut records = Vec::with_capacity(count);
    let mut bytes = [[0; W]; 2];
    for _ in 0..count {
        input.read_exact(bytes.as_flattened_mut()).with_context(context)?;
        records.push(record(bytes));
    }
    Ok(records)
}

/// Writes points and segments in a format of the program triangle: `.node`, or `.poly` if there are
/// segments.
pub fn write_for_triangle(points: &Path, segments: Option<&Path>, output: &Path) -> anyhow::Result<()> {
    let points = read_points(points)?;
    let segments = segments.map(read_segments).transpose()?;
    let write = || -> io::Result<()> {
        let mut out = BufWriter::with_capacity(1 << 20, File::create(output)?);
        writeln!(out, "{} 2 0 0", points.len())?;
        for (point, number) in points.iter().zip(0u64..) {
            writeln!(out, "{number} {} {}", point.x, point.y)?;
        }
        if let Some(segments) = &segments {
            writeln!(out, "{} 0", segments.len())?;
            for ([from, to], number) in segments.iter().zip(0u64..) {
                writeln!(out, "{number} {from} {to}")?;
            }
            writeln!(out, "0")?;
        }
        out.flush()
    };
    write().with_context(|| format!("cannot write {}", output.display()))
}

/// Returns the path of the program triangle, if it is installed.
pub fn find_triangle() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .map(|folder| folder.join("triangle"))
        .find(|path| path.is_file())
}
