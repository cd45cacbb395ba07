//! Raw little-endian f64: pairs x y, or triples x y z.
//!
//! In: a stream of bytes and the numbers per point. Out: points. The fastest format there is, and exact.

use super::bytes::ByteInput;
use super::reader::Reader;
use super::sink::Sink;
use super::{InputError, InputOptions, Place};
use std::io::Read;

pub(super) struct Raw {
    input: ByteInput,
    /// Bytes per point: 16 or 24.
    stride: usize,
    /// The points read last.
    data: Vec<u8>,
    /// The bytes read before them.
    offset: u64,
}

impl Raw {
    /// Fails at once on a length that is no multiple of a point's, if the length is known: not after an hour's work.
    pub fn new(input: ByteInput, options: &InputOptions) -> Result<Self, InputError> {
        let stride = 8 * usize::from(options.dims);
        let size = input.size;
        let raw = Self {
            input,
            stride,
            data: Vec::new(),
            offset: 0,
        };
        match size {
            Some(size) if size % stride as u64 != 0 && !options.skip_invalid => {
                Err(raw.cut_short(size - size % stride as u64, size % stride as u64))
            }
            _ => Ok(raw),
        }
    }

    fn cut_short(&self, offset: u64, rest: u64) -> InputError {
        InputError::Malformed {
            path: self.input.path.to_path_buf(),
            place: Place::Byte(offset),
            problem: format!(
                "{rest} bytes are left over behind the last whole point of {} bytes",
                self.stride
            ),
            hint: "the file is cut short, or has another number of dimensions (--dims); --skip-invalid drops the rest",
            source: None,
        }
    }
}

impl Reader for Raw {
    fn has_z(&self) -> bool {
        self.stride == 24
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            self.offset += self.data.len() as u64;
            self.data.clear();
            let wanted = sink.room() * self.stride;
            let read = self.input.read.by_ref().take(wanted as u64).read_to_end(&mut self.data);
            read.map_err(|source| InputError::Read {
                path: self.input.path.to_path_buf(),
                offset: self.offset + self.data.len() as u64,
                source,
            })?;
            let mut offset = self.offset;
            let records = self.data.chunks_exact(self.stride);
            let rest = records.remainder();
            for record in records {
                let (numbers, _) = record.as_chunks::<8>();
                let z = numbers.get(2).map(|&z| f64::from_le_bytes(z));
                let (x, y) = (f64::from_le_bytes(numbers[0]), f64::from_le_bytes(numbers[1]));
                sink.point(x, y, z, || Place::Byte(offset))?;
                offset += self.stride as u64;
            }
            if !rest.is_empty() {
                if !sink.skip_invalid {
                    return Err(self.cut_short(offset, rest.len() as u64));
                }
                sink.invalid(|| Place::Byte(offset), String::new)?;
            }
            if self.data.len() < wanted {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
