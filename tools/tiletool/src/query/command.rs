//! The query commands of `tiletool query`.

use clap::{Args, Subcommand};
use delaunay_tiles::query::Mode;
use delaunay_tiles_answers::ask::Ask;
use delaunay_tiles_answers::question::{self, Question};

use super::args::{AtArgs, CommonArgs, ModeArgs, ProgressArgs, SearchArgs, WayArgs};

#[derive(Subcommand, Clone, Debug)]
pub enum QueryCommand {
    /// Find the vertex, edge or triangle at a point, and whether the point is free
    #[command(after_help = "Example:\n  tiletool query locate town.tiles --at 3.5,-4")]
    Locate(AtArgs),
    /// Find the nearest sites or vertices by Euclidean distance
    #[command(after_help = "Example:\n  tiletool query nearest town.tiles --at 3.5,-4 -k 3")]
    Nearest(NearestArgs),
    /// Find the nearest sites by walking distance
    #[command(
        after_help = "Examples:\n  tiletool query knn town.tiles --at 3.5,-4 -k 3\n  tiletool query knn town.tiles --batch homes.csv -k 1 --csv"
    )]
    Knn(KnnArgs),
    /// Find all sites, and optionally the area, within a walking distance
    #[command(after_help = "Example:\n  tiletool query range town.tiles --at 7,7 --radius 500 --area --plot reach.png")]
    Range(RangeArgs),
    /// Find a shortest path between two points
    #[command(
        after_help = "Examples:\n  tiletool query path town.tiles --from -1,2 --to 8,8 --geojson\n  tiletool query path town.tiles --from -1,2 --to 8,8 --mode within:0.05"
    )]
    Path(PathArgs),
    /// Find the nearest sites along a straight line, in intervals with the same sites
    #[command(after_help = "Example:\n  tiletool query along town.tiles --from -1,2 --to 8,8 -k 3")]
    Along(AlongArgs),
}

#[derive(Args, Clone, Debug)]
pub struct NearestArgs {
    #[command(flatten)]
    pub points: AtArgs,
    /// Number of sites or vertices to find
    #[arg(short, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
    /// Find vertices even if the file has sites
    #[arg(long)]
    pub vertices: bool,
}

#[derive(Args, Clone, Debug)]
pub struct KnnArgs {
    #[command(flatten)]
    pub points: AtArgs,
    /// Number of sites to find
    #[arg(short, value_name = "COUNT", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
    #[command(flatten)]
    pub mode: ModeArgs,
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
pub struct RangeArgs {
    #[command(flatten)]
    pub points: AtArgs,
    /// Maximum walking distance
    #[arg(long, value_name = "DISTANCE", value_parser = question::radius)]
    pub radius: f64,
    #[command(flatten)]
    pub mode: ModeArgs,
    /// Also return the area within that distance
    ///
    /// Its arcs become straight edges, which are inside the arc by at most a ten-thousandth of its
    /// radius. So its size is too small by at most 0.014 %. With --geojson and --plot, it also
    /// consists of polygons.
    #[arg(long)]
    pub area: bool,
}

#[derive(Args, Clone, Debug)]
pub struct PathArgs {
    #[command(flatten)]
    pub way: WayArgs,
    #[command(flatten)]
    pub mode: ModeArgs,
    #[command(flatten)]
    pub progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
pub struct AlongArgs {
    #[command(flatten)]
    pub line: WayArgs,
    /// Number of nearest sites on each interval
    #[arg(short, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
}

impl QueryCommand {
    /// Returns the accuracy of the answer, and whether the fast answer is printed first.
    pub fn mode(&self) -> (Mode, bool) {
        match self {
            Self::Locate(_) | Self::Nearest(_) | Self::Along(_) => (Mode::Exact, false),
            Self::Knn(args) => (args.mode.mode, args.progress.progressive),
            Self::Range(args) => (args.mode.mode, false),
            Self::Path(args) => (args.mode.mode, args.progress.progressive),
        }
    }

    /// Returns the kind of the query, its points and its common options.
    pub fn parts(&self) -> (Ask, Vec<Question>, &CommonArgs) {
        let of = |points: &AtArgs| points.at.iter().map(|&at| Question::At(at)).collect();
        match self {
            Self::Locate(args) => (Ask::Locate, of(args), &args.common),
            Self::Nearest(args) => {
                let ask = Ask::Nearest {
                    k: args.k,
                    vertices: args.vertices,
                };
                (ask, of(&args.points), &args.points.common)
            }
            Self::Knn(args) => {
                let ask = Ask::Knn {
                    k: args.k,
                    search: args.search.search,
                };
                (ask, of(&args.points), &args.points.common)
            }
            Self::Range(args) => (
                Ask::Range {
                    radius: args.radius,
                    area: args.area,
                },
                of(&args.points),
                &args.points.common,
            ),
            Self::Path(args) => (Ask::Path, args.way.ways(), &args.way.common),
            Self::Along(args) => (Ask::Along { k: args.k }, args.line.ways(), &args.line.common),
        }
    }
}
