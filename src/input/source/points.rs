//! The source of points: the reader of each format, and the methods that only sources of points
//! have.

use crate::geometry::{Point, Rect};
use crate::input::bytes::ByteInput;
use crate::input::content;
use crate::input::error::{InputError, Location, NOT_COPC, RecordKind};
use crate::input::format::Format;
#[cfg(feature = "las")]
use crate::input::formats::las;
use crate::input::formats::node::Node;
#[cfg(feature = "parquet")]
use crate::input::formats::parquet;
use crate::input::formats::poly::{no_points, open_node_beside};
use crate::input::formats::raw;
use crate::input::formats::shapes;
#[cfg(feature = "text")]
use crate::input::formats::text;
use crate::input::formats::vector::Vector;
use crate::input::formats::{obj, ply};
use crate::input::options::InputOptions;
use crate::input::points::{InputCounts, PointBatch};
use crate::input::reader::Started;
use crate::input::sample::sample;
use crate::input::source::stream::{Input, Opened, Records, Source, start_stream};
use crate::input::watch::{Reading, Watched};
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A blocking stream of the points of several files, which together form one set.
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
pub type PointSource = Source<PointBatch>;

impl Records for PointBatch {
    /// `None` for standard input without a chosen format: its first bytes determine the format.
    type Format = Option<Format>;

    const SPANS_FILES: bool = true;

    fn content(format: Option<Format>) -> Option<Format> {
        format.filter(|format| *format != Format::F64)
    }

    fn may_be_gzip(format: Option<Format>) -> bool {
        format != Some(Format::F64)
    }

    fn start(format: Option<Format>, input: ByteInput, options: &InputOptions) -> Started<Self> {
        let format = format
            .or_else(|| content::recognise(&input.head))
            .unwrap_or(Format::Text);
        check_levels(format, &input.path, options)?;
        match format {
            Format::F64 => Ok(Box::new(raw::Points::new(input, options)?)),
            Format::Node => Ok(Box::new(Node::new(input)?)),
            Format::Poly => Ok(Box::new(Node::of_poly(input)?)),
            Format::Ply => Ok(Box::new(ply::Points::new(input)?)),
            Format::Obj => Ok(Box::new(obj::Points::new(input)?)),
            #[cfg(feature = "text")]
            Format::Text => Ok(Box::new(text::Points::new(
                input,
                options.columns.as_ref(),
                options.decoding_threads(),
            )?)),
            Format::GeoJson => start_vector(Vector::GeoJson, input),
            Format::FlatGeobuf => start_vector(Vector::FlatGeobuf, input),
            Format::Shapefile => start_vector(Vector::Shapefile, input),
            Format::GeoPackage => start_vector(Vector::GeoPackage, input),
            #[cfg(feature = "las")]
            Format::Las => Err(las::no_stream(&input.path)),
            #[cfg(feature = "parquet")]
            Format::Parquet => Err(parquet::no_stream(&input.path)),
            #[cfg(not(all(feature = "text", feature = "las", feature = "parquet")))]
            absent => Err(absent.missing(&input.path)),
        }
    }

    fn start_file(format: Option<Format>, file: Watched<Arc<File>>, options: &InputOptions) -> Started<Self> {
        if let Some(format) = format {
            check_levels(format, &file.watch.path, options)?;
        }
        match (format, file.watch.size()) {
            #[cfg(feature = "las")]
            (Some(Format::Las), Some(size)) => las::open(file, size, options),
            #[cfg(not(feature = "las"))]
            (Some(Format::Las), Some(_)) => Err(Format::Las.missing(&file.watch.path)),
            (Some(Format::GeoPackage), Some(_)) => {
                let path = Arc::clone(&file.watch.path);
                let shapes = Vector::GeoPackage.start_file(file)?;
                Ok(Box::new(shapes::Points::new(shapes, &path)?))
            }
            #[cfg(feature = "parquet")]
            (Some(Format::Parquet), Some(size)) => parquet::open(file, size, options),
            #[cfg(not(feature = "parquet"))]
            (Some(Format::Parquet), Some(_)) => Err(Format::Parquet.missing(&file.watch.path)),
            _ => start_stream(format, file, options),
        }
    }
}

/// Fails if the options select levels of an octree, and files of this format have none.
fn check_levels(format: Format, path: &Path, options: &InputOptions) -> Result<(), InputError> {
    if options.selects_levels() && format != Format::Las {
        return Err(InputError::malformed(path, Location::File, NOT_COPC.0, NOT_COPC.1));
    }
    Ok(())
}

fn start_vector(vector: Vector, input: ByteInput) -> Started<PointBatch> {
    let path = Arc::clone(&input.path);
    Ok(Box::new(shapes::Points::new(vector.start(input)?, &path)?))
}

/// Returns whether this is a `.poly` file that refers to the file with points beside it.
fn has_points_beside(format: Option<Format>, opened: &Opened<PointBatch>) -> bool {
    format == Some(Format::Poly) && opened.reader.expected() == Some(0)
}

/// Returns positions that are evenly spread over a rectangle, however many of them are taken: the sequence
/// R2 of Roberts, *The unreasonable effectiveness of quasirandom sequences* (2018).
fn spread(extent: Rect) -> impl Iterator<Item = Point> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let (width, height) = extent.size();
    (1u32..).map(move |number| {
        let [x, y] = STEPS.map(|step| (f64::from(number) * step).fract());
        Point::new(extent.min_x + x * width, extent.min_y + y * height).normalized()
    })
}

impl Source<PointBatch> {
    /// Opens the inputs in this order and examines the beginning of each. A path `-` means standard
    /// input.
    ///
    /// The format of an input is [`InputOptions::format`], otherwise the one that its name
    /// indicates, otherwise the one of its first bytes. Standard input whose first bytes indicate
    /// none is text.
    ///
    /// # Errors
    /// Fails if an input does not exist, has no known format or is broken at its beginning, or if
    /// an option has an invalid value.
    pub fn open(paths: &[PathBuf], options: &InputOptions) -> Result<Self, InputError> {
        let mut source = Self::with_options(options)?;
        let is_standard_input = |path: &&PathBuf| path.as_os_str() == "-";
        if paths.iter().filter(is_standard_input).count() > 1 {
            return Err(InputError::Option {
                option: "input",
                value: "-".to_owned(),
                expected: "standard input can be read only once".to_owned(),
            });
        }
        for path in paths {
            if is_standard_input(&path) {
                source.add_stream("standard input", Box::new(std::io::stdin()))?;
            } else {
                source.add_points(path)?;
            }
        }
        Ok(source)
    }

    /// Reads one stream, as [`Self::open`] does with standard input. Messages use `name` as its
    /// name.
    ///
    /// # Errors
    /// As for [`Self::open`]. LAS is an error: it needs a file.
    pub fn from_reader(name: &str, reader: Box<dyn Read + Send>, options: &InputOptions) -> Result<Self, InputError> {
        let mut source = Self::with_options(options)?;
        source.add_stream(name, reader)?;
        Ok(source)
    }

    /// Opens one file, whose reading `reading` follows and stops.
    pub(in crate::input) fn open_followed(
        path: &Path,
        options: &InputOptions,
        reading: &Reading,
    ) -> Result<Self, InputError> {
        let mut source = Self::with_options(options)?;
        source.reading = reading.clone();
        source.add_points(path)?;
        Ok(source)
    }

    fn with_options(options: &InputOptions) -> Result<Self, InputError> {
        if !matches!(options.dims, 2 | 3) {
            return Err(InputError::Option {
                option: "dims",
                value: options.dims.to_string(),
                expected: "expected 2 or 3".to_owned(),
            });
        }
        if let Some(resolution) = options.copc_resolution
            && !(resolution.is_finite() && resolution > 0.0)
        {
            return Err(InputError::Option {
                option: "copc_resolution",
                value: resolution.to_string(),
                expected: "expected a finite number above 0".to_owned(),
            });
        }
        Ok(Self::new(options.clone()))
    }

    fn add_points(&mut self, path: &Path) -> Result<(), InputError> {
        let Some(format) = self.options.format.or_else(|| content::format_of(path)) else {
            return Err(InputError::UnknownFormat {
                path: path.to_owned(),
                kind: RecordKind::Point,
            });
        };
        let mut input = Input::new(path, Some(format));
        let opened = input.open(&self.options, &self.reading)?;
        if !has_points_beside(Some(format), &opened) {
            self.add(input, opened);
            return Ok(());
        }
        // From here on the file with the points replaces this one, but a change of either is an
        // error.
        self.note_stamp(&opened);
        open_node_beside(path, |node| self.add_file(node, Some(Format::Node)))
    }

    fn add_stream(&mut self, name: &str, stream: Box<dyn Read + Send>) -> Result<(), InputError> {
        let format = self.options.format;
        let input = Input::new(Path::new(name), format);
        let opened = input.open_stream(stream, &self.options, &self.reading)?;
        if has_points_beside(format, &opened) {
            return Err(no_points(&input.path, "a stream has none".to_owned(), None));
        }
        self.add(input, opened);
        Ok(())
    }

    /// Returns the counts so far.
    #[must_use]
    pub fn counts(&self) -> InputCounts {
        InputCounts {
            records: self.totals.counts.records - self.totals.first_record,
            bytes_read: self.bytes_read(),
            ..self.totals.counts
        }
    }

    /// Returns the sum of the file sizes; `None` if an input has no size, for instance a pipe.
    #[must_use]
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// Returns the number of points that remain, as estimated from the beginnings of the inputs:
    /// for raw f64 from the file's size, for LAS, LAZ, `.node`, `.poly`, PLY and most Parquet files
    /// from the header, for COPC from the nodes that the options select. Returns `None` if an input gives no estimate: text, GeoJSON, OBJ, and raw f64
    /// from a stream or gzip.
    ///
    /// This is an estimate for planning and progress, and 0 after an error. It is too high where
    /// records are withheld, filtered or invalid. A header may claim any number up to [`u64::MAX`],
    /// so do not allocate memory according to it.
    #[must_use]
    pub fn expected_points(&self) -> Option<u64> {
        self.expected()
    }

    /// Returns the number of records of each input that remains, as
    /// [`expected_points`](Self::expected_points) has it of all of them.
    #[must_use]
    pub fn expected_records(&self) -> Vec<Option<u64>> {
        self.inputs.iter().map(Input::expected).collect()
    }

    /// Returns about `count` positions where points may be: evenly spread over the rectangles that the
    /// inputs announce, as many in each as it announces points, valid and normalized. The result is empty
    /// unless all inputs announce both. LAS and LAZ do. It serves in place of a [sample](Self::sample)
    /// where there is none.
    #[must_use]
    pub fn expected_positions(&self, count: usize) -> Vec<Point> {
        let Some(total) = self.expected().filter(|&total| total > 0) else {
            return Vec::new();
        };
        let mut positions = Vec::new();
        for input in &self.inputs {
            let (Some(points), Some(extent)) = (input.expected(), input.extent) else {
                return Vec::new();
            };
            let share = (u128::from(points) * count as u128).div_ceil(u128::from(total));
            positions.extend(spread(extent).take(share as usize));
        }
        let bounds = self.options.bounds;
        positions.retain(|&point| point.is_valid() && bounds.is_none_or(|bounds| bounds.contains(point)));
        positions
    }

    /// Makes these inputs a part of more inputs: the first record gets the number `first_record`, and
    /// batches have z if `has_z` says that the others do. The points are those that all inputs would give
    /// here.
    ///
    /// ```
    /// use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let dir = tempfile::tempdir()?;
    /// let paths = [dir.path().join("a.f64"), dir.path().join("b.f64")];
    /// for path in &paths {
    ///     std::fs::write(path, [1.5f64.to_le_bytes(), 2.5f64.to_le_bytes()].concat())?;
    /// }
    /// let all = PointSource::open(&paths, &InputOptions::default())?;
    /// assert_eq!(all.expected_records(), [Some(1), Some(1)]);
    /// let second = PointSource::open(&paths[1..], &InputOptions::default())?;
    /// let mut second = second.as_part(1, all.has_z());
    /// let mut batch = PointBatch::default();
    /// second.next_batch(&mut batch)?;
    /// assert_eq!((batch.records, second.counts().records), (vec![1], 1));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn as_part(mut self, first_record: u64, has_z: bool) -> Self {
        self.has_z |= has_z;
        self.totals.first_record = first_record;
        self.totals.counts.records = first_record;
        self.done_records = first_record;
        self
    }

    /// Returns about `count` points from all parts of the inputs, in input order, valid and
    /// normalized. The same inputs give the same points. They are runs of about 16 neighbours,
    /// evenly spread over the records of all inputs, including records that were already read.
    ///
    /// The position of the stream does not change: this opens the files again and reads at most
    /// about 4 MiB from them. Very large counts (from 262144 on for pairs of f64) are therefore not
    /// reached. Invalid points and points that the options exclude are left out without an error,
    /// so there are fewer points, or none, where these are many.
    ///
    /// The result is empty unless every input can be read in any order, since a sample of only some
    /// inputs would mislead. Raw f64, LAS and binary PLY without lists before the
    /// end of the vertices can be read in any order; all others, gzip and streams cannot.
    ///
    /// # Errors
    /// Fails if a file can no longer be opened or read.
    pub fn sample(&self, count: usize) -> Result<Vec<Point>, InputError> {
        let files = self.random_access.iter().flatten();
        let mut points = sample(files.map(|(path, access)| (&**path, access)), count)?;
        points.retain(|&point| self.options.bounds.is_none_or(|bounds| bounds.contains(point)));
        Ok(points)
    }

    /// Returns a text that identifies these inputs and the options, so that work on them can be
    /// resumed. It contains the options, but for the number of threads, and, for each file, its
    /// absolute path, size in bytes and time of modification in nanoseconds since 1970, as at open.
    /// Returns `None` if an input is not a regular file. Use the text only for comparison: its form
    /// may change between versions.
    #[must_use]
    pub fn identity(&self) -> Option<String> {
        self.total_bytes?;
        let mut identity = format!("{:?}", self.options.clone().threads(0));
        for (path, stamp) in &self.stamps {
            let path = std::path::absolute(path).ok()?;
            // The path is quoted, so that a path with line breaks cannot look like two paths.
            write!(identity, "\n{path:?} {} {}", stamp.length, stamp.modified).ok()?;
        }
        Some(identity)
    }
}
