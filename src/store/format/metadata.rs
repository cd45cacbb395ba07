//! The metadata of the whole file, and its encoding in the root of the directory.

use flatbuffers::FlatBufferBuilder;
use flatbuffers::Vector;
use flatbuffers::WIPOffset;

use crate::geometry::{Point, Rect};
use crate::store::format::damage::Damage;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::generated::directory as schema;

/// A file from which points were read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file name without its folder.
    pub name: String,
    /// The number of records read from the file, including those left out.
    pub records: u64,
    /// The number of the first of these records among those of all files.
    pub first: u64,
}

/// A file from which lines were read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSource {
    /// The file name without its folder.
    pub name: String,
    /// The kind of its lines.
    pub kind: LineKind,
    /// The number of its first line.
    pub first: u64,
    /// The number of lines read from the file.
    pub lines: u64,
    /// 0 for lines of the build, else the number of the edit that added them, from 1 on.
    pub edit: u32,
}

impl LineSource {
    /// Returns whether `source` is one of `lines`, which are in order. Also returns true if `lines`
    /// is empty, because then the lines are not known.
    pub(crate) fn knows(lines: &[Self], source: EdgeSource) -> bool {
        let before = lines.partition_point(|of_file| of_file.first <= source.number());
        let of_file = before.checked_sub(1).map(|index| &lines[index]);
        let has_source = |l: &Self| l.kind == source.kind() && source.number() - l.first < l.lines;
        lines.is_empty() || of_file.is_some_and(has_source)
    }
}

/// Returns the name and version of this program, as they are stored in files that it writes.
pub(crate) fn this_program() -> String {
    concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// The metadata of the whole file.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The maximum number of vertices per tile for which the file was built.
    pub tile_vertices: u32,
    /// The number of vertices.
    pub vertices: u64,
    /// The number of triangles.
    pub triangles: u64,
    /// The number of edges with a triangle on one side only.
    pub hull_edges: u64,
    /// The number of points in the input.
    pub points: u64,
    /// The number of input points that coincide with another one.
    pub duplicates: u64,
    /// The number of vertices that are an end of a segment or a site, but no point of the input.
    pub ends: u64,
    /// The number of constraint edges.
    pub constraint_edges: u64,
    /// Whether the vertices have a z.
    pub has_z: bool,
    /// The bounding rectangle of all vertices.
    pub bounds: Rect,
    /// The files from which the points were read, in order.
    pub sources: Vec<Source>,
    /// The coordinate reference system, as named by the input.
    pub crs: Option<String>,
    /// The program that wrote the file.
    pub producer: String,
    /// The number of regions: parts of the triangulation that no constraint crosses. 0 in files
    /// without regions.
    pub regions: u64,
    /// The number of regions that may extend over several tiles. These have the numbers from 0 up
    /// to this one; each of the others is within one tile.
    pub spanning_regions: u64,
    /// The number of regions that are holes.
    pub hole_regions: u64,
    /// The number of triangles in holes.
    pub hole_triangles: u64,
    /// The number of sites.
    pub sites: u64,
    /// The number of pairs of lines that crossed and were split.
    pub crossings: u64,
    /// The files from which the lines were read. Lines are numbered across all files in this order.
    pub lines: Vec<LineSource>,
    /// Whether regions that reach the hull without a constraint are holes.
    pub exterior_is_hole: bool,
    /// Points whose regions are holes.
    pub seeds: Vec<Point>,
    /// The borders between cells at which lines were split too, each a segment between two points.
    /// See [`Steiner::Borders`](crate::pipeline::Steiner::Borders).
    pub borders: Vec<[Point; 2]>,
    /// One more than the largest record number ever assigned to a point, to the end of a segment,
    /// to a crossing point or to a site. Edits number the ends of their segments from here on.
    pub next_record: u64,
}

impl Default for Metadata {
    fn default() -> Self {
        Self {
            tile_vertices: 0,
            vertices: 0,
            triangles: 0,
            hull_edges: 0,
            points: 0,
            duplicates: 0,
            ends: 0,
            constraint_edges: 0,
            has_z: false,
            bounds: Rect::EMPTY,
            sources: Vec::new(),
            crs: None,
            producer: this_program(),
            regions: 0,
            spanning_regions: 0,
            hole_regions: 0,
            hole_triangles: 0,
            sites: 0,
            crossings: 0,
            lines: Vec::new(),
            exterior_is_hole: false,
            seeds: Vec::new(),
            borders: Vec::new(),
            next_record: 0,
        }
    }
}

impl Metadata {
    /// Adds the root of a directory of `tiles` tiles to a buffer.
    pub(crate) fn encode<'b>(
        &self,
        builder: &mut FlatBufferBuilder<'b>,
        tiles: u32,
        nodes: WIPOffset<Vector<'b, schema::KdNode>>,
        pages: WIPOffset<Vector<'b, schema::PageExtent>>,
    ) -> WIPOffset<schema::Directory<'b>> {
        let sources: Vec<_> = self
            .sources
            .iter()
            .map(|source| {
                let name = Some(builder.create_string(&source.name));
                let (records, first) = (source.records, source.first);
                schema::Source::create(builder, &schema::SourceArgs { name, records, first })
            })
            .collect();
        let sources = Some(builder.create_vector(&sources));
        let crs = self.crs.as_ref().map(|crs| builder.create_string(crs));
        let producer = Some(builder.create_string(&self.producer));
        let lines = self.encode_lines(builder);
        let seeds = encode_points(builder, &self.seeds);
        let borders = encode_points(builder, self.borders.as_flattened());
        let args = schema::DirectoryArgs {
            tiles,
            tile_vertices: self.tile_vertices,
            vertices: self.vertices,
            triangles: self.triangles,
            hull_edges: self.hull_edges,
            points: self.points,
            duplicates: self.duplicates,
            has_z: self.has_z,
            min_x: self.bounds.min_x,
            min_y: self.bounds.min_y,
            max_x: self.bounds.max_x,
            max_y: self.bounds.max_y,
            nodes: Some(nodes),
            pages: Some(pages),
            sources,
            crs,
            producer,
            ends: self.ends,
            constraint_edges: self.constraint_edges,
            regions: self.regions,
            spanning_regions: self.spanning_regions,
            hole_regions: self.hole_regions,
            hole_triangles: self.hole_triangles,
            sites: self.sites,
            crossings: self.crossings,
            lines,
            exterior_is_hole: self.exterior_is_hole,
            seeds,
            borders,
            next_record: self.next_record,
        };
        schema::Directory::create(builder, &args)
    }

    fn encode_lines<'b>(&self, builder: &mut FlatBufferBuilder<'b>) -> Option<WIPOffset<LineVector<'b>>> {
        let lines: Vec<_> = self
            .lines
            .iter()
            .map(|source| {
                let args = schema::LineSourceArgs {
                    name: Some(builder.create_string(&source.name)),
                    kind: source.kind.to_code(),
                    first: source.first,
                    lines: source.lines,
                    edit: source.edit,
                };
                schema::LineSource::create(builder, &args)
            })
            .collect();
        (!lines.is_empty()).then(|| builder.create_vector(&lines))
    }

    /// Decodes the metadata from a verified root. The error says what is wrong with it.
    pub(crate) fn decode(root: schema::Directory<'_>) -> Result<Self, Damage> {
        let this = Self {
            tile_vertices: root.tile_vertices(),
            vertices: root.vertices(),
            triangles: root.triangles(),
            hull_edges: root.hull_edges(),
            points: root.points(),
            duplicates: root.duplicates(),
            ends: root.ends(),
            constraint_edges: root.constraint_edges(),
            has_z: root.has_z(),
            bounds: Rect::new(root.min_x(), root.min_y(), root.max_x(), root.max_y()),
            sources: root.sources().map_or_else(Vec::new, |sources| {
                sources
                    .iter()
                    .map(|source| Source {
                        name: source.name().to_owned(),
                        records: source.records(),
                        first: source.first(),
                    })
                    .collect()
            }),
            crs: root.crs().map(str::to_owned),
            producer: root.producer().unwrap_or_default().to_owned(),
            regions: root.regions(),
            spanning_regions: root.spanning_regions(),
            hole_regions: root.hole_regions(),
            hole_triangles: root.hole_triangles(),
            sites: root.sites(),
            crossings: root.crossings(),
            lines: decode_lines(root)?,
            exterior_is_hole: root.exterior_is_hole(),
            seeds: decode_points(root.seeds()),
            borders: match decode_points(root.borders()).as_chunks() {
                (borders, []) => borders.to_vec(),
                _ => return Err(Damage::new("its borders are not pairs of points")),
            },
            next_record: root.next_record(),
        };
        // Callers allocate memory according to the number of regions. The number of triangles
        // bounds it, and is checked against the tiles.
        let counts = [this.spanning_regions, this.regions, this.triangles];
        if !counts.is_sorted() || this.hole_regions > this.regions || this.hole_triangles > this.triangles {
            return Err(Damage::new("its counts of regions and holes are inconsistent"));
        }
        let mut points = this.seeds.iter().chain(this.borders.as_flattened());
        match points.find(|point| !point.is_valid()) {
            Some(point) => Err(Damage::new(format!(
                "a seed or a border has the invalid coordinates ({}, {})",
                point.x, point.y
            ))),
            None => Ok(this),
        }
    }
}

/// Returns the number of hull edges for `vertices` vertices and `triangles` triangles, by Euler's
/// formula for a triangulated disc; 0 without triangles.
pub(crate) fn hull_edges(vertices: u64, triangles: u64) -> u64 {
    match triangles {
        0 => 0,
        triangles => (2 * vertices - 2).saturating_sub(triangles),
    }
}

fn encode_points<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    points: &[Point],
) -> Option<WIPOffset<Vector<'b, schema::Place>>> {
    let points: Vec<_> = points.iter().map(|p| schema::Place::new(p.x, p.y)).collect();
    (!points.is_empty()).then(|| builder.create_vector(&points))
}

fn decode_points(points: Option<Vector<'_, schema::Place>>) -> Vec<Point> {
    let points = points.iter().flatten();
    points.map(|point| Point::new(point.x(), point.y())).collect()
}

/// Decodes the files from which the lines were read. Their lines must be numbered consecutively.
fn decode_lines(root: schema::Directory<'_>) -> Result<Vec<LineSource>, Damage> {
    let mut lines = Vec::new();
    let (mut end, mut edit) = (0u64, 0);
    for source in root.lines().into_iter().flatten() {
        let kind = LineKind::from_code(source.kind());
        let kind = kind.ok_or_else(|| Damage::new(format!("lines of kind {} are unknown", source.kind())))?;
        let after = end.checked_add(source.lines());
        let Some(after) = after.filter(|_| source.first() == end) else {
            return Err(Damage::new(format!(
                "the lines of {} are not numbered from {end} on",
                source.name()
            )));
        };
        end = after;
        if source.edit() < edit {
            return Err(Damage::new(format!(
                "the lines of {} come before those of an earlier edit",
                source.name()
            )));
        }
        edit = source.edit();
        lines.push(LineSource {
            name: source.name().to_owned(),
            kind,
            first: source.first(),
            lines: source.lines(),
            edit: source.edit(),
        });
    }
    Ok(lines)
}

type LineVector<'b> = Vector<'b, flatbuffers::ForwardsUOffset<schema::LineSource<'b>>>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::directory::verified;

    fn decoded(metadata: &Metadata) -> Result<Metadata, Damage> {
        let mut builder = FlatBufferBuilder::new();
        let nodes = builder.create_vector::<schema::KdNode>(&[]);
        let pages = builder.create_vector::<schema::PageExtent>(&[]);
        let root = metadata.encode(&mut builder, 0, nodes, pages);
        builder.finish(root, None);
        Metadata::decode(verified(builder.finished_data(), "it")?)
    }

    fn lines(first: u64, lines: u64) -> LineSource {
        LineSource {
            name: format!("{first}.geojson"),
            kind: LineKind::Wall,
            first,
            lines,
            edit: u32::from(first > 0),
        }
    }

    fn full() -> Metadata {
        Metadata {
            triangles: 100,
            regions: 9,
            spanning_regions: 3,
            hole_regions: 2,
            hole_triangles: 40,
            sites: 5,
            crossings: 6,
            lines: vec![lines(0, 7), lines(7, 0), lines(7, 1)],
            exterior_is_hole: true,
            seeds: vec![Point::new(1.0, 2.0), Point::new(-0.5, 0.0)],
            next_record: 1 << 40,
            ..Metadata::default()
        }
    }

    #[test]
    fn lines_regions_and_seeds_are_read_as_they_were_written() {
        assert_eq!(decoded(&full()), Ok(full()));
        assert_eq!(decoded(&Metadata::default()), Ok(Metadata::default()));
    }

    #[test]
    fn inconsistent_counts_lines_and_seeds_are_rejected() {
        let faults: [fn(&mut Metadata); 10] = [
            |m| m.spanning_regions = 10,
            |m| m.regions = 101,
            |m| m.hole_regions = 10,
            |m| m.hole_triangles = 101,
            |m| m.lines[0].first = 1,
            |m| m.lines[2].first = 8,
            |m| m.lines[0].lines = u64::MAX,
            |m| m.lines[0].edit = 2,
            |m| m.seeds[1].x = f64::NAN,
            |m| m.seeds[0].y = 1e300,
        ];
        for (fault, number) in faults.iter().zip(0..) {
            let mut wrong = full();
            fault(&mut wrong);
            assert!(decoded(&wrong).is_err(), "{number}");
        }
    }
}
