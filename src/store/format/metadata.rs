//! What the directory knows of the whole file, and how it stands in the root.

use flatbuffers::FlatBufferBuilder;
use flatbuffers::Vector;
use flatbuffers::WIPOffset;

use crate::geometry::{Point, Rect};
use crate::store::format::damage::Damage;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::generated::directory as schema;

/// A file that points came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its name, without the folder.
    pub name: String,
    /// Records read from it, those left out included.
    pub records: u64,
}

/// A file that lines came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSource {
    /// Its name, without the folder.
    pub name: String,
    /// What its lines are for.
    pub kind: LineKind,
    /// The number of its first line.
    pub first: u64,
    /// How many lines came from it.
    pub lines: u64,
    /// 0: the build. Else the number of the edit that added them, from 1 on.
    pub edit: u32,
}

impl LineSource {
    /// Whether a source is one of these lines, which are in order; or the lines are not known at all.
    pub(crate) fn knows(lines: &[Self], source: EdgeSource) -> bool {
        let before = lines.partition_point(|of_file| of_file.first <= source.number());
        let of_file = before.checked_sub(1).map(|place| &lines[place]);
        let is_its = |l: &Self| l.kind == source.kind() && source.number() - l.first < l.lines;
        lines.is_empty() || of_file.is_some_and(is_its)
    }
}

/// The name of this program, as files that it writes have it.
pub(crate) fn this_program() -> String {
    concat!("delaunay-tiles ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// What is known of the whole file.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The most vertices that the tiles were cut for.
    pub tile_vertices: u32,
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Edges with a triangle on one side only.
    pub hull_edges: u64,
    /// Points that came in.
    pub points: u64,
    /// Those of them that lay on another.
    pub duplicates: u64,
    /// Vertices that are an end of a segment or a site, and no point of the input.
    pub ends: u64,
    /// Edges that are constraints.
    pub constraint_edges: u64,
    /// Whether vertices have a z.
    pub has_z: bool,
    /// Around all vertices.
    pub bounds: Rect,
    /// Where the points came from, in order.
    pub sources: Vec<Source>,
    /// Coordinate reference system, as the input named it.
    pub crs: Option<String>,
    /// The program that wrote the file.
    pub producer: String,
    /// Regions: parts of the triangulation that no constraint passes through. 0 in files that know none.
    pub regions: u64,
    /// Regions from 0 up to here may lie in several tiles; the others lie in one each.
    pub spanning_regions: u64,
    /// Regions that are holes.
    pub hole_regions: u64,
    /// Triangles in holes.
    pub hole_triangles: u64,
    /// Sites.
    pub sites: u64,
    /// Pairs of lines that crossed and were split.
    pub crossings: u64,
    /// Where the lines came from; they are numbered through in this order.
    pub lines: Vec<LineSource>,
    /// Whether regions that reach the hull without a constraint are holes.
    pub exterior_is_hole: bool,
    /// Points whose regions are holes.
    pub seeds: Vec<Point>,
    /// The borders at which lines were split too, each from one place to another; see
    /// [`Steiner::Borders`](crate::pipeline::Steiner::Borders).
    pub borders: Vec<[Point; 2]>,
    /// One more than the largest record number that was ever given to a point, to the end of a segment, to a crossing point or to a
    /// site. Edits number the ends of their segments from here on.
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
    /// Adds the root to a buffer, for so many tiles.
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
                let records = source.records;
                schema::Source::create(builder, &schema::SourceArgs { name, records })
            })
            .collect();
        let sources = Some(builder.create_vector(&sources));
        let crs = self.crs.as_ref().map(|crs| builder.create_string(crs));
        let producer = Some(builder.create_string(&self.producer));
        let lines = self.encode_lines(builder);
        let seeds = encode_places(builder, &self.seeds);
        let borders = encode_places(builder, self.borders.as_flattened());
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

    /// Takes it from a verified root; an error says what is wrong with it.
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
            seeds: decode_places(root.seeds()),
            borders: match decode_places(root.borders()).as_chunks() {
                (borders, []) => borders.to_vec(),
                _ => return Err(Damage::new("its borders are no pairs of places")),
            },
            next_record: root.next_record(),
        };
        // Others allocate by the number of regions, and the triangles are counted.
        let counts = [this.spanning_regions, this.regions, this.triangles];
        if !counts.is_sorted() || this.hole_regions > this.regions || this.hole_triangles > this.triangles {
            return Err(Damage::new("its counts of regions and holes are absurd"));
        }
        let mut places = this.seeds.iter().chain(this.borders.as_flattened());
        match places.find(|place| !place.is_valid()) {
            Some(place) => Err(Damage::new(format!(
                "there is a seed or a border at ({}, {})",
                place.x, place.y
            ))),
            None => Ok(this),
        }
    }
}

/// Edges of the hull of so many vertices and triangles, by Euler's formula for a triangulated disc; 0 without triangles.
pub(crate) fn hull_edges(vertices: u64, triangles: u64) -> u64 {
    match triangles {
        0 => 0,
        triangles => (2 * vertices - 2).saturating_sub(triangles),
    }
}

fn encode_places<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    places: &[Point],
) -> Option<WIPOffset<Vector<'b, schema::Place>>> {
    let places: Vec<_> = places.iter().map(|p| schema::Place::new(p.x, p.y)).collect();
    (!places.is_empty()).then(|| builder.create_vector(&places))
}

fn decode_places(places: Option<Vector<'_, schema::Place>>) -> Vec<Point> {
    let places = places.iter().flatten();
    places.map(|place| Point::new(place.x(), place.y())).collect()
}

/// The files that lines came from, whose lines are numbered through.
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
    fn lines_regions_and_seeds_come_back() {
        assert_eq!(decoded(&full()), Ok(full()));
        assert_eq!(decoded(&Metadata::default()), Ok(Metadata::default()));
    }

    #[test]
    fn absurd_counts_lines_and_seeds_are_refused() {
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
