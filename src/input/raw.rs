//! Raw little-endian f64: pairs x y, or triples x y z.
//!
//! In: a stream of bytes and the numbers per point. Out: points. The fastest format there is, and exact.

use super::bytes::ByteInput;
use super::reader::Reader;
use super::sample::RandomAccess;
use super::sink::Sink;
use super::{InputError, InputOptions, Place};
use crate::geometry::Point;
use std::io::{ErrorKind, Read};

pub(super) struct Raw {
    input: ByteInput,
    /// Bytes per point: 16 or 24.
    stride: usize,
    /// Room for the points that are read at once, and kept for that alone.
    buffer: Vec<u8>,
    /// The bytes read so far.
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
            buffer: Vec::new(),
            offset: 0,
        };
        match size {
            Some(size) if size % stride as u64 != 0 && !options.skip_invalid => {
                Err(raw.cut_short(size - size % stride as u64, size % stride as u64))
            }
            _ => Ok(raw),
        }
    }

    /// Fills the buffer, but for the stream's end, and gives the number of bytes. Not `read_to_end`, which cannot know
    /// that the buffer is large enough and takes several reads where one does.
    fn read(&mut self) -> Result<usize, InputError> {
        let mut filled = 0;
        while filled < self.buffer.len() {
            match self.input.read.read(&mut self.buffer[filled..]) {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(InputError::Read {
                        path: self.input.path.to_path_buf(),
                        offset: self.offset + filled as u64,
                        source,
                    });
                }
            }
        }
        Ok(filled)
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

    fn expected_points(&self) -> Option<u64> {
        let left = self.input.size?.saturating_sub(self.offset);
        Some(left / self.stride as u64)
    }

    fn random_access(&self) -> Option<RandomAccess> {
        Some(RandomAccess {
            start: 0,
            count: self.input.size? / self.stride as u64,
            length: self.stride,
            decode: Box::new(|record| {
                let (x, y, z) = numbers(record);
                z.is_none_or(f64::is_finite).then_some(Point::new(x, y))
            }),
        })
    }

    fn fill(&mut self, sink: &mut Sink<'_>) -> Result<bool, InputError> {
        while !sink.is_full() {
            let wanted = sink.room() * self.stride;
            self.buffer.resize(wanted, 0);
            let length = self.read()?;
            let mut offset = self.offset;
            self.offset += length as u64;
            let (data, rest) = self.buffer[..length].split_at(length - length % self.stride);
            let all_valid = match self.stride {
                16 => take_all::<2>(data, sink),
                _ => take_all::<3>(data, sink),
            };
            if !all_valid {
                for record in data.chunks_exact(self.stride) {
                    let (x, y, z) = numbers(record);
                    sink.point(x, y, z, || Place::Byte(offset))?;
                    offset += self.stride as u64;
                }
            }
            if !rest.is_empty() {
                let offset = self.offset - rest.len() as u64;
                if !sink.skip_invalid {
                    return Err(self.cut_short(offset, rest.len() as u64));
                }
                sink.invalid(|| Place::Byte(offset), String::new)?;
            }
            if length < wanted {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Takes whole records of N numbers at once, or none of them if one is not valid.
fn take_all<const N: usize>(data: &[u8], sink: &mut Sink<'_>) -> bool {
    let (numbers, _) = data.as_chunks::<8>();
    let (records, _) = numbers.as_chunks::<N>();
    let points = records
        .iter()
        .map(|record| Point::new(f64::from_le_bytes(record[0]), f64::from_le_bytes(record[1])));
    let z = (N == 3).then(|| records.iter().map(|record| f64::from_le_bytes(record[N - 1])));
    sink.points(points, z)
}

fn numbers(record: &[u8]) -> (f64, f64, Option<f64>) {
    let (numbers, _) = record.as_chunks::<8>();
    let number = |axis: usize| f64::from_le_bytes(numbers[axis]);
    (number(0), number(1), (numbers.len() == 3).then(|| number(2)))
}
