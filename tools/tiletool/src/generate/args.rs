//! The arguments of `tiletool generate`.

use std::path::PathBuf;

use clap::Args;

use super::count::parse_count;
use super::what::{What, kinds};

/// Generate test points, segments, or maps of obstacles and sites
///
/// The same arguments give the same bytes on every machine and with every version. Coordinates are
/// raw little-endian f64, x y x y ...; segments are pairs of record numbers, raw little-endian u32.
/// Maps are polygons in GeoJSON and sites in rows x,y.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct GenerateArgs {
    /// Distribution of the points, or kind of map
    #[arg(value_parser = kinds())]
    pub(super) kind: What,
    /// Number of points, or of obstacles of a map, such as 1000000, 1e6 or 1.5M (k, M and G are
    /// 10^3, 10^6 and 10^9)
    #[arg(short = 'n', long = "points", value_name = "COUNT", value_parser = parse_count)]
    pub(super) n: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    pub(super) seed: u64,
    /// File to write; - is standard output. Segments are written to the same name with suffix .u32,
    /// the sites of a map with suffix .sites.csv
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    /// Also write about ALPHA segments per point, from 0 to 1
    ///
    /// About n/3 cells have three points each. With probability ALPHA, the three points of a cell
    /// are joined by three segments. Only for uniform, kuzmin and line-singularity.
    #[arg(long, value_name = "ALPHA", conflicts_with = "long_segments")]
    pub(super) pslg: Option<f64>,
    /// Also write this many segments, each across nearly the whole square, that do not cross
    ///
    /// Their ends are two more points for each segment, after the other points. Only for uniform.
    #[arg(long, value_name = "COUNT", value_parser = parse_count)]
    pub(super) long_segments: Option<u64>,
    /// Number of sites, for city and parks [default: the number of obstacles]
    #[arg(long, value_name = "COUNT", value_parser = parse_count)]
    pub(super) sites: Option<u64>,
    /// Coordinates per point; the third is the height of the terrain for lidar, and 0 for all other
    /// kinds
    #[arg(long, value_name = "2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub(super) dims: u8,
    /// Print the summary as one JSON object
    #[arg(long)]
    pub(super) json: bool,
}

const EXAMPLES: &str = "\
Examples:
  Ten million points, dense at the origin, with five million segments, to kuzmin.f64 and kuzmin.u32:
      tiletool generate kuzmin -n 10M --pslg 0.5 --seed 1 -o kuzmin.f64

  A lidar survey with heights (build it with --dims 3):
      tiletool generate lidar -n 1e6 --dims 3 -o survey.f64

  A city of a million buildings, and as many sites, in city.geojson and city.sites.csv:
      tiletool generate city -n 1M -o city.geojson
      tiletool build --obstacles city.geojson --sites city.sites.csv -o city.tiles";
