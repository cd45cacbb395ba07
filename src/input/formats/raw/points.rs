//! Raw little-endian f64: pairs x y, or triples x y z.
//!
//! In: a stream of bytes and the number of values per point. Out: points. This is the fastest
//! format, and exact.

use crate::geometry::Point;
use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, Location};
use crate::input::formats::raw::records::{Records, left_over};
use crate::input::options::InputOptions;
use crate::input::points::PointBatch;
use crate::input::reader::{Reader, Sink};
use crate::input::sample::RandomAccess;

const HINT: &str = "the file is cut short, or its points have another number of dimensions (option `dims`); the option \
                    `skip_invalid` drops the rest";

pub struct Points {
    records: Records,
}

impl Points {
    /// Fails at once, not after hours of work, if the length is known and not a multiple of a
    /// point's.
    pub fn new(input: ByteInput, options: &InputOptions) -> Result<Self, InputError> {
        let stride = 8 * usize::from(options.dims);
        let records = Records::new(input, stride);
        let size = records.size().unwrap_or(0);
        match (size % stride as u64) as usize {
            rest @ 1.. if !options.skip_invalid => {
                let offset = size - rest as u64;
                Err(left_over(records.path(), offset, rest, "point", stride, HINT))
            }
            _ => Ok(Self { records }),
        }
    }
}

impl Reader<PointBatch> for Points {
    fn has_z(&self) -> bool {
        self.records.stride == 24
    }

    fn expected(&self) -> Option<u64> {
        let left = self.records.size()?.saturating_sub(self.records.offset);
        Some(left / self.records.stride as u64)
    }

    fn random_access(&self) -> Option<RandomAccess> {
        Some(RandomAccess {
            start: 0,
            count: self.records.size()? / self.records.stride as u64,
            length: self.records.stride,
            decode: Box::new(|record| {
                let (x, y, z) = numbers(record);
                z.is_none_or(f64::is_finite).then_some(Point::new(x, y))
            }),
        })
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        let stride = self.records.stride;
        while !sink.is_full() {
            let chunk = self.records.read(sink.room())?;
            let mut offset = chunk.offset;
            let all_valid = match stride {
                16 => take_all::<2>(chunk.records, sink),
                _ => take_all::<3>(chunk.records, sink),
            };
            if !all_valid {
                for record in chunk.records.chunks_exact(stride) {
                    let (x, y, z) = numbers(record);
                    sink.point(x, y, z, || Location::Byte(offset))?;
                    offset += stride as u64;
                }
            }
            if !chunk.rest.is_empty() {
                if !sink.options.skip_invalid {
                    let offset = chunk.offset + chunk.records.len() as u64;
                    return Err(left_over(sink.path, offset, chunk.rest.len(), "point", stride, HINT));
                }
                sink.pass_over();
            }
            if chunk.is_last {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Takes whole records of N numbers. Takes none of them, and returns false, if one is invalid.
fn take_all<const N: usize>(data: &[u8], sink: &mut Sink<'_, PointBatch>) -> bool {
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
