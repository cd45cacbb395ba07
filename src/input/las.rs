//! LAS, LAZ and COPC: lidar.
//!
//! In: a file. Out: its points with z, scaled as the header says, without the withheld ones and those that the choice of
//! classes and returns leaves out. Source: ASPRS, LAS Specification 1.4 R15.
//!
//! The crate `las` parses header and records, `laz` decompresses. Not `las::Reader`: it cannot be sent to another thread,
//! and it believes lengths (an extended record of 2^60 bytes, a layer of 4 GiB). So every number of the header is compared
//! with the file's size here, before anything is allocated or decoded from it. A file that is cut short fails at
//! open. Whether a file is LAZ its header tells, and not its suffix.

use super::bytes::BUFFER;
use super::laz::Laz;
use super::reader::Reader;
use super::sample::RandomAccess;
use super::sink::Sink;
use super::watch::Watched;
use super::{InputError, InputOptions, Place, Returns};
use crate::geometry::Point;
use ::las::raw::Vlr;
use ::las::raw::header::Header;
use std::error::Error;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// A file with lidar points.
pub(super) type FileReader = BufReader<Watched<Arc<File>>>;

/// The bytes of points that are read at once.
const CHUNK: usize = 1 << 20;

/// The longest point record. Format 10 has 67 bytes; the rest are extra bytes, for each of which LAZ keeps
/// some 10 KiB of models.
const LONGEST_RECORD: usize = 4096;

/// The longest coordinate reference system that is read from an extended record.
const LONGEST_WKT: u64 = 1 << 20;

const DAMAGED: &str = "the file is damaged";
pub(super) const CUT_SHORT: &str = "the file is cut short, or its header is damaged";

/// What is wrong with the file, before it is known which file it is.
pub(super) struct Problem {
    pub problem: String,
    pub hint: &'static str,
    pub source: Option<Box<dyn Error + Send + Sync>>,
}

impl Problem {
    pub fn damaged(problem: impl Into<String>) -> Self {
        Self {
            problem: problem.into(),
            hint: DAMAGED,
            source: None,
        }
    }

    pub fn cut_short(problem: impl Into<String>) -> Self {
        Self {
            hint: CUT_SHORT,
            ..Self::damaged(problem)
        }
    }

    pub fn caused_by(mut self, source: impl Error + Send + Sync + 'static) -> Self {
        self.source = Some(Box::new(source));
        self
    }

    fn at(self, path: &Path, place: Place) -> InputError {
        InputError::Malformed {
            path: path.to_owned(),
            place,
            problem: self.problem,
            hint: self.hint,
            source: self.source,
        }
    }
}

/// The error for a LAS file that cannot be read as a file.
pub(super) fn no_stream(path: &Path) -> InputError {
    Problem {
        hint: "give the name of a file (not a pipe, and not gzip)",
        ..Problem::damaged("LAS is not read from a stream")
    }
    .at(path, Place::File)
}

pub(super) fn open(
    path: &Path,
    file: Watched<Arc<File>>,
    size: u64,
    options: &InputOptions,
) -> Result<Box<dyn Reader>, InputError> {
    match Las::new(BufReader::with_capacity(BUFFER, file), size, options) {
        Ok(las) => Ok(Box::new(las)),
        Err(problem) => Err(problem.at(path, Place::File)),
    }
}

struct Las {
    layout: Layout,
    records: Records,
    /// The first byte of the points.
    start: u64,
    /// The points in the file, and of these the ones read.
    count: u64,
    read: u64,
    keep: Keep,
    /// Whole records.
    buffer: Vec<u8>,
    crs: Option<String>,
}

/// Where the records come from.
enum Records {
    Plain(FileReader),
    Compressed(Box<Laz>),
}

/// How a record is laid out.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    /// The bytes of a record.
    pub length: usize,
    /// Whether the format is 6 or higher.
    pub extended: bool,
    scale: [f64; 3],
    offset: [f64; 3],
}

/// Which points to keep.
#[derive(Clone, Copy)]
struct Keep {
    classes: [bool; 256],
    returns: Returns,
}

impl Las {
    fn new(mut file: FileReader, size: u64, options: &InputOptions) -> Result<Self, Problem> {
        let mut magic = [0; 4];
        match file.read_exact(&mut magic) {
            Ok(()) if magic == *b"LASF" => {}
            _ => {
                return Err(Problem {
                    hint: "this is no LAS or LAZ file",
                    ..Problem::damaged("the file does not begin with `LASF`")
                });
            }
        }
        let seek_start = file.seek(SeekFrom::Start(0)).map(drop);
        let header = seek_start
            .map_err(::las::Error::from)
            .and_then(|()| Header::read_from(&mut file))
            .map_err(|error| Problem::cut_short("the header cannot be read").caused_by(error))?;
        let (layout, compressed) = Layout::new(&header)?;
        let count = count(&header);
        let start = u64::from(header.offset_to_point_data);
        let records = records(&mut file, &header, start.min(size))?;
        let crs = match crs(&records) {
            Some(crs) => Some(crs),
            None => extended_wkt(&mut file, &header, size),
        };
        file.seek(SeekFrom::Start(start))
            .map_err(|error| Problem::cut_short("the points cannot be found").caused_by(error))?;
        let records = if compressed && count > 0 {
            Records::Compressed(Box::new(Laz::new(file, size, start, count, &records, layout)?))
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
            Records::Plain(file)
        };
        let classes = std::array::from_fn(|class| {
            options.classes.is_empty() || options.classes.iter().any(|&c| usize::from(c) == class)
        });
        Ok(Self {
            layout,
            records,
            start,
            count,
            read: 0,
            keep: Keep {
                classes,
                returns: options.returns,
            },
            buffer: Vec::new(),
            crs,
        })
    }
}

impl Layout {
    /// The layout, and whether the points are compressed.
    fn new(header: &Header) -> Result<(Self, bool), Problem> {
        let version = header.version;
        if version.major != 1 || version.minor > 4 {
            return Err(Problem {
                hint: "versions 1.0 to 1.4 are read",
                ..Problem::damaged(format!("this is LAS version {version}"))
            });
        }
        let least = match version.minor {
            0..=2 => 227,
            3 => 235,
            _ => 375,
        };
        if header.header_size < least {
            let size = header.header_size;
            return Err(Problem::damaged(format!(
                "a header of {size} bytes, where {least} are the least"
            )));
        }
        // LAZ sets the highest bit. As in the crate `las`, the next one has no meaning.
        let compressed = header.point_data_record_format & 0x80 != 0;
        let number = header.point_data_record_format & 0x3f;
        let format = match ::las::point::Format::new(number) {
            Ok(format) if number <= 10 => format,
            _ => {
                return Err(Problem::damaged(format!(
                    "point format {number}, where 10 is the highest"
                )));
            }
        };
        let length = usize::from(header.point_data_record_length);
        if length < usize::from(format.len()) || length > LONGEST_RECORD {
            return Err(Problem::damaged(format!(
                "point records of {length} bytes, where format {number} needs {}, and {LONGEST_RECORD} are the most",
                format.len()
            )));
        }
        let layout = Self {
            length,
            extended: number >= 6,
            scale: [header.x_scale_factor, header.y_scale_factor, header.z_scale_factor],
            offset: [header.x_offset, header.y_offset, header.z_offset],
        };
        if layout.scale.iter().chain(&layout.offset).any(|v| !v.is_finite()) {
            return Err(Problem::damaged(
                "the scale or the offset of the coordinates is not finite",
            ));
        }
        if let Some((_, name)) = layout
            .scale
            .iter()
            .zip(["x", "y", "z"])
            .find(|(scale, _)| **scale == 0.0)
        {
            return Err(Problem::damaged(format!(
                "the scale of {name} is 0, so that all points have the same {name}"
            )));
        }
        Ok((layout, compressed))
    }

    #[inline]
    fn coordinate(&self, record: &[u8], axis: usize) -> f64 {
        let bytes = [0, 1, 2, 3].map(|n| record[4 * axis + n]);
        self.scale[axis] * f64::from(i32::from_le_bytes(bytes)) + self.offset[axis]
    }

    fn is_withheld(&self, record: &[u8]) -> bool {
        record[15] & (if self.extended { 0x04 } else { 0x80 }) != 0
    }
}

impl Keep {
    fn keeps(&self, record: &[u8], extended: bool) -> bool {
        let (class, number, of) = if extended {
            (record[16], record[14] & 15, record[14] >> 4)
        } else {
            (record[15] & 0x1f, record[14] & 7, (record[14] >> 3) & 7)
        };
        let returns = match self.returns {
            Returns::First => number == 1,
            Returns::Last => number == of,
            Returns::All => true,
        };
        returns && self.classes[usize::from(class)]
    }
}

/// The number of points: the former field wins if it is not zero, as the specification wants.
fn count(header: &Header) -> u64 {
    match (header.number_of_point_records, &header.large_file) {
        (0, Some(large)) => large.number_of_point_records,
        (count, _) => u64::from(count),
    }
}

/// The variable length records. Each one has 64 KiB at most, and all of them end before the points.
fn records(file: &mut FileReader, header: &Header, end: u64) -> Result<Vec<Vlr>, Problem> {
    const SHORTEST: u64 = 54;
    let mut records = Vec::new();
    let mut position = u64::from(header.header_size);
    let number = header.number_of_variable_length_records;
    for n in 0..number {
        if position + SHORTEST > end {
            return Err(Problem::cut_short(format!(
                "variable length record {n} of {number} is not before the points (byte {end})"
            )));
        }
        let read = match file.seek(SeekFrom::Start(position)) {
            Ok(_) => Vlr::read_from(&mut *file, false),
            Err(error) => Err(error.into()),
        };
        let record = read.map_err(|error| {
            Problem::cut_short(format!("variable length record {n} of {number} cannot be read")).caused_by(error)
        })?;
        position += SHORTEST + record.data.len() as u64;
        // Only these are looked at later: a file may have many others.
        if matches!(trimmed(&record.user_id), b"LASF_Projection" | b"laszip encoded") {
            records.push(record);
        }
    }
    if position > end {
        return Err(Problem::cut_short(format!(
            "variable length records reach behind byte {end}"
        )));
    }
    Ok(records)
}

/// A fixed-size field up to its first zero.
pub(super) fn trimmed(field: &[u8]) -> &[u8] {
    field.split(|&b| b == 0).next().unwrap_or_default()
}

/// The coordinate reference system as WKT, or `EPSG:…` from GeoTIFF keys.
fn crs(records: &[Vlr]) -> Option<String> {
    let find = |id: u16| {
        let is_it = |r: &&Vlr| r.record_id == id && trimmed(&r.user_id) == b"LASF_Projection";
        records.iter().find(is_it).map(|r| &r.data[..])
    };
    if let Some(wkt) = find(2112).and_then(wkt) {
        return Some(wkt);
    }
    // GeoTIFF's directory: a header of four u16, then key, place, count, value for each key.
    let (numbers, _) = find(34735)?.as_chunks::<2>();
    let numbers: Vec<u16> = numbers.iter().map(|&n| u16::from_le_bytes(n)).collect();
    let (entries, _) = numbers.get(4..)?.as_chunks::<4>();
    let value = |key: u16| {
        let entry = entries.iter().find(|e| e[0] == key && e[1] == 0)?;
        // 32767 is "user-defined".
        (entry[3] > 0 && entry[3] < 32767).then(|| format!("EPSG:{}", entry[3]))
    };
    value(3072).or_else(|| value(2048))
}

fn wkt(data: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(trimmed(data)).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// The WKT in an extended record, if there is one and all is well: it is mere metadata.
fn extended_wkt(file: &mut FileReader, header: &Header, size: u64) -> Option<String> {
    let evlr = header.evlr?;
    let mut position = evlr.start_of_first_evlr;
    for _ in 0..evlr.number_of_evlrs {
        if position.checked_add(60)? > size {
            return None;
        }
        file.seek(SeekFrom::Start(position)).ok()?;
        let mut head = [0; 60];
        file.read_exact(&mut head).ok()?;
        let length = u64::from_le_bytes(head[20..28].try_into().ok()?);
        position = position.checked_add(60)?.checked_add(length)?;
        let id = u16::from_le_bytes([head[18], head[19]]);
        if trimmed(&head[2..18]) == b"LASF_Projection" && id == 2112 {
            let mut data = Vec::new();
            file.take(length.min(LONGEST_WKT)).read_to_end(&mut data).ok()?;
            return wkt(&data);
        }
    }
    None
}

impl Reader for Las {
    fn has_z(&self) -> bool {
        true
    }

    fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    fn expected_points(&self) -> Option<u64> {
        Some(self.count.saturating_sub(self.read))
    }

    fn random_access(&self) -> Option<RandomAccess> {
        let (layout, keep) = (self.layout, self.keep);
        let plain = matches!(self.records, Records::Plain(_));
        plain.then(|| RandomAccess {
            start: self.start,
            count: self.count,
            length: layout.length,
            decode: Box::new(move |record| {
                let kept = !layout.is_withheld(record) && keep.keeps(record, layout.extended);
                let [x, y, z] = [0, 1, 2].map(|axis| layout.coordinate(record, axis));
                (kept && z.is_finite()).then_some(Point::new(x, y))
            }),
        })
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        let layout = self.layout;
        while !sink.is_full() {
            let n = (sink.room() as u64)
                .min((CHUNK / layout.length) as u64)
                .min(self.count - self.read);
            if n == 0 {
                return Ok(false);
            }
            self.buffer.resize(n as usize * layout.length, 0);
            let problem = match &mut self.records {
                Records::Plain(file) => file.read_exact(&mut self.buffer).map_err(unreadable),
                Records::Compressed(laz) => laz.read(&mut self.buffer),
            };
            problem.map_err(|problem| problem.at(sink.path, Place::Point(self.read)))?;
            for record in self.buffer.chunks_exact(layout.length) {
                let point = self.read;
                self.read += 1;
                if layout.is_withheld(record) {
                    sink.counts.records += 1;
                    sink.counts.withheld += 1;
                } else if !self.keep.keeps(record, layout.extended) {
                    sink.counts.records += 1;
                    sink.counts.filtered += 1;
                } else {
                    let [x, y, z] = [0, 1, 2].map(|axis| layout.coordinate(record, axis));
                    sink.point(x, y, Some(z), || Place::Point(point))?;
                }
            }
        }
        Ok(true)
    }
}

fn unreadable(error: io::Error) -> Problem {
    Problem::cut_short("the points cannot be read").caused_by(error)
}
