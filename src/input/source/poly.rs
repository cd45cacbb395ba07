//! The segments and the hole points of Triangle's `.poly` files.
//!
//! In: the path of a file that [`PointSource`](crate::input::PointSource) reads the points of. Out: [`SegmentBatch`]es of segments
//! by record numbers, then the hole points. The file is read twice, so it cannot be a pipe.

use crate::geometry::Point;
use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Place, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::formats::node::{Vertices, fields, whole_number};
use crate::input::formats::poly::{Section, open_node_beside};
use crate::input::formats::text_lines::{Lines, number};
use crate::input::lines::SegmentBatch;
use crate::input::reader::FULL;
use crate::input::spot::Spot;
use crate::input::watch::{FileStamp, Reading, Watch, Watched, note};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The segments and the hole points of one `.poly` file.
///
/// **Record numbers** count the points of this file (or of the `.node` file beside it) from 0, as a
/// [`PointSource`](crate::input::PointSource) that has no other input does. Where it has others before this one, their
/// records are to be added. Segments are numbered from 0 in this file.
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
    /// The number of points, and the index of the first one.
    points: u64,
    base: u64,
    segments: Section,
}

/// The lines of a regular file.
fn open_lines(path: &Path, reading: &Reading) -> Result<(Lines, Arc<Watch>), InputError> {
    let file = Watched::open(path, reading, None)?;
    let watch = Arc::clone(&file.watch);
    if watch.size().is_none() {
        let hint = "a .poly file is read twice, for its points and for its segments";
        return Err(InputError::malformed(
            path,
            Place::File,
            "this is no regular file",
            hint,
        ));
    }
    let lines = ByteInput::new(file, true).and_then(Lines::new);
    Ok((lines.map_err(|error| watch.explain(error))?, watch))
}

impl PolySource {
    /// Opens a file and passes over its points.
    ///
    /// # Errors
    /// A file that does not exist, is no regular file, or is broken up to its segments; the same for a `.node` file beside it.
    /// Whether the points' coordinates are valid is not looked at.
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

    /// How far the reading is, and the way to stop it.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.watch.reading
    }

    /// The file, and the `.node` file beside it if that has the points, as they were when they were
    /// looked at.
    #[must_use]
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        &self.stamps
    }

    /// The number of points that the file (or the `.node` file beside it) claims.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Segments so far.
    #[must_use]
    pub fn segments(&self) -> u64 {
        self.segments.read
    }

    /// Clears the batch and fills it with the next segments, at most 8192; false if there are none left.
    ///
    /// # Errors
    /// A row that is no segment, or has an index of no point; a file that is cut short or cannot be read. An error ends the
    /// segments.
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

    /// The points inside holes: valid and normalized. Passes over the segments that are left, and reads the file to its end.
    ///
    /// # Errors
    /// As for [`Self::next_batch`]; a hole that is no valid point; rows behind the last one; a file
    /// that has changed since it was opened.
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

    /// The records of the segment at hand.
    fn segment(&self) -> Result<[u64; 2], InputError> {
        let mut fields = fields(self.lines.text()).map(whole_number);
        let (Some(Some(_)), Some(Some(from)), Some(Some(to))) = (fields.next(), fields.next(), fields.next()) else {
            let row = self.lines.excerpt();
            return Err(self.wrong(&Flaw::PolySegment { row }));
        };
        Ok([self.record(from)?, self.record(to)?])
    }

    /// The record of the point of this index.
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
            place: Place::Line(self.lines.row()),
            found: flaw.to_string(),
        }
    }

    /// The point of the hole at hand, which is this one.
    fn hole(&self, hole: u64) -> Result<Point, InputError> {
        let mut fields = fields(self.lines.text()).skip(1).map(number);
        let spot = match (fields.next(), fields.next()) {
            (Some(Some(x)), Some(Some(y))) => Spot::new(x, y, None),
            _ => Err(Flaw::PolyHole {
                row: self.lines.excerpt(),
            }),
        };
        let hint = "a hole is given by a point in it";
        let point = spot.map(|spot| spot.point);
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
