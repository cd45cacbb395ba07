//! Raw little-endian f64: pairs x y, or triples x y z.
//!
//! In: a stream of bytes and the numbers per point. Out: points. The fastest format there is, and exact.

use super::bytes::{Buffered, ByteInput};
use super::sink::Sink;
use super::source::Reader;
use super::{InputError, InputOptions, Place};

pub(super) struct Raw {
    bytes: Buffered,
    /// Bytes per point: 16 or 24.
    stride: usize,
}

impl Raw {
    /// Fails at once on a length that is no multiple of a point's, if the length is known: not after an hour's work.
    pub fn new(input: ByteInput, options: &InputOptions) -> Result<Self, InputError> {
        let stride = 8 * usize::from(options.dims);
        let size = input.size;
        let raw = Self {
            bytes: Buffered::new(input),
            stride,
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
            path: self.bytes.path(),
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
            let offset = self.bytes.offset();
            let data = self.bytes.data();
            if data.len() < self.stride {
                if self.bytes.more()? {
                    continue;
                }
                let rest = self.bytes.data().len();
                if rest == 0 {
                    return Ok(false);
                }
                if !sink.skip_invalid {
                    return Err(self.cut_short(offset, rest as u64));
                }
                self.bytes.consume(rest);
                sink.invalid(|| Place::Byte(offset), String::new)?;
                return Ok(false);
            }
            let mut taken = 0;
            for record in data.chunks_exact(self.stride) {
                if sink.is_full() {
                    break;
                }
                let (numbers, _) = record.as_chunks::<8>();
                let z = numbers.get(2).map(|&z| f64::from_le_bytes(z));
                let (x, y) = (f64::from_le_bytes(numbers[0]), f64::from_le_bytes(numbers[1]));
                sink.point(x, y, z, || Place::Byte(offset + taken as u64))?;
                taken += self.stride;
            }
            self.bytes.consume(taken);
        }
        Ok(true)
    }
}
