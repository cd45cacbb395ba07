//! The stream of batches over all inputs, for records of any kind.
//!
//! After open, every file was examined (header or first record) and closed again, except the first
//! file and those that can be read only once (standard input, pipes); these stay open. While
//! reading, the state is one reader and the remaining inputs. An error ends the stream.

use crate::geometry::Rect;
use crate::input::about::About;
use crate::input::bytes::ByteInput;
use crate::input::content;
use crate::input::error::{InputError, RecordKind};
use crate::input::format::Format;
use crate::input::reader::{Batch, Reader, Sink, Started, Totals};
use crate::input::sample::RandomAccess;
use crate::input::watch::{FileStamp, Reading, Watch, Watched, note};
use std::collections::VecDeque;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The records of one kind, and the formats from which they are read.
pub trait Records: Batch {
    /// The format of a file.
    type Format: Copy;

    /// Whether a batch may contain records of several files.
    const SPANS_FILES: bool;

    /// Returns the format that the content of a file must not contradict; `None` if any bytes may
    /// begin a file of this format.
    fn content(format: Self::Format) -> Option<Format>;

    /// Returns whether a file of this format that begins with gzip's magic number is gzip. Only
    /// files of raw numbers can begin so without being gzip.
    fn may_be_gzip(format: Self::Format) -> bool;

    /// Starts the reader of `input`, which is decompressed.
    fn start(format: Self::Format, input: ByteInput, options: &Self::Options) -> Started<Self>;

    /// Starts the reader of a file. Differs from [`start`](Self::start) for formats whose reader
    /// has to seek.
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
    let input = ByteInput::new(stream, B::may_be_gzip(format))?;
    if let Some(format) = B::content(format).filter(|_| input.was_gzip) {
        content::check_unzipped(&input, format)?;
    }
    B::start(format, input, options)
}

/// An input and, if it is open, its reader.
pub struct Input<B: Records> {
    pub path: Arc<Path>,
    format: B::Format,
    /// The stamp of the file when it was examined; `None` for streams.
    stamp: Option<FileStamp>,
    /// The stamps of the files beside it when it was examined.
    beside: Vec<(PathBuf, FileStamp)>,
    /// The number of records that the file claimed when it was examined, and where they are.
    expected: Option<u64>,
    pub extent: Option<Rect>,
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
            beside: Vec::new(),
            expected: None,
            extent: None,
            opened: None,
        }
    }

    /// Returns the length in bytes of a regular file.
    pub fn size(&self) -> Option<u64> {
        self.stamp.map(|stamp| stamp.length)
    }

    /// Opens the file and starts its reader. If it was opened before, it must not have changed
    /// since.
    pub fn open(&mut self, options: &B::Options, reading: &Reading) -> Result<Opened<B>, InputError> {
        let file = Watched::open(&self.path, reading, self.stamp)?;
        let watch = Arc::clone(&file.watch);
        self.stamp = watch.stamp();
        if let Some(format) = B::content(self.format) {
            content::check(&self.path, format, &file.head())?;
        }
        let reader = B::start_file(self.format, file, options).map_err(|error| watch.explain(error))?;
        watch.check_beside(&self.beside)?;
        self.beside = watch.stamps_beside();
        Ok(Opened { reader, watch })
    }

    /// Returns a reader of records in memory as open.
    #[cfg(feature = "wkb")]
    pub fn open_reader(&self, reader: Box<dyn Reader<B>>, reading: &Reading) -> Opened<B> {
        let Watched { watch, .. } = Watched::stream((), &self.path, reading);
        Opened { reader, watch }
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

impl<B: Records> Input<B> {
    /// Returns the number of records that remain, as estimated.
    pub fn expected(&self) -> Option<u64> {
        match &self.opened {
            Some(opened) => opened.reader.expected(),
            None => self.expected,
        }
    }
}

/// A blocking stream of the records of several files. See
/// [`PointSource`](crate::input::PointSource), [`SegmentSource`](crate::input::SegmentSource) and
/// [`SiteSource`](crate::input::SiteSource) for what they read.
pub struct Source<B: Records> {
    /// The inputs that remain to be read.
    pub(super) inputs: VecDeque<Input<B>>,
    /// All inputs.
    pub(super) all: Vec<(Arc<Path>, B::Format)>,
    pub(super) options: B::Options,
    pub(super) totals: B::Totals,
    /// The number of records handed out.
    pub(super) records: u64,
    pub(super) has_z: bool,
    /// The coordinate reference system of each file that names one, as far as it is known.
    crs: Vec<(PathBuf, String)>,
    notes: Vec<String>,
    /// What the input that ended last says of itself.
    about: Box<About>,
    /// The sum of the file sizes, if all inputs are regular files.
    pub(super) total_bytes: Option<u64>,
    /// The access to all inputs, if each of them can be read in any order.
    pub(super) random_access: Option<Vec<(Arc<Path>, RandomAccess)>>,
    pub(super) stamps: Vec<(PathBuf, FileStamp)>,
    pub(super) reading: Reading,
    bytes_read: u64,
    /// The number of bytes and of records of the inputs that have ended.
    done_bytes: u64,
    pub(super) done_records: u64,
    /// The name and the number of records of each input that has ended.
    pub(super) done: Vec<(String, u64)>,
}

impl<B: Records> Source<B> {
    /// Creates a source without inputs.
    pub(super) fn new(options: B::Options) -> Self {
        Self {
            inputs: VecDeque::new(),
            all: Vec::new(),
            options,
            totals: B::Totals::default(),
            records: 0,
            has_z: false,
            crs: Vec::new(),
            notes: Vec::new(),
            about: Box::default(),
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

    /// Opens files whose formats `format` derives from their names, and examines the beginning of
    /// each.
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

    /// Opens and examines a file, and adds it after the inputs that were added before.
    pub(super) fn add_file(&mut self, path: &Path, format: B::Format) -> Result<(), InputError> {
        let mut input = Input::new(path, format);
        let opened = input.open(&self.options, &self.reading)?;
        self.add(input, opened);
        Ok(())
    }

    /// Adds an input that was examined.
    pub(super) fn add(&mut self, mut input: Input<B>, opened: Opened<B>) {
        self.has_z |= opened.reader.has_z();
        self.total_bytes = self.total_bytes.zip(input.size()).map(|(sum, size)| sum + size);
        self.note_stamp(&opened);
        self.take_crs(&input.path, &opened);
        match (&mut self.random_access, opened.reader.random_access()) {
            (Some(files), Some(access)) => files.push((input.path.clone(), access)),
            _ => self.random_access = None,
        }
        input.expected = opened.reader.expected();
        input.extent = opened.reader.expected_extent();
        // An input that can be read only once stays open.
        let keep = self.inputs.is_empty() || input.stamp.is_none();
        input.opened = keep.then_some(opened);
        self.all.push((input.path.clone(), input.format));
        self.inputs.push_back(input);
    }

    /// Records the stamp of a file as it was when it was examined, if it is a regular file.
    pub(super) fn note_stamp(&mut self, opened: &Opened<B>) {
        note(&mut self.stamps, &opened.watch);
    }

    fn take_crs(&mut self, path: &Path, opened: &Opened<B>) {
        let is_known = self.crs.iter().any(|(of, _)| of == path);
        if let Some(crs) = opened.reader.crs().filter(|_| !is_known) {
            self.crs.push((path.to_owned(), crs.to_owned()));
        }
    }

    /// Clears the batch and fills it with the next records, at most 8192. Returns false if no
    /// records are left.
    ///
    /// # Errors
    /// Fails if a record is invalid, unless the options skip such records, or if a file is broken,
    /// cannot be read or has changed since it was opened. An error ends the stream: later calls
    /// return false.
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
            // A reader that seeks may read some bytes twice, and need not read all bytes.
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

    /// Adds up the counts of an input that has ended; `in_batch` records were not handed out yet.
    fn end_file(&mut self, input: &Input<B>, opened: &Opened<B>, in_batch: usize) {
        self.done_bytes += input.size().unwrap_or(opened.watch.taken());
        self.bytes_read = self.done_bytes;
        self.take_crs(&input.path, opened);
        let before = self.done_records;
        let by_now = self.records + in_batch as u64;
        self.done_records = self.totals.end_file(&opened.reader.tally(), by_now);
        let name = input.path.file_name().unwrap_or(input.path.as_os_str());
        let name = name.to_string_lossy().into_owned();
        self.done.push((name, self.done_records - before));
        self.notes.extend(opened.reader.notes());
        *self.about = opened.reader.about();
        self.notes.extend(self.totals.notes(&input.path));
    }

    /// Returns the number of records that remain, as estimated from the beginnings of the inputs;
    /// `None` if an input gives no estimate.
    pub(super) fn expected(&self) -> Option<u64> {
        self.inputs
            .iter()
            .try_fold(0u64, |sum, input| Some(sum.saturating_add(input.expected()?)))
    }

    /// Returns whether the batches have z. They do if any input has z according to its header or
    /// first record.
    #[must_use]
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// Returns the inputs that have ended, in order: the file name of each, without its folder, and
    /// its number of records. For segments this is the number of lines.
    #[must_use]
    pub fn sources(&self) -> &[(String, u64)] {
        &self.done
    }

    /// Returns the files that name a coordinate reference system, with the text that names it; see
    /// [`Crs`](crate::crs::Crs). A GeoJSON file that names it behind its features is listed when the
    /// file has ended, all others from the start.
    #[must_use]
    pub fn crs_of_files(&self) -> &[(PathBuf, String)] {
        &self.crs
    }

    /// Returns notes for the user about the inputs that have ended, for instance which columns were
    /// not read.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns what the input that ended last says of itself.
    pub(in crate::input) fn about(&self) -> &About {
        &self.about
    }

    /// Returns the number of bytes taken from the inputs so far, for progress. In a compressed
    /// file, compressed bytes count.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read
    }

    /// Returns the [`Reading`], which shows the progress and stops the reading.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Returns the regular files among the inputs, with their stamps when they were examined.
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
