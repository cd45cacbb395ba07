//! How the points of a LAZ file are compressed: the record of its header and the table of its chunks.
//!
//! In: a file and the LASzip record of its header. Out: the items of a point and the chunks, checked.

use crate::input::caught::catch;
use crate::input::formats::las::layout::Layout;
use crate::input::formats::las::problem::{FileReader, Problem, trimmed};
use ::las::raw::Vlr;
use laz::laszip::{ChunkTable, ChunkTableEntry, LazItem};
use laz::{LazItemType, LazVlr};
use std::io;
use std::io::{Read, Seek, SeekFrom};

/// The least number of bytes of the file per chunk: a chunk stores its first point uncompressed,
/// and the smallest point has 20 bytes.
const LARGEST_TABLE: u64 = 20;

/// How a point is compressed.
#[derive(Clone)]
pub struct Scheme {
    pub items: Vec<LazItem>,
    /// The number of layers of a chunk; `None` if chunks have no layers.
    pub layers: Option<usize>,
    /// The length of a point's record, in bytes.
    pub length: usize,
}

/// How the points of a file are compressed.
pub struct Compression {
    pub scheme: Scheme,
    /// The number of points.
    pub count: u64,
    /// The chunks; `None` if they have no table.
    pub table: Option<ChunkTable>,
    /// The number of points of each chunk, where there is no table.
    pub chunk_points: u64,
    /// The offset of the first chunk, in bytes, and of the end of the last one, where there is a table.
    pub start: u64,
    pub end: u64,
}

impl Compression {
    pub fn new(
        file: &mut FileReader,
        size: u64,
        start: u64,
        count: u64,
        records: &[Vlr],
        layout: Layout,
    ) -> Result<Self, Problem> {
        let is_it = |r: &&Vlr| r.record_id == LazVlr::RECORD_ID && trimmed(&r.user_id) == LazVlr::USER_ID.as_bytes();
        let Some(record) = records.iter().find(is_it) else {
            return Err(Problem::damaged(
                "compressed points, but no record that describes the compression",
            ));
        };
        let vlr = LazVlr::from_buffer(&record.data).map_err(|error| {
            Problem::damaged("the record that describes the compression is invalid").caused_by(error)
        })?;
        let layers = check_items(&vlr, &record.data, layout)?;
        let scheme = Scheme {
            items: vlr.items().clone(),
            layers,
            length: layout.length,
        };
        if is_pointwise(&record.data) {
            // There is one chunk, and neither a table nor its offset. The size of chunks in the
            // record is arbitrary.
            return Ok(Self {
                scheme,
                count,
                table: None,
                chunk_points: u64::from(u32::MAX),
                start,
                end: size,
            });
        }
        let (table, end) = read_table(file, size, start, &vlr)?.unzip();
        check_table(&vlr, table.as_ref(), count)?;
        Ok(Self {
            scheme,
            count,
            table,
            chunk_points: u64::from(vlr.chunk_size()),
            start: start + ChunkTable::OFFSET_SIZE as u64,
            end: end.unwrap_or(size),
        })
    }

    /// Returns the table of the chunks, if there is one.
    pub fn table(&self) -> Option<&[ChunkTableEntry]> {
        self.table.as_ref().map(AsRef::as_ref)
    }
}

/// Returns whether the LASzip record names the compressor without chunks.
fn is_pointwise(record: &[u8]) -> bool {
    record.starts_with(&[1, 0])
}

/// Checks that the items of a record match the point format. Returns the number of their layers, if
/// the format has layers.
fn check_items(vlr: &LazVlr, record: &[u8], layout: Layout) -> Result<Option<usize>, Problem> {
    let items = vlr.items();
    let first = match layout.extended {
        true => LazItemType::Point14,
        false => LazItemType::Point10,
    };
    let mut length = 0;
    let mut layers = 0;
    let mut sound = items.first().is_some_and(|item| item.item_type() == first);
    for (n, item) in items.iter().enumerate() {
        let (size, item_layers) = match item.item_type() {
            LazItemType::Byte(size) => (size, 0),
            LazItemType::Point10 => (20, 0),
            LazItemType::GpsTime => (8, 0),
            LazItemType::RGB12 => (6, 0),
            LazItemType::WavePacket13 => (29, 0),
            LazItemType::Point14 => (30, 9),
            LazItemType::RGB14 => (6, 1),
            LazItemType::RGBNIR14 => (8, 2),
            LazItemType::WavePacket14 => (29, 1),
            LazItemType::Byte14(size) => (size, usize::from(size)),
        };
        sound &= item.size() == size && (n == 0 || item.item_type() != first);
        sound &= matches!((layout.extended, item.version()), (false, 1 | 2) | (true, 3 | 4));
        length += usize::from(size);
        layers += item_layers;
    }
    let compressor = record.first().copied().unwrap_or_default();
    if record.get(1) != Some(&0) || !matches!((layout.extended, compressor), (false, 1 | 2) | (true, 3)) {
        let format = if layout.extended { "6 to 10" } else { "0 to 5" };
        return Err(Problem {
            hint: "write the file again with a current version of LASzip",
            ..Problem::damaged(format!(
                "not supported: compressor {compressor} with point formats {format}"
            ))
        });
    }
    if sound && length == layout.length {
        Ok(layout.extended.then_some(layers))
    } else {
        Err(Problem::damaged("the compression does not match the point format"))
    }
}

/// Reads the table of chunks and its offset; `None` if there is none, because the writer was
/// interrupted.
fn read_table(
    file: &mut FileReader,
    size: u64,
    start: u64,
    vlr: &LazVlr,
) -> Result<Option<(ChunkTable, u64)>, Problem> {
    let number = |file: &mut FileReader, at: u64| {
        // Nothing is read behind the end: that would look like a file that changed its length.
        if at > size.saturating_sub(8) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut bytes = [0; 8];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    };
    let unreadable = |error: std::io::Error| Problem::cut_short("the chunk table cannot be read").caused_by(error);
    // The offset of the table is at the beginning of the points or, if it could not be written
    // there, at the end of the file.
    let is_offset = |offset: u64| offset > start && i64::try_from(offset).is_ok();
    let mut offset = number(file, start).map_err(unreadable)?;
    if !is_offset(offset) {
        offset = number(file, size.saturating_sub(8)).map_err(unreadable)?;
        if !is_offset(offset) {
            return Ok(None);
        }
    }
    let chunks = number(file, offset).map_err(unreadable)? >> 32;
    if chunks > size / LARGEST_TABLE {
        return Err(Problem::damaged(format!(
            "a table of {chunks} chunks in a file of {size} bytes"
        )));
    }
    file.seek(SeekFrom::Start(start)).map_err(unreadable)?;
    match catch(|| ChunkTable::read_from(&mut *file, vlr)) {
        Some(Ok(table)) => Ok(Some((table, offset))),
        Some(Err(error)) => Err(Problem::cut_short("the chunk table cannot be read").caused_by(error)),
        None => Err(Problem::damaged("the chunk table cannot be read")),
    }
}

/// Checks that the table has at least as many points as the header, and is there if it must be.
fn check_table(vlr: &LazVlr, table: Option<&ChunkTable>, count: u64) -> Result<(), Problem> {
    let Some(table) = table else {
        return match vlr.uses_variable_size_chunks() {
            true => Err(Problem::damaged("chunks of different sizes, but no table of them")),
            false => Ok(()),
        };
    };
    let points = || table.as_ref().iter().map(|chunk| chunk.point_count);
    if points().any(|n| n == 0 || n > u64::from(u32::MAX)) {
        return Err(Problem::damaged(
            "the chunk table has a chunk of no points, or of too many",
        ));
    }
    let sum = points().fold(0, u64::saturating_add);
    if sum < count {
        return Err(Problem::cut_short(format!(
            "the chunk table has {sum} of {count} points"
        )));
    }
    Ok(())
}
