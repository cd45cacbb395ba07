//! The options of `tiletool export`.

use std::path::{Path, PathBuf};

use clap::Args;
use delaunay_tiles::terrain::Surface;
use delaunay_tiles::{Point, Rect};
use delaunay_tiles_answers::question::{length, point};

use super::formats::{AnyFormat, Shown};
use super::given::first_given;
#[cfg(feature = "pmtiles")]
use super::map_args::MapArgs;
use crate::common::MemoryArgs;
use crate::crs::CrsArgs;
use crate::input_args::rect;

/// Export a mesh, features, a raster, contours or map tiles
///
/// PLY, Triangle's .node and .ele, OBJ and glTF are meshes: all vertices, numbered in the order of the file,
/// and triangles. GeoJSON, FlatGeobuf and GeoParquet are features for GIS and databases, by --what, or
/// contours. GeoTIFF and ASCII grid are rasters, PMTiles map tiles.
///
/// A raster holds, for each cell, the height of the triangle at its centre, or, by --what, its slope,
/// aspect or shade. Cells without a triangle have the value -9999, of shades 0.
///
/// Map tiles are those of `tiletool serve`, byte for byte, as one file that needs no server.
///
/// Triangles in holes are left out, and with --max-edge and --clip further ones, but never vertices of
/// a mesh. An existing output is replaced when the new one is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool export survey.tiles -o survey.ply
  tiletool export survey.tiles -o survey --format node    # survey.node and survey.ele
  tiletool export survey.tiles -o survey.fgb --max-edge 50 --from-hull
  tiletool export survey.tiles -o points.parquet --what vertices --clip district.geojson
  tiletool export survey.tiles -o dem.tif --resolution 1
  tiletool export survey.tiles -o contours.fgb --contours 5
  tiletool export survey.tiles -o shaded.tif --resolution 0.5 --what hillshade --cog
  tiletool export town.tiles -o town.pmtiles              # pictures for web maps
  tiletool export town.tiles -o mesh.pmtiles --layer mesh --zooms 0..16
  tiletool export survey.tiles -o - --format geojson | gzip > survey.geojson.gz")]
pub struct ExportArgs {
    /// Tile file to read
    pub file: PathBuf,
    /// File to write: .ply, .node or .ele (writes both), .obj, .glb, .geojson, .fgb, .parquet, .tif, .asc
    /// or .pmtiles; - is standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Output format [default: by the suffix of the output]
    #[arg(long, value_name = "ply|node|obj|glb|geojson|fgb|parquet|tif|asc|pmtiles")]
    pub format: Option<AnyFormat>,
    /// For GeoJSON, FlatGeobuf and GeoParquet: a feature for each of the triangles, vertices or edges
    /// (constraint edges, with the kind and number of their lines) [default: triangles; vertices if
    /// there are no triangles]. For rasters: z, slope or aspect (both in degrees) or hillshade [default:
    /// z]
    #[arg(long, value_name = "triangles|vertices|edges|z|slope|aspect|hillshade")]
    pub what: Option<Shown>,
    /// For PLY and glTF: also write constraint edges; some readers of PLY refuse them
    #[arg(long)]
    pub edges: bool,
    /// Also write triangles in holes
    #[arg(long)]
    pub all: bool,
    /// Leave out triangles with an edge longer than this, in units of the coordinates
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub max_edge: Option<f64>,
    /// With --max-edge: leave out only triangles that are peeled off from the hull inwards, so that those
    /// over a lake stay
    #[arg(long, requires = "max_edge")]
    pub from_hull: bool,
    /// Write only triangles and edges that meet the interior of these polygons, whole, and, with --what
    /// vertices, vertices in them; of rasters, cells whose centres are in them; of contours, the parts in
    /// them. The polygons must have the file's coordinate reference system, and take at most half of
    /// --memory
    #[arg(long, value_name = "POLYGONS.geojson")]
    pub clip: Option<PathBuf>,
    #[command(flatten)]
    pub crs: CrsArgs,
    #[command(flatten)]
    pub raster: RasterArgs,
    #[command(flatten)]
    pub contours: ContourArgs,
    #[cfg(feature = "pmtiles")]
    #[command(flatten)]
    pub maps: MapArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl ExportArgs {
    /// Returns the triangles that count, before they are clipped.
    pub fn surface(&self) -> Surface {
        let surface = Surface::default().holes(self.all);
        surface.max_edge(self.max_edge).from_hull(self.from_hull)
    }

    /// Returns whether the output is standard output.
    pub fn is_stdout(&self) -> bool {
        self.output == Path::new("-")
    }

    /// Returns the folder for temporary files: that of the output, or the system's for standard output.
    pub fn scratch(&self) -> PathBuf {
        match self.output.parent() {
            _ if self.is_stdout() => std::env::temp_dir(),
            Some(folder) if folder != Path::new("") => folder.to_owned(),
            _ => PathBuf::from("."),
        }
    }
}

/// Options for contours.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options for contours")]
pub struct ContourArgs {
    /// For GeoJSON and FlatGeobuf: write lines of equal height instead of triangles, at steps of this
    /// height. The higher ground is on their left
    #[arg(long = "contours", value_name = "STEP", value_parser = length)]
    pub step: Option<f64>,
    /// Height of one of the contours [default: 0]
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true, requires = "step", value_parser = height)]
    pub base: Option<f64>,
}

impl ContourArgs {
    /// Returns whether contours are wanted.
    pub fn are_given(&self) -> bool {
        self.step.is_some()
    }
}

/// Options for rasters.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options for rasters")]
pub struct RasterArgs {
    /// Size of the cells, in units of the coordinates; required for rasters
    #[arg(long, value_name = "SIZE", value_parser = length)]
    pub resolution: Option<f64>,
    /// Rectangle to cover; without --align its upper left corner is that of a cell [default: all]
    #[arg(long, value_name = "XMIN,YMIN,XMAX,YMAX", allow_hyphen_values = true, value_parser = rect)]
    pub bounds: Option<Rect>,
    /// Corners of cells are whole multiples of the resolution away from this point [default: 0,0]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub align: Option<Point>,
    /// Multiply heights by this first, for instance to convert feet to metres
    #[arg(long, value_name = "FACTOR", value_parser = length)]
    pub z_factor: Option<f64>,
    /// For hillshade: direction of the light, in degrees clockwise from north [default: 315]
    #[arg(long, value_name = "DEGREES", value_parser = azimuth)]
    pub azimuth: Option<f64>,
    /// For hillshade: height of the light above the horizon, in degrees [default: 45]
    #[arg(long, value_name = "DEGREES", value_parser = altitude)]
    pub altitude: Option<f64>,
    /// Store numbers of 32 bits instead of 64
    #[arg(long)]
    pub float32: bool,
    /// For GeoTIFF: add overviews, which make it a Cloud Optimized GeoTIFF
    #[arg(long)]
    pub cog: bool,
}

impl RasterArgs {
    /// Returns the first option that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--resolution", self.resolution.is_some()),
            ("--bounds", self.bounds.is_some()),
            ("--align", self.align.is_some()),
            ("--z-factor", self.z_factor.is_some()),
            ("--azimuth", self.azimuth.is_some()),
            ("--altitude", self.altitude.is_some()),
            ("--float32", self.float32),
            ("--cog", self.cog),
        ];
        first_given(given)
    }
}

fn azimuth(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.0..=360.0).contains(degrees));
    degrees.ok_or_else(|| "a direction is a number from 0 to 360".to_owned())
}

fn altitude(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.0..=90.0).contains(degrees));
    degrees.ok_or_else(|| "a height above the horizon is a number from 0 to 90".to_owned())
}

fn height(text: &str) -> Result<f64, String> {
    let height = text.parse().ok().filter(|height: &f64| height.is_finite());
    height.ok_or_else(|| "a height is a number".to_owned())
}

/// Returns the error of options that do not fit together.
pub fn usage(why: &str) -> clap::Error {
    let mut command = ExportArgs::augment_args(clap::Command::new("tiletool export"));
    command.error(clap::error::ErrorKind::ValueValidation, why)
}
