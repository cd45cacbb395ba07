//! The reader of points in Parquet files.

use crate::input::about::{About, Field, MOST_FIELDS};
use crate::input::caught::catch;
use crate::input::error::{InputError, Location};
use crate::input::flaw::Flaw;
use crate::input::formats::parquet::choice::{Choice, Layout};
use crate::input::formats::parquet::chunks::Chunks;
use crate::input::formats::parquet::column::Column;
use crate::input::formats::parquet::metadata::{self, Problem};
use crate::input::formats::parquet::wkb;
use crate::input::options::InputOptions;
use crate::input::points::PointBatch;
use crate::input::reader::{FULL, Reader, Sink, Started};
use crate::input::watch::Watched;
use crate::shown;
use ::parquet::basic::ConvertedType;
use ::parquet::data_type::ByteArray;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::ParquetMetaData;
use ::parquet::schema::types::ColumnDescPtr;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Returns the error for Parquet in an input that is not a file.
pub fn no_stream(path: &Path) -> InputError {
    let hint = "give the name of a file (not a pipe, and not gzip)";
    at(
        path,
        Location::File,
        Problem::new("Parquet is not read from a stream", hint),
    )
}

/// Starts the reader of a file of `size` bytes.
pub fn open(file: Watched<Arc<File>>, size: u64, options: &InputOptions) -> Started<PointBatch> {
    let path = Arc::clone(&file.watch.path);
    match Parquet::new(file, size, options) {
        Ok(parquet) => Ok(Box::new(parquet)),
        Err(problem) => Err(at(&path, Location::File, problem)),
    }
}

fn at(path: &Path, location: Location, problem: Problem) -> InputError {
    InputError::Malformed {
        path: path.to_owned(),
        location,
        problem: problem.problem,
        hint: problem.hint,
        source: problem.source.map(Into::into),
    }
}

struct Parquet {
    chunks: Arc<Chunks>,
    metadata: ParquetMetaData,
    choice: Choice,
    has_z: bool,
    /// The number of row groups begun, the columns of the last one, and its rows that were not read.
    groups: usize,
    columns: Vec<Column>,
    left: u64,
    /// The rows that were read, and the number of those before them.
    rows: Rows,
    before: u64,
    /// The number of all rows.
    total: u64,
    /// The number of rows without a geometry.
    without: u64,
    name: String,
}

/// Some rows, of which the first `taken` were taken.
#[derive(Default)]
struct Rows {
    taken: usize,
    count: usize,
    axes: [Vec<Option<f64>>; 3],
    geometries: Vec<Option<ByteArray>>,
    /// The positions of the current geometry.
    positions: Option<wkb::Positions>,
}

impl Parquet {
    fn new(file: Watched<Arc<File>>, size: u64, options: &InputOptions) -> Result<Self, Problem> {
        let name = shown::path(&file.watch.path);
        let chunks = Arc::new(Chunks::new(file, size));
        let metadata = metadata::read(&chunks)?;
        let choice = Choice::new(&metadata, options.columns.as_ref())?;
        let mut total = 0u64;
        for group in metadata.row_groups() {
            let rows = u64::try_from(group.num_rows());
            let rows = rows.map_err(|_| Problem::decoding("a row group has less than no rows", None))?;
            total = total.saturating_add(rows);
        }
        let mut parquet = Self {
            chunks,
            metadata,
            has_z: choice.leaves.len() == 3,
            choice,
            groups: 0,
            columns: Vec::new(),
            left: 0,
            rows: Rows::default(),
            before: 0,
            total,
            without: 0,
            name,
        };
        if parquet.choice.layout == Layout::Wkb {
            // The first geometry of the first rows tells whether there is z.
            parquet.next_rows()?;
            let first = parquet.rows.geometries.iter().flatten().next();
            parquet.has_z = first.is_some_and(|wkb| wkb::has_z(wkb.data()));
        }
        Ok(parquet)
    }

    /// Reads the next rows. Returns false at the end.
    fn next_rows(&mut self) -> Result<bool, Problem> {
        self.before += self.rows.count as u64;
        self.rows.clear();
        while self.left == 0 {
            let Some(group) = self.metadata.row_groups().get(self.groups) else {
                return Ok(false);
            };
            self.groups += 1;
            let columns = || {
                let columns = self.choice.leaves.iter();
                columns.map(|&leaf| Column::new(&self.chunks, group, leaf)).collect()
            };
            self.columns = decoded(columns)?;
            self.left = group.num_rows().unsigned_abs();
        }
        let most = self.left.min(FULL as u64) as usize;
        let (rows, columns) = (&mut self.rows, &mut self.columns);
        let layout = self.choice.layout;
        let count = decoded(|| match (layout, &mut columns[..]) {
            (Layout::Wkb, [column]) => column.bytes(most, &mut rows.geometries),
            _ => {
                let mut axes = columns.iter_mut().zip(&mut rows.axes);
                axes.try_for_each(|(column, axis)| column.numbers(most, axis))?;
                Ok(most)
            }
        })?;
        self.left -= count as u64;
        self.rows.count = count;
        Ok(true)
    }

    /// Takes one row of numbers.
    fn take_numbers(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<(), InputError> {
        let n = self.rows.taken;
        self.rows.taken += 1;
        let location = || Location::Row(self.before + n as u64);
        let [x, y, z] = &self.rows.axes;
        let (x, y, z) = (x[n], y[n], z.get(n).copied());
        let is_empty = |axis: Option<f64>| axis.is_none_or(f64::is_nan);
        match (x, y, z) {
            _ if self.choice.layout == Layout::Struct && is_empty(x) && is_empty(y) => {
                self.without += 1;
                Ok(())
            }
            (Some(x), Some(y), None) => sink.point(x, y, None, location),
            (Some(x), Some(y), Some(Some(z))) => sink.point(x, y, Some(z), location),
            (None, ..) => sink.invalid(location, &Flaw::Null { axis: 'x' }),
            (_, None, _) => sink.invalid(location, &Flaw::Null { axis: 'y' }),
            _ => sink.invalid(location, &Flaw::Null { axis: 'z' }),
        }
    }

    /// Takes positions of a geometry until it ends or the batch is full.
    fn take_geometry(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<(), InputError> {
        let n = self.rows.taken;
        let location = || Location::Row(self.before + n as u64);
        let Some(wkb) = self.rows.geometries.get(n).and_then(Option::as_ref) else {
            self.without += 1;
            self.rows.taken += 1;
            return Ok(());
        };
        let wkb = wkb.data();
        if self.rows.positions.is_none() {
            match wkb::Positions::of(wkb) {
                Ok(positions) => self.rows.positions = Some(positions),
                Err(flaw) => {
                    self.rows.taken += 1;
                    return sink.invalid(location, &flaw);
                }
            }
        }
        while let Some(positions) = self.rows.positions.as_mut().filter(|_| !sink.is_full()) {
            match positions.next(wkb) {
                Some(Ok((x, y, z))) => sink.point(x, y, z, location)?,
                Some(Err(flaw)) => sink.invalid(location, &flaw)?,
                None => {
                    self.without += u64::from(!positions.any);
                    self.rows.positions = None;
                    self.rows.taken += 1;
                }
            }
        }
        Ok(())
    }
}

impl Rows {
    /// Removes all rows and keeps the memory.
    fn clear(&mut self) {
        self.taken = 0;
        self.count = 0;
        self.axes.iter_mut().for_each(Vec::clear);
        self.geometries.clear();
    }
}

/// Returns the columns for a description of the file.
fn fields(metadata: &ParquetMetaData) -> Vec<Field> {
    let leaves = metadata.file_metadata().schema_descr().columns().iter();
    let field = |leaf: &ColumnDescPtr| {
        let kind = leaf.physical_type().to_string();
        let kind = match leaf.converted_type() {
            ConvertedType::NONE => kind,
            converted => format!("{kind} ({converted})"),
        };
        Field::new(leaf.path().string(), kind)
    };
    leaves.take(MOST_FIELDS).map(field).collect()
}

/// Returns what the decoder returns, or its error or panic.
fn decoded<T>(decode: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, Problem> {
    match catch(decode) {
        Some(Ok(decoded)) => Ok(decoded),
        Some(Err(error)) => Err(Problem::decoding("the rows from here on cannot be read", Some(error))),
        None => Err(Problem::decoding("the rows from here on cannot be read", None)),
    }
}

impl Reader<PointBatch> for Parquet {
    fn has_z(&self) -> bool {
        self.has_z
    }

    fn crs(&self) -> Option<&str> {
        self.choice.crs.as_deref()
    }

    fn expected(&self) -> Option<u64> {
        let read = self.before + self.rows.taken as u64;
        self.choice.one_per_row.then(|| self.total.saturating_sub(read))
    }

    fn fill(&mut self, sink: &mut Sink<'_, PointBatch>) -> Result<bool, InputError> {
        while !sink.is_full() {
            if self.rows.taken == self.rows.count {
                let begin = Location::Row(self.before + self.rows.count as u64);
                match self.next_rows() {
                    Ok(true) => {}
                    Ok(false) => return Ok(false),
                    Err(problem) => return Err(at(sink.path, begin, problem)),
                }
            }
            match self.choice.layout {
                Layout::Wkb => self.take_geometry(sink)?,
                Layout::Columns | Layout::Struct => self.take_numbers(sink)?,
            }
        }
        Ok(true)
    }

    fn about(&self) -> About {
        let is_geo = self.choice.layout != Layout::Columns;
        About {
            variety: is_geo.then(|| "GeoParquet".to_owned()),
            fields: fields(&self.metadata),
            las: None,
        }
    }

    fn notes(&self) -> Vec<String> {
        match self.without {
            0 => Vec::new(),
            n => vec![format!("{}: {n} rows have no geometry", self.name)],
        }
    }
}
