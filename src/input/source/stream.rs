//! The stream of batches over all inputs, whatever kind of record they have.
//!
//! State on open: every file was looked at (header or first record) and closed again, but the first one and those that
//! can be read only once (standard input, pipes), which wait opened. State while reading: one reader, and the inputs
//! that are left. A failure ends the stream.

use crate::input::bytes::ByteInput;
use crate::input::error::{InputError, RecordKind};
use crate::input::reader::{Batch, Reader, Sink, Started, Totals};
use crate::input::sample::RandomAccess;
use crate::input::watch::{FileStamp, Reading, Watch, Watched, note};
use std::collections::VecDeque;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Records of one kind, by the formats that they are read from.
pub trait Records: Batch {
    /// How a file is written.
    type Format: Copy;

    /// Whether a batch may have records of several files.
    const SPANS_FILES: bool;

    /// Whether a file of the format that begins as gzip does is gzip. Of formats but raw numbers no file can begin so.
    fn may_be_gzip(format: Self::Format) -> bool;

    /// Starts the reader of bytes, which were unzipped.
    fn start(format: Self::Format, input: ByteInput, options: &Self::Options) -> Started<Self>;

    /// Starts the reader of a file; other than [`start`](Self::start) for formats in which a reader has to seek.
    fn start_file(format: Self::Format, file: Watched<Arc<File>>, options: &Self::Options) -> Started<Self> {
        start_stream(format, file, options)
    }
}

/// Starts the reader of a stream, which may be gzip.
pub fn start_stream<B: Records>(
    format: B::Format,
    stream: Watched<impl Read + Send + 'static>,
    options: &B::Options,
) -> Started<B> {
    B::start(format, ByteInput::new(stream, B::may_be_gzip(format))?, options)
}

/// An input and, if it is open, its reader.
pub struct Input<B: Records> {
    pub path: Arc<Path>,
    format: B::Format,
    /// What it was when it was looked at; `None` of streams.
    stamp: Option<FileStamp>,
    /// The records that it claimed when it was looked at.
    expected: Option<u64>,
    opened: Option<Opened<B>>,
}

pub struct Opened<B: Batch> {
    pub reader: Box<dyn Reader<B>>,
    watch: Arc<Watch>,
}

impl<B: Records> Input<B> {
    pub fn new(path: &Path, format: B::Format) -> Self {
        Self {
            path: path.into(),
            format,
            stamp: None,
            expected: None,
            opened: None,
        }
    }

    /// Its length in bytes, if it is a regular file.
    fn size(&self) -> Option<u64> {
        self.stamp.map(|stamp| stamp.length)
    }

    /// Opens the file and starts its reader. If it was open before, it must not have changed since.
    pub fn open(&mut self, options: &B::Options, reading: &Reading) -> Result<Opened<B>, InputError> {
        let file = Watched::open(&self.path, reading, self.stamp)?;
        let watch = Arc::clone(&file.watch);
        self.stamp = watch.stamp();
        match B::start_file(self.format, file, options) {
            Ok(reader) => Ok(Opened { reader, watch }),
            Err(error) => Err(watch.explain(error)),
        }
    }

    /// Starts the reader of a stream.
    pub fn open_stream(
        &self,
        stream: Box<dyn Read + Send>,
        options: &B::Options,
        reading: &Reading,
    ) -> Result<Opened<B>, InputError> {
        let stream = Watched::stream(stream, &self.path, reading);
        let watch = Arc::clone(&stream.watch);
        let reader = start_stream(self.format, stream, options)?;
        Ok(Opened { reader, watch })
    }
}

/// A blocking stream of the records of several files: [`PointSource`](crate::input::PointSource),
/// [`SegmentSource`](crate::input::SegmentSource) and [`SiteSource`](crate::input::SiteSource) tell what they read.
pub struct Source<B: Records> {
    /// The inputs that are left.
    inputs: VecDeque<Input<B>>,
    /// All inputs.
    pub(super) all: Vec<(Arc<Path>, B::Format)>,
    pub(super) options: B::Options,
    pub(super) totals: B::Totals,
    /// Records handed out.
    pub(super) records: u64,
    has_z: bool,
    pub(super) crs: Option<String>,
    notes: Vec<String>,
    /// The sum of the files' sizes, if all inputs are regular files.
    pub(super) total_bytes: Option<u64>,
    /// All inputs, if each one can be read in any order.
    pub(super) random_access: Option<Vec<(Arc<Path>, RandomAccess)>>,
    pub(super) stamps: Vec<(PathBuf, FileStamp)>,
    pub(super) reading: Reading,
    bytes_read: u64,
    /// Bytes and records of the inputs that are done.
    done_bytes: u64,
    done_records: u64,
    /// Name and records of each input that is done.
    pub(super) done: Vec<(String, u64)>,
}

impl<B: Records> Source<B> {
    /// A source without inputs.
    pub(super) fn new(options: B::Options) -> Self {
        Self {
            inputs: VecDeque::new(),
            all: Vec::new(),
            options,
            totals: B::Totals::default(),
            records: 0,
            has_z: false,
            crs: None,
            notes: Vec::new(),
            total_bytes: Some(0),
            random_access: Some(Vec::new()),
            stamps: Vec::new(),
            reading: Reading::default(),
            bytes_read: 0,
            done_bytes: 0,
            done_records: 0,
            done: Vec::new(),
        }
    }

    /// A source of files whose formats their names tell, by this function. Looks at each one's beginning.
    pub(super) fn of_files(
        paths: &[PathBuf],
        options: B::Options,
        format: fn(&Path) -> Option<B::Format>,
        kind: RecordKind,
    ) -> Result<Self, InputError> {
        let format = |path: &PathBuf| match format(path) {
            Some(format) => Ok(format),
            None => Err(InputError::UnknownFormat {
                path: path.clone(),
                kind,
            }),
        };
        let formats: Vec<B::Format> = paths.iter().map(format).collect::<Result<_, _>>()?;
        let mut source = Self::new(options);
        for (path, format) in paths.iter().zip(formats) {
            source.add_file(path, format)?;
        }
        Ok(source)
    }

    /// Looks at a file, which comes behind those that were added before.
    pub(super) fn add_file(&mut self, path: &Path, format: B::Format) -> Result<(), InputError> {
        let mut input = Input::new(path, format);
        let opened = input.open(&self.options, &self.reading)?;
        self.add(input, opened);
        Ok(())
    }

    /// Adds an input that was looked at.
    pub(super) fn add(&mut self, mut input: Input<B>, opened: Opened<B>) {
        self.has_z |= opened.reader.has_z();
        self.total_bytes = self.total_bytes.zip(input.size()).map(|(sum, size)| sum + size);
        self.note_stamp(&opened);
        self.take_crs(&opened);
        match (&mut self.random_access, opened.reader.random_access()) {
            (Some(files), Some(access)) => files.push((input.path.clone(), access)),
            _ => self.random_access = None,
        }
        input.expected = opened.reader.expected();
        // What can be read only once stays open.
        let keep = self.inputs.is_empty() || input.stamp.is_none();
        input.opened = keep.then_some(opened);
        self.all.push((input.path.clone(), input.format));
        self.inputs.push_back(input);
    }

    /// Notes a file, if it is one, as it was when it was looked at.
    pub(super) fn note_stamp(&mut self, opened: &Opened<B>) {
        note(&mut self.stamps, &opened.watch);
    }

    fn take_crs(&mut self, opened: &Opened<B>) {
        if self.crs.is_none() {
            self.crs = opened.reader.crs().map(str::to_owned);
        }
    }

    /// Clears the batch and fills it with the next records, 8192 or less; false if there are none left.
    ///
    /// # Errors
    /// A record that is not what it should be, unless the options pass over it; a file that is broken, cannot be read or
    /// has changed since it was opened. An error ends the stream: what comes after it is false.
    pub fn next_batch(&mut self, batch: &mut B) -> Result<bool, InputError> {
        batch.clear();
        let filled = self.fill(batch);
        if filled.is_err() {
            self.inputs.clear();
            batch.clear();
        }
        self.records += batch.len() as u64;
        filled.map(|()| !batch.is_empty())
    }

    fn fill(&mut self, batch: &mut B) -> Result<(), InputError> {
        while let Some(mut input) = self.inputs.pop_front() {
            self.reading.check()?;
            let mut opened = match input.opened.take() {
                Some(opened) => opened,
                None => input.open(&self.options, &self.reading)?,
            };
            let filled = opened.reader.fill(&mut Sink {
                batch,
                totals: &mut self.totals,
                options: &self.options,
                path: &input.path,
                wants_z: self.has_z,
                before: self.records,
            });
            let taken = opened.watch.taken();
            // A reader that seeks may take some bytes twice, and need not take all.
            self.bytes_read = self.done_bytes + input.size().map_or(taken, |size| size.min(taken));
            let has_more = filled.map_err(|error| opened.watch.explain(error))?;
            self.totals.add(batch, &opened.reader.tally());
            if has_more {
                input.opened = Some(opened);
                self.inputs.push_front(input);
                return Ok(());
            }
            opened.watch.check()?;
            self.end_file(&input, &opened, batch.len());
            if !B::SPANS_FILES && !batch.is_empty() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Sums up an input that is done; `in_batch` records were not handed out yet.
    fn end_file(&mut self, input: &Input<B>, opened: &Opened<B>, in_batch: usize) {
        self.done_bytes += input.size().unwrap_or(opened.watch.taken());
        self.bytes_read = self.done_bytes;
        self.take_crs(opened);
        let before = self.done_records;
        let by_now = self.records + in_batch as u64;
        self.done_records = self.totals.end_file(&opened.reader.tally(), by_now);
        let name = input.path.file_name().unwrap_or(input.path.as_os_str());
        let name = name.to_string_lossy().into_owned();
        self.done.push((name, self.done_records - before));
        self.notes.extend(opened.reader.notes());
        self.notes.extend(self.totals.notes(&input.path));
    }

    /// How many records are still to come, as far as the inputs' beginnings tell; `None` if one tells nothing.
    pub(super) fn expected(&self) -> Option<u64> {
        let left = |input: &Input<B>| match &input.opened {
            Some(opened) => opened.reader.expected(),
            None => input.expected,
        };
        self.inputs
            .iter()
            .try_fold(0u64, |sum, input| Some(sum.saturating_add(left(input)?)))
    }

    /// Whether the batches have z: if any input has, by its header or its first record.
    #[must_use]
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// The inputs that are done, in order: the name of each, without its folder, and how many records it had. Of
    /// segments these are lines.
    #[must_use]
    pub fn sources(&self) -> &[(String, u64)] {
        &self.done
    }

    /// What a person should know about the inputs that are done, such as which columns were not read.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Bytes taken from the inputs so far, for progress: of compressed files the compressed ones.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read
    }

    /// How far the reading is, and the way to stop it.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// The regular files among the inputs, as they were when they were looked at.
    #[must_use]
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        &self.stamps
    }
}

impl<B: Records> fmt::Debug for Source<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inputs: Vec<&Path> = self.inputs.iter().map(|input| &*input.path).collect();
        f.debug_struct("Source")
            .field("inputs", &inputs)
            .field("records", &self.records)
            .field("has_z", &self.has_z)
            .finish_non_exhaustive()
    }
}
