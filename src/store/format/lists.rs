//! The lists of a file that may be long: the sources of its points and lines, its coordinate
//! reference system, its hole points. Each is a FlatBuffer of its own, read on demand.

use bytes::Bytes;
use flatbuffers::FlatBufferBuilder;

use crate::geometry::Point;
use crate::store::format::damage::Damage;
use crate::store::format::edge_source::LineKind;
use crate::store::format::flat_buffer::{finished, verified};
use crate::store::format::generated::directory as schema;
use crate::store::format::line_source::LineSource;
use crate::store::format::polygon_lines::{self, PolygonLine, polygon_of};

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

/// The lists of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists {
    /// The files from which the points were read, in order.
    pub sources: Vec<Source>,
    /// The coordinate reference system, as named by the input.
    pub crs: Option<String>,
    /// The files from which the lines were read. Lines are numbered across all files in this order.
    pub lines: Vec<LineSource>,
    /// Points whose regions are holes.
    pub hole_points: Vec<Point>,
    /// The borders between cells at which lines were split too, each a segment between two points.
    /// See [`Steiner::Borders`](crate::pipeline::Steiner::Borders).
    pub cell_borders: Vec<[Point; 2]>,
    /// The lines of obstacles that are not the first of their polygon, in order.
    pub polygon_lines: Vec<PolygonLine>,
}

/// One value for each of the lists, in the order of [`Lists`].
pub(crate) type OfLists<T> = [T; 6];

/// The place of [`Lists::sources`] among the lists.
pub(crate) const SOURCES: usize = 0;
/// The place of [`Lists::crs`] among the lists.
pub(crate) const CRS: usize = 1;

/// The names of the lists, for errors.
pub(crate) const LIST_NAMES: OfLists<&str> = [
    "the sources of points",
    "the coordinate reference system",
    "the sources of lines",
    "the hole points",
    "the cell borders",
    "the polygons of several lines",
];

impl Lists {
    /// Returns the kinds of the lines, as [`Metadata::line_kinds`](super::metadata::Metadata) has
    /// them.
    pub(crate) fn line_kinds(&self) -> u32 {
        self.lines
            .iter()
            .fold(0, |kinds, source| kinds | 1 << source.kind.to_code())
    }

    /// Returns the polygon of a line of an obstacle: the smallest number of a line of the polygon.
    #[must_use]
    pub fn polygon(&self, line: u64) -> u64 {
        polygon_of(&self.polygon_lines, line)
    }

    /// Encodes each list that is not empty.
    pub(crate) fn encode(&self) -> OfLists<Option<Vec<u8>>> {
        [
            (!self.sources.is_empty()).then(|| encode_sources(&self.sources)),
            self.crs.as_deref().map(encode_crs),
            (!self.lines.is_empty()).then(|| encode_lines(&self.lines)),
            (!self.hole_points.is_empty()).then(|| encode_points(&self.hole_points)),
            (!self.cell_borders.is_empty()).then(|| encode_points(self.cell_borders.as_flattened())),
            (!self.polygon_lines.is_empty()).then(|| polygon_lines::encode(&self.polygon_lines)),
        ]
    }

    /// Decodes the lists from their bytes. The error says what is wrong.
    pub(crate) fn decode(lists: OfLists<Option<Bytes>>) -> Result<Self, Damage> {
        let [sources, crs, lines, hole_points, cell_borders, polygon_lines] = lists;
        let points = |bytes: Option<Bytes>| bytes.map_or(Ok(Vec::new()), |bytes| decode_points(&bytes));
        let cell_borders = points(cell_borders)?;
        let lines = lines.map_or(Ok(Vec::new()), |bytes| decode_lines(&bytes))?;
        let polygon_lines = polygon_lines.map_or(Ok(Vec::new()), |bytes| polygon_lines::decode(&bytes, &lines))?;
        Ok(Self {
            sources: sources.map_or(Ok(Vec::new()), |bytes| decode_sources(&bytes))?,
            crs: crs.map(|bytes| decode_crs(&bytes)).transpose()?,
            lines,
            hole_points: points(hole_points)?,
            cell_borders: match cell_borders.as_chunks() {
                (borders, []) => borders.to_vec(),
                _ => return Err(Damage::new("the cell borders are not pairs of points")),
            },
            polygon_lines,
        })
    }
}

fn encode_sources(sources: &[Source]) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let list: Vec<_> = sources
        .iter()
        .map(|source| {
            let name = Some(builder.create_string(&source.name));
            let (records, first) = (source.records, source.first);
            schema::Source::create(&mut builder, &schema::SourceArgs { name, records, first })
        })
        .collect();
    let list = Some(builder.create_vector(&list));
    let root = schema::Sources::create(&mut builder, &schema::SourcesArgs { list });
    finished(builder, root)
}

pub(crate) fn decode_sources(bytes: &[u8]) -> Result<Vec<Source>, Damage> {
    let sources: schema::Sources<'_> = verified(bytes, "the list of sources of points")?;
    let sources = sources.list().iter().map(|source| Source {
        name: source.name().to_owned(),
        records: source.records(),
        first: source.first(),
    });
    Ok(sources.collect())
}

fn encode_crs(crs: &str) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let text = Some(builder.create_string(crs));
    let root = schema::Crs::create(&mut builder, &schema::CrsArgs { text });
    finished(builder, root)
}

pub(crate) fn decode_crs(bytes: &[u8]) -> Result<String, Damage> {
    let crs: schema::Crs<'_> = verified(bytes, "the coordinate reference system")?;
    Ok(crs.text().to_owned())
}

fn encode_lines(lines: &[LineSource]) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let list: Vec<_> = lines
        .iter()
        .map(|source| {
            let args = schema::LineSourceArgs {
                name: Some(builder.create_string(&source.name)),
                kind: source.kind.to_code(),
                first: source.first,
                lines: source.lines,
                edit: source.edit,
            };
            schema::LineSource::create(&mut builder, &args)
        })
        .collect();
    let list = Some(builder.create_vector(&list));
    let root = schema::LineSources::create(&mut builder, &schema::LineSourcesArgs { list });
    finished(builder, root)
}

/// Decodes the files from which the lines were read. Their lines must be numbered consecutively.
fn decode_lines(bytes: &[u8]) -> Result<Vec<LineSource>, Damage> {
    let sources: schema::LineSources<'_> = verified(bytes, "the list of sources of lines")?;
    let mut lines = Vec::new();
    let (mut end, mut edit) = (0u64, 0);
    for source in sources.list() {
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

fn encode_points(points: &[Point]) -> Vec<u8> {
    let mut builder = FlatBufferBuilder::new();
    let points: Vec<_> = points.iter().map(|p| schema::Place::new(p.x, p.y)).collect();
    let list = Some(builder.create_vector(&points));
    let root = schema::Places::create(&mut builder, &schema::PlacesArgs { list });
    finished(builder, root)
}

fn decode_points(bytes: &[u8]) -> Result<Vec<Point>, Damage> {
    let places: schema::Places<'_> = verified(bytes, "a list of points")?;
    let points = places.list().iter().map(|place| Point::new(place.x(), place.y()));
    let points: Vec<Point> = points.collect();
    match points.iter().find(|point| !point.is_valid()) {
        Some(point) => Err(Damage::new(format!(
            "a hole point or a cell border has the invalid coordinates ({}, {})",
            point.x, point.y
        ))),
        None => Ok(points),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(lists: &Lists) -> Result<Lists, Damage> {
        Lists::decode(lists.encode().map(|bytes| bytes.map(Bytes::from)))
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

    fn polygon_line(line: u64, polygon: u64) -> PolygonLine {
        PolygonLine { line, polygon }
    }

    fn full() -> Lists {
        let obstacles = LineSource {
            kind: LineKind::Obstacle,
            ..lines(8, 6)
        };
        let source = |i: u64| Source {
            name: "a".repeat(i as usize % 2),
            records: i,
            first: i * 7,
        };
        Lists {
            sources: (0..10_000).map(source).collect(),
            crs: Some("EPSG:4326".to_owned()),
            lines: vec![lines(0, 7), lines(7, 0), lines(7, 1), obstacles],
            hole_points: vec![Point::new(1.0, 2.0), Point::new(-0.5, 0.0)],
            cell_borders: vec![[Point::new(1.0, 2.0), Point::new(1.0, 3.0)]],
            polygon_lines: vec![polygon_line(10, 9), polygon_line(12, 9), polygon_line(13, 11)],
        }
    }

    #[test]
    fn lists_are_read_as_they_were_written_and_empty_ones_take_no_bytes() {
        assert_eq!(decoded(&full()), Ok(full()));
        assert_eq!(decoded(&Lists::default()), Ok(Lists::default()));
        assert_eq!(Lists::default().encode(), [const { None }; 6]);
        let polygons = [8, 9, 10, 11, 12, 13].map(|line| full().polygon(line));
        assert_eq!(polygons, [8, 9, 9, 11, 9, 11]);
    }

    #[test]
    fn lines_of_polygons_are_put_in_order() {
        let of = |its: &[(u64, u64)], lines: &[LineSource]| -> Vec<(u64, u64)> {
            let its = its.iter().map(|&(line, polygon)| polygon_line(line, polygon)).collect();
            let its = polygon_lines::in_order(its, lines);
            its.iter().map(|of| (of.line, of.polygon)).collect()
        };
        let wrong = [(9, 9), (2, 1), (3, 2), (1, 0), (3, 7), (8, 7), (8, 6)];
        assert_eq!(of(&wrong, &[]), [(1, 0), (2, 0), (3, 0), (8, 6)]);
        assert_eq!(
            of(&[(13, 11), (10, 9), (14, 13), (9, 7)], &full().lines),
            [(10, 9), (13, 11)]
        );
    }

    #[test]
    fn lines_that_are_not_numbered_through_and_invalid_points_are_rejected() {
        let faults: [fn(&mut Lists); 14] = [
            |m| m.lines[0].first = 1,
            |m| m.lines[2].first = 8,
            |m| m.lines[0].lines = u64::MAX,
            |m| m.lines[0].edit = 2,
            |m| m.hole_points[1].x = f64::NAN,
            |m| m.hole_points[0].y = 1e300,
            |m| m.cell_borders[0][1].y = f64::INFINITY,
            |m| m.polygon_lines.swap(0, 1),
            |m| m.polygon_lines[1].line = 10,
            |m| m.polygon_lines[2].polygon = 13,
            |m| m.polygon_lines[2].polygon = 12,
            |m| m.polygon_lines[0].polygon = 7,
            |m| m.polygon_lines[2].line = 14,
            |m| m.polygon_lines[2].line = u64::MAX,
        ];
        for (fault, number) in faults.iter().zip(0..) {
            let mut wrong = full();
            fault(&mut wrong);
            assert!(decoded(&wrong).is_err(), "{number}");
        }
        // Cell borders are pairs of points.
        let mut odd = OfLists::default();
        odd[4] = Some(encode_points(&[Point::new(1.0, 1.0)]).into());
        assert!(Lists::decode(odd).is_err());
    }

    /// A list of 100 KB whose thousand sources share one name would unpack to 100 MB.
    #[test]
    fn a_list_cannot_unpack_to_many_times_its_size() {
        let mut builder = FlatBufferBuilder::new();
        let name = Some(builder.create_string(&"x".repeat(100_000)));
        let source = schema::SourceArgs {
            name,
            records: 0,
            first: 0,
        };
        let sources: Vec<_> = (0..1000)
            .map(|_| schema::Source::create(&mut builder, &source))
            .collect();
        let list = Some(builder.create_vector(&sources));
        let root = schema::Sources::create(&mut builder, &schema::SourcesArgs { list });
        let bytes = finished(builder, root);
        assert!(flatbuffers::root::<schema::Sources<'_>>(&bytes).is_ok());
        assert!(decode_sources(&bytes).is_err());
    }
}
