//! The triangles that count.

use clap::Args;
use delaunay_tiles::terrain::Surface;
use delaunay_tiles_answers::height::Counted;
use delaunay_tiles_answers::question::length;

#[derive(Args, Clone, Copy, Debug)]
pub struct SurfaceArgs {
    /// Count triangles in holes too
    #[arg(long)]
    all: bool,
    /// Leave out triangles with an edge longer than this, in units of the coordinates
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    max_edge: Option<f64>,
}

/// The triangles that count, for queries that may read the whole file before.
#[derive(Args, Clone, Copy, Debug)]
pub struct WholeSurfaceArgs {
    #[command(flatten)]
    of_triangles: SurfaceArgs,
    /// With --max-edge: leave out only triangles that are peeled off from the hull inwards, so that those
    /// over a lake stay. Reads the whole file first
    #[arg(long, requires = "max_edge")]
    from_hull: bool,
}

impl WholeSurfaceArgs {
    pub fn surface(self) -> Surface {
        self.of_triangles.counted().surface().from_hull(self.from_hull)
    }
}

impl SurfaceArgs {
    pub const fn counted(self) -> Counted {
        Counted {
            all: self.all,
            max_edge: self.max_edge,
        }
    }
}
