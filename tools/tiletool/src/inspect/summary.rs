//! The summary of a tile file, from its directory.

use delaunay_tiles::shown;
use delaunay_tiles::store::{Directory, FORMAT_VERSION, LineSource, TileEntry, TileReader};
use serde::Serialize;

use crate::common::{bytes, counted, share, thousands};
use crate::crs::{self, System};
use crate::numbers::{self, Bounds, Coordinates, Row, percent};
use crate::overviews::OverviewRow;

/// Maximum number of input files on the screen.
const SOURCES_SHOWN: usize = 12;

/// The summary of a tile file. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct Summary {
    file: String,
    file_id: String,
    file_bytes: u64,
    format_version: u32,
    generation: u64,
    producer: String,
    backend: &'static str,
    backend_note: Option<String>,
    crs: Option<String>,
    #[serde(flatten)]
    system: System,
    sources: Vec<InputFile>,
    points: u64,
    duplicates: u64,
    vertices: u64,
    triangles: u64,
    hull_edges: u64,
    added_vertices: u64,
    constraint_edges: u64,
    has_z: bool,
    regions: u64,
    hole_regions: u64,
    hole_triangles: u64,
    exterior_is_hole: bool,
    hole_points: u64,
    sites: u64,
    crossings: u64,
    cell_borders: u64,
    lines: Vec<LineFile>,
    bounds: Option<Bounds>,
    tiles: u64,
    tile_vertices: u32,
    vertices_per_tile: Option<Distribution>,
    #[serde(flatten)]
    parts: PartSizes,
    overview_list: Vec<OverviewRow>,
    #[serde(skip)]
    rect: delaunay_tiles::geometry::Rect,
}

/// The sizes of the parts of a file.
#[derive(Serialize)]
struct PartSizes {
    core_triangles: u64,
    border_triangles: u64,
    border_triangles_share: f64,
    bytes_per_vertex: f64,
    core_bytes: u64,
    border_bytes: u64,
    raw_core_bytes: u64,
    raw_border_bytes: u64,
    cached_bytes: u64,
    directory_bytes: u64,
    overview_bytes: u64,
    other_bytes: u64,
    core_bytes_share: f64,
    border_bytes_share: f64,
    directory_bytes_share: f64,
    overview_bytes_share: f64,
    other_bytes_share: f64,
}

/// A file that points came from.
#[derive(Serialize)]
struct InputFile {
    name: String,
    records: u64,
    first_record: u64,
}

/// A file that lines came from.
#[derive(Serialize)]
struct LineFile {
    name: String,
    kind: String,
    first_line: u64,
    count: u64,
}

/// The distribution of numbers, with quartiles by nearest rank.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct Distribution {
    min: u32,
    lower_quartile: u32,
    median: u32,
    upper_quartile: u32,
    max: u32,
}

impl Distribution {
    fn of(mut values: Vec<u32>) -> Option<Self> {
        values.sort_unstable();
        let last = values.len().checked_sub(1)?;
        let at = |quarter: usize| values[(last * quarter + 2) / 4];
        Some(Self {
            min: at(0),
            lower_quartile: at(1),
            median: at(2),
            upper_quartile: at(3),
            max: at(4),
        })
    }
}

impl LineFile {
    fn new(source: &LineSource) -> Self {
        Self {
            name: source.name.clone(),
            kind: source.kind.to_string(),
            first_line: source.first,
            count: source.lines,
        }
    }
}

impl PartSizes {
    fn of(directory: &Directory, file_bytes: u64, overview_bytes: u64) -> Self {
        let Directory { metadata: m, tiles, .. } = directory;
        let sum = |part: fn(&TileEntry) -> u32| tiles.iter().map(|t| u64::from(part(t))).sum();
        let core_triangles: u64 = sum(|t| t.core_triangles);
        let [core_bytes, border_bytes]: [u64; 2] = [sum(|t| t.core.length), sum(|t| t.border.length)];
        let directory_bytes = directory.stored_bytes();
        let other_bytes = file_bytes.saturating_sub(core_bytes + border_bytes + directory_bytes + overview_bytes);
        // A contradictory file must not cause a panic here.
        let border_triangles = m.triangles.saturating_sub(core_triangles);
        Self {
            core_triangles,
            border_triangles,
            border_triangles_share: share(border_triangles, m.triangles),
            bytes_per_vertex: share(file_bytes, m.vertices),
            core_bytes,
            border_bytes,
            raw_core_bytes: sum(|t| t.core.decoded),
            raw_border_bytes: sum(|t| t.border.decoded),
            cached_bytes: tiles.iter().map(TileEntry::cached_bytes).sum(),
            directory_bytes,
            overview_bytes,
            other_bytes,
            core_bytes_share: share(core_bytes, file_bytes),
            border_bytes_share: share(border_bytes, file_bytes),
            directory_bytes_share: share(directory_bytes, file_bytes),
            overview_bytes_share: share(overview_bytes, file_bytes),
            other_bytes_share: share(other_bytes, file_bytes),
        }
    }
}

impl Summary {
    /// Creates the summary from the directory and the overviews, without reading from the file.
    pub fn new(reader: &TileReader, directory: &Directory, overview_list: Vec<OverviewRow>) -> Self {
        let Directory {
            metadata: m,
            lists,
            tiles,
            ..
        } = directory;
        let used = tiles.iter().filter(|entry| !entry.is_unused());
        let file_bytes = reader.file_length();
        let sources = lists.sources.iter().map(|source| InputFile {
            name: source.name.clone(),
            records: source.records,
            first_record: source.first,
        });
        Self {
            file: reader.name().to_owned(),
            file_id: reader.file_id().to_string(),
            file_bytes,
            format_version: FORMAT_VERSION,
            generation: reader.generation(),
            producer: m.producer.clone(),
            backend: reader.backend(),
            backend_note: reader.backend_note().map(str::to_owned),
            crs: lists.crs.clone(),
            system: System::of(lists.crs.as_deref()),
            sources: sources.collect(),
            points: m.points,
            duplicates: m.duplicates,
            vertices: m.vertices,
            triangles: m.triangles,
            hull_edges: m.hull_edges,
            added_vertices: m.ends,
            constraint_edges: m.constraint_edges,
            has_z: m.has_z,
            regions: m.regions,
            hole_regions: m.hole_regions,
            hole_triangles: m.hole_triangles,
            exterior_is_hole: m.exterior_is_hole,
            hole_points: lists.hole_points.len() as u64,
            sites: m.sites,
            crossings: m.crossings,
            cell_borders: lists.cell_borders.len() as u64,
            lines: lists.lines.iter().map(LineFile::new).collect(),
            bounds: Bounds::new(m.bounds),
            tiles: m.tiles.into(),
            tile_vertices: m.tile_vertices,
            vertices_per_tile: Distribution::of(used.map(|t| t.vertices).collect()),
            parts: PartSizes::of(directory, file_bytes, overview_list.iter().map(|row| row.bytes).sum()),
            overview_list,
            rect: m.bounds,
        }
    }

    /// Returns the summary for people.
    pub fn report(&self, coordinates: Coordinates) -> String {
        let groups = [
            self.file_rows(),
            self.input_rows(),
            self.mesh_rows(coordinates),
            self.tile_rows(),
            self.overview_rows(),
        ];
        numbers::report(&shown::text(&self.file), &groups)
    }

    fn file_rows(&self) -> Vec<Row> {
        let mut size = format!("{} ({} bytes)", bytes(self.file_bytes), thousands(self.file_bytes));
        if self.vertices > 0 {
            size += &format!(", {:.1} per vertex", self.parts.bytes_per_vertex);
        }
        let [stored, raw] = [
            self.parts.core_bytes + self.parts.border_bytes,
            self.parts.raw_core_bytes + self.parts.raw_border_bytes,
        ];
        if stored != raw {
            let percent = 100.0 * share(stored, raw);
            size += &format!("; tiles are compressed to {percent:.1} % of {}", bytes(raw));
        }
        let read_by = match &self.backend_note {
            Some(note) => format!("{}: {note}", self.backend),
            None => self.backend.to_owned(),
        };
        vec![
            ("size", size),
            ("file id", self.file_id.clone()),
            (
                "format",
                format!(
                    "version {}, generation {}",
                    self.format_version,
                    thousands(self.generation)
                ),
            ),
            ("written by", shown::text(&self.producer).into_owned()),
            ("read by", read_by),
        ]
    }

    fn input_rows(&self) -> Vec<Row> {
        let sources = self
            .sources
            .iter()
            .map(|s| (&s.name, counted(s.records, "record", "records")));
        let mut lines = files("sources", sources);
        lines.extend(files(
            "lines",
            self.lines
                .iter()
                .map(|l| (&l.name, counted(l.count, &l.kind, &format!("{}s", l.kind)))),
        ));
        lines.extend(self.crs.as_deref().map(|crs| ("CRS", crs::shown(crs))));
        let duplicates = match self.duplicates {
            0 => "no duplicates".to_owned(),
            n => format!("{} merged", counted(n, "duplicate", "duplicates")),
        };
        lines.push(("points", format!("{}, {duplicates}", thousands(self.points))));
        lines
    }

    fn mesh_rows(&self, coordinates: Coordinates) -> Vec<Row> {
        let z = if self.has_z { "with z" } else { "without z" };
        let mut lines = vec![
            ("vertices", format!("{}, {z}", thousands(self.vertices))),
            ("triangles", thousands(self.triangles)),
            ("hull edges", thousands(self.hull_edges)),
        ];
        if self.constraint_edges > 0 {
            let added = counted(self.added_vertices, "vertex", "vertices");
            let edges = counted(self.constraint_edges, "edge", "edges");
            lines.push(("constraints", format!("{edges}; {added} added")));
        }
        lines.extend(self.region_rows());
        lines.extend(numbers::bounds(self.rect, None, coordinates));
        lines
    }

    /// Returns the rows about crossings, regions, holes and sites, if there are any.
    fn region_rows(&self) -> Vec<Row> {
        let mut lines = Vec::new();
        if self.crossings > 0 {
            let crossings = thousands(self.crossings);
            lines.push(("crossings", format!("{crossings}; the lines were split there")));
        }
        if self.cell_borders > 0 {
            let borders = counted(self.cell_borders, "cell border", "cell borders");
            lines.push(("steiner", format!("lines were split at {borders}")));
        }
        if self.regions > 0 {
            lines.push(("regions", thousands(self.regions)));
        }
        if self.hole_regions > 0 {
            let (holes, triangles) = (
                thousands(self.hole_regions),
                counted(self.hole_triangles, "triangle", "triangles"),
            );
            let mut text = format!("{holes}, with {triangles}");
            if self.hole_points > 0 {
                text += &format!("; {}", counted(self.hole_points, "hole point", "hole points"));
            }
            if self.exterior_is_hole {
                text += "; the exterior is a hole";
            }
            lines.push(("holes", text));
        }
        if self.sites > 0 {
            lines.push(("sites", thousands(self.sites)));
        }
        lines
    }

    fn overview_rows(&self) -> Vec<Row> {
        let rows = self.overview_list.iter().map(|row| {
            let name = if row.level == 1 { "overviews" } else { "" };
            let stale = if row.is_stale { " (stale)" } else { "" };
            (name, format!("{}  {}{stale}", row.level, row.text(self.has_z)))
        });
        let mut rows: Vec<Row> = rows.collect();
        if self.overview_list.iter().any(|row| row.is_stale) {
            let file = shown::text(&self.file);
            rows.push(("", format!("stale, renew with `tiletool overviews {file}`")));
        }
        rows
    }

    fn tile_rows(&self) -> Vec<Row> {
        let limit = counted(self.tile_vertices.into(), "vertex", "vertices");
        let mut lines = vec![("tiles", format!("{}, at most {limit} each", thousands(self.tiles)))];
        if let Some(d) = &self.vertices_per_tile {
            let shown = [
                ("min", d.min),
                ("lower quartile", d.lower_quartile),
                ("median", d.median),
                ("upper quartile", d.upper_quartile),
                ("max", d.max),
            ];
            let shown = shown.map(|(name, value)| format!("{name} {}", thousands(value.into())));
            lines.push(("vertices per tile", shown.join(", ")));
        }
        if self.triangles > 0 {
            let (border, of) = (
                thousands(self.parts.border_triangles),
                percent(self.parts.border_triangles_share),
            );
            lines.push(("border triangles", format!("{border}, {of} of all")));
        }
        let mut shares = vec![
            ("cores", self.parts.core_bytes_share),
            ("borders", self.parts.border_bytes_share),
            ("directory", self.parts.directory_bytes_share),
            ("superblocks and padding", self.parts.other_bytes_share),
        ];
        if self.parts.overview_bytes > 0 {
            shares.insert(3, ("overviews", self.parts.overview_bytes_share));
        }
        let shares = shares.into_iter();
        let shares: Vec<_> = shares
            .map(|(name, share)| format!("{name} {}", percent(share)))
            .collect();
        lines.push(("bytes", shares.join(", ")));
        let cached = bytes(self.parts.cached_bytes);
        lines.push(("cache", format!("{cached} hold all tiles")));
        lines
    }
}

/// Returns rows of files and their counts, up to [`SOURCES_SHOWN`].
fn files<'a>(title: &'static str, files: impl ExactSizeIterator<Item = (&'a String, String)> + Clone) -> Vec<Row> {
    let hidden = files.len().saturating_sub(SOURCES_SHOWN) as u64;
    let shown = files.take(SOURCES_SHOWN);
    let shown: Vec<_> = shown.map(|(name, count)| (shown::text(name), count)).collect();
    let width = shown.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let mut lines: Vec<_> = shown
        .iter()
        .map(|(name, count)| ("", format!("{name:<width$}  {count}")))
        .collect();
    if let Some(first) = lines.first_mut() {
        first.0 = title;
    }
    if hidden > 0 {
        lines.push(("", format!("and {} more; --json lists them all", thousands(hidden))));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_values_of_the_set() {
        assert_eq!(Distribution::of(vec![]), None);
        let of = |values: &[u32]| {
            let d = Distribution::of(values.to_vec()).unwrap();
            [d.min, d.lower_quartile, d.median, d.upper_quartile, d.max]
        };
        assert_eq!(of(&[7]), [7; 5]);
        assert_eq!(of(&[5, 1, 4, 2, 3]), [1, 2, 3, 4, 5]);
        assert_eq!(of(&[1, 2]), [1, 1, 2, 2, 2]);
    }
}
