//! What `tiletool build` tells of a finished build, to programs and to people.

use std::path::Path;

use delaunay_tiles::{BuildSummary, Phase};
use serde::{Deserialize, Serialize};

use crate::common;

/// What is known of the input once it was read; a build that is resumed has it from the build before.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(super) struct Read {
    pub(super) records: u64,
    pub(super) withheld: u64,
    pub(super) filtered: u64,
    pub(super) invalid: u64,
    #[serde(default)]
    pub(super) segments: u64,
    pub(super) input_bytes: u64,
    pub(super) notes: Vec<String>,
}

/// The keys of `--json`, which are stable.
#[derive(Serialize)]
pub(super) struct Output<'a> {
    records: u64,
    points: u64,
    withheld: u64,
    filtered: u64,
    invalid: u64,
    duplicates: u64,
    segments: u64,
    ends: u64,
    vertices: u64,
    triangles: u64,
    border_triangles: u64,
    hull_edges: u64,
    constraint_edges: u64,
    held_triangles: u64,
    deferred_segments: u64,
    crossings: u64,
    split_points: u64,
    inverted_regions: u64,
    regions: u64,
    hole_regions: u64,
    hole_triangles: u64,
    sites: u64,
    tiles: u64,
    input_bytes: u64,
    file_bytes: u64,
    bytes_per_vertex: f64,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    phases: Vec<PhaseOutput>,
    levels: Vec<LevelOutput>,
    blocks: u64,
    resumed_blocks: u64,
    waits: WaitsOutput,
    notes: &'a [String],
}

#[derive(Serialize)]
struct PhaseOutput {
    name: &'static str,
    seconds: f64,
    bytes_read: u64,
    bytes_written: u64,
}

/// Seconds, summed over the threads that waited.
#[derive(Serialize)]
struct WaitsOutput {
    computing_for_blocks: f64,
    computing_for_writing: f64,
    blocks_for_computing: f64,
}

#[derive(Serialize)]
struct LevelOutput {
    level: usize,
    nodes: u64,
    vertices: u64,
    settled_triangles: u64,
    seam_vertices: u64,
    seam_share: f64,
}

impl<'a> Output<'a> {
    pub(super) fn new(summary: &BuildSummary, read: &'a Read) -> Self {
        let phases = summary.phases.iter().map(|phase| PhaseOutput {
            name: phase.phase.name(),
            seconds: phase.time.as_secs_f64(),
            bytes_read: phase.bytes_read
                + if phase.phase == Phase::Read && summary.resumed_blocks == 0 {
                    read.input_bytes
                } else {
                    0
                },
            bytes_written: phase.bytes_written,
        });
        let levels = summary.levels.iter().zip(0..).map(|(level, number)| LevelOutput {
            level: number,
            nodes: level.nodes,
            vertices: level.vertices,
            settled_triangles: level.settled,
            seam_vertices: level.seam_vertices,
            seam_share: share(level.seam_vertices, summary.vertices),
        });
        Self {
            records: read.records,
            points: summary.points,
            withheld: read.withheld,
            filtered: read.filtered,
            invalid: read.invalid,
            duplicates: summary.duplicates,
            segments: read.segments,
            ends: summary.ends,
            vertices: summary.vertices,
            triangles: summary.triangles,
            border_triangles: summary.border_triangles,
            hull_edges: summary.hull_edges,
            constraint_edges: summary.constraint_edges,
            held_triangles: summary.held_triangles,
            deferred_segments: summary.deferred_segments,
            crossings: summary.crossings,
            split_points: summary.split_points,
            inverted_regions: summary.inverted_regions,
            regions: summary.regions,
            hole_regions: summary.hole_regions,
            hole_triangles: summary.hole_triangles,
            sites: summary.sites,
            tiles: summary.tiles,
            input_bytes: read.input_bytes,
            file_bytes: summary.file_bytes,
            bytes_per_vertex: share(summary.file_bytes, summary.vertices),
            seconds: seconds(summary),
            peak_memory_bytes: summary.peak_memory,
            phases: phases.collect(),
            levels: levels.collect(),
            blocks: summary.blocks,
            resumed_blocks: summary.resumed_blocks,
            waits: WaitsOutput {
                computing_for_blocks: summary.waits.computing_for_blocks.as_secs_f64(),
                computing_for_writing: summary.waits.computing_for_writing.as_secs_f64(),
                blocks_for_computing: summary.waits.blocks_for_computing.as_secs_f64(),
            },
            notes: &read.notes,
        }
    }
}

fn seconds(summary: &BuildSummary) -> f64 {
    summary.phases.iter().map(|phase| phase.time.as_secs_f64()).sum()
}

/// A quotient that is 0 where there is nothing to divide by.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

pub(super) fn report(output: &Path, summary: &BuildSummary, read: &Read) -> String {
    let thousands = common::thousands;
    let mut text = format!(
        "{}: {} vertices, {} triangles, {} hull edges in {} tiles\n",
        common::shown(output),
        thousands(summary.vertices),
        thousands(summary.triangles),
        thousands(summary.hull_edges),
        thousands(summary.tiles)
    );
    let mut left_out = format!("{} points", thousands(summary.points));
    for (count, what) in [
        (summary.duplicates, "merged with others at the same place"),
        (read.withheld, "withheld"),
        (read.filtered, "not of the classes or returns asked for"),
        (read.invalid, "invalid"),
    ] {
        if count > 0 {
            left_out += &format!(", {} {what}", thousands(count));
        }
    }
    text += &format!("  input   {left_out}; {}\n", common::bytes(read.input_bytes));
    if read.segments > 0 {
        text += &format!(
            "  lines   {} segments, {} constraint edges, {} vertices at their ends; {:.2} % of the triangles held\n",
            thousands(read.segments),
            thousands(summary.constraint_edges),
            thousands(summary.ends),
            100.0 * share(summary.held_triangles, summary.triangles)
        );
    }
    if summary.deferred_segments > 0 {
        text += &format!(
            "  late    {} segments would have held too many triangles, and were inserted at the end\n",
            thousands(summary.deferred_segments)
        );
    }
    if summary.split_points > 0 {
        text += &format!(
            "  split   lines at {} points, and {} pairs that crossed\n",
            thousands(summary.split_points),
            thousands(summary.crossings)
        );
    }
    if summary.regions > 0 {
        text += &format!(
            "  regions {}, of which {} are holes, with {} triangles\n",
            thousands(summary.regions),
            thousands(summary.hole_regions),
            thousands(summary.hole_triangles)
        );
    }
    if summary.sites > 0 {
        text += &format!("  sites   {}\n", thousands(summary.sites));
    }
    text += &format!(
        "  output  {}, {:.1} bytes per vertex\n",
        common::bytes(summary.file_bytes),
        share(summary.file_bytes, summary.vertices)
    );
    let phases = summary
        .phases
        .iter()
        .map(|p| format!("{} {:.2} s", p.phase.name(), p.time.as_secs_f64()));
    text += &format!(
        "  time    {:.2} s: {}\n",
        seconds(summary),
        phases.collect::<Vec<_>>().join(", ")
    );
    let levels = summary
        .levels
        .iter()
        .filter(|level| level.seam_vertices > 0)
        .map(|level| format!("{:.2} %", 100.0 * share(level.seam_vertices, summary.vertices)));
    let levels: Vec<_> = levels.collect();
    if !levels.is_empty() {
        text += &format!("  seams   {} of the vertices, from the leaves up\n", levels.join(", "));
    }
    if let Some(peak) = summary.peak_memory {
        text += &format!("  memory  {} at the peak\n", common::bytes(peak));
    }
    text
}
