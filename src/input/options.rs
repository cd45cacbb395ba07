//! The options of reading: formats, columns, filters.

use crate::geometry::Rect;
use crate::input::error::InputError;
use crate::input::layer;
use std::fmt;
use std::num::NonZeroU64;
use std::path::Path;
use std::str::FromStr;

/// The format of a file with points.
///
/// ```
/// use delaunay_tiles::input::Format;
///
/// assert_eq!(Format::from_path("lidar/Tile.LAZ".as_ref()), Some(Format::Las));
/// assert_eq!("csv".parse::<Format>()?, Format::Text);
/// # Ok::<(), delaunay_tiles::input::InputError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Rows of text whose fields are separated by commas, semicolons, tabs or blanks.
    Text,
    /// Raw little-endian f64: x y, or x y z if [`InputOptions::dims`] is 3.
    F64,
    /// The `.node` files of Triangle (two dimensions) and TetGen (three).
    Node,
    /// The points of Triangle's `.poly` files. [`PolySource`](crate::input::PolySource) reads their
    /// segments and holes.
    Poly,
    /// GeoJSON: a document, or a sequence of features or geometries.
    GeoJson,
    /// LAS, LAZ and COPC.
    Las,
    /// FlatGeobuf.
    FlatGeobuf,
    /// The `.shp` file of a shapefile.
    Shapefile,
    /// A feature table of a GeoPackage: `FILE.gpkg`, or `FILE.gpkg:LAYER` where there are several.
    GeoPackage,
    /// PLY: the vertices.
    Ply,
    /// Wavefront OBJ: the vertices.
    Obj,
    /// Parquet: columns of coordinates, or GeoParquet's points.
    Parquet,
}

impl Format {
    /// Returns the format that the suffix of a file name indicates, ignoring case and a trailing
    /// `.gz` or `.gpkg:LAYER`.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        if layer::split(path).is_some() {
            return Some(Self::GeoPackage);
        }
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let (stem, suffix) = name.rsplit_once('.')?;
        if stem.is_empty() {
            return None;
        }
        match suffix {
            "csv" | "tsv" | "txt" | "xyz" => Some(Self::Text),
            "f64" => Some(Self::F64),
            "node" => Some(Self::Node),
            "poly" => Some(Self::Poly),
            "geojson" | "json" | "geojsonl" | "geojsons" | "ndjson" => Some(Self::GeoJson),
            "las" | "laz" => Some(Self::Las),
            "fgb" => Some(Self::FlatGeobuf),
            "shp" => Some(Self::Shapefile),
            "gpkg" => Some(Self::GeoPackage),
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "parquet" | "geoparquet" => Some(Self::Parquet),
            _ => None,
        }
    }

    /// Returns whether files of this format may have the edges of a triangulation beside its
    /// vertices: [`SegmentSource::open_edges`](crate::input::SegmentSource::open_edges) reads them.
    #[must_use]
    pub fn may_have_edges(self) -> bool {
        matches!(self, Self::Node | Self::Ply | Self::Obj)
    }
}

#[cfg(not(all(
    feature = "text",
    feature = "geojson",
    feature = "las",
    feature = "flatgeobuf",
    feature = "shapefile",
    feature = "geopackage",
    feature = "parquet"
)))]
impl Format {
    /// Returns the error of a file in a format that the library was built without.
    pub(super) fn missing(self, path: &Path) -> InputError {
        InputError::MissingFeature {
            path: path.to_owned(),
            what: self.to_string(),
            feature: match self {
                Self::Las => "las",
                Self::Parquet => "parquet",
                Self::GeoJson => "geojson",
                Self::FlatGeobuf => "flatgeobuf",
                Self::Shapefile => "shapefile",
                Self::GeoPackage => "geopackage",
                _ => "text",
            },
        }
    }
}

impl FromStr for Format {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        match text.to_ascii_lowercase().as_str() {
            "text" | "csv" | "tsv" | "xyz" | "txt" => Ok(Self::Text),
            "f64" => Ok(Self::F64),
            "node" => Ok(Self::Node),
            "poly" => Ok(Self::Poly),
            "geojson" | "json" => Ok(Self::GeoJson),
            "las" | "laz" => Ok(Self::Las),
            "flatgeobuf" | "fgb" => Ok(Self::FlatGeobuf),
            "shapefile" | "shp" => Ok(Self::Shapefile),
            "geopackage" | "gpkg" => Ok(Self::GeoPackage),
            "ply" => Ok(Self::Ply),
            "obj" => Ok(Self::Obj),
            "parquet" | "geoparquet" => Ok(Self::Parquet),
            _ => Err(InputError::Option {
                option: "format",
                value: text.to_owned(),
                expected:
                    "expected one of text, f64, node, poly, geojson, las, flatgeobuf, shapefile, geopackage, ply, \
                           obj, parquet"
                        .to_owned(),
            }),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Text => "text",
            Self::F64 => "f64",
            Self::Node => "node",
            Self::Poly => "poly",
            Self::GeoJson => "geojson",
            Self::Las => "las",
            Self::FlatGeobuf => "flatgeobuf",
            Self::Shapefile => "shapefile",
            Self::GeoPackage => "geopackage",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Parquet => "parquet",
        })
    }
}

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
