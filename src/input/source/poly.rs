//! The segments and the hole points of Triangle's `.poly` files.
//!
//! In: the path of a file whose points a [`PointSource`](crate::input::PointSource) reads. Out:
//! [`SegmentBatch`]es of segments given by record numbers, then the hole points. The file is read
//! twice, so it cannot be a pipe.

use crate::geometry::Point;
use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::node::{Vertices, fields, whole_number};
use crate::input::formats::poly::{Section, open_node_beside};
use crate::input::formats::text_lines::{Lines, number};
use crate::input::lines::SegmentBatch;
use crate::input::point_z::PointZ;
use crate::input::reader::FULL;
use crate::input::watch::{FileStamp, Reading, Watch, Watched, note};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The segments and the hole points of one `.poly` file.
///
/// **Record numbers** count the points of this file (or of the `.node` file beside it) from 0, as a
/// [`PointSource`](crate::input::PointSource) with no other input does. If the point source has
/// other inputs before this file, add the number of their records. Segments are numbered from 0 in
/// this file.
///
/// ```
/// use delaunay_tiles::input::{PolySource, SegmentBatch};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("triangle.poly");
/// std::fs::write(&path, "3 2 0 0\n1 0 0\n2 9 0\n3 0 9\n3 0\n1 1 2\n2 2 3\n3 3 1\n1\n1 2.5 2.5\n")?;
///
/// let mut source = PolySource::open(&path)?;
/// let mut batch = SegmentBatch::default();
/// while source.next_batch(&mut batch)? {
///     assert_eq!(batch.records, [[0, 1], [1, 2], [2, 0]]);
/// }
/// assert_eq!(source.holes()?.len(), 1);
/// # Ok(())
/// # }
/// ```
pub struct PolySource {
    path: PathBuf,
    lines: Lines,
    watch: Arc<Watch>,
    stamps: Vec<(PathBuf, FileStamp)>,
    /// The number of points, and the index of the first point.
    points: u64,
    base: u64,
    segments: Section,
}

/// Opens a regular file as lines.
fn open_lines(path: &Path, reading: &Reading) -> Result<(Lines, Arc<Watch>), InputError> {
    let file = Watched::open(path, reading, None)?;
    let watch = Arc::clone(&file.watch);
    if watch.size().is_none() {
        let hint = "a .poly file is read twice, for its points and for its segments";
        return Err(InputError::malformed(
            path,
            Location::File,
            "this is not a regular file",
            hint,
        ));
    }
    let lines = ByteInput::new(file, true).and_then(Lines::new);
    Ok((lines.map_err(|error| watch.explain(error))?, watch))
}

impl PolySource {
    /// Opens a file and skips its points.
    ///
    /// # Errors
    /// Fails if the file does not exist, is not a regular file, or is broken before the rows of
    /// its segments; likewise for a `.node` file beside it. Does not check
    /// whether the points' coordinates are valid.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let (reading, mut stamps) = (Reading::default(), Vec::new());
        let (lines, watch) = open_lines(path, &reading)?;
        note(&mut stamps, &watch);
        let begun = Self::begin(path, lines, watch.clone(), &reading, stamps);
        begun.map_err(|error| watch.explain(error))
    }

    fn begin(
        path: &Path,
        lines: Lines,
        watch: Arc<Watch>,
        reading: &Reading,
        mut stamps: Vec<(PathBuf, FileStamp)>,
    ) -> Result<Self, InputError> {
        let mut vertices = Vertices::new(lines, true)?;
        let (mut points, mut base) = (vertices.claimed, None);
        if points == 0 {
            let (lines, watch) = open_node_beside(path, |node| open_lines(node, reading))?;
            note(&mut stamps, &watch);
            let mut beside = Vertices::new(lines, false)?;
            beside.next_row()?;
            (points, base) = (beside.claimed, beside.base());
        }
        while vertices.next_row()?.is_some() {}
        let base = base.or(vertices.base()).unwrap_or(0);
        let mut lines = vertices.lines;
        let segments = Section::begin(&mut lines, "segments", 2)?;
        Ok(Self {
            path: path.to_owned(),
            lines,
            watch,
            stamps,
            points,
            base,
            segments,
        })
    }

    /// Returns the [`Reading`], which shows the progress and stops the reading.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.watch.reading
    }

    /// Returns the stamps at opening of the file, and of the `.node` file beside it if that has the
    /// points.
    #[must_use]
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        &self.stamps
    }

    /// Returns the number of points that the file (or the `.node` file beside it) claims.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Returns the number of segments read so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.segments.read
    }

    /// Clears the batch and fills it with the next segments, at most 8192. Returns false if no
    /// segments are left.
    ///
    /// # Errors
    /// Fails if a row is not a segment or has an index of no point, or if the file is cut short or
    /// cannot be read. After an error there are no more segments.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> Result<bool, InputError> {
        batch.clear();
        let first = self.segments.read;
        let filled = self.fill(batch, first + FULL as u64);
        if filled.is_err() {
            batch.clear();
            self.segments.claimed = self.segments.read;
        }
        filled.map_err(|error| self.watch.explain(error))?;
        batch.lines.extend(first..self.segments.read);
        Ok(!batch.is_empty())
    }

    fn fill(&mut self, batch: &mut SegmentBatch, end: u64) -> Result<(), InputError> {
        while self.segments.read < end && self.segments.next_row(&mut self.lines)? {
            let records = self.segment()?;
            batch.records.push(records);
        }
        Ok(())
    }

    /// Returns the points inside holes, valid and normalized. Skips the remaining segments and
    /// reads the file to its end.
    ///
    /// # Errors
    /// As for [`Self::next_batch`]. Also fails if a hole is not a valid point, if rows follow the
    /// last section, or if the file has changed since it was opened.
    pub fn holes(mut self) -> Result<Vec<Point>, InputError> {
        let watch = Arc::clone(&self.watch);
        let holes = self.read_holes().map_err(|error| watch.explain(error))?;
        watch.check()?;
        Ok(holes)
    }

    fn read_holes(&mut self) -> Result<Vec<Point>, InputError> {
        while self.segments.next_row(&mut self.lines)? {
            self.segment()?;
        }
        let mut section = Section::begin(&mut self.lines, "holes", 1)?;
        let mut holes = Vec::new();
        while section.next_row(&mut self.lines)? {
            holes.push(self.hole(section.read - 1)?);
        }
        if self.lines.next_row()? {
            let mut regions = Section::of_row(&self.lines, "regions", 1)?;
            while regions.next_row(&mut self.lines)? {}
            regions.end(&mut self.lines)?;
        }
        Ok(holes)
    }

    /// Returns the record numbers of the current segment.
    fn segment(&self) -> Result<[u64; 2], InputError> {
        let mut fields = fields(self.lines.text()).map(whole_number);
        let (Some(Some(_)), Some(Some(from)), Some(Some(to))) = (fields.next(), fields.next(), fields.next()) else {
            let row = self.lines.excerpt();
            return Err(self.wrong(&Flaw::PolySegment { row }));
        };
        Ok([self.record(from)?, self.record(to)?])
    }

    /// Returns the record number of the point with this index.
    fn record(&self, index: u64) -> Result<u64, InputError> {
        let record = index.checked_sub(self.base).filter(|record| *record < self.points);
        record.ok_or_else(|| match self.points.checked_sub(1) {
            None => self.wrong(&Flaw::NoPoints { index }),
            Some(last) => self.wrong(&Flaw::NoSuchPoint {
                index,
                first: self.base,
                last: self.base + last,
            }),
        })
    }

    fn wrong(&self, flaw: &Flaw) -> InputError {
        InputError::Record {
            path: self.path.clone(),
            kind: RecordKind::Segment,
            number: self.segments.read - 1,
            location: Location::Line(self.lines.row()),
            found: flaw.to_string(),
        }
    }

    /// Returns the point of the current hole, which has the number `hole`.
    fn hole(&self, hole: u64) -> Result<Point, InputError> {
        let mut fields = fields(self.lines.text()).skip(1).map(number);
        let point_z = match (fields.next(), fields.next()) {
            (Some(Some(x)), Some(Some(y))) => PointZ::new(x, y, None),
            _ => Err(Flaw::PolyHole {
                row: self.lines.excerpt(),
            }),
        };
        let hint = "a hole is given by a point in it";
        let point = point_z.map(|point_z| point_z.point);
        point.map_err(|flaw| self.lines.malformed(format!("hole {hole}: {flaw}"), hint))
    }
}

impl fmt::Debug for PolySource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PolySource")
            .field("path", &self.path)
            .field("points", &self.points)
            .field("segments", &self.segments.read)
            .finish_non_exhaustive()
    }
}
