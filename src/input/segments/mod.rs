//! Segments from files: break lines, walls, and the outlines of obstacles.
//!
//! In: paths. Out: [`SegmentBatch`]es. [`SegmentSource`] tells the formats and what is promised of each. Why one source for
//! all three: they differ in what they are for, which whoever builds says, and polygons in having a side that is inside.
//!
//! ```text
//!   paths ─> Files ─> one Reader at a time ─> Sink ─> SegmentBatch
//!                       │ geojson, text, pairs: lines      numbers, z for all ends or none
//!                       └ rings: polygons, directed
//! ```
//!
//! **Memory**: a batch, and of GeoJSON the vertices of one geometry, since only its end tells for sure what it is, or of
//! obstacles those of one ring.

#[cfg(feature = "geojson")]
mod geojson;
mod pairs;
#[cfg(feature = "geojson")]
mod rings;
#[cfg_attr(
    not(feature = "geojson"),
    allow(dead_code, reason = "polygons, z and some errors are of GeoJSON alone")
)]
mod sink;
#[cfg(feature = "text")]
mod text;

use super::InputError;
use super::bytes::ByteInput;
use super::files::{Files, name_of};
#[cfg(not(all(feature = "text", feature = "geojson")))]
use super::source::missing;
use super::watch::{FileStamp, Reading};
use crate::geometry::Point;
use crate::shown;
use sink::{OddEnds, Sink};
use std::fmt;
use std::path::{Path, PathBuf};

/// A batch of segments.
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// Segments by their ends: valid and normalized points.
    pub ends: Vec<[Point; 2]>,
    /// The elevations of these ends: finite, or NaN where an end has none. Empty if the source has
    /// none ([`SegmentSource::has_z`]), else as long as `ends`.
    pub z: Vec<[f64; 2]>,
    /// Segments by the record numbers of two points.
    pub records: Vec<[u64; 2]>,
    /// The number of each segment's line, first of those in `ends`, then of those in `records`.
    pub lines: Vec<u64>,
    /// Of obstacles, the number of the polygon of each segment in `ends`: a line has several if it is a MultiPolygon. Empty where each
    /// line is one.
    pub polygons: Vec<u64>,
}

impl SegmentBatch {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.records.is_empty()
    }

    /// Removes all segments and keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.z.clear();
        self.records.clear();
        self.lines.clear();
        self.polygons.clear();
    }

    fn len(&self) -> usize {
        self.ends.len() + self.records.len()
    }
}

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
pub struct SegmentSource {
    files: Files<Box<dyn Reader>>,
    segments: u64,
    has_z: bool,
    odd: OddEnds,
    notes: Vec<String>,
    done: Vec<(String, u64)>,
    /// The lines of the files that are done.
    done_lines: u64,
    /// Their polygons.
    done_polygons: u64,
    /// One more than the largest line that is known by now.
    lines: u64,
    /// Each file that was begun, and its first line.
    begun: Vec<(PathBuf, u64)>,
}

/// What a format does.
trait Reader: Send {
    /// Whether its first position has z. Known from the start.
    fn has_z(&self) -> bool {
        false
    }

    /// The lines that are at their end.
    fn lines(&self) -> u64;

    /// The polygons that were begun.
    fn polygons(&self) -> u64 {
        0
    }

    /// Puts segments into the sink until it is full (true) or the file is at its end (false).
    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError>;

    /// What a person should know, when the file is at its end.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

type Opened = Result<Box<dyn Reader>, InputError>;

/// Where a line comes from.
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

/// The format of a file with segments.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    Pairs { bytes: usize },
    Text,
    GeoJson,
}

impl Format {
    fn from_path(path: &Path) -> Option<Self> {
        let suffix = path.extension().and_then(|suffix| suffix.to_str());
        match suffix.map(str::to_ascii_lowercase).as_deref() {
            Some("u32") => return Some(Self::Pairs { bytes: 4 }),
            Some("u64") => return Some(Self::Pairs { bytes: 8 }),
            _ => {}
        }
        match super::Format::from_path(path)? {
            super::Format::Text => Some(Self::Text),
            super::Format::GeoJson => Some(Self::GeoJson),
            _ => None,
        }
    }

    /// What a line is.
    fn line(self) -> &'static str {
        match self {
            Self::Pairs { .. } => "pair",
            Self::Text => "row",
            Self::GeoJson => "feature",
        }
    }
}

impl SegmentSource {
    /// Opens files with lines, and looks at each one's beginning.
    ///
    /// # Errors
    /// A file that does not exist, whose name tells no format, or that is broken at its beginning.
    pub fn open(paths: &[PathBuf]) -> Result<Self, InputError> {
        if let Some(path) = paths.iter().find(|path| Format::from_path(path).is_none()) {
            return Err(InputError::UnknownSegments { path: path.clone() });
        }
        Self::over(paths, lines_of)
    }

    /// Opens files with polygons, and looks at each one's beginning.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn open_obstacles(paths: &[PathBuf]) -> Result<Self, InputError> {
        let is_polygons = |path: &&PathBuf| Format::from_path(path) == Some(Format::GeoJson);
        if let Some(path) = paths.iter().find(|path| !is_polygons(path)) {
            return Err(InputError::UnknownObstacles { path: path.clone() });
        }
        Self::over(paths, polygons_of)
    }

    fn over(paths: &[PathBuf], start: fn(&Path, ByteInput) -> Opened) -> Result<Self, InputError> {
        // Of formats but raw numbers no file can begin as gzip does.
        let unzip = |path: &Path| !matches!(Format::from_path(path), Some(Format::Pairs { .. }));
        let mut has_z = false;
        Ok(Self {
            files: Files::open(paths, unzip, Box::new(start), |reader| has_z |= reader.has_z())?,
            segments: 0,
            has_z,
            odd: OddEnds::default(),
            notes: Vec::new(),
            done: Vec::new(),
            done_lines: 0,
            done_polygons: 0,
            lines: 0,
            begun: Vec::new(),
        })
    }

    /// Segments so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// Whether the batches have z: if the first position of any file has.
    #[must_use]
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// The files that are done, in order: the name of each, without its folder, and how many lines it had.
    #[must_use]
    pub fn sources(&self) -> &[(String, u64)] {
        &self.done
    }

    /// Bytes read so far, as they are in the files.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.files.bytes_read()
    }

    /// How far the reading is, and the way to stop it.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        self.files.reading()
    }

    /// The regular files among the inputs, as they were when they were looked at.
    #[must_use]
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        self.files.stamps()
    }

    /// What a person should know about the files that are done, such as which rings were closed.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Where a line comes from that was handed out; `None` if there was none of this number.
    #[must_use]
    pub fn origin(&self, line: u64) -> Option<LineOrigin<'_>> {
        let at = self.begun.partition_point(|&(_, first)| first <= line);
        let (path, first) = self.begun[..at].last().filter(|_| line < self.lines)?;
        Some(LineOrigin {
            path,
            what: Format::from_path(path)?.line(),
            number: line - first,
        })
    }

    /// Clears the batch and fills it with the next segments, at most 8192; false if there are none left.
    ///
    /// # Errors
    /// A file that is broken or cannot be read, an end that is no valid point, an obstacle that is no polygon. An error
    /// ends the stream.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        batch.clear();
        let filled = self.fill(batch);
        if filled.is_err() {
            self.files.clear();
            batch.clear();
        }
        filled?;
        self.segments += batch.len() as u64;
        Ok(!batch.is_empty())
    }

    fn fill(&mut self, batch: &mut SegmentBatch) -> Result<(), InputError> {
        while let Some((path, reader)) = self.files.current()? {
            if self.begun.len() == self.done.len() {
                self.begun.push((path.to_owned(), self.done_lines));
            }
            let filled = reader.fill(&mut Sink {
                batch,
                path,
                wants_z: self.has_z,
                first_segment: self.segments,
                first_line: self.done_lines,
                first_polygon: self.done_polygons,
                odd: &mut self.odd,
            });
            let more = match filled {
                Ok(more) => more,
                Err(error) => return Err(self.files.explain(error)),
            };
            self.lines = self.done_lines + reader.lines();
            if !more {
                self.done.push((name_of(path), reader.lines()));
                self.done_lines = self.lines;
                self.done_polygons += reader.polygons();
                self.notes.extend(reader.notes());
                self.notes.extend(std::mem::take(&mut self.odd).notes(path));
                self.files.next_file()?;
            }
            if let Some(last) = batch.lines.last() {
                self.lines = self.lines.max(last + 1);
                return Ok(());
            }
        }
        Ok(())
    }
}

impl fmt::Debug for SegmentSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SegmentSource")
            .field("paths", &self.files.paths().collect::<Vec<_>>())
            .field("segments", &self.segments)
            .finish_non_exhaustive()
    }
}

fn lines_of(path: &Path, input: ByteInput) -> Opened {
    match Format::from_path(path) {
        Some(Format::Pairs { bytes }) => Ok(Box::new(pairs::Pairs::new(input, bytes))),
        #[cfg(feature = "text")]
        Some(Format::Text) => Ok(Box::new(text::Text::new(input)?)),
        #[cfg(feature = "geojson")]
        Some(Format::GeoJson) => Ok(Box::new(geojson::Lines::new(input)?)),
        #[cfg(not(feature = "text"))]
        Some(Format::Text) => Err(missing(path, super::Format::Text)),
        #[cfg(not(feature = "geojson"))]
        Some(Format::GeoJson) => Err(missing(path, super::Format::GeoJson)),
        None => Err(InputError::UnknownSegments { path: path.to_owned() }),
    }
}

#[cfg(feature = "geojson")]
fn polygons_of(_: &Path, input: ByteInput) -> Opened {
    Ok(Box::new(rings::Rings::new(input)?))
}

#[cfg(not(feature = "geojson"))]
fn polygons_of(path: &Path, _: ByteInput) -> Opened {
    Err(missing(path, super::Format::GeoJson))
}
