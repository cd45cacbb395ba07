//! Raw pairs of record numbers: little-endian, 4 or 8 bytes each.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::raw::records::{Records, left_over};
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::{Reader, Sink};

const HINT: &str = "the file is cut short, or its numbers have another width";

/// A reader of raw pairs of record numbers.
pub struct Pairs {
    records: Records,
    /// The number of pairs read.
    pairs: u64,
}

impl Pairs {
    /// Creates a reader of pairs of numbers of `bytes` bytes each.
    pub fn new(input: ByteInput, bytes: usize) -> Self {
        Self {
            records: Records::new(input, 2 * bytes),
            pairs: 0,
        }
    }
}

impl Reader<SegmentBatch> for Pairs {
    fn fill(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> Result<bool, InputError> {
        let stride = self.records.stride;
        let chunk = self.records.read(sink.room())?;
        if !chunk.rest.is_empty() {
            let offset = chunk.offset + chunk.records.len() as u64;
            return Err(left_over(sink.path, offset, chunk.rest.len(), "pair", stride, HINT));
        }
        for pair in chunk.records.chunks_exact(stride) {
            let (from, to) = pair.split_at(stride / 2);
            sink.pair([number(from), number(to)], self.pairs);
            self.pairs += 1;
        }
        Ok(!chunk.is_last)
    }

    fn tally(&self) -> LineTally {
        LineTally {
            lines: self.pairs,
            polygons: 0,
        }
    }
}

fn number(bytes: &[u8]) -> u64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(wide)
}
