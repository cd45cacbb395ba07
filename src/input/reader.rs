//! The reader of a format and the sink that takes its records, for points, segments and sites
//! alike.
//!
//! A [`Reader`] reads one file and puts its records into a [`Sink`]. The sink numbers and checks
//! the records, and fills a [`Batch`]. The methods of the sink depend on the kind of record; they
//! are defined in the modules `points`, `lines` and `sites`.

use crate::geometry::Rect;
use crate::input::about::About;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::sample::RandomAccess;
use std::path::Path;

/// The number of records in a full batch.
pub const FULL: usize = 8192;

/// A batch of records of one kind.
pub trait Batch: Default {
    /// The options that select the records to read and how to read them.
    type Options;
    /// The counts over all files of a source.
    type Totals: Totals<Self>;
    /// The counts that the reader of one file keeps, beside the records that it puts into batches.
    type Tally: Default;

    /// Returns the number of records.
    fn len(&self) -> usize;

    /// Returns whether the batch has no records.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes all records and keeps the memory.
    fn clear(&mut self);
}

/// The counts over all files of a source.
pub trait Totals<B: Batch>: Default {
    /// Updates the totals after a reader has put records into `batch`; `tally` has the counts of
    /// its file so far.
    fn add(&mut self, _batch: &B, _tally: &B::Tally) {}

    /// Updates the totals at the end of a file, which has the counts `tally`. `handed_out` is the
    /// number of records of all files that are in batches so far. Returns the number of records of
    /// all files so far, as a person counts them.
    fn end_file(&mut self, tally: &B::Tally, handed_out: u64) -> u64;

    /// Returns notes for the user about the file that just ended.
    fn notes(&mut self, path: &Path) -> Vec<String>;
}

/// The reader of one file.
pub trait Reader<B: Batch>: Send {
    /// Returns whether the records have z. This is known from the start.
    fn has_z(&self) -> bool {
        false
    }

    /// Returns the coordinate reference system, if the part of the file that was read contains one.
    fn crs(&self) -> Option<&str> {
        None
    }

    /// Returns the number of records that remain, as estimated from the file's beginning and its
    /// size. The file may claim any number, so no memory may be allocated according to it.
    fn expected(&self) -> Option<u64> {
        None
    }

    /// Returns the rectangle that contains the records, as the file's beginning says, which may be wrong.
    fn expected_extent(&self) -> Option<Rect> {
        None
    }

    /// Returns how to read the records in any order, if the format allows it and the input is a
    /// regular file.
    fn random_access(&self) -> Option<RandomAccess> {
        None
    }

    /// Puts records into `sink` until it is full (returns true) or the file ends (returns false).
    fn fill(&mut self, sink: &mut Sink<'_, B>) -> Result<bool, InputError>;

    /// Returns the counts so far.
    fn tally(&self) -> B::Tally {
        B::Tally::default()
    }

    /// Returns what the file says of itself, at its end.
    fn about(&self) -> About {
        About::default()
    }

    /// Returns notes for the user, at the end of the file.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A reader that has examined the beginning of its file, or the error found there.
pub type Started<B> = Result<Box<dyn Reader<B>>, InputError>;

/// The path of records from one file into one batch.
pub struct Sink<'a, B: Batch> {
    pub batch: &'a mut B,
    pub totals: &'a mut B::Totals,
    pub options: &'a B::Options,
    pub path: &'a Path,
    /// Whether the batches have z.
    pub wants_z: bool,
    /// The number of records that were handed out before this batch.
    pub before: u64,
}

impl<B: Batch> Sink<'_, B> {
    /// Returns whether the batch must be handed out before more records are put in.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.batch.len() >= FULL
    }

    /// Returns the number of records for which the batch has room.
    pub fn room(&self) -> usize {
        FULL.saturating_sub(self.batch.len())
    }

    /// Returns the number of the next record.
    pub fn next(&self) -> u64 {
        self.before + self.batch.len() as u64
    }

    /// Returns the error of an invalid record.
    #[cold]
    pub fn wrong(&self, kind: RecordKind, number: u64, location: Location, flaw: &Flaw) -> InputError {
        InputError::Record {
            path: self.path.to_owned(),
            kind,
            number,
            location,
            found: flaw.to_string(),
        }
    }
}
