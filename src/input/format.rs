//! The formats of files with points.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::input::error::InputError;
use crate::input::layer;

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
    /// Raw little-endian f64: x y, or x y z if [`InputOptions::dims`](crate::input::InputOptions::dims) is 3.
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
