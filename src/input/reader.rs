//! What the reader of a format does, and where it puts what it reads: the same for points, segments and sites.
//!
//! A [`Reader`] has one file, whose records it puts into a [`Sink`]; that numbers and checks them, and fills a [`Batch`].
//! What the sink takes depends on the kind, and stands in the file of the kind: `points`, `lines`, `sites`.

use crate::input::error::{InputError, Place, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::sample::RandomAccess;
use std::path::Path;

/// Records in a full batch.
pub const FULL: usize = 8192;

/// Records of one kind, which are handed out together.
pub trait Batch: Default {
    /// What says which records are read, and how.
    type Options;
    /// What is counted over all files of a source.
    type Totals: Totals<Self>;
    /// What the reader of a file counts, beside what it puts into batches.
    type Tally: Default;

    /// The number of records.
    fn len(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes all records and keeps the memory.
    fn clear(&mut self);
}

/// What is counted over all files of a source.
pub trait Totals<B: Batch>: Default {
    /// A reader has put records into this batch, and counted so much of its file by now.
    fn add(&mut self, _batch: &B, _tally: &B::Tally) {}

    /// A file is at its end, of which this was counted; `handed_out` records of all files are in batches by now. Gives
    /// the number of records of all files by now, as a person counts them.
    fn end_file(&mut self, tally: &B::Tally, handed_out: u64) -> u64;

    /// What a person should know of the file that is at its end.
    fn notes(&mut self, path: &Path) -> Vec<String>;
}

/// What a format does with one file.
pub trait Reader<B: Batch>: Send {
    /// Whether its records have z. Known from the start.
    fn has_z(&self) -> bool {
        false
    }

    /// The coordinate reference system, if the file has told it by now.
    fn crs(&self) -> Option<&str> {
        None
    }

    /// How many records are still to come, as far as the file's beginning and its size tell. A claim: nothing may be
    /// allocated by it.
    fn expected(&self) -> Option<u64> {
        None
    }

    /// How to read the records in any order, if the format allows it and the input is a regular file.
    fn random_access(&self) -> Option<RandomAccess> {
        None
    }

    /// Puts records into the sink until it is full (true) or the file is at its end (false).
    fn fill(&mut self, sink: &mut Sink<'_, B>) -> Result<bool, InputError>;

    /// What it has counted by now.
    fn tally(&self) -> B::Tally {
        B::Tally::default()
    }

    /// What a person should know, when the file is at its end.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A reader that has looked at the beginning of its file, or what is wrong there.
pub type Started<B> = Result<Box<dyn Reader<B>>, InputError>;

/// The way from one file into one batch.
pub struct Sink<'a, B: Batch> {
    pub batch: &'a mut B,
    pub totals: &'a mut B::Totals,
    pub options: &'a B::Options,
    pub path: &'a Path,
    /// Whether the batches have z.
    pub wants_z: bool,
    /// Records that were handed out before this batch.
    pub before: u64,
}

impl<B: Batch> Sink<'_, B> {
    /// Whether the batch should be handed out before more is put in.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.batch.len() >= FULL
    }

    /// The number of records that the batch still takes.
    pub fn room(&self) -> usize {
        FULL.saturating_sub(self.batch.len())
    }

    /// The number of the record that comes.
    pub fn next(&self) -> u64 {
        self.before + self.batch.len() as u64
    }

    /// The error of a record that is none of its kind.
    #[cold]
    pub fn wrong(&self, kind: RecordKind, number: u64, place: Place, flaw: &Flaw) -> InputError {
        InputError::Record {
            path: self.path.to_owned(),
            kind,
            number,
            place,
            found: flaw.to_string(),
        }
    }
}
