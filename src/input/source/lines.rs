//! The source of segments: break lines, walls, and the outlines of obstacles.
//!
//! One source serves all three. They differ only in their purpose, which the code that builds
//! knows, and in that polygons have an interior.
//!
//! **Memory**: a batch. For vector data also the vertices of one geometry, since in GeoJSON its type
//! is certain only at its end; for obstacles those of one ring.

use crate::input::bytes::ByteInput;
use crate::input::content;
use crate::input::error::{InputError, RecordKind};
use crate::input::format::Format;
use crate::input::formats::raw::pairs::Pairs;
#[cfg(feature = "wkb")]
use crate::input::formats::shapes::Decoded;
use crate::input::formats::shapes::{Lines, Rings};
#[cfg(feature = "text")]
use crate::input::formats::text;
use crate::input::formats::vector::Vector;
#[cfg(feature = "wkb")]
use crate::input::formats::wkb::Geometries;
use crate::input::formats::{ele, obj, ply};
use crate::input::lines::SegmentBatch;
use crate::input::reader::Started;
#[cfg(feature = "wkb")]
use crate::input::source::stream::Input;
use crate::input::source::stream::{Records, Source, start_stream};
use crate::input::watch::Watched;
use crate::shown;
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A blocking stream of the segments of several files: lines ([`Self::open`]) or polygons
/// ([`Self::open_obstacles`]).
///
/// | suffix | lines | polygons |
/// |---|---|---|
/// | `.geojson` and the like, `.fgb`, `.shp`, `.gpkg` | a segment between consecutive positions of lines and of the rings of polygons; points are skipped | Polygon and MultiPolygon; any other geometry but null is an error |
/// | `.csv` and the like | rows `x1,y1,x2,y2`, with or without a header; further columns are not read | |
/// | `.u32`, `.u64` | pairs of record numbers of points, raw and little-endian | |
///
/// All but `.gpkg` and the last may be compressed with gzip. `FILE.gpkg:LAYER` names one of several
/// layers. A file with another suffix is recognised by its content, if that is vector data. Segments are numbered from 0 over all files.
///
/// **Lines** are the units that a person finds in the file: features (or geometries
/// outside of any feature, in GeoJSON), rows, pairs. They are numbered from 0 over all files of the source,
/// including those that give no segment. [`Self::origin`] turns a number back into a file and a
/// number in that file. A line may have any number of segments.
///
/// **Polygons** are directed so that the interior is on the left of every segment, whatever the
/// winding in the file: outer rings go counter-clockwise and inner ones clockwise, by the exact
/// sign of their area. Details:
///
/// - An unclosed ring is closed, with a note.
/// - Repeated positions make no segment. Neither does a ring of one position, with a note.
/// - A ring without area (collinear, or with lobes that cancel out) encloses nothing, and neither
///   does any ring of a polygon whose outer ring has no area. Each of their segments comes once in
///   each direction, so that neither side of it is the inside, and it still blocks the way. A note
///   tells how many such rings there are.
/// - There is one exception: an outer ring with lobes that cancel out comes in the order of the
///   file. It encloses its lobes, one of them with the wrong winding.
/// - Rings that cross, and inner rings that are outside of their outer ring, are not detected here
///   but when the triangulation is built. [`SegmentBatch::polygons`] tells which rings belong
///   together.
///
/// **z** is kept from vector data. The first position of each file tells whether the file has z. If any
/// file has z, ends without z have NaN. If no file has z, z that appears later is dropped. Notes
/// report both.
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

/// The origin of a line, as returned by [`SegmentSource::origin`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LineOrigin<'a> {
    /// The file.
    pub path: &'a Path,
    /// The word for a line in this file: `feature`, `row`, `pair`, `triangle` or `face`.
    pub what: &'static str,
    /// The number of the line in the file, counted from 0. Header, comment and blank lines do not
    /// count as rows.
    pub number: u64,
}

impl fmt::Display for LineOrigin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, what, number } = self;
        write!(f, "{}: {what} {number} (counted from 0)", shown::path(path))
    }
}

/// The format of a file with segments.
#[derive(Clone, Copy, PartialEq)]
pub enum LineFormat {
    /// Pairs of numbers of `bytes` bytes each.
    Pairs {
        bytes: usize,
    },
    Text,
    Lines(Vector),
    /// Polygons.
    Rings(Vector),
    /// The edges of triangles between `points` points, which are numbered from `base` on.
    Elements {
        base: u64,
        points: u64,
    },
    /// The edges of faces in PLY, and in OBJ, between `points` points.
    PlyFaces {
        points: u64,
    },
    ObjFaces {
        points: u64,
    },
    /// Geometries in memory, whose reader is open from the start.
    #[cfg(feature = "wkb")]
    Memory,
}

impl LineFormat {
    /// Returns the format of a file with lines, by its name or else its content.
    fn of_lines(path: &Path) -> Option<Self> {
        let suffix = path.extension().and_then(|suffix| suffix.to_str());
        match suffix.map(str::to_ascii_lowercase).as_deref() {
            Some("u32") => Some(Self::Pairs { bytes: 4 }),
            Some("u64") => Some(Self::Pairs { bytes: 8 }),
            _ => match content::format_of(path)? {
                Format::Text => Some(Self::Text),
                format => Vector::of(format).map(Self::Lines),
            },
        }
    }

    /// Returns the format of a file with polygons, by its name or else its content.
    fn of_polygons(path: &Path) -> Option<Self> {
        content::format_of(path).and_then(Vector::of).map(Self::Rings)
    }

    /// Returns the word for a line.
    fn line(self) -> &'static str {
        match self {
            Self::Pairs { .. } => "pair",
            Self::Text => "row",
            Self::Lines(_) | Self::Rings(_) => "feature",
            Self::Elements { .. } => "triangle",
            Self::PlyFaces { .. } | Self::ObjFaces { .. } => "face",
            #[cfg(feature = "wkb")]
            Self::Memory => "feature",
        }
    }
}

impl Records for SegmentBatch {
    type Format = LineFormat;

    // A batch has segments by their ends before those by records, so the order of the files would
    // be lost.
    const SPANS_FILES: bool = false;

    fn content(format: LineFormat) -> Option<Format> {
        match format {
            LineFormat::Pairs { .. } | LineFormat::Elements { .. } => None,
            LineFormat::PlyFaces { .. } => Some(Format::Ply),
            LineFormat::ObjFaces { .. } => Some(Format::Obj),
            LineFormat::Text => Some(Format::Text),
            LineFormat::Lines(vector) | LineFormat::Rings(vector) => Some(vector.format()),
            #[cfg(feature = "wkb")]
            LineFormat::Memory => None,
        }
    }

    fn may_be_gzip(format: LineFormat) -> bool {
        !matches!(format, LineFormat::Pairs { .. })
    }

    fn start(format: LineFormat, input: ByteInput, (): &()) -> Started<Self> {
        match format {
            LineFormat::Pairs { bytes } => Ok(Box::new(Pairs::new(input, bytes))),
            LineFormat::Elements { base, points } => Ok(Box::new(ele::Edges::new(input, base, points)?)),
            LineFormat::PlyFaces { points } => Ok(Box::new(ply::Edges::new(input, points)?)),
            LineFormat::ObjFaces { points } => Ok(Box::new(obj::Edges::new(input, points)?)),
            #[cfg(feature = "text")]
            LineFormat::Text => Ok(Box::new(text::Segments::new(input)?)),
            #[cfg(not(feature = "text"))]
            LineFormat::Text => Err(Format::Text.missing(&input.path)),
            LineFormat::Lines(vector) => Ok(Box::new(Lines::new(vector.start(input)?)?)),
            LineFormat::Rings(vector) => {
                let path = Arc::clone(&input.path);
                Ok(Box::new(Rings::new(vector.start(input)?, &path)?))
            }
            #[cfg(feature = "wkb")]
            LineFormat::Memory => unreachable!("its reader stays open"),
        }
    }

    fn start_file(format: LineFormat, file: Watched<Arc<File>>, (): &()) -> Started<Self> {
        match format {
            LineFormat::Lines(vector) => Ok(Box::new(Lines::new(vector.start_file(file)?)?)),
            LineFormat::Rings(vector) => {
                let path = Arc::clone(&file.watch.path);
                Ok(Box::new(Rings::new(vector.start_file(file)?, &path)?))
            }
            _ => start_stream(format, file, &()),
        }
    }
}

impl Source<SegmentBatch> {
    /// Opens files with lines and examines the beginning of each.
    ///
    /// # Errors
    /// Fails if a file does not exist, its name does not indicate a format, or it is broken at its
    /// beginning.
    pub fn open(paths: &[PathBuf]) -> Result<Self, InputError> {
        Self::of_files(paths, (), LineFormat::of_lines, RecordKind::Segment)
    }

    /// Opens files with polygons and examines the beginning of each.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn open_obstacles(paths: &[PathBuf]) -> Result<Self, InputError> {
        Self::of_files(paths, (), LineFormat::of_polygons, RecordKind::Obstacle)
    }

    /// Takes geometries from memory as one input: lines, or polygons if `are_polygons` is set. Each
    /// geometry is a line, given as well-known binary (WKB), of z too; one without bytes is empty.
    /// Messages use `name` as the name of the input.
    ///
    /// # Errors
    /// Fails if a geometry up to the first position is invalid.
    ///
    /// # Examples
    ///
    /// ```
    /// use delaunay_tiles::input::{SegmentBatch, SegmentSource};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mut line = vec![1, 2, 0, 0, 0, 2, 0, 0, 0]; // little-endian, LineString, 2 positions
    /// line.extend([0.0, 0.0, 3.0, 4.0].into_iter().flat_map(f64::to_le_bytes));
    /// let mut source = SegmentSource::from_wkb("streets", vec![line].into_iter(), false)?;
    /// let mut batch = SegmentBatch::default();
    /// assert!(source.next_batch(&mut batch)?);
    /// assert_eq!(batch.ends[0][1].x, 3.0);
    /// assert_eq!(source.origin(0).expect("it was read").to_string(), "streets: feature 0 (counted from 0)");
    /// # Ok(())
    /// # }
    /// ```
    #[cfg(feature = "wkb")]
    pub fn from_wkb(
        name: &str,
        geometries: impl Iterator<Item = Vec<u8>> + Send + 'static,
        are_polygons: bool,
    ) -> Result<Self, InputError> {
        let mut source = Self::new(());
        let input = Input::new(Path::new(name), LineFormat::Memory);
        let geometries = Geometries {
            geometries,
            name: Arc::clone(&input.path),
            reading: source.reading.clone(),
        };
        let shapes = Box::new(Decoded::new(geometries));
        let opened = input.open_reader(
            match are_polygons {
                true => Box::new(Rings::new(shapes, &input.path)?),
                false => Box::new(Lines::new(shapes)?),
            },
            &source.reading,
        );
        source.add(input, opened);
        Ok(source)
    }

    /// Returns the number of segments read so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.records
    }

    /// Returns the origin of line `line`; `None` if no line with this number was handed out.
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
