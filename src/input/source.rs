//! The stream of batches over all inputs.
//!
//! State on open: every file was looked at (header or first record) and closed again, but the first one and those that
//! can be read only once (standard input, pipes), which wait opened. State while reading: one reader, and the inputs
//! that are left. A failure ends the stream.

use super::bytes::ByteInput;
use super::files::name_of;
use super::poly::{no_points, open_node_beside};
use super::reader::Reader;
use super::sample::{RandomAccess, sample};
use super::sink::Sink;
use super::watch::{FileStamp, Reading, Watch, Watched, note};
use super::{Format, InputCounts, InputError, InputOptions, PointBatch};
use crate::geometry::Point;
use crate::shown;
use std::collections::VecDeque;
use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An input and, if it is open, its reader.
struct Input {
    path: Arc<Path>,
    format: Option<Format>,
    /// What it was when it was looked at; `None` of streams.
    stamp: Option<FileStamp>,
    /// The points that it claimed when it was looked at.
    expected: Option<u64>,
    opened: Option<Opened>,
}

struct Opened {
    reader: Box<dyn Reader>,
    watch: Arc<Watch>,
    /// Points without z that got 0.
    padded: u64,
}

/// A blocking stream of the points of several files, which together are one set.
///
/// ```
/// use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("points.f64");
/// std::fs::write(&path, [1.5f64.to_le_bytes(), 2.5f64.to_le_bytes()].concat())?;
///
/// let mut source = PointSource::open(&[path], &InputOptions::default())?;
/// let mut batch = PointBatch::default();
/// while source.next_batch(&mut batch)? {
///     for (point, record) in batch.points.iter().zip(&batch.records) {
///         println!("{record}: {} {}", point.x, point.y);
///     }
/// }
/// assert_eq!(source.counts().points, 1);
/// # Ok(())
/// # }
/// ```
pub struct PointSource {
    inputs: VecDeque<Input>,
    options: InputOptions,
    counts: InputCounts,
    notes: Vec<String>,
    has_z: bool,
    crs: Option<String>,
    total_bytes: Option<u64>,
    /// All inputs, if each one can be read in any order.
    files: Option<Vec<(Arc<Path>, RandomAccess)>>,
    identity: Option<String>,
    stamps: Vec<(PathBuf, FileStamp)>,
    reading: Reading,
    /// Bytes of the inputs that are done.
    done_bytes: u64,
    /// Name and records of each input that is done.
    done: Vec<(String, u64)>,
}

impl PointSource {
    /// Opens the inputs in this order and looks at each one's beginning. A path `-` is standard input.
    ///
    /// Standard input needs [`InputOptions::format`], or is taken for GeoJSON if it begins with a brace, else for text.
    ///
    /// # Errors
    /// An input that does not exist, has no known format, or is broken at its beginning; options that are not possible.
    pub fn open(paths: &[PathBuf], options: &InputOptions) -> Result<Self, InputError> {
        let mut source = Self::new(options)?;
        let is_standard_input = |path: &&PathBuf| path.as_os_str() == "-";
        if paths.iter().filter(is_standard_input).count() > 1 {
            return Err(InputError::Option {
                option: "an input",
                value: "-".to_owned(),
                expected: "standard input can be read only once".to_owned(),
            });
        }
        for path in paths {
            if is_standard_input(&path) {
                source.add_stream("standard input", Box::new(std::io::stdin()))?;
            } else {
                source.add_file(path)?;
            }
        }
        Ok(source)
    }

    /// Reads one stream, as [`Self::open`] does with standard input; `name` stands for it in messages.
    ///
    /// # Errors
    /// As for [`Self::open`]. LAS is not possible: it needs a file.
    pub fn from_reader(name: &str, reader: Box<dyn Read + Send>, options: &InputOptions) -> Result<Self, InputError> {
        let mut source = Self::new(options)?;
        source.add_stream(name, reader)?;
        Ok(source)
    }

    fn new(options: &InputOptions) -> Result<Self, InputError> {
        if !matches!(options.dims, 2 | 3) {
            return Err(InputError::Option {
                option: "--dims",
                value: options.dims.to_string(),
                expected: "it is 2 or 3".to_owned(),
            });
        }
        Ok(Self {
            inputs: VecDeque::new(),
            options: options.clone(),
            counts: InputCounts::default(),
            notes: Vec::new(),
            has_z: false,
            crs: None,
            total_bytes: Some(0),
            files: Some(Vec::new()),
            identity: Some(format!("{options:?}")),
            stamps: Vec::new(),
            reading: Reading::default(),
            done_bytes: 0,
            done: Vec::new(),
        })
    }

    fn add_file(&mut self, path: &Path) -> Result<(), InputError> {
        let Some(format) = self.options.format.or_else(|| Format::from_path(path)) else {
            return Err(InputError::UnknownFormat { path: path.to_owned() });
        };
        let mut input = Input::new(path, Some(format));
        let mut opened = input.open(&self.options, &self.reading)?;
        if opened.has_points_beside(format) {
            // From here on the file with the points stands for it, but a change of either is a change.
            self.add_identity(input.identity());
            note(&mut self.stamps, &opened.watch);
            (input, opened) = open_node_beside(path, |node| {
                let mut input = Input::new(node, Some(Format::Node));
                let opened = input.open(&self.options, &self.reading)?;
                Ok((input, opened))
            })?;
        }
        let once = input.stamp.is_none();
        let keep = self.inputs.is_empty() || once;
        self.add(input, opened, keep);
        Ok(())
    }

    fn add_stream(&mut self, name: &str, stream: Box<dyn Read + Send>) -> Result<(), InputError> {
        let input = Input::new(Path::new(name), self.options.format);
        let stream = Watched::stream(stream, &input.path, &self.reading);
        let opened = input.start(stream, &self.options)?;
        if input.format.is_some_and(|format| opened.has_points_beside(format)) {
            return Err(no_points(&input.path, "a stream has none".to_owned(), None));
        }
        self.add(input, opened, true);
        Ok(())
    }

    fn add(&mut self, mut input: Input, opened: Opened, keep: bool) {
        self.has_z |= opened.reader.has_z();
        self.total_bytes = self.total_bytes.zip(input.size()).map(|(sum, size)| sum + size);
        note(&mut self.stamps, &opened.watch);
        self.take_crs(&*opened.reader);
        self.add_identity(input.identity());
        match (&mut self.files, opened.reader.random_access()) {
            (Some(files), Some(access)) => files.push((input.path.clone(), access)),
            _ => self.files = None,
        }
        input.expected = opened.reader.expected_points();
        input.opened = keep.then_some(opened);
        self.inputs.push_back(input);
    }

    fn add_identity(&mut self, one: Option<String>) {
        match (&mut self.identity, one) {
            (Some(all), Some(one)) => all.extend(["\n", one.as_str()]),
            _ => self.identity = None,
        }
    }

    fn take_crs(&mut self, reader: &dyn Reader) {
        if self.crs.is_none() {
            self.crs = reader.crs().map(str::to_owned);
        }
    }

    /// Clears the batch and fills it with the next points, 8192 or a few less; false if there are none left.
    ///
    /// # Errors
    /// A record that is no valid point, unless [`InputOptions::skip_invalid`]; a file that is broken or cannot be read.
    /// An error ends the stream: what comes after it is false.
    pub fn next_batch(&mut self, batch: &mut PointBatch) -> Result<bool, InputError> {
        batch.clear();
        let result = self.fill(batch);
        if result.is_err() {
            self.inputs.clear();
            batch.clear();
        }
        result.map(|()| !batch.is_empty())
    }

    fn fill(&mut self, batch: &mut PointBatch) -> Result<(), InputError> {
        while let Some(mut input) = self.inputs.pop_front() {
            self.reading.check()?;
            let mut opened = match input.opened.take() {
                Some(opened) => opened,
                None => input.open(&self.options, &self.reading)?,
            };
            let mut sink = Sink {
                batch,
                counts: &mut self.counts,
                path: &input.path,
                skip_invalid: self.options.skip_invalid,
                wants_z: self.has_z,
                padded: &mut opened.padded,
                missing_z: self.options.missing_z,
            };
            let full = opened.reader.fill(&mut sink);
            let taken = opened.watch.taken();
            // A reader that seeks may take some bytes twice, and need not take all.
            let taken_of_size = input.size().map_or(taken, |size| size.min(taken));
            self.counts.bytes_read = self.done_bytes + taken_of_size;
            if full.map_err(|error| opened.watch.explain(error))? {
                input.opened = Some(opened);
                self.inputs.push_front(input);
                return Ok(());
            }
            opened.watch.check()?;
            self.done_bytes += input.size().unwrap_or(taken);
            self.counts.bytes_read = self.done_bytes;
            self.take_crs(&*opened.reader);
            let before: u64 = self.done.iter().map(|(_, records)| records).sum();
            self.done.push((name_of(&input.path), self.counts.records - before));
            self.notes.extend(opened.reader.notes());
            if opened.padded > 0 {
                self.notes.push(format!(
                    "{}: {} points without z got z = 0",
                    shown::path(&input.path),
                    opened.padded
                ));
            }
        }
        Ok(())
    }

    /// What was read so far.
    #[must_use]
    pub fn counts(&self) -> InputCounts {
        self.counts
    }

    /// The inputs that are done, in order: the name of each, without its folder, and how many records it had.
    #[must_use]
    pub fn sources(&self) -> &[(String, u64)] {
        &self.done
    }

    /// What a person should know about the inputs that are done, such as which columns were not read.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The sum of the file sizes; `None` if an input has none, as a pipe.
    #[must_use]
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// How many points are still to come, as far as the inputs' beginnings tell: raw f64 by the file's size, LAS, LAZ,
    /// `.node` and `.poly` by their headers. `None` if an input tells nothing, as text, GeoJSON, and raw f64 from a stream or gzip.
    ///
    /// An estimate, for plans and progress; 0 after an error. It is too high where records are withheld, filtered or invalid, and a header
    /// may claim anything up to [`u64::MAX`]: allocate nothing by it.
    #[must_use]
    pub fn expected_points(&self) -> Option<u64> {
        let left = |input: &Input| match &input.opened {
            Some(opened) => opened.reader.expected_points(),
            None => input.expected,
        };
        self.inputs
            .iter()
            .try_fold(0u64, |sum, input| Some(sum.saturating_add(left(input)?)))
    }

    /// About `count` points from all over the inputs, in input order, valid and normalized; the same for the same inputs.
    /// They are runs of some 16 neighbours, evenly spread over the records of all inputs, what was read already included.
    ///
    /// The stream is left as it is: the files are opened again, and at most some 4 MiB are read from them, so that very
    /// large counts (from 262144 on for pairs of f64) are not reached. Invalid points are left out without an error, as
    /// are those that the options leave out, so that there are fewer points, or none, where these are many.
    ///
    /// Empty unless every input can be read in any order, since a sample of some inputs would mislead. Raw f64 and LAS can;
    /// text, GeoJSON, `.node`, `.poly`, LAZ, gzip and streams cannot.
    ///
    /// # Errors
    /// A file that can no longer be opened or read.
    pub fn sample(&self, count: usize) -> Result<Vec<Point>, InputError> {
        let files = self.files.iter().flatten();
        sample(files.map(|(path, access)| (&**path, access)), count)
    }

    /// A text that tells these inputs and the options from others, so that work on them can be resumed: the options, and
    /// of each file its absolute path, size in bytes and time of modification in nanoseconds since 1970, as at open.
    /// `None` if an input is not a regular file. Only to be compared: what it looks like may change with the version.
    #[must_use]
    pub fn identity(&self) -> Option<String> {
        self.identity.clone()
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

    /// Bytes taken from the inputs so far, for progress: of compressed files the compressed ones.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.counts.bytes_read
    }

    /// Whether the batches have z: if any input has.
    #[must_use]
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// The coordinate reference system as the first input tells it that has one: WKT or `EPSG:…` from LAS, the name in
    /// the former `crs` member of GeoJSON. Nothing is computed from it. It may be known only when that input is done.
    #[must_use]
    pub fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }
}

impl fmt::Debug for PointSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inputs: Vec<&Path> = self.inputs.iter().map(|input| &*input.path).collect();
        f.debug_struct("PointSource")
            .field("inputs", &inputs)
            .field("counts", &self.counts)
            .field("has_z", &self.has_z)
            .finish_non_exhaustive()
    }
}

impl Opened {
    /// Whether this is a `.poly` file that says its points are in the file beside it.
    fn has_points_beside(&self, format: Format) -> bool {
        format == Format::Poly && self.reader.expected_points() == Some(0)
    }
}

impl Input {
    fn new(path: &Path, format: Option<Format>) -> Self {
        Self {
            path: path.into(),
            format,
            stamp: None,
            expected: None,
            opened: None,
        }
    }

    /// What tells the file from others, and from itself before a change.
    fn identity(&self) -> Option<String> {
        let path = std::path::absolute(&self.path).ok()?;
        let FileStamp { length, modified, .. } = self.stamp?;
        // Quoted, a path with line breaks in it cannot pass for two.
        Some(format!("{path:?} {length} {modified}"))
    }

    /// Its length in bytes, if it is a regular file.
    fn size(&self) -> Option<u64> {
        self.stamp.map(|stamp| stamp.length)
    }

    /// Opens the file and starts its reader. If it was open before, it must not have changed since.
    fn open(&mut self, options: &InputOptions, reading: &Reading) -> Result<Opened, InputError> {
        let file = Watched::open(&self.path, reading, self.stamp)?;
        let watch = Arc::clone(&file.watch);
        self.stamp = watch.stamp();
        let opened = match (self.format, watch.size()) {
            (Some(Format::Las), Some(size)) => las_reader(&self.path, file, size, options).map(|reader| Opened {
                reader,
                watch: Arc::clone(&watch),
                padded: 0,
            }),
            _ => self.start(file, options),
        };
        opened.map_err(|error| watch.explain(error))
    }

    /// Starts the reader of a stream.
    fn start(&self, stream: Watched<impl Read + Send + 'static>, options: &InputOptions) -> Result<Opened, InputError> {
        let watch = Arc::clone(&stream.watch);
        // Of formats but raw numbers no file can begin as gzip does.
        let by_magic = self.format != Some(Format::F64);
        let input = ByteInput::new(stream, by_magic)?;
        let format = self.format.unwrap_or_else(|| sniff(&input.head));
        Ok(Opened {
            reader: stream_reader(format, input, options)?,
            watch,
            padded: 0,
        })
    }
}

/// The format of a stream without a name.
fn sniff(head: &[u8]) -> Format {
    if head.starts_with(b"LASF") {
        Format::Las
    } else if head.trim_ascii_start().starts_with(b"{") {
        Format::GeoJson
    } else {
        Format::Text
    }
}

/// The reader of a format that is read as a stream.
fn stream_reader(format: Format, input: ByteInput, options: &InputOptions) -> Result<Box<dyn Reader>, InputError> {
    match format {
        Format::F64 => Ok(Box::new(super::raw::Raw::new(input, options)?)),
        Format::Node => Ok(Box::new(super::node::Node::new(input)?)),
        Format::Poly => Ok(Box::new(super::node::Node::of_poly(input)?)),
        #[cfg(feature = "text")]
        Format::Text => Ok(Box::new(super::text::Text::new(input, options)?)),
        #[cfg(feature = "geojson")]
        Format::GeoJson => Ok(Box::new(super::geojson::GeoJson::of_points(input)?)),
        #[cfg(feature = "las")]
        Format::Las => Err(super::las::no_stream(&input.path)),
        #[cfg(not(all(feature = "text", feature = "geojson", feature = "las")))]
        absent => Err(missing(&input.path, absent)),
    }
}

#[cfg(feature = "las")]
use super::las::open as las_reader;

#[cfg(not(feature = "las"))]
fn las_reader(
    path: &Path,
    _: Watched<Arc<std::fs::File>>,
    _: u64,
    _: &InputOptions,
) -> Result<Box<dyn Reader>, InputError> {
    Err(missing(path, Format::Las))
}

#[cfg(not(all(feature = "text", feature = "geojson", feature = "las")))]
pub(super) fn missing(path: &Path, format: Format) -> InputError {
    InputError::MissingFeature {
        path: path.to_owned(),
        what: format.to_string(),
        feature: match format {
            Format::Las => "las",
            Format::GeoJson => "geojson",
            _ => "text",
        },
    }
}
