//! `tiletool verify`: proves a tile file, and compares it with its input.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use delaunay_tiles::peak_memory;
use serde::Serialize;

use crate::against::{self, Against, Compared};
use crate::common::{self, MemoryArgs, thousands};
use crate::input_args::InputArgs;
use crate::lines::LineArgs;
use crate::unchanged::Unchanged;

/// Check a tile file: checksums and structure; with --deep, that it is the Delaunay triangulation; with --against and the
/// lines and sites of the build, that it holds all of its input, and nothing else.
///
/// The first thing that is wrong is named with its tile and triangle, or file and line, and the exit code is 1. The file is
/// read once for each part of the input that fits in three quarters of the memory, at 40 bytes a point, 48 a site and 72 a segment;
/// the points once for each part of the segments between records that fits in an eighth, at 72 bytes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool verify --deep survey.tiles --against survey.laz
  tiletool verify --deep town.tiles --obstacles houses.geojson --walls fences.geojson --sites shops.csv")]
pub struct VerifyArgs {
    /// The tile file
    file: PathBuf,
    /// Prove the triangulation: orientation, stars, convex hull, agreement across tiles, empty circles, regions and holes
    #[arg(long)]
    deep: bool,
    /// Look up every point of these inputs too, read with the same options as for the build
    #[arg(long, value_name = "INPUT", num_args = 1..)]
    against: Vec<PathBuf>,
    #[command(flatten)]
    lines: LineArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    input: InputArgs,
}

#[derive(Default, Serialize)]
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
    regions: u64,
    hole_regions: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_points: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_segments: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_sites: Option<u64>,
    /// Whether segments were compared as they were split.
    #[serde(skip)]
    is_split: bool,
    peak_memory_bytes: Option<u64>,
}

/// Checks a file.
pub fn run(args: VerifyArgs) -> anyhow::Result<()> {
    let mut output = Output {
        deep: args.deep,
        ..Output::default()
    };
    let done = common::block_on(check(&args, &mut output)).with_context(|| common::shown(&args.file));
    output.ok = done.is_ok();
    if args.json {
        output.peak_memory_bytes = peak_memory();
        output.error = done.as_ref().err().map(|error| format!("{error:#}"));
        common::print_json(&output)?;
        return done;
    }
    done?;
    common::print(&output.text())
}

impl Output {
    /// What was proven, for people.
    fn text(&self) -> String {
        let [vertices, triangles, tiles, edges] =
            [self.vertices, self.triangles, self.tiles, self.edges].map(thousands);
        let mut text = format!(
            "{vertices} vertices and {triangles} triangles in {tiles} tiles: checksums and structure are right\n"
        );
        if self.deep {
            text += &match self.constraint_edges {
                0 => format!("It is the Delaunay triangulation: {edges} edges proven\n"),
                constraints => format!(
                    "It is the constrained Delaunay triangulation: {edges} edges proven, of which {} are constraints\n",
                    thousands(constraints)
                ),
            };
        }
        if self.regions > 0 {
            let [regions, holes] = [self.regions, self.hole_regions].map(thousands);
            text +=
                &format!("{regions} regions end at constraints only; {holes} of them are holes, each for a reason\n");
        }
        if let Some(points) = self.input_points.map(thousands) {
            text += &format!("All {points} points of the input are in it, and nothing else\n");
        }
        if let Some(segments) = self.input_segments.map(thousands) {
            let split = match self.is_split {
                true => ", split again where they cross each other, or borders,",
                false => "",
            };
            text += &format!(
                "All {segments} segments of the input{split} are chains of edges that know their line, and no other edge is a constraint\n"
            );
        }
        if let Some(sites) = self.input_sites.filter(|&sites| sites > 0) {
            text += &format!("All {} sites of the input are in it, and no others\n", thousands(sites));
        }
        text
    }
}

async fn check(args: &VerifyArgs, output: &mut Output) -> anyhow::Result<()> {
    let mut against = Against {
        inputs: &args.against,
        options: args.input.options(),
        lines: &args.lines,
        added: Vec::new(),
        memory: args.memory.bytes() / 8,
        split_memory: args.memory.bytes() / 2,
        files: Unchanged::default(),
    };
    let mut reader = args.memory.open(&args.file).await?;
    against.added = reader.directory().metadata.lines.clone();
    let is_split = against.is_split(&reader)?;
    let report = reader.verify(args.deep).await?;
    output.tiles = report.tiles;
    output.vertices = report.vertices;
    output.triangles = report.triangles;
    output.edges = report.edges;
    output.constraint_edges = report.constraint_edges;
    output.regions = report.regions;
    output.hole_regions = report.hole_regions;
    if against.is_empty() {
        return Ok(());
    }
    let mut others = against.byte_size();
    if is_split {
        against.split_memory = against::split_memory(&reader.directory().metadata, args.memory.bytes());
        others += against.split_memory;
    }
    if others > 0 {
        reader = args.memory.open_beside(&args.file, others).await?;
    }
    let Compared {
        points,
        segments,
        sites,
    } = against.compare(&reader, is_split).await?;
    output.input_points = Some(points);
    output.input_segments = segments;
    output.is_split = is_split;
    output.input_sites = sites;
    Ok(())
}
