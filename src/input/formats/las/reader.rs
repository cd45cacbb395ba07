//! The reader of LAS, LAZ and COPC files of lidar points.
//!
//! In: a file. Out: its points with z, scaled according to the header, without withheld points and
//! without points that the selected classes and returns exclude. Of a COPC file, nodes that the
//! options exclude are not read; their points count as filtered. Source: ASPRS, LAS Specification
//! 1.4 R15.
//!
//! The crate `las` parses the header and records, `laz` decompresses. `las::Reader` is not used: it
//! cannot be sent to another thread, and it trusts lengths (an extended record of 2^60 bytes, a
//! layer of 4 GiB). Here, every number of the header is compared with the file's size before
//! anything is allocated or decoded according to it. A file that is cut short fails at open. The
//! header, not the suffix, determines whether a file is LAZ.

use crate::geometry::{Point, Rect};
use crate::input::about::About;
use crate::input::bytes::BUFFER;
use crate::input::error::{InputError, Location};
use crate::input::formats::las::about::Census;
use crate::input::formats::las::copc::{Choice, stale};
use crate::input::formats::las::header::{count, crs, extended_wkt, header, records};
use crate::input::formats::las::layout::{Keep, Layout};
use crate::input::formats::las::laz::{Compression, Laz};
use crate::input::formats::las::problem::{FileReader, Problem};
use crate::input::options::InputOptions;
use crate::input::points::{InputCounts, PointBatch};
use crate::input::reader::{Reader, Sink, Started};
use crate::input::sample::RandomAccess;
use crate::input::watch::Watched;
use std::fs::File;
use std::io;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// The number of bytes of points read at once.
const CHUNK: usize = 1 << 20;

/// The size of the buffer for parts of the file here and there: its header and tables, and nodes of
/// which others are left out.
const SMALL_BUFFER: usize = 8192;

/// Returns the error for LAS in an input that is not a file.
pub fn no_stream(path: &Path) -> InputError {
    Problem {
        hint: "give the name of a file (not a pipe, and not gzip)",
        ..Problem::damaged("LAS is not read from a stream")
    }
    .at(path, Location::File)
}

/// Starts the reader of a file of `size` bytes.
pub fn open(file: Watched<Arc<File>>, size: u64, options: &InputOptions) -> Started<PointBatch> {
    let path = Arc::clone(&file.watch.path);
    match Las::new(BufReader::with_capacity(SMALL_BUFFER, file), size, options) {
        Ok(las) => Ok(Box::new(las)),
        Err(problem) => Err(problem.at(&path, Location::File)),
    }
}

struct Las {
    layout: Layout,
    records: Records,
    /// The offset of the first point, in bytes.
    start: u64,
    /// The number of points in the file, and how many of them were read or passed over.
    count: u64,
    read: u64,
    /// The number of points that are still to be read.
    left: u64,
    keep: Keep,
    /// Space for whole records.
    buffer: Vec<u8>,
    crs: Option<String>,
    /// The rectangle of the header.
    extent: Rect,
    /// The counts for a description, if there is to be one.
    census: Option<Box<Census>>,
}

/// The origin of the records.
enum Records {
    Plain(FileReader),
    Compressed(Box<Laz>),
}

impl Las {
    fn new(mut file: FileReader, size: u64, options: &InputOptions) -> Result<Self, Problem> {
        let header = header(&mut file)?;
        let (layout, compressed) = Layout::new(&header)?;
        let count = count(&header);
        let start = u64::from(header.offset_to_point_data);
        let records = records(&mut file, &header, start.min(size))?;
        let crs = match crs(&records) {
            Some(crs) => Some(crs),
            None => extended_wkt(&mut file, &header, size),
        };
        let census = options
            .is_description
            .then(|| Box::new(Census::new(&mut file, &header, &records, &layout, size)));
        let choice = Choice::new(&records, compressed, &layout, options)?;
        let mut left = count;
        let records = if compressed && count > 0 {
            let compression = Compression::new(&mut file, size, start, count, &records, layout)?;
            let nodes = match (choice, compression.table()) {
                (Some(choice), Some(table)) => choice.nodes(&mut file, size, compression.start, table, count)?,
                (Some(_), None) => return Err(stale("there is no chunk table".to_owned())),
                (None, _) => None,
            };
            match &nodes {
                Some(nodes) => left = nodes.iter().map(|node| node.points).sum(),
                None => file = widened(file),
            }
            Records::Compressed(Box::new(Laz::new(
                file,
                size,
                compression,
                nodes,
                options.decoding_threads(),
            )?))
        } else {
            let end = count
                .checked_mul(layout.length as u64)
                .and_then(|length| length.checked_add(start));
            if end.is_none_or(|end| end > size) {
                return Err(Problem::cut_short(format!(
                    "{count} points of {} bytes from byte {start} on do not fit into {size} bytes",
                    layout.length
                )));
            }
            file = widened(file);
            file.seek(SeekFrom::Start(start)).map_err(unreadable)?;
            Records::Plain(file)
        };
        Ok(Self {
            layout,
            records,
            start,
            count,
            read: 0,
            left,
            keep: Keep::new(options),
            buffer: Vec::new(),
            crs,
            extent: Rect::new(header.min_x, header.min_y, header.max_x, header.max_y),
            census,
        })
    }

    /// Begins the next chunk if no point of the last one is left. Points that are passed over count
    /// as filtered. Returns the number of points that can be read now, 0 at the end.
    fn advance(&mut self, counts: &mut InputCounts) -> Result<u64, Problem> {
        let rest = self.count - self.read;
        let Records::Compressed(laz) = &mut self.records else {
            return Ok(rest);
        };
        if laz.left() == 0 && rest > 0 {
            let skipped = laz.next_chunk()?.unwrap_or(rest);
            counts.records += skipped;
            counts.filtered += skipped;
            self.read += skipped;
        }
        Ok(laz.left().min(self.count - self.read))
    }

    /// Returns a rectangle that must contain the points that were just read.
    fn bounds(&self) -> Option<Rect> {
        match &self.records {
            Records::Plain(_) => None,
            Records::Compressed(laz) => laz.bounds(),
        }
    }
}

/// Returns the file with a large buffer, for reading all of it. Its position is not kept.
fn widened(file: FileReader) -> FileReader {
    BufReader::with_capacity(BUFFER, file.into_inner())
}

impl Reader<PointBatch> for Las {
    fn has_z(&self) -> bool {
        true
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn expected(&self) -> Option<u64> {
        Some(self.left)
    }

    fn expected_extent(&self) -> Option<Rect> {
        Some(self.extent)
    }

    fn random_access(&self) -> Option<RandomAccess> {
        let (layout, keep) = (self.layout, self.keep);
        let plain = matches!(self.records, Records::Plain(_));
        plain.then(|| RandomAccess {
            start: self.start,
            count: self.count,
            length: layout.length,
            decode: Box::new(move |record| {
                let kept = !keep.drops_withheld(record, &layout) && keep.keeps(record, &layout);
                let [x, y, z] = [0, 1, 2].map(|axis| layout.coordinate(record, axis));
                (kept && z.is_finite()).then_some(Point::new(x, y))
            }),
        })
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        let layout = self.layout;
        while !sink.is_full() {
            let can_read = self
                .advance(&mut sink.totals.counts)
                .map_err(|problem| problem.at(sink.path, Location::Point(self.read)))?;
            let n = can_read.min(sink.room() as u64).min((CHUNK / layout.length) as u64);
            if n == 0 {
                return Ok(false);
            }
            self.buffer.resize(n as usize * layout.length, 0);
            let problem = match &mut self.records {
                Records::Plain(file) => file.read_exact(&mut self.buffer).map_err(unreadable),
                Records::Compressed(laz) => laz.read(&mut self.buffer),
            };
            problem.map_err(|problem| problem.at(sink.path, Location::Point(self.read)))?;
            if let Some(census) = &mut self.census {
                census.add(&self.buffer, &layout);
            }
            self.left = self.left.saturating_sub(n);
            let bounds = self.bounds();
            for record in self.buffer.chunks_exact(layout.length) {
                let point = self.read;
                self.read += 1;
                if self.keep.drops_withheld(record, &layout) {
                    sink.totals.counts.records += 1;
                    sink.totals.counts.withheld += 1;
                } else if !self.keep.keeps(record, &layout) {
                    sink.totals.counts.records += 1;
                    sink.totals.counts.filtered += 1;
                } else {
                    let [x, y, z] = [0, 1, 2].map(|axis| layout.coordinate(record, axis));
                    if bounds.is_some_and(|bounds| !bounds.contains(Point::new(x, y))) {
                        return Err(out_of_node().at(sink.path, Location::Point(point)));
                    }
                    sink.point(x, y, Some(z), || Location::Point(point))?;
                }
            }
        }
        Ok(true)
    }

    fn about(&self) -> About {
        self.census.as_ref().map(|census| census.about()).unwrap_or_default()
    }
}

fn out_of_node() -> Problem {
    stale("the point is not within the cube of its node of the octree".to_owned())
}

fn unreadable(error: io::Error) -> Problem {
    Problem::cut_short("the points cannot be read").caused_by(error)
}
