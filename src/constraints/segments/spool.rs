//! The spool: stores segments as they arrive, and returns them in the same order.

use std::path::Path;
use std::sync::Arc;
use std::{io, mem};

use crate::constraints::error::ConstraintError;
use crate::constraints::segment::{CHUNK_SEGMENTS, Segment};
use crate::constraints::segments::chunk_store::{Chunk, ChunkStore, damaged};
use crate::constraints::segments::codec::{Numbers, SegmentChunk, encode_numbers, encode_segments};
use crate::constraints::segments::join::Join;
use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::memory::SpoolShares;
use crate::store::{EdgeSource, LineKind, LinePart};

/// Stored segments: first those by their ends and then those between points, each in the order in
/// which they came.
///
/// ```text
/// memory  1/2   chunks, up to this number of bytes
///         1/4   the join: sorted records; then pairs that wait; then positions of a part
///         1/4   buffers, lists of chunks
/// ```
#[derive(Debug)]
pub(crate) struct SegmentSpool {
    store: Arc<ChunkStore>,
    /// Number of segments of a chunk.
    capacity: usize,
    by_ends: Vec<Chunk>,
    by_ends_count: u64,
    /// Whether z came with the ends of any segment. Then later chunks have z, with [`NO_Z`] for
    /// segments without it.
    has_z: bool,
    /// Whether an end came without z.
    lacks_z: bool,
    /// Segments that are in no chunk yet.
    pending: Vec<Segment>,
    pending_z: Vec<[f64; 2]>,
    join: Join,
    /// The sources of the segments in the join.
    sources: Vec<Chunk>,
    pending_sources: Vec<u64>,
    /// A buffer for the bytes of a chunk.
    bytes: Vec<u8>,
}

impl SegmentSpool {
    /// Makes an empty spool. It takes at most about `memory` bytes of memory. Further segments take
    /// room in `folder`.
    pub(crate) fn new(folder: &Path, memory: u64) -> Self {
        let shares = SpoolShares::new(memory);
        let capacity = shares.pending / size_of::<Segment>() as u64;
        Self {
            store: Arc::new(ChunkStore::new(folder, shares.chunks)),
            capacity: capacity.clamp(4, CHUNK_SEGMENTS as u64) as usize,
            by_ends: Vec::new(),
            by_ends_count: 0,
            has_z: false,
            lacks_z: false,
            pending: Vec::new(),
            pending_z: Vec::new(),
            join: Join::new(shares.join),
            sources: Vec::new(),
            pending_sources: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// Returns the number of segments, including those of zero length.
    pub(crate) fn len(&self) -> u64 {
        self.by_ends_count + self.join.segments()
    }

    /// Returns whether there are no segments.
    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the bytes that the segments take in memory now.
    pub(crate) fn byte_size(&self) -> u64 {
        let lists = (self.by_ends.capacity() + self.sources.capacity()) * size_of::<Chunk>();
        let pending = self.pending.capacity() * size_of::<Segment>()
            + self.pending_z.capacity() * size_of::<[f64; 2]>()
            + self.pending_sources.capacity() * size_of::<u64>();
        (lists + pending + self.bytes.capacity()) as u64 + self.store.byte_size() + self.join.byte_size()
    }

    /// Returns the number of segments that came by their ends, and of those between points.
    pub(crate) fn counts(&self) -> [u64; 2] {
        [self.by_ends_count, self.join.segments()]
    }

    /// Returns about how many bytes all segments take on the disk, while they arrive or while
    /// blocks get the segments that meet them. The latter replace the segments that were read.
    /// Returns 0 if they stay in memory.
    pub(crate) fn disk_bytes(&self) -> u64 {
        /// Bytes of a segment by its ends: the ends and the source. `Z` adds its z.
        const BY_ENDS: u64 = 36;
        const Z: u64 = 16;
        /// Bytes of a segment between points: waiting records, found positions, and the source.
        const BETWEEN: u64 = 60;
        let [by_ends, between] = self.counts();
        let each = if self.has_z { BY_ENDS + Z } else { BY_ENDS };
        let bytes = by_ends
            .saturating_mul(each)
            .saturating_add(between.saturating_mul(BETWEEN));
        if bytes > self.store.limit() { bytes } else { 0 }
    }

    /// Returns about how many bytes all segments take in a file of their own.
    pub(crate) fn saved_bytes(&self) -> u64 {
        self.len().saturating_mul(36)
    }

    /// Returns the bytes that are on the disk already.
    pub(crate) fn spilled_bytes(&self) -> u64 {
        self.store.file_bytes()
    }

    /// Adds segments by their ends, of the given lines. `z` has the z of both ends of each segment,
    /// or is empty.
    ///
    /// Returns an error if an end or a z is not valid, if the number of a line is too large, if the
    /// lists have different lengths, or if spilling fails. In the first three cases no segment is
    /// added.
    pub(crate) fn push(
        &mut self,
        ends: &[[Point; 2]],
        z: &[[f64; 2]],
        kind: LineKind,
        lines: &[u64],
    ) -> Result<(), ConstraintError> {
        if lines.len() != ends.len() || !(z.is_empty() || z.len() == ends.len()) {
            return Err(ConstraintError::SegmentBatch {
                segments: ends.len(),
                z: z.len(),
                lines: lines.len(),
            });
        }
        for (ends, segment) in ends.iter().zip(self.len()..) {
            if let Some(&point) = ends.iter().find(|end| !end.is_valid()) {
                return Err(ConstraintError::InvalidEnd { segment, point });
            }
        }
        for (z, segment) in z.iter().zip(self.len()..) {
            if let Some(&z) = z.iter().find(|z| z.is_infinite()) {
                return Err(ConstraintError::InvalidEndZ { segment, z });
            }
        }
        self.check_lines(lines)?;
        if !z.is_empty() && !self.has_z {
            self.flush_pending().map_err(|error| self.cannot_spill(error))?;
            self.has_z = true;
        }
        let lacks_z = || z.is_empty() && !ends.is_empty() || z.as_flattened().iter().any(|z| z.is_nan());
        self.lacks_z = self.lacks_z || lacks_z();
        for (at, (ends, &line)) in ends.iter().zip(lines).enumerate() {
            let segment = Segment {
                ends: ends.map(Point::normalized),
                source: LinePart::whole(EdgeSource::new(kind, line)),
            };
            self.push_one(segment, z.get(at).copied().unwrap_or([NO_Z; 2]))?;
        }
        Ok(())
    }

    /// Returns whether an end came without z.
    pub(crate) fn lacks_z(&self) -> bool {
        self.lacks_z
    }

    /// Adds parts of segments that were split. They have no z, and their ends are valid.
    pub(crate) fn push_parts(&mut self, parts: impl IntoIterator<Item = Segment>) -> Result<(), ConstraintError> {
        parts.into_iter().try_for_each(|part| self.push_one(part, [NO_Z; 2]))
    }

    fn push_one(&mut self, segment: Segment, z: [f64; 2]) -> Result<(), ConstraintError> {
        self.pending.push(segment);
        if self.has_z {
            self.pending_z.push(z);
        }
        self.by_ends_count += 1;
        if self.pending.len() >= self.capacity {
            self.flush_pending().map_err(|error| self.cannot_spill(error))?;
        }
        Ok(())
    }

    /// Adds segments of the given lines, by the record numbers of points that come later.
    ///
    /// Errors are those of [`push`](Self::push), except those about ends.
    pub(crate) fn push_between(
        &mut self,
        records: &[[u64; 2]],
        kind: LineKind,
        lines: &[u64],
    ) -> Result<(), ConstraintError> {
        if lines.len() != records.len() {
            return Err(ConstraintError::SegmentBatch {
                segments: records.len(),
                z: 0,
                lines: lines.len(),
            });
        }
        self.check_lines(lines)?;
        self.spill_between(records, kind, lines)
            .map_err(|error| self.cannot_spill(error))
    }

    fn spill_between(&mut self, records: &[[u64; 2]], kind: LineKind, lines: &[u64]) -> io::Result<()> {
        for &line in lines {
            self.pending_sources
                .push(LinePart::whole(EdgeSource::new(kind, line)).to_bits());
            if self.pending_sources.len() >= 4 * self.capacity {
                encode_numbers(self.pending_sources.iter().copied(), &mut self.bytes);
                self.sources.push(self.store.append(&self.bytes)?);
                self.pending_sources.clear();
            }
        }
        self.join.push(records, &self.store)
    }

    fn check_lines(&self, lines: &[u64]) -> Result<(), ConstraintError> {
        let mut numbered = lines.iter().zip(self.len()..);
        match numbered.find(|&(&line, _)| line > EdgeSource::MAX_NUMBER) {
            Some((&line, segment)) => Err(ConstraintError::LineNumber { segment, line }),
            None => Ok(()),
        }
    }

    fn flush_pending(&mut self) -> io::Result<()> {
        if !self.pending.is_empty() {
            encode_segments(&self.pending, &self.pending_z, &mut self.bytes);
            self.by_ends.push(self.store.append(&self.bytes)?);
            self.pending.clear();
            self.pending_z.clear();
        }
        Ok(())
    }

    fn cannot_spill(&self, error: io::Error) -> ConstraintError {
        ConstraintError::io(self.store.folder(), "spill segments in", error)
    }

    fn cannot_read(&self, error: io::Error) -> ConstraintError {
        ConstraintError::io(self.store.folder(), "read segments back from", error)
    }

    /// Finds the ends that are among the points of a batch. Segments between these points must have
    /// come before.
    ///
    /// It is fastest if records ascend, but they need not. If a record comes twice, the last point
    /// counts.
    pub(crate) fn resolve(&mut self, batch: &PointBatch) -> Result<(), ConstraintError> {
        let resolved = self.join.resolve(batch, &self.store);
        resolved.map_err(|error| self.cannot_spill(error))
    }

    /// Returns the z at the ends of the segments that [`for_each_chunk`](Self::for_each_chunk)
    /// passes first, in its order, [`NO_Z`] where there is none. All other segments have no z.
    pub(crate) fn z_of_ends(&self) -> Result<Vec<[f64; 2]>, ConstraintError> {
        let mut all = Vec::new();
        for batch in self.ends(0) {
            let PointBatch { points, mut z, .. } = batch?;
            z.resize(points.len(), NO_Z);
            let pairs = points.as_chunks::<2>().0.iter().zip(z.as_chunks::<2>().0);
            all.extend(pairs.filter(|([a, b], _)| a != b).map(|(_, z)| *z));
        }
        Ok(all)
    }

    /// Returns the ends of the segments that came by their ends, two for each, as points with
    /// ascending record numbers from `first_record` on, with z or [`NO_Z`].
    pub(crate) fn ends(&self, first_record: u64) -> impl Iterator<Item = Result<PointBatch, ConstraintError>> + Send {
        let mut record = first_record;
        let mut bytes = Vec::new();
        let chunks = self.by_ends.iter().map(Some).chain([None]);
        let batches = chunks.map(move |chunk| {
            let (ends, z): (Vec<[Point; 2]>, Vec<f64>) = match chunk {
                Some(chunk) => {
                    let read = self.store.read(chunk, &mut bytes);
                    let chunk = read.and_then(decode).map_err(|error| self.cannot_read(error))?;
                    (
                        chunk.clone().segments().map(|segment| segment.ends).collect(),
                        chunk.z().collect(),
                    )
                }
                None => {
                    let ends = self.pending.iter().map(|segment| segment.ends);
                    (ends.collect(), self.pending_z.as_flattened().to_vec())
                }
            };
            let points = ends.into_flattened();
            let first = record;
            record = record.saturating_add(points.len() as u64);
            Ok(PointBatch {
                records: (0..points.len() as u64).map(|at| first.saturating_add(at)).collect(),
                points,
                z,
            })
        });
        batches.filter(|batch| !matches!(batch, Ok(batch) if batch.is_empty()))
    }

    /// Passes all segments of nonzero length to `take`, in chunks, once all points have arrived. It
    /// may be called again.
    ///
    /// Returns [`ConstraintError::NoSuchRecord`], the system's error, or the error of `take`.
    pub(crate) fn for_each_chunk(
        &mut self,
        mut take: impl FnMut(&[Segment]) -> Result<(), ConstraintError>,
    ) -> Result<(), ConstraintError> {
        let given = self.give(false, &mut |segments| take(segments).map_err(Stopped::Build));
        given.map_err(|stopped| self.error(stopped))
    }

    fn error(&self, stopped: Stopped) -> ConstraintError {
        match stopped {
            Stopped::Io(error) => self.cannot_read(error),
            Stopped::Build(error) => error,
        }
    }

    fn give(&mut self, is_last: bool, take: &mut Take) -> Result<(), Stopped> {
        self.join.rest(&self.store)?;
        let mut segments: Vec<Segment> = Vec::with_capacity(self.capacity);
        let has_length = |segment: &Segment| segment.ends[0] != segment.ends[1];
        let mut give = |segments: &mut Vec<Segment>| -> Result<(), Stopped> {
            if !segments.is_empty() {
                take(segments)?;
                segments.clear();
                segments.reserve_exact(self.capacity);
            }
            Ok(())
        };
        for chunk in &mut self.by_ends {
            let its = decode(self.store.read(chunk, &mut self.bytes)?)?;
            segments.extend(its.segments().filter(has_length));
            if is_last {
                self.store.free(mem::take(chunk));
            }
            give(&mut segments)?;
        }
        segments.extend(self.pending.iter().filter(|segment| has_length(segment)));
        give(&mut segments)?;
        let mut sources = Sources {
            chunks: &self.sources,
            pending: &self.pending_sources,
            now: Vec::new().into_iter(),
            bytes: &mut self.bytes,
        };
        let store = &*self.store;
        let take = |all: &[[Point; 2]]| {
            for ends in all.chunks(self.capacity) {
                for &ends in ends {
                    let source = sources.next(store)?;
                    segments.extend(Some(Segment { ends, source }).filter(has_length));
                }
                give(&mut segments)?;
            }
            Ok(())
        };
        let missing = |segment, record| Stopped::Build(ConstraintError::NoSuchRecord { segment, record });
        self.join.for_each(is_last, store, take, missing)
    }

    /// Passes all segments of nonzero length to `take`, and frees their chunks. `take` may empty
    /// the list that it gets.
    ///
    /// Errors are those of [`for_each_chunk`](Self::for_each_chunk).
    pub(super) fn give_last(
        &mut self,
        mut take: impl FnMut(&mut Vec<Segment>) -> Result<(), ConstraintError>,
    ) -> Result<(), ConstraintError> {
        let given = self.give(true, &mut |segments| take(segments).map_err(Stopped::Build));
        given.map_err(|stopped| self.error(stopped))
    }

    /// Returns the store of the chunks.
    pub(super) fn store(&self) -> &Arc<ChunkStore> {
        &self.store
    }
}

/// A function that takes segments. It may empty the list.
type Take<'a> = dyn FnMut(&mut Vec<Segment>) -> Result<(), Stopped> + 'a;

/// The reason why no more segments are passed.
enum Stopped {
    Io(io::Error),
    Build(ConstraintError),
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

fn decode(bytes: &[u8]) -> io::Result<SegmentChunk<'_>> {
    SegmentChunk::decode(bytes).ok_or_else(|| damaged("a chunk is not of segments"))
}

/// A reader of sources, one after another.
struct Sources<'a> {
    /// Chunks that were not read yet.
    chunks: &'a [Chunk],
    /// The sources after those in chunks.
    pending: &'a [u64],
    now: std::vec::IntoIter<u64>,
    bytes: &'a mut Vec<u8>,
}

impl Sources<'_> {
    #[inline]
    fn next(&mut self, store: &ChunkStore) -> io::Result<LinePart> {
        loop {
            if let Some(source) = self.now.next() {
                return Ok(LinePart::from_bits(source));
            }
            self.read(store)?;
        }
    }

    #[cold]
    fn read(&mut self, store: &ChunkStore) -> io::Result<()> {
        let sources = match self.chunks.split_first() {
            Some((chunk, rest)) => {
                self.chunks = rest;
                let numbers = Numbers::decode(store.read(chunk, self.bytes)?);
                numbers.ok_or_else(|| damaged("a chunk is not of numbers"))?.collect()
            }
            None => mem::take(&mut self.pending).to_vec(),
        };
        if sources.is_empty() {
            return Err(damaged("segments have no sources"));
        }
        self.now = sources.into_iter();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
