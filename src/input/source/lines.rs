//! Segments from files: break lines, walls, and the outlines of obstacles.
//!
//! Why one source for all three: they differ in what they are for, which whoever builds says, and polygons in having a
//! side that is inside.
//!
//! **Memory**: a batch, and of GeoJSON the vertices of one geometry, since only its end tells for sure what it is, or of
//! obstacles those of one ring.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, RecordKind};
#[cfg(feature = "geojson")]
use crate::input::formats::geojson;
use crate::input::formats::raw::pairs::Pairs;
#[cfg(feature = "text")]
use crate::input::formats::text;
use crate::input::lines::SegmentBatch;
use crate::input::options::Format;
use crate::input::reader::Started;
use crate::input::source::stream::{Records, Source};
use crate::shown;
use std::fmt;
use std::path::{Path, PathBuf};

/// A blocking stream of the segments of several files: lines ([`Self::open`]) or polygons ([`Self::open_obstacles`]).
///
/// | suffix | lines | polygons |
/// |---|---|---|
/// | `.geojson` and the like | a segment between each position and the next of lines and of the rings of polygons; points are passed over | Polygon and MultiPolygon; another geometry is an error, but null |
/// | `.csv` and the like | rows `x1,y1,x2,y2`, with or without a header; further columns are not read | |
/// | `.u32`, `.u64` | pairs of record numbers of points, raw and little-endian | |
///
/// All but the last may be gzip'd. Segments are numbered from 0 over all files.
///
/// **Lines** are what a person finds in the file: GeoJSON's features (or geometries outside of any), rows, pairs. They are
/// numbered from 0 over all files of the source, those that give no segment too, and [`Self::origin`] turns a number back
/// into file and place. A line may have any number of segments.
///
/// **Polygons** are directed so that the interior is on the left of every segment, whatever the winding in the file: outer
/// rings go counter-clockwise and inner ones clockwise, by the exact sign of their area. An unclosed ring is closed, with a
/// note. Repeated positions make no segment, nor does a ring of one position, with a note. A ring without area (collinear, or with lobes that cancel out), and every ring of a
/// polygon whose outer one has no area, encloses nothing: its segments come once in each direction, so that no side of them is
/// the inside, and they still block the way; a note tells how many rings. Only an outer ring with lobes that cancel out comes as it
/// is in the file: it encloses its lobes, one of them the wrong way round. Whether rings cross, or an inner one lies outside, is for
/// whoever builds to find out; [`SegmentBatch::polygons`] tells which rings belong together.
///
/// **z** is kept from GeoJSON. The first position of each file tells whether it has z. If any file has, ends without z
/// have NaN; if none has, z that comes later is left out. Notes tell of both.
///
/// ```
/// use delaunay_tiles::input::{SegmentBatch, SegmentSource};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("streets.u32");
/// std::fs::write(&path, [0u32, 7, 7, 3].map(u32::to_le_bytes).concat())?;
///
/// let mut source = SegmentSource::open(&[path])?;
/// let mut batch = SegmentBatch::default();
/// assert!(source.next_batch(&mut batch)?);
/// assert_eq!(batch.records, [[0, 7], [7, 3]]);
/// let origin = source.origin(batch.lines[1]).expect("it was just read");
/// assert!(origin.to_string().ends_with("streets.u32: pair 1 (counted from 0)"));
/// # Ok(())
/// # }
/// ```
pub type SegmentSource = Source<SegmentBatch>;

/// Where a line comes from: what [`SegmentSource::origin`] gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LineOrigin<'a> {
    /// The file.
    pub path: &'a Path,
    /// What a line is in it: `feature`, `row` or `pair`.
    pub what: &'static str,
    /// Which one in the file, from 0. Header, comment and blank lines are no rows.
    pub number: u64,
}

impl fmt::Display for LineOrigin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, what, number } = self;
        write!(f, "{}: {what} {number} (counted from 0)", shown::path(path))
    }
}

/// How a file with segments is written.
#[derive(Clone, Copy, PartialEq)]
pub enum LineFormat {
    /// Pairs of numbers of so many bytes.
    Pairs {
        bytes: usize,
    },
    Text,
    GeoJson,
    /// Polygons in GeoJSON.
    Rings,
}

impl LineFormat {
    /// The format of a file with lines, by its name.
    fn of_lines(path: &Path) -> Option<Self> {
        let suffix = path.extension().and_then(|suffix| suffix.to_str());
        match (suffix.map(str::to_ascii_lowercase).as_deref(), Format::from_path(path)) {
            (Some("u32"), _) => Some(Self::Pairs { bytes: 4 }),
            (Some("u64"), _) => Some(Self::Pairs { bytes: 8 }),
            (_, Some(Format::Text)) => Some(Self::Text),
            (_, Some(Format::GeoJson)) => Some(Self::GeoJson),
            _ => None,
        }
    }

    /// The format of a file with polygons, by its name.
    fn of_polygons(path: &Path) -> Option<Self> {
        (Format::from_path(path) == Some(Format::GeoJson)).then_some(Self::Rings)
    }

    /// What a line is.
    fn line(self) -> &'static str {
        match self {
            Self::Pairs { .. } => "pair",
            Self::Text => "row",
            Self::GeoJson | Self::Rings => "feature",
        }
    }
}

impl Records for SegmentBatch {
    type Format = LineFormat;

    // Segments by their ends come before those by records in a batch, so the files' order would be lost.
    const SPANS_FILES: bool = false;

    fn may_be_gzip(format: LineFormat) -> bool {
        !matches!(format, LineFormat::Pairs { .. })
    }

    fn start(format: LineFormat, input: ByteInput, (): &()) -> Started<Self> {
        match format {
            LineFormat::Pairs { bytes } => Ok(Box::new(Pairs::new(input, bytes))),
            #[cfg(feature = "text")]
            LineFormat::Text => Ok(Box::new(text::Segments::new(input)?)),
            #[cfg(feature = "geojson")]
            LineFormat::GeoJson => Ok(Box::new(geojson::Lines::new(input)?)),
            #[cfg(feature = "geojson")]
            LineFormat::Rings => Ok(Box::new(geojson::Rings::new(input)?)),
            #[cfg(not(feature = "text"))]
            LineFormat::Text => Err(Format::Text.missing(&input.path)),
            #[cfg(not(feature = "geojson"))]
            LineFormat::GeoJson | LineFormat::Rings => Err(Format::GeoJson.missing(&input.path)),
        }
    }
}

impl Source<SegmentBatch> {
    /// Opens files with lines, and looks at each one's beginning.
    ///
    /// # Errors
    /// A file that does not exist, whose name tells no format, or that is broken at its beginning.
    pub fn open(paths: &[PathBuf]) -> Result<Self, InputError> {
        Self::of_files(paths, (), LineFormat::of_lines, RecordKind::Segment)
    }

    /// Opens files with polygons, and looks at each one's beginning.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn open_obstacles(paths: &[PathBuf]) -> Result<Self, InputError> {
        Self::of_files(paths, (), LineFormat::of_polygons, RecordKind::Obstacle)
    }

    /// Segments so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.records
    }

    /// Where a line comes from that was handed out; `None` if there was none of this number.
    #[must_use]
    pub fn origin(&self, line: u64) -> Option<LineOrigin<'_>> {
        let mut number = Some(line).filter(|line| *line < self.totals.lines)?;
        let mut at = 0;
        while let Some((_, lines)) = self.done.get(at).filter(|(_, lines)| number >= *lines) {
            number -= lines;
            at += 1;
        }
        let (path, format) = self.all.get(at)?;
        let what = format.line();
        Some(LineOrigin { path, what, number })
    }
}
