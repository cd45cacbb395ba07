//! Calls that do not fit into memory: a file without a name, in parts that do.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

use crate::edit::points::bytes::{MAX_CALL_BYTES, decode_call, encode_call};
use crate::edit::points::call::PointCall;
use crate::geometry::Rect;

/// The number of calls that are read at a time.
const CALLS_AT_ONCE: usize = 4096;

/// Calls on disk, in order.
#[derive(Clone, Debug)]
pub(crate) struct SpilledCalls {
    file: Arc<File>,
    /// The number of calls up to the end of each part.
    ends: Vec<u64>,
    /// A box around the positions that they name.
    pub(crate) bounds: Rect,
}

impl SpilledCalls {
    /// Creates an empty file in a folder.
    pub(crate) fn in_folder(folder: &Path) -> io::Result<Self> {
        Ok(Self {
            file: Arc::new(tempfile::tempfile_in(folder)?),
            ends: Vec::new(),
            bounds: Rect::EMPTY,
        })
    }

    /// Returns the number of calls.
    pub(crate) fn len(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Returns the number of parts.
    pub(crate) fn parts(&self) -> usize {
        self.ends.len()
    }

    /// Returns the number of calls before a part.
    pub(crate) fn first_of(&self, part: usize) -> u64 {
        part.checked_sub(1).map_or(0, |before| self.ends[before])
    }

    /// Adds a part.
    pub(crate) fn push(&mut self, calls: &[PointCall]) -> io::Result<()> {
        let mut file = &*self.file;
        // Where a part could not be written, the next one takes its place.
        file.seek(SeekFrom::Start(self.len() * MAX_CALL_BYTES as u64))?;
        let mut file = BufWriter::with_capacity(CALLS_AT_ONCE * MAX_CALL_BYTES, file);
        let mut bytes = Vec::with_capacity(MAX_CALL_BYTES);
        for &call in calls {
            bytes.clear();
            encode_call(call, &mut bytes);
            bytes.resize(MAX_CALL_BYTES, 0);
            file.write_all(&bytes)?;
        }
        file.flush()?;
        drop(file);
        let positions = calls.iter().flat_map(|call| call.positions()).flatten();
        self.bounds = self.bounds.union(Rect::around(positions));
        self.ends.push(self.len() + calls.len() as u64);
        Ok(())
    }

    /// Reads a part.
    pub(crate) fn part(&self, part: usize) -> io::Result<Vec<PointCall>> {
        let first = self.first_of(part);
        let count = (self.ends[part] - first) as usize;
        let mut calls = Vec::with_capacity(count);
        let mut bytes = vec![0; count.min(CALLS_AT_ONCE) * MAX_CALL_BYTES];
        while calls.len() < count {
            let more = (count - calls.len()).min(CALLS_AT_ONCE);
            let bytes = &mut bytes[..more * MAX_CALL_BYTES];
            self.file
                .read_exact_at(bytes, (first + calls.len() as u64) * MAX_CALL_BYTES as u64)?;
            for mut bytes in bytes.chunks_exact(MAX_CALL_BYTES) {
                let call = decode_call(&mut bytes).ok().flatten();
                calls.push(call.ok_or_else(|| io::Error::other("a spilled change is not what was written"))?);
            }
        }
        Ok(calls)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn parts_are_read_as_they_were_written() {
        let at = |i: usize| Point::new(i as f64, -0.5);
        let call = |i: usize| match i % 4 {
            0 => PointCall::Insert(at(i), 2.5, i as u64),
            1 => PointCall::Delete(at(i)),
            2 => PointCall::Move([at(i), at(i + 1)]),
            _ => PointCall::SetZ(at(i), -1.0),
        };
        let folder = tempfile::tempdir().unwrap();
        let mut spilled = SpilledCalls::in_folder(folder.path()).unwrap();
        let parts: Vec<Vec<PointCall>> = [3, 10_000, 1].map(|count| (0..count).map(call).collect()).into();
        for part in &parts {
            spilled.push(part).unwrap();
        }
        assert_eq!((spilled.parts(), spilled.len()), (3, 10_004));
        for number in [2, 0, 1] {
            assert_eq!(spilled.part(number).unwrap(), parts[number]);
        }
        assert_eq!(spilled.bounds, Rect::around([at(0), at(9999)]));
    }
}
