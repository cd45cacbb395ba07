//! The questions of `tiletool query`.

use clap::{Args, Subcommand};
use delaunay_tiles::query::Mode;

use super::args::{AtArgs, CommonArgs, ModeArgs, ProgressArgs, WayArgs};
use super::ask::Ask;
use super::batch::{self, Question};

#[derive(Subcommand, Clone, Debug)]
pub enum QueryCommand {
    /// The vertex, edge or triangle that a point lies on or in, and whether it is free
    Locate(AtArgs),
    /// The nearest sites as the crow flies, or the nearest vertices
    Nearest(NearestArgs),
    /// The nearest sites by walking distance
    Knn(KnnArgs),
    /// All sites within a walking distance, and the area
    Range(RangeArgs),
    /// A shortest path
    Path(PathArgs),
    /// The nearest sites along a straight line: the intervals on which they stay the same
    Along(AlongArgs),
}

#[derive(Args, Clone, Debug)]
pub struct NearestArgs {
    #[command(flatten)]
    pub places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
    /// Vertices, even if there are sites
    #[arg(long)]
    pub vertices: bool,
}

#[derive(Args, Clone, Debug)]
pub struct KnnArgs {
    #[command(flatten)]
    pub places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
    #[command(flatten)]
    pub mode: ModeArgs,
    #[command(flatten)]
    pub progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
pub struct RangeArgs {
    #[command(flatten)]
    pub places: AtArgs,
    /// How far away they are at most
    #[arg(long, value_name = "DISTANCE", value_parser = batch::radius)]
    pub radius: f64,
    #[command(flatten)]
    pub mode: ModeArgs,
    /// Give the area within that distance, too, in --geojson and --plot: polygons whose arcs are lines, a ten-thousandth of the
    /// arc's radius inside it at most
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
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub k: u32,
}

impl QueryCommand {
    /// How exact the answer is to be, and whether the fast one comes first.
    pub fn mode(&self) -> (Mode, bool) {
        match self {
            Self::Locate(_) | Self::Nearest(_) | Self::Along(_) => (Mode::Exact, false),
            Self::Knn(args) => (args.mode.mode, args.progress.progressive),
            Self::Range(args) => (args.mode.mode, false),
            Self::Path(args) => (args.mode.mode, args.progress.progressive),
        }
    }

    /// What is asked, of which points, and with which options.
    pub fn parts(&self) -> (Ask, Vec<Question>, &CommonArgs) {
        let of = |places: &AtArgs| places.at.iter().map(|&at| Question::At(at)).collect();
        match self {
            Self::Locate(args) => (Ask::Locate, of(args), &args.common),
            Self::Nearest(args) => {
                let ask = Ask::Nearest {
                    k: args.k,
                    vertices: args.vertices,
                };
                (ask, of(&args.places), &args.places.common)
            }
            Self::Knn(args) => (Ask::Knn { k: args.k }, of(&args.places), &args.places.common),
            Self::Range(args) => (
                Ask::Range {
                    radius: args.radius,
                    area: args.area,
                },
                of(&args.places),
                &args.places.common,
            ),
            Self::Path(args) => (Ask::Path, args.way.ways(), &args.way.common),
            Self::Along(args) => (Ask::Along { k: args.k }, args.line.ways(), &args.line.common),
        }
    }
}
