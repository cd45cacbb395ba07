//! `tiletool verify`: proves a tile file, and compares it with its input.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use delaunay_tiles::build::peak_memory;
use delaunay_tiles::input::{PointBatch, PointSource, SegmentBatch, SegmentSource};
use serde::Serialize;

use crate::common::{self, MemoryArgs};
use crate::input_args::InputArgs;

/// Check a tile file: checksums and structure; with --deep, that it is the Delaunay triangulation; with --against,
/// that it holds every point of its input.
///
/// The first thing that is wrong is named with its tile and triangle, and the exit code is 1. With --against, the file is
/// read once for each part of the inputs' points that fits in three quarters of the memory, at 40 bytes a point.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool verify --deep survey.tiles --against survey.laz")]
pub struct VerifyArgs {
    /// The tile file
    file: PathBuf,
    /// Prove the triangulation: orientation, stars, convex hull, agreement across tiles, empty circles
    #[arg(long)]
    deep: bool,
    /// Look up every point of these inputs too, read with the same options as for the build
    #[arg(long, value_name = "INPUT", num_args = 1..)]
    against: Vec<PathBuf>,
    /// With --against: the segments of the build, whose ends are vertices too
    #[arg(long, value_name = "FILE")]
    segments: Vec<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    input: InputArgs,
}

#[derive(Serialize)]
struct Output {
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    tiles: u64,
    vertices: u64,
    triangles: u64,
    deep: bool,
    edges: u64,
    constraint_edges: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_points: Option<u64>,
    peak_memory_bytes: Option<u64>,
}

/// Checks a file.
pub fn run(args: VerifyArgs) -> anyhow::Result<()> {
    let mut output = Output {
        ok: false,
        error: None,
        tiles: 0,
        vertices: 0,
        triangles: 0,
        deep: args.deep,
        edges: 0,
        constraint_edges: 0,
        input_points: None,
        peak_memory_bytes: None,
    };
    let done = common::block_on(check(&args, &mut output)).with_context(|| args.file.display().to_string());
    output.ok = done.is_ok();
    if args.json {
        output.peak_memory_bytes = peak_memory();
        output.error = done.as_ref().err().map(|error| format!("{error:#}"));
        common::print_json(&output)?;
        return done;
    }
    done?;
    let thousands = common::thousands;
    let mut text = format!(
        "{} vertices and {} triangles in {} tiles: checksums and structure are right\n",
        thousands(output.vertices),
        thousands(output.triangles),
        thousands(output.tiles)
    );
    if output.deep {
        text += &match output.constraint_edges {
            0 => format!(
                "It is the Delaunay triangulation: {} edges proven\n",
                thousands(output.edges)
            ),
            constraints => format!(
                "It is the constrained Delaunay triangulation: {} edges proven, of which {} are constraints\n",
                thousands(output.edges),
                thousands(constraints)
            ),
        };
    }
    if let Some(points) = output.input_points {
        text += &format!(
            "All {} points of the input are in it, and nothing else\n",
            thousands(points)
        );
    }
    common::print(&text)
}

async fn check(args: &VerifyArgs, output: &mut Output) -> anyhow::Result<()> {
    let reader = args.memory.open(&args.file).await?;
    let report = reader.verify(args.deep).await?;
    output.tiles = report.tiles;
    output.vertices = report.vertices;
    output.triangles = report.triangles;
    output.edges = report.edges;
    output.constraint_edges = report.constraint_edges;
    if !args.against.is_empty() || !args.segments.is_empty() {
        let mut points = PointSource::open(&args.against, &args.input.options())?;
        let mut ends = Ends {
            segments: SegmentSource::open(&args.segments)?,
            batch: SegmentBatch::default(),
            first: 0,
        };
        let next = |batch: &mut PointBatch| -> anyhow::Result<bool> {
            if points.next_batch(batch)? {
                ends.first = batch.records.last().map_or(0, |last| last + 1);
                return Ok(true);
            }
            ends.next_batch(batch)
        };
        let report = reader.verify_points(next).await?;
        output.input_points = Some(report.vertices);
    }
    Ok(())
}

/// The ends of segments that are given by these, numbered as a build does: behind all points.
struct Ends {
    segments: SegmentSource,
    batch: SegmentBatch,
    first: u64,
}

impl Ends {
    fn next_batch(&mut self, points: &mut PointBatch) -> anyhow::Result<bool> {
        points.clear();
        while points.is_empty() {
            if !self.segments.next_batch(&mut self.batch)? {
                return Ok(false);
            }
            points.points.extend_from_slice(self.batch.ends.as_flattened());
        }
        let next = self.first + points.len() as u64;
        points.records.extend(self.first..next);
        self.first = next;
        Ok(true)
    }
}
