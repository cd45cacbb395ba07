//! The triangles that count.

use clap::Args;
use delaunay_tiles::terrain::Surface;

use crate::surface::length;

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
        self.of_triangles.surface().from_hull(self.from_hull)
    }
}

impl SurfaceArgs {
    pub fn surface(self) -> Surface {
        Surface::default().holes(self.all).max_edge(self.max_edge)
    }

    /// Returns why a point within the hull is not on the surface.
    pub fn why_not(self) -> &'static str {
        match (self.all, self.max_edge) {
            (false, None) => "in a hole",
            (false, Some(_)) => "in a hole, or in a triangle that --max-edge leaves out",
            (true, _) => "in a triangle that --max-edge leaves out",
        }
    }
}
