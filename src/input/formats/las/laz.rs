//! Decompression of LAZ, with checks of everything that the crate `laz` trusts.
//!
//! In: a file at its point data, the LASzip record of its header, and the nodes to read if it is a
//! COPC file. Out: point records as in LAS, chunk by chunk.
//! Format: LASzip 2 and 3 (chunks of points; from point format 6 on, the fields of a chunk are in
//! layers).
//!
//! ```text
//!   point data:  [i64: offset of the table] chunk 0 | chunk 1 | ... | table
//!   layered chunk:  first point, raw | u32: points | u32 per layer: its bytes | layers
//!   table:  u32 version | u32: chunks | compressed entries (points), bytes
//! ```
//!
//! This uses the decompressors of records, not the crate's `LasZipDecompressor`: that one cannot
//! begin at a chunk if chunks differ in size, and reads the table a second time.
//!
//! `laz` 0.13 handles hostile numbers as follows. This module checks them first:
//!
//! - It allocates 16 bytes for each chunk that the table claims. Here the number of chunks is
//!   limited to the file's size divided by [`LARGEST_TABLE`].
//! - It allocates the bytes that each layer claims. Here the sum is compared with the rest of the
//!   file.
//! - It allocates about 10 KiB per extra byte. The limit on the record length bounds this.
//! - It accepts tables of any numbers of points. Here the table must have as many points as the
//!   header, and no chunk without points.
//!
//! Its arithmetic decoder can still divide by zero or index out of range on damaged data. Only
//! decoding itself could detect this, so such a panic is caught and becomes an error (where panics
//! unwind; `caught` tells the program's panic hook not to report it).

use crate::geometry::Rect;
use crate::input::caught::catch;
use crate::input::formats::las::copc::Node;
use crate::input::formats::las::layout::Layout;
use crate::input::formats::las::problem::{CUT_SHORT, FileReader, Problem, trimmed};
use ::las::raw::Vlr;
use laz::laszip::{ChunkTable, ChunkTableEntry, LazItem};
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItemType, LazVlr};
use std::io;
use std::io::{Read, Seek, SeekFrom};

/// The least number of bytes of the file per chunk: a chunk stores its first point uncompressed,
/// and the smallest point has 20 bytes.
const LARGEST_TABLE: u64 = 20;

/// How the points of a file are compressed.
pub struct Compression {
    items: Vec<LazItem>,
    /// The number of layers of a chunk; `None` if chunks have no layers.
    layers: Option<usize>,
    /// The chunks; `None` if they have no table.
    table: Option<ChunkTable>,
    /// The number of points of each chunk, where there is no table.
    chunk_points: u64,
    /// The offset of the first chunk, in bytes.
    pub start: u64,
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
        let items = vlr.items().clone();
        if is_pointwise(&record.data) {
            // There is one chunk, and neither a table nor its offset. The size of chunks in the
            // record is arbitrary.
            return Ok(Self {
                items,
                layers,
                table: None,
                chunk_points: u64::from(u32::MAX),
                start,
            });
        }
        let table = read_table(file, size, start, &vlr)?;
        check_table(&vlr, table.as_ref(), count)?;
        Ok(Self {
            items,
            layers,
            table,
            chunk_points: u64::from(vlr.chunk_size()),
            start: start + ChunkTable::OFFSET_SIZE as u64,
        })
    }

    /// Returns the table of the chunks, if there is one.
    pub fn table(&self) -> Option<&[ChunkTableEntry]> {
        self.table.as_ref().map(AsRef::as_ref)
    }
}

/// The points of the chunks that are read.
pub struct Laz {
    decompressor: Box<dyn RecordDecompressor<FileReader> + Send + Sync>,
    items: Vec<LazItem>,
    size: u64,
    length: usize,
    layers: Option<usize>,
    chunks: Chunks,
    /// The number of points left in the chunk.
    left: u64,
    /// Contains the points of the chunk.
    bounds: Option<Rect>,
    /// Whether the decoder panicked or failed, so that its state must not be used.
    broken: bool,
}

/// The remaining chunks.
enum Chunks {
    /// All have this number of points, and one follows another.
    Fixed(u64),
    /// As in the table, from this index on.
    Table(ChunkTable, usize),
    /// Those of these nodes.
    Nodes(std::vec::IntoIter<Node>),
}

impl Laz {
    /// Starts the decompression of all chunks, or of those of some nodes.
    pub fn new(
        mut file: FileReader,
        size: u64,
        compression: Compression,
        nodes: Option<Vec<Node>>,
        layout: Layout,
    ) -> Result<Self, Problem> {
        file.seek(SeekFrom::Start(compression.start)).map_err(not_found)?;
        let chunks = match (nodes, compression.table) {
            (Some(nodes), _) => Chunks::Nodes(nodes.into_iter()),
            (None, Some(table)) => Chunks::Table(table, 0),
            (None, None) => Chunks::Fixed(compression.chunk_points),
        };
        Ok(Self {
            decompressor: match compression.layers {
                Some(_) => Box::new(LayeredPointRecordDecompressor::new(file)),
                None => Box::new(SequentialPointRecordDecompressor::new(file)),
            },
            items: compression.items,
            size,
            length: layout.length,
            layers: compression.layers,
            chunks,
            left: 0,
            bounds: None,
            broken: false,
        })
    }

    /// Returns the number of points left in the chunk.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Returns a rectangle that the octree of the file says contains the points of the chunk.
    pub fn bounds(&self) -> Option<Rect> {
        self.bounds
    }

    /// Fills the buffer with whole records of the chunk, at most as many as are left.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<(), Problem> {
        self.left -= (buffer.len() / self.length) as u64;
        self.decompress(|decompressor| decompressor.decompress_many(buffer))
    }

    /// Begins the next chunk to read, once no point of the last one is left. Returns the number of
    /// points between them; `None` if there is no chunk to read.
    pub fn next_chunk(&mut self) -> Result<Option<u64>, Problem> {
        let mut skipped = 0;
        self.left = match &mut self.chunks {
            Chunks::Fixed(points) => *points,
            Chunks::Table(table, next) => {
                let chunk = table.as_ref().get(*next);
                *next += 1;
                chunk
                    .ok_or_else(|| Problem::damaged("the chunk table has fewer points than the header"))?
                    .point_count
            }
            Chunks::Nodes(nodes) => {
                let Some(node) = nodes.next() else {
                    return Ok(None);
                };
                let file = self.decompressor.get_mut();
                file.seek(SeekFrom::Start(node.offset)).map_err(not_found)?;
                self.bounds = Some(node.bounds);
                skipped = node.skipped;
                node.points
            }
        };
        if let Some(layers) = self.layers {
            self.check_layers(layers)?;
        }
        let items = self.items.clone();
        self.decompress(|decompressor| {
            decompressor.reset();
            decompressor.set_fields_from(&items).map_err(io::Error::other)?;
            decompressor.set_selection(selection());
            Ok(())
        })?;
        Ok(Some(skipped))
    }

    /// Compares the sizes of the next chunk's layers with the rest of the file.
    fn check_layers(&mut self, layers: usize) -> Result<(), Problem> {
        let file = self.decompressor.get_mut();
        let mut head = vec![0; self.length + 4 + 4 * layers];
        let mut check = || {
            file.read_exact(&mut head)?;
            let position = file.stream_position()?;
            file.seek_relative(-(head.len() as i64))?;
            Ok(position)
        };
        let position: u64 = check().map_err(|error: std::io::Error| {
            Problem::cut_short("a chunk of points begins beyond the end of the file").caused_by(error)
        })?;
        let (sizes, _) = head[self.length + 4..].as_chunks::<4>();
        let sum: u64 = sizes.iter().map(|&size| u64::from(u32::from_le_bytes(size))).sum();
        let rest = self.size.saturating_sub(position);
        if sum > rest {
            return Err(Problem::cut_short(format!(
                "a chunk of {sum} bytes, but {rest} bytes are left in the file"
            )));
        }
        Ok(())
    }

    /// Lets the decompressor work. See the head of this file: the state that a panic leaves behind
    /// is never used again.
    fn decompress(
        &mut self,
        work: impl FnOnce(&mut dyn RecordDecompressor<FileReader>) -> io::Result<()>,
    ) -> Result<(), Problem> {
        if self.broken {
            return Err(undecodable());
        }
        let decompressor = &mut *self.decompressor;
        let result = catch(|| work(decompressor));
        self.broken = !matches!(result, Some(Ok(())));
        match result {
            Some(Ok(())) => Ok(()),
            Some(Err(error)) => Err(Problem {
                hint: CUT_SHORT,
                ..undecodable()
            }
            .caused_by(error)),
            None => Err(undecodable()),
        }
    }
}

/// Returns the fields to decompress. Those that are not read need not be; only layers can be left
/// out.
fn selection() -> DecompressionSelection {
    DecompressionSelection::xy_returns_channel()
        .decompress_z()
        .decompress_classification()
        .decompress_flags()
}

fn not_found(error: io::Error) -> Problem {
    Problem::cut_short("the points cannot be found").caused_by(error)
}

/// Returns the error of points that the decoder cannot decode.
fn undecodable() -> Problem {
    Problem {
        hint: "the file is damaged, or compressed in a way that is not supported",
        ..Problem::damaged("the points cannot be decompressed")
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

/// Reads the table of chunks; `None` if there is none, because the writer was interrupted.
fn read_table(file: &mut FileReader, size: u64, start: u64, vlr: &LazVlr) -> Result<Option<ChunkTable>, Problem> {
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
        Some(Ok(table)) => Ok(Some(table)),
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
