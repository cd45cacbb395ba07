//! Triangle's `.poly` files: the segments between their points, and the points that tell holes.
//!
//! In: the path of a file that [`PointSource`](super::PointSource) reads the points of. Out: [`SegmentBatch`]es of segments
//! by record numbers, then the hole points. The file is read twice, so it cannot be a pipe.
//!
//! ```text
//! 4 2 0 0             points, dimension (2), attributes, markers: as in a .node file
//! 1  0.0 0.0          index from 0 or 1, x, y, attributes, marker
//! …
//! 4 0                 segments, markers (0 or 1)
//! 1  1 2              number, the indices of two points, marker
//! …
//! 1                   holes
//! 1  0.5 0.5          number, x, y
//! 0                   regions (this line may be missing)
//! …                   number, x, y, attribute, area
//! ```
//!
//! If the number of points is 0, they are in the `.node` file of the same stem beside it (`a.node` of `a.poly`, `a.node.gz` of
//! `a.poly.gz`). `#` begins a comment. Markers and regions are not read, and as in Triangle the numbers of segments and
//! holes are anything. Source: <https://www.cs.cmu.edu/~quake/triangle.poly.html>. No count is believed: rows are
//! counted, and none may be left over.

use super::bytes::ByteInput;
use super::lines::{Lines, number};
use super::node::{Vertices, fields, whole_number};
use super::sink::describe;
use super::watch::{FileStamp, Reading, Watch, Watched, note};
use super::{InputError, Place, SegmentBatch};
use crate::geometry::Point;
use crate::shown;
use crate::shown::excerpt;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Segments in a full batch.
const BATCH: u64 = 8192;

/// The segments and the hole points of one `.poly` file.
///
/// **Record numbers** count the points of this file (or of the `.node` file beside it) from 0, as a
/// [`PointSource`](super::PointSource) that has no other input does. Where it has others before this one, their
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

/// Rows of a kind, behind the line with their number.
#[derive(Clone, Copy)]
struct Section {
    what: &'static str,
    claimed: u64,
    read: u64,
}

/// The path of the `.node` file beside a `.poly` file; `None` if that has another suffix.
fn node_beside(poly: &Path) -> Option<PathBuf> {
    let name = poly.file_name()?.to_str()?;
    let (name, zipped) = match name.to_ascii_lowercase().ends_with(".gz") {
        true => (&name[..name.len() - 3], ".gz"),
        false => (name, ""),
    };
    let (stem, suffix) = name.rsplit_once('.')?;
    let is_poly = suffix.eq_ignore_ascii_case("poly");
    is_poly.then(|| poly.with_file_name(format!("{stem}.node{zipped}")))
}

/// Opens the `.node` file that has the points of a `.poly` file, by this function.
pub(super) fn open_node_beside<T>(
    poly: &Path,
    open: impl FnOnce(&Path) -> Result<T, InputError>,
) -> Result<T, InputError> {
    let node = node_beside(poly).ok_or_else(|| no_points(poly, "its name does not end in .poly".to_owned(), None))?;
    open(&node).map_err(|error| match error {
        InputError::Open { path, source } => {
            no_points(poly, format!("{} cannot be opened", shown::path(&path)), Some(source))
        }
        other => other,
    })
}

/// The error of a `.poly` file that has no points, and no file with points beside it, for this reason.
pub(super) fn no_points(poly: &Path, reason: String, source: Option<io::Error>) -> InputError {
    InputError::Malformed {
        path: poly.to_owned(),
        place: Place::File,
        problem: format!("by its first line its points are in the .node file of the same stem beside it, but {reason}"),
        hint: "put that file there, or the points into this one",
        source: source.map(Into::into),
    }
}

/// The lines of a regular file.
fn open_lines(path: &Path, reading: &Reading) -> Result<(Lines, Arc<Watch>), InputError> {
    let file = Watched::open(path, reading, None)?;
    let watch = Arc::clone(&file.watch);
    if watch.size().is_none() {
        return Err(InputError::Malformed {
            path: path.to_owned(),
            place: Place::File,
            problem: "this is no regular file".to_owned(),
            hint: "a .poly file is read twice, for its points and for its segments",
            source: None,
        });
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
        let filled = self.fill(batch, first + BATCH);
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
            if self.lines.next_row()? {
                let row = excerpt(self.lines.text().trim_ascii_end());
                let problem = format!("a row behind the last of {} regions: `{row}`", regions.claimed);
                return Err(self.lines.malformed(problem, COUNT_HINT));
            }
        }
        Ok(holes)
    }

    /// The records of the segment at hand.
    fn segment(&self) -> Result<[u64; 2], InputError> {
        let row = self.lines.text().trim_ascii_end();
        let mut fields = fields(row).map(whole_number);
        let (Some(Some(_)), Some(Some(from)), Some(Some(to))) = (fields.next(), fields.next(), fields.next()) else {
            let found = format!(
                "a number and the indices of two points are due, and the row is `{}`",
                excerpt(row)
            );
            return Err(self.wrong(found));
        };
        let record = |index: u64| {
            let record = index.checked_sub(self.base).filter(|record| *record < self.points);
            record.ok_or_else(|| {
                let found = match self.points {
                    0 => format!("there is no point {index}, since there are no points"),
                    n => format!(
                        "there is no point {index}; they are {} to {}",
                        self.base,
                        self.base + (n - 1)
                    ),
                };
                self.wrong(found)
            })
        };
        Ok([record(from)?, record(to)?])
    }

    fn wrong(&self, found: String) -> InputError {
        InputError::Segment {
            path: self.path.clone(),
            segment: self.segments.read - 1,
            place: Place::Line(self.lines.row()),
            found,
        }
    }

    /// The point of the hole at hand, which is this one.
    fn hole(&self, hole: u64) -> Result<Point, InputError> {
        let row = self.lines.text().trim_ascii_end();
        let mut fields = fields(row).skip(1).map(number);
        let found = match (fields.next(), fields.next()) {
            (Some(Some(x)), Some(Some(y))) if Point::new(x, y).is_valid() => return Ok(Point::new(x, y).normalized()),
            (Some(Some(x)), Some(Some(y))) => describe(x, y, None),
            _ => format!("a number, x and y are due, and the row is `{}`", excerpt(row)),
        };
        Err(self
            .lines
            .malformed(format!("hole {hole}: {found}"), "a hole is given by a point in it"))
    }
}

const COUNT_HINT: &str = "the file is cut short, or one of its counts is wrong";

impl Section {
    /// Reads the line with the number of the rows, which has so many fields at most.
    fn begin(lines: &mut Lines, what: &'static str, most: usize) -> Result<Self, InputError> {
        if !lines.next_row()? {
            let problem = format!("the file ends before the number of {what}");
            return Err(lines.malformed(problem, COUNT_HINT));
        }
        Self::of_row(lines, what, most)
    }

    fn of_row(lines: &Lines, what: &'static str, most: usize) -> Result<Self, InputError> {
        let row = lines.text().trim_ascii_end();
        let mut numbers = fields(row).map(whole_number);
        match numbers.next().flatten() {
            // A row more, or less, of what is before shows by its fields.
            Some(claimed) if numbers.by_ref().take(most).count() < most => Ok(Self { what, claimed, read: 0 }),
            _ => {
                let problem = format!("the number of {what} is due, and the row is `{}`", excerpt(row));
                Err(lines.malformed(problem, COUNT_HINT))
            }
        }
    }

    /// Goes to the next row; false behind the last one.
    fn next_row(&mut self, lines: &mut Lines) -> Result<bool, InputError> {
        if self.read == self.claimed {
            return Ok(false);
        }
        if !lines.next_row()? {
            let problem = format!("the file ends after {} of {} {}", self.read, self.claimed, self.what);
            return Err(lines.malformed(problem, COUNT_HINT));
        }
        self.read += 1;
        Ok(true)
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
