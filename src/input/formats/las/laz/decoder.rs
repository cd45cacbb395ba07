//! Decompression of the points of one chunk after another.
//!
//! In: bytes from the beginning of a chunk on. Out: records. This uses the decompressors of records,
//! not the crate's `LasZipDecompressor`: that one cannot begin at a chunk if chunks differ in size, and
//! reads the table a second time.

use crate::input::caught::catch;
use crate::input::formats::las::laz::compression::Scheme;
use crate::input::formats::las::problem::{CUT_SHORT, Problem};
use laz::DecompressionSelection;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use std::io;
use std::io::{Read, Seek};

/// A decoder of chunks.
pub struct ChunkDecoder<R> {
    decompressor: Box<dyn RecordDecompressor<R> + Send + Sync>,
    scheme: Scheme,
    /// The number of bytes of the source, and what messages call it.
    size: u64,
    whole: &'static str,
    /// Whether the decoder panicked or failed, so that its state must not be used.
    is_broken: bool,
}

impl<R: Read + Seek + Send + Sync + 'static> ChunkDecoder<R> {
    /// Creates the decoder of a source of `size` bytes, which messages call `whole`.
    pub fn new(source: R, size: u64, whole: &'static str, scheme: &Scheme) -> Self {
        Self {
            decompressor: match scheme.layers {
                Some(_) => Box::new(LayeredPointRecordDecompressor::new(source)),
                None => Box::new(SequentialPointRecordDecompressor::new(source)),
            },
            scheme: scheme.clone(),
            size,
            whole,
            is_broken: false,
        }
    }

    /// Returns the source, to go to the next chunk.
    pub fn source(&mut self) -> &mut R {
        self.decompressor.get_mut()
    }

    /// Begins the chunk at the position of the source.
    pub fn begin(&mut self) -> Result<(), Problem> {
        if let Some(layers) = self.scheme.layers {
            self.check_layers(layers)?;
        }
        let items = self.scheme.items.clone();
        self.decompress(|decompressor| {
            decompressor.reset();
            decompressor.set_fields_from(&items).map_err(io::Error::other)?;
            decompressor.set_selection(selection());
            Ok(())
        })
    }

    /// Fills the buffer with whole records of the chunk, at most as many as are left.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<(), Problem> {
        self.decompress(|decompressor| decompressor.decompress_many(buffer))
    }

    /// Compares the sizes of the next chunk's layers with the rest of the source.
    fn check_layers(&mut self, layers: usize) -> Result<(), Problem> {
        let (source, whole) = (self.decompressor.get_mut(), self.whole);
        let mut head = vec![0; self.scheme.length + 4 + 4 * layers];
        let mut check = || {
            source.read_exact(&mut head)?;
            let position = source.stream_position()?;
            source.seek_relative(-(head.len() as i64))?;
            Ok(position)
        };
        let position: u64 = check().map_err(|error: std::io::Error| {
            Problem::cut_short(format!("a chunk of points begins beyond the end of {whole}")).caused_by(error)
        })?;
        let (sizes, _) = head[self.scheme.length + 4..].as_chunks::<4>();
        let sum: u64 = sizes.iter().map(|&size| u64::from(u32::from_le_bytes(size))).sum();
        let rest = self.size.saturating_sub(position);
        if sum > rest {
            return Err(Problem::cut_short(format!(
                "a chunk of {sum} bytes, but {rest} bytes are left in {whole}"
            )));
        }
        Ok(())
    }

    /// Lets the decompressor work. See the head of this file: the state that a panic leaves behind
    /// is never used again.
    fn decompress(
        &mut self,
        work: impl FnOnce(&mut dyn RecordDecompressor<R>) -> io::Result<()>,
    ) -> Result<(), Problem> {
        if self.is_broken {
            return Err(undecodable());
        }
        let decompressor = &mut *self.decompressor;
        let result = catch(|| work(decompressor));
        self.is_broken = !matches!(result, Some(Ok(())));
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

/// Returns the error of points that the decoder cannot decode.
pub fn undecodable() -> Problem {
    Problem {
        hint: "the file is damaged, or compressed in a way that is not supported",
        ..Problem::damaged("the points cannot be decompressed")
    }
}
