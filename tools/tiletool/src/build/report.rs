//! The reports of `tiletool build` about a finished build, for programs and for people.

use std::path::Path;

use delaunay_tiles::{BuildSummary, Phase, Waits};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use crate::common::{self, bytes, counted, share, thousands};
use crate::lines::LineInput;
use crate::overviews::MadeOverviews;
use crate::plot::Plotted;
use crate::points::PointsRead;

/// Counts of the input, known after it was read. A resumed build has them from the build that it
/// resumes.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(super) struct InputCounts {
    pub(super) records: u64,
    pub(super) withheld: u64,
    pub(super) filtered: u64,
    pub(super) invalid: u64,
    #[serde(default)]
    pub(super) segments: u64,
    pub(super) input_bytes: u64,
    pub(super) notes: Vec<String>,
}

impl InputCounts {
    pub(super) fn new(points: &PointsRead, lines: &LineInput) -> Self {
        Self {
            records: points.records,
            withheld: points.withheld,
            filtered: points.filtered,
            invalid: points.invalid,
            segments: lines.segments(),
            input_bytes: points.bytes + lines.bytes_read(),
            notes: points.notes.iter().cloned().chain(lines.notes()).collect(),
        }
    }
}

/// The output of `--json`. Its keys are stable.
pub(super) struct BuildReport<'a> {
    pub(super) summary: &'a BuildSummary,
    pub(super) read: &'a InputCounts,
    /// Bytes of the tiles before they were compressed, if they were.
    pub(super) raw_bytes: Option<u64>,
    pub(super) plot: Option<&'a Plotted>,
    pub(super) overviews: Option<&'a MadeOverviews>,
}

#[derive(Serialize)]
struct PhaseOutput {
    name: &'static str,
    seconds: f64,
    bytes_read: u64,
    bytes_written: u64,
}

/// Waiting times in seconds, summed over the threads that waited.
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

impl Serialize for BuildReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self {
            summary,
            read,
            raw_bytes,
            ..
        } = self;
        let counts = [
            ("records", read.records),
            ("points", summary.points),
            ("withheld", read.withheld),
            ("filtered", read.filtered),
            ("invalid", read.invalid),
            ("duplicates", summary.duplicates),
            ("segments", read.segments),
            ("added_vertices", summary.added_vertices),
            ("vertices", summary.vertices),
            ("triangles", summary.triangles),
            ("border_triangles", summary.border_triangles),
            ("hull_edges", summary.hull_edges),
            ("constraint_edges", summary.constraint_edges),
            ("held_triangles", summary.held_triangles),
            ("deferred_segments", summary.deferred_segments),
            ("crossings", summary.crossings),
            ("split_points", summary.split_points),
            ("inverted_parts", summary.inverted_parts),
            ("regions", summary.regions),
            ("hole_regions", summary.hole_regions),
            ("hole_triangles", summary.hole_triangles),
            ("ponds", summary.ponds),
            ("flattened", summary.flattened),
            ("sites", summary.sites),
            ("sites_in_holes", summary.sites_in_holes),
            ("tiles", summary.tiles),
            ("input_bytes", read.input_bytes),
            ("file_bytes", summary.file_bytes),
        ];
        let mut map = serializer.serialize_map(None)?;
        for (key, count) in counts {
            map.serialize_entry(key, &count)?;
        }
        if let Some(raw_bytes) = raw_bytes {
            map.serialize_entry("raw_tile_bytes", raw_bytes)?;
        }
        map.serialize_entry("bytes_per_vertex", &share(summary.file_bytes, summary.vertices))?;
        map.serialize_entry("seconds", &seconds(summary))?;
        map.serialize_entry("peak_memory_bytes", &summary.peak_memory)?;
        map.serialize_entry("phases", &self.phases())?;
        map.serialize_entry("levels", &self.levels())?;
        map.serialize_entry("blocks", &summary.blocks)?;
        map.serialize_entry("resumed_blocks", &summary.resumed_blocks)?;
        map.serialize_entry("waits", &WaitsOutput::new(&summary.waits))?;
        map.serialize_entry("notes", &read.notes)?;
        self.serialize_extras(&mut map)?;
        map.end()
    }
}

impl BuildReport<'_> {
    /// Adds what the options ask for.
    fn serialize_extras<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        if let Some(made) = self.overviews {
            map.serialize_entry("overview_list", &made.rows)?;
            map.serialize_entry("overviews_seconds", &made.summary.seconds)?;
        }
        match self.plot {
            Some(plot) => map.serialize_entry("plot", plot),
            None => Ok(()),
        }
    }

    fn phases(&self) -> Vec<PhaseOutput> {
        // The builder does not count the bytes from which the points were read.
        let of_input = |phase| match phase == Phase::Read && self.summary.resumed_blocks == 0 {
            true => self.read.input_bytes,
            false => 0,
        };
        let phases = self.summary.phases.iter().map(|phase| PhaseOutput {
            name: phase.phase.name(),
            seconds: phase.time.as_secs_f64(),
            bytes_read: phase.bytes_read + of_input(phase.phase),
            bytes_written: phase.bytes_written,
        });
        phases.collect()
    }

    fn levels(&self) -> Vec<LevelOutput> {
        let levels = self.summary.levels.iter().zip(0..).map(|(level, number)| LevelOutput {
            level: number,
            nodes: level.nodes,
            vertices: level.vertices,
            settled_triangles: level.settled,
            seam_vertices: level.seam_vertices,
            seam_share: share(level.seam_vertices, self.summary.vertices),
        });
        levels.collect()
    }
}

impl WaitsOutput {
    fn new(waits: &Waits) -> Self {
        Self {
            computing_for_blocks: waits.computing_for_blocks.as_secs_f64(),
            computing_for_writing: waits.computing_for_writing.as_secs_f64(),
            blocks_for_computing: waits.blocks_for_computing.as_secs_f64(),
        }
    }
}

fn seconds(summary: &BuildSummary) -> f64 {
    summary.phases.iter().map(|phase| phase.time.as_secs_f64()).sum()
}

/// Returns the report for people.
pub(super) fn report(output: &Path, summary: &BuildSummary, read: &InputCounts, raw_bytes: Option<u64>) -> String {
    let mut rows = vec![("input", input_row(summary, read))];
    rows.extend(line_rows(summary, read));
    rows.extend(output_rows(summary, raw_bytes));
    let mut text = format!(
        "{}: {}, {} and {} in {}\n",
        common::shown(output),
        counted(summary.vertices, "vertex", "vertices"),
        counted(summary.triangles, "triangle", "triangles"),
        counted(summary.hull_edges, "hull edge", "hull edges"),
        counted(summary.tiles, "tile", "tiles")
    );
    for (name, value) in rows {
        text += &format!("  {name:<8} {value}\n");
    }
    text
}

/// Describes the points, and those that were left out.
fn input_row(summary: &BuildSummary, read: &InputCounts) -> String {
    let mut text = counted(summary.points, "point", "points");
    for (count, what) in [
        (summary.duplicates, "merged with points at the same position"),
        (read.withheld, "withheld"),
        (read.filtered, "left out by the filters"),
        (read.invalid, "invalid"),
    ] {
        if count > 0 {
            text += &format!(", {} {what}", thousands(count));
        }
    }
    text + &format!("; {}", bytes(read.input_bytes))
}

/// Describes lines, regions and sites, if there are any.
fn line_rows(summary: &BuildSummary, read: &InputCounts) -> Vec<(&'static str, String)> {
    let mut rows = Vec::new();
    if read.segments > 0 {
        let lines = format!(
            "{}, {}, {} added; {:.2} % of the triangles held back",
            counted(read.segments, "segment", "segments"),
            counted(summary.constraint_edges, "constraint edge", "constraint edges"),
            counted(summary.added_vertices, "vertex", "vertices"),
            100.0 * share(summary.held_triangles, summary.triangles)
        );
        rows.push(("lines", lines));
    }
    if summary.deferred_segments > 0 {
        let segments = counted(summary.deferred_segments, "segment", "segments");
        let deferred = format!("{segments} inserted at the end, to hold back fewer triangles");
        rows.push(("deferred", deferred));
    }
    if summary.split_points > 0 {
        let points = counted(summary.split_points, "point", "points");
        let crossings = counted(summary.crossings, "crossing", "crossings");
        rows.push(("split", format!("{crossings}; lines were split at {points}")));
    }
    if summary.regions > 0 {
        let holes = counted(summary.hole_regions, "hole", "holes");
        let triangles = counted(summary.hole_triangles, "triangle", "triangles");
        let regions = thousands(summary.regions);
        rows.push(("regions", format!("{regions}, including {holes} with {triangles}")));
    }
    if summary.ponds > 0 {
        let ponds = format!(
            "{}; {} in them took the lowest z of the shore",
            thousands(summary.ponds),
            counted(summary.flattened, "point", "points")
        );
        rows.push(("ponds", ponds));
    }
    if summary.sites > 0 {
        rows.push(("sites", thousands(summary.sites)));
    }
    rows
}

/// Describes the output file, and the time and memory of the build.
fn output_rows(summary: &BuildSummary, raw_bytes: Option<u64>) -> Vec<(&'static str, String)> {
    let per_vertex = share(summary.file_bytes, summary.vertices);
    let phases = summary.phases.iter();
    let phases = phases.map(|p| format!("{} {:.2} s", p.phase.name(), p.time.as_secs_f64()));
    let phases = phases.collect::<Vec<_>>().join(", ");
    let raw = raw_bytes.map(|raw| format!("; {} of tiles before compression", bytes(raw)));
    let mut rows = vec![
        (
            "output",
            format!(
                "{}, {per_vertex:.1} bytes per vertex{}",
                bytes(summary.file_bytes),
                raw.unwrap_or_default()
            ),
        ),
        ("time", format!("{:.2} s: {phases}", seconds(summary))),
    ];
    let levels = summary.levels.iter().filter(|level| level.seam_vertices > 0);
    let levels = levels.map(|level| format!("{:.2} %", 100.0 * share(level.seam_vertices, summary.vertices)));
    let levels: Vec<_> = levels.collect();
    if !levels.is_empty() {
        let seams = format!(
            "{} of the vertices at each level, from the leaves up",
            levels.join(", ")
        );
        rows.push(("seams", seams));
    }
    if let Some(peak) = summary.peak_memory {
        rows.push(("memory", format!("{} at peak", bytes(peak))));
    }
    rows
}
