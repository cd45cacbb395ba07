//! The options of reading: columns, filters.

use std::fmt;
use std::num::NonZeroU64;
use std::str::FromStr;

use crate::geometry::Rect;
use crate::input::error::InputError;
use crate::input::format::Format;

/// A column of a text file, as part of [`Columns`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// The column with this number, counted from 1.
    Number(usize),
    /// The column with this name in the header, ignoring case.
    Name(String),
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(n) => n.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

/// The columns of a text file that hold the coordinates, parsed from text such as `lon,lat` or
/// `2,3,5`.
///
/// A column that consists of digits is a number, any other column is a name. Without a third column
/// there is no z.
///
/// ```
/// use delaunay_tiles::input::{Column, Columns};
///
/// let columns: Columns = "lon,lat,5".parse()?;
/// assert_eq!(columns.z, Some(Column::Number(5)));
/// # Ok::<(), delaunay_tiles::input::InputError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// The column of x.
    pub x: Column,
    /// The column of y.
    pub y: Column,
    /// The column of z, if z is read.
    pub z: Option<Column>,
}

impl FromStr for Columns {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let fail = || InputError::Option {
            option: "columns",
            value: text.to_owned(),
            expected: "expected x,y or x,y,z, each a name in the header or a column number from 1".to_owned(),
        };
        let column = |field: &str| {
            let field = field.trim();
            if field.bytes().all(|b| b.is_ascii_digit()) {
                match field.parse() {
                    Ok(n) if n > 0 => Ok(Column::Number(n)),
                    _ => Err(fail()),
                }
            } else {
                Ok(Column::Name(field.to_owned()))
            }
        };
        let fields: Vec<&str> = text.split(',').collect();
        match fields[..] {
            [x, y] => Ok(Self {
                x: column(x)?,
                y: column(y)?,
                z: None,
            }),
            [x, y, z] => Ok(Self {
                x: column(x)?,
                y: column(y)?,
                z: Some(column(z)?),
            }),
            _ => Err(fail()),
        }
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.x, self.y)?;
        match &self.z {
            Some(z) => write!(f, ",{z}"),
            None => Ok(()),
        }
    }
}

/// The returns of a lidar pulse that become points: an option of [`InputOptions`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Returns {
    /// The first return of each pulse.
    First,
    /// The last return of each pulse.
    Last,
    /// All returns.
    #[default]
    All,
}

impl FromStr for Returns {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        match text.to_ascii_lowercase().as_str() {
            "first" => Ok(Self::First),
            "last" => Ok(Self::Last),
            "all" => Ok(Self::All),
            _ => Err(InputError::Option {
                option: "returns",
                value: text.to_owned(),
                expected: "expected one of first, last, all".to_owned(),
            }),
        }
    }
}

impl fmt::Display for Returns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::First => "first",
            Self::Last => "last",
            Self::All => "all",
        })
    }
}

/// The treatment of points, lines or sites without z where others have z: an option of
/// [`InputOptions`] and of builds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum MissingZ {
    /// Ends of lines, crossing points and sites without z take it from the surface: from the
    /// triangulation of the points alone in a build, from the triangulation before the edit in an
    /// edit. Outside the hull of the points they take the z of the nearest point of the hull. A
    /// point without z is an error.
    #[default]
    Drape,
    /// Missing z is an error, unless a point with z has the same position.
    Error,
    /// Missing z becomes 0.
    Zero,
}

/// The options of reading points. An option that does not apply to a format has no effect, except
/// [`copc_level`](Self::copc_level) and [`copc_resolution`](Self::copc_resolution).
///
/// ```
/// use delaunay_tiles::input::{Format, InputOptions};
///
/// let options = InputOptions::default().format(Format::F64).dims(3).skip_invalid(true);
/// ```
#[derive(Clone, Debug)]
pub struct InputOptions {
    pub(super) format: Option<Format>,
    pub(super) columns: Option<Columns>,
    pub(super) dims: u8,
    pub(super) classes: Vec<u8>,
    pub(super) returns: Returns,
    pub(super) keep_withheld: bool,
    pub(super) bounds: Option<Rect>,
    pub(super) every: NonZeroU64,
    pub(super) copc_level: Option<u8>,
    pub(super) copc_resolution: Option<f64>,
    pub(super) skip_invalid: bool,
    pub(super) missing_z: MissingZ,
    pub(super) threads: usize,
    /// Whether readers also count what only a description of the file needs, and the z that a point
    /// lacks is NaN instead of 0.
    pub(super) is_description: bool,
}

impl Default for InputOptions {
    fn default() -> Self {
        Self {
            format: None,
            columns: None,
            dims: 2,
            classes: Vec::new(),
            returns: Returns::All,
            keep_withheld: false,
            bounds: None,
            every: NonZeroU64::MIN,
            copc_level: None,
            copc_resolution: None,
            skip_invalid: false,
            missing_z: MissingZ::Error,
            threads: 0,
            is_description: false,
        }
    }
}

impl InputOptions {
    /// Sets the format of all inputs. With `None`, the default, each file's suffix determines its
    /// format.
    #[must_use]
    pub fn format(mut self, format: impl Into<Option<Format>>) -> Self {
        self.format = format.into();
        self
    }

    /// For text and Parquet, sets the columns. With `None`, the default, the header determines them,
    /// or their order if there is no header; in GeoParquet, the geometry column has the points.
    #[must_use]
    pub fn columns(mut self, columns: impl Into<Option<Columns>>) -> Self {
        self.columns = columns.into();
        self
    }

    /// For f64, sets the number of values per point, 2 or 3; 2 by default.
    #[must_use]
    pub fn dims(mut self, dims: u8) -> Self {
        self.dims = dims;
        self
    }

    /// Returns the number of threads that decode.
    #[cfg(any(feature = "las", feature = "text"))]
    pub(super) fn decoding_threads(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }

    /// For LAZ and text, sets the number of threads that decode ahead of the reading. With 0, the
    /// default, there is one for each processor, and with 1, the reading thread decodes. At most four are
    /// started. The points are the same.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// For LAS, sets the classes to keep. An empty list, the default, keeps all.
    #[must_use]
    pub fn classes(mut self, classes: impl Into<Vec<u8>>) -> Self {
        self.classes = classes.into();
        self
    }

    /// For LAS, sets the returns to keep; all by default.
    #[must_use]
    pub fn returns(mut self, returns: Returns) -> Self {
        self.returns = returns;
        self
    }

    /// For LAS, sets whether points that are marked as withheld are kept; false by default.
    #[must_use]
    pub fn keep_withheld(mut self, keep: bool) -> Self {
        self.keep_withheld = keep;
        self
    }

    /// Keeps only points within a rectangle, its border included. With `None`, the default, all are
    /// kept. Of a COPC file, only nodes of the octree that meet the rectangle are read.
    #[must_use]
    pub fn bounds(mut self, bounds: impl Into<Option<Rect>>) -> Self {
        self.bounds = bounds.into();
        self
    }

    /// Keeps only records whose number is a multiple of `every`; 1, the default, keeps all. Records
    /// are counted over all inputs, including those that other options exclude.
    #[must_use]
    pub fn every(mut self, every: NonZeroU64) -> Self {
        self.every = every;
        self
    }

    /// For COPC, keeps only points in nodes of the octree up to this level; 0 is the root. With
    /// `None`, the default, all levels are kept.
    ///
    /// The points up to a level are spread over the whole file, at about half the distance that
    /// those up to the level before have. The rest is not read. Each file has an octree of its own,
    /// so for several files [`copc_resolution`](Self::copc_resolution) is the better measure.
    ///
    /// An input that is not COPC is an error.
    ///
    /// ```
    /// use delaunay_tiles::input::{InputOptions, PointSource};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let dir = tempfile::tempdir()?;
    /// # let path = dir.path().join("points.f64");
    /// # std::fs::write(&path, [0; 16])?;
    /// let error = PointSource::open(&[path], &InputOptions::default().copc_level(3)).unwrap_err();
    /// assert!(error.to_string().contains("points.f64: this is not a COPC file"));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn copc_level(mut self, level: impl Into<Option<u8>>) -> Self {
        self.copc_level = level.into();
        self
    }

    /// For COPC, keeps only points in nodes of the octree up to the first level at which points are
    /// at most `resolution` apart, in the unit of the coordinates. A file says how far apart the
    /// points of the root are, and each level halves that. With `None`, the default, all are kept.
    ///
    /// If a level is set too, the one nearer to the root is the limit. `resolution` must be finite and
    /// above 0. An input that is not COPC is an error.
    #[must_use]
    pub fn copc_resolution(mut self, resolution: impl Into<Option<f64>>) -> Self {
        self.copc_resolution = resolution.into();
        self
    }

    /// Returns whether the options select levels of an octree.
    pub(super) fn selects_levels(&self) -> bool {
        self.copc_level.is_some() || self.copc_resolution.is_some()
    }

    /// Returns whether some valid points may be left out that an input announces. Then the number of
    /// these says little about the number of points. Levels of COPC leave out points that are not
    /// announced.
    #[must_use]
    pub fn is_filtered(&self) -> bool {
        !self.classes.is_empty() || self.returns != Returns::All || self.is_thinned()
    }

    /// Returns whether points are selected by their place or their number.
    pub(super) fn is_thinned(&self) -> bool {
        self.bounds.is_some() || self.every > NonZeroU64::MIN
    }

    /// Sets whether invalid records are counted and skipped. By default the first one is an error.
    #[must_use]
    pub fn skip_invalid(mut self, skip: bool) -> Self {
        self.skip_invalid = skip;
        self
    }

    /// Sets the treatment of points that have no z where others have; an error by default.
    #[must_use]
    pub fn missing_z(mut self, missing_z: MissingZ) -> Self {
        self.missing_z = missing_z;
        self
    }
}
