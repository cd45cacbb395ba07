//! Candidates on their way: in memory as long as they fit, otherwise on the disk; and which of them are
//! chosen.
//!
//! How many candidates have which weight is counted in bins, which are the leading bits of the weight. So
//! the choice needs neither a sort nor all candidates in memory. In the bin that is chosen in part, a hash
//! decides.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

use crate::geometry::Point;
use crate::input::PointBatch;
use crate::overviews::candidates::Candidate;
use crate::overviews::error::OverviewError;
use crate::overviews::hash::{hash, is_below};

/// The lower bits of a weight that do not count. A bin is a 256th of a power of 2.
const SHIFT: u32 = 44;
const BINS: usize = 1 << (63 - SHIFT);
/// The bytes of a candidate on the disk.
const BYTES: usize = 40;
/// The candidates that are passed on at once.
const BATCH: usize = 1 << 16;

/// Candidates of a round.
pub(super) struct Candidates {
    /// How many there are in each bin.
    bins: Vec<u64>,
    count: u64,
    in_memory: Vec<Candidate>,
    /// How many are in memory before they are written.
    most: usize,
    file: Option<BufWriter<File>>,
}

/// Which candidates are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Threshold {
    bin: usize,
    /// The share of the bin that is chosen.
    share: f64,
    seed: u64,
}

fn bin(weight: f64) -> usize {
    (weight.to_bits() >> SHIFT) as usize
}

impl Threshold {
    fn chooses(&self, candidate: &Candidate) -> bool {
        match bin(candidate.weight).cmp(&self.bin) {
            std::cmp::Ordering::Greater => true,
            std::cmp::Ordering::Equal => is_below(hash(candidate.point, self.seed), self.share),
            std::cmp::Ordering::Less => false,
        }
    }
}

impl Candidates {
    /// Creates an empty list that takes about `memory` bytes.
    pub(super) fn new(memory: u64) -> Self {
        Self {
            bins: vec![0; BINS],
            count: 0,
            in_memory: Vec::new(),
            most: (memory as usize / size_of::<Candidate>() / 2).max(BATCH),
            file: None,
        }
    }

    /// Returns how many candidates there are.
    pub(super) fn len(&self) -> u64 {
        self.count
    }

    /// Adds candidates. `spill` is where they are written if they do not fit into the memory.
    pub(super) fn add(&mut self, candidates: &[Candidate], spill: &Path) -> Result<(), OverviewError> {
        candidates
            .iter()
            .for_each(|candidate| self.bins[bin(candidate.weight)] += 1);
        self.count += candidates.len() as u64;
        self.in_memory.extend_from_slice(candidates);
        match self.in_memory.len() > self.most {
            true => self.write(spill).map_err(OverviewError::io(spill, "write")),
            false => Ok(()),
        }
    }

    fn write(&mut self, spill: &Path) -> std::io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                let file = File::options().read(true).write(true).create_new(true).open(spill)?;
                // The open file is all that is needed.
                std::fs::remove_file(spill)?;
                none.insert(BufWriter::with_capacity(1 << 20, file))
            }
        };
        for candidate in self.in_memory.drain(..) {
            file.write_all(&encode(candidate))?;
        }
        Ok(())
    }

    /// Returns the threshold above which there are about `want` candidates.
    pub(super) fn threshold(&self, want: u64, seed: u64) -> Threshold {
        let mut left = want;
        for (bin, &count) in self.bins.iter().enumerate().rev() {
            if count > left {
                let share = left as f64 / count as f64;
                return Threshold { bin, share, seed };
            }
            left -= count;
        }
        Threshold {
            bin: 0,
            share: 1.0,
            seed,
        }
    }

    /// Returns the chosen candidates in batches. `spill` is for errors.
    pub(super) fn chosen(
        self,
        threshold: Threshold,
        spill: &Path,
    ) -> Result<impl Iterator<Item = Result<PointBatch, OverviewError>> + Send + use<'_>, OverviewError> {
        let written = self.count as usize - self.in_memory.len();
        let file = self.file.map(BufWriter::into_inner).transpose();
        let mut file = file.map_err(|error| OverviewError::io(spill, "write")(error.into_error()))?;
        if let Some(file) = &mut file {
            file.rewind().map_err(OverviewError::io(spill, "read"))?;
        }
        let mut file = file.map(|file| BufReader::with_capacity(1 << 20, file));
        let mut from_file = (0..written).step_by(BATCH).map(move |start| {
            let mut candidates = Vec::with_capacity(BATCH.min(written - start));
            for _ in start..(start + BATCH).min(written) {
                let mut bytes = [0; BYTES];
                let file = file.as_mut().ok_or(std::io::ErrorKind::UnexpectedEof);
                let read = file.map_err(Into::into).and_then(|file| file.read_exact(&mut bytes));
                read.map_err(OverviewError::io(spill, "read"))?;
                candidates.push(decode(&bytes));
            }
            Ok(candidates)
        });
        let mut in_memory = self.in_memory.into_iter();
        let rest = std::iter::from_fn(move || {
            let candidates: Vec<Candidate> = in_memory.by_ref().take(BATCH).collect();
            (!candidates.is_empty()).then_some(Ok(candidates))
        });
        let all = std::iter::from_fn(move || from_file.next()).chain(rest);
        Ok(all.map(move |candidates| candidates.map(|candidates| batch(&candidates, threshold))))
    }
}

fn batch(candidates: &[Candidate], threshold: Threshold) -> PointBatch {
    let mut batch = PointBatch::default();
    for candidate in candidates.iter().filter(|candidate| threshold.chooses(candidate)) {
        batch.points.push(candidate.point);
        batch.z.push(candidate.z);
        batch.records.push(candidate.record);
    }
    batch
}

fn encode(candidate: Candidate) -> [u8; BYTES] {
    let Candidate {
        weight,
        point,
        z,
        record,
    } = candidate;
    let words = [weight, point.x, point.y, z].map(f64::to_bits);
    let mut bytes = [0; BYTES];
    for (bytes, word) in bytes.chunks_exact_mut(8).zip(words.into_iter().chain([record])) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

fn decode(bytes: &[u8; BYTES]) -> Candidate {
    let word = |at: usize| u64::from_le_bytes(bytes[8 * at..8 * at + 8].try_into().expect("eight bytes"));
    let number = |at: usize| f64::from_bits(word(at));
    Candidate {
        weight: number(0),
        point: Point::new(number(1), number(2)),
        z: number(3),
        record: word(4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(i: u32) -> Candidate {
        Candidate {
            weight: f64::from(i % 100),
            point: Point::new(f64::from(i), f64::from(i % 7)),
            z: f64::from(i) / 3.0,
            record: u64::from(i) << 33,
        }
    }

    fn chosen(count: u32, want: u64, memory: usize) -> Vec<u64> {
        let folder = tempfile::tempdir().unwrap();
        let spill = folder.path().join("spill");
        let mut all = Candidates::new(0);
        all.most = memory;
        for start in (0..count).step_by(10) {
            let some: Vec<Candidate> = (start..(start + 10).min(count)).map(candidate).collect();
            all.add(&some, &spill).unwrap();
        }
        let threshold = all.threshold(want, 3);
        let batches: Vec<PointBatch> = all.chosen(threshold, &spill).unwrap().map(Result::unwrap).collect();
        let chosen: Vec<u64> = batches.iter().flat_map(|batch| batch.records.clone()).collect();
        for batch in batches {
            for ((point, z), record) in batch.points.iter().zip(batch.z).zip(batch.records) {
                let expected = candidate((record >> 33) as u32);
                assert_eq!((*point, z), (expected.point, expected.z));
            }
        }
        chosen
    }

    #[test]
    fn the_heaviest_are_chosen_whether_they_fit_in_memory_or_not() {
        let all = chosen(70_000, 30_000, usize::MAX);
        assert_eq!(all, chosen(70_000, 30_000, 100));
        assert_eq!(all, chosen(70_000, 30_000, 65_000));
        let weight = |record: &u64| (record >> 33) % 100;
        // 700 of each weight: those above 57 are 29,400.
        assert_eq!(all.iter().filter(|record| weight(record) > 57).count(), 29_400);
        assert!(all.iter().all(|record| weight(record) >= 57));
        assert!((29_900..30_100).contains(&all.len()), "{}", all.len());
    }

    #[test]
    fn all_or_none_can_be_chosen() {
        assert_eq!(chosen(500, 500, usize::MAX).len(), 500);
        assert_eq!(chosen(500, 9999, usize::MAX).len(), 500);
        assert_eq!(chosen(500, 0, usize::MAX).len(), 0);
        assert_eq!(chosen(0, 5, usize::MAX).len(), 0);
    }
}
