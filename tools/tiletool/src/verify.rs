//! `tiletool verify`: checks a tile file, and compares it with its input.

use std::path::PathBuf;

use clap::Args;
use delaunay_tiles::{overviews, peak_memory};
use serde::Serialize;

use crate::against::{self, BuildInput, ComparedCounts};
use crate::common::{self, MemoryArgs, counted, thousands};
use crate::input_args::InputArgs;
use crate::lines::LineArgs;
use crate::unchanged::Unchanged;

/// Check that a tile file is valid and holds its input
///
/// By default, checksums and structure are checked. --deep also proves that the file holds the
/// Delaunay triangulation. --against and the files of lines and sites of the build prove that the
/// file holds all of this input and nothing else. Overviews are checked too, unless they are stale.
///
/// The first fault is reported with its tile and triangle, or with its file and line, and the exit
/// code is 1.
///
/// The tile file is read once for each part of the input that fits in three quarters of the memory,
/// at 40 bytes per point, 48 per site and 72 per segment. The points are read once for each part of
/// the segments between record numbers that fits in an eighth of the memory, at 72 bytes per
/// segment.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool verify --deep survey.tiles --against survey.laz
  tiletool verify --deep town.tiles --obstacles houses.geojson --walls fences.geojson --sites shops.csv")]
pub struct VerifyArgs {
    /// Tile file to check
    file: PathBuf,
    /// Prove that the file holds the Delaunay triangulation
    ///
    /// This checks orientation, stars, the convex hull, agreement across tiles, empty circles,
    /// regions and holes.
    #[arg(long)]
    deep: bool,
    /// Files of points to compare with, read with the same options as for the build
    #[arg(long, value_name = "INPUT", num_args = 1..)]
    against: Vec<PathBuf>,
    #[command(flatten)]
    lines: LineArgs,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    input: InputArgs,
}

#[derive(Default, Serialize)]
struct VerifyReport {
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
    overviews: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_points: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_segments: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_sites: Option<u64>,
    /// Whether the segments were split before they were compared.
    #[serde(skip)]
    is_split: bool,
    peak_memory_bytes: Option<u64>,
}

/// Checks a tile file.
pub fn run(args: VerifyArgs) -> anyhow::Result<()> {
    let mut report = VerifyReport {
        deep: args.deep,
        ..VerifyReport::default()
    };
    let name = common::shown(&args.file);
    let done = common::wait_for("verifying", check(&args, &mut report)).map_err(|error| {
        // Errors of reading the file name it.
        match error.to_string().starts_with(&name) {
            true => error,
            false => error.context(name),
        }
    });
    report.ok = done.is_ok();
    if args.json {
        report.peak_memory_bytes = peak_memory();
        report.error = done.as_ref().err().map(|error| format!("{error:#}"));
        common::print_json("the result", &report)?;
        return done;
    }
    done?;
    common::print_summary("the result", &report.text())
}

impl VerifyReport {
    /// Returns the report for people.
    fn text(&self) -> String {
        let mut text = format!(
            "{}, {} and {}: checksums and structure are correct\n",
            counted(self.tiles, "tile", "tiles"),
            counted(self.vertices, "vertex", "vertices"),
            counted(self.triangles, "triangle", "triangles"),
        );
        if self.deep {
            let edges = counted(self.edges, "edge", "edges");
            text += &match self.constraint_edges {
                0 => format!("The file holds the Delaunay triangulation: {edges} proven\n"),
                constraints => format!(
                    "The file holds the constrained Delaunay triangulation: {edges} proven, including {}\n",
                    counted(constraints, "constraint", "constraints")
                ),
            };
        }
        if self.regions > 0 {
            text += &format!(
                "{}, separated only by constraints; all holes ({}) are due to obstacles, hole points or the exterior\n",
                counted(self.regions, "region", "regions"),
                thousands(self.hole_regions),
            );
        }
        if self.overviews > 0 {
            let count = counted(self.overviews, "overview", "overviews");
            text += &match self.deep {
                true => format!(
                    "{count}: Delaunay triangulations of subsets of the vertices, with errors as the file says\n"
                ),
                false => format!("{count}: checksums and structure are correct\n"),
            };
        }
        if let Some(points) = self.input_points.map(thousands) {
            text += &format!("The file holds all points of the input ({points}) and no others\n");
        }
        if let Some(segments) = self.input_segments.map(thousands) {
            let split = match self.is_split {
                true => ", split where they cross each other or cell borders,",
                false => "",
            };
            text += &format!(
                "All segments of the input ({segments}){split} are chains of edges that name their lines, and no other edge is a constraint\n"
            );
        }
        if let Some(sites) = self.input_sites.filter(|&sites| sites > 0) {
            text += &format!(
                "The file holds all sites of the input ({}) and no others\n",
                thousands(sites)
            );
        }
        text
    }
}

async fn check(args: &VerifyArgs, report: &mut VerifyReport) -> anyhow::Result<()> {
    let mut input = BuildInput {
        inputs: &args.against,
        options: args.input.options(),
        lines: &args.lines,
        added: Vec::new(),
        memory: args.memory.bytes() / 8,
        split_memory: args.memory.bytes() / 2,
        ponds: None,
        files: Unchanged::default(),
    };
    let mut reader = args.memory.open(&args.file).await?;
    // After lines were removed, they are compared whatever their numbers.
    if reader.metadata().line_removals == 0 {
        input.added = reader.lists().await?.lines.clone();
    }
    let is_split = input.is_split(&reader).await?;
    let verified = reader.verify(args.deep).await?;
    report.tiles = verified.tiles;
    report.vertices = verified.vertices;
    report.triangles = verified.triangles;
    report.edges = verified.edges;
    report.constraint_edges = verified.constraint_edges;
    report.regions = verified.regions;
    report.hole_regions = verified.hole_regions;
    report.overviews = overviews::verify(&reader, args.deep).await? as u64;
    if input.is_empty() {
        return Ok(());
    }
    let mut others = input.byte_size() + input.find_ponds(&reader).await?;
    if is_split {
        input.split_memory = against::split_memory(reader.metadata(), args.memory.bytes());
        others += input.split_memory;
    }
    if others > 0 {
        reader = args.memory.open_beside(&args.file, others).await?;
    }
    let ComparedCounts {
        points,
        segments,
        sites,
    } = input.compare(&reader, is_split).await?;
    report.input_points = Some(points);
    report.input_segments = segments;
    report.is_split = is_split;
    report.input_sites = sites;
    Ok(())
}
