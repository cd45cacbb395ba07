//! The options of `tiletool export` for map tiles.

use clap::Args;
use delaunay_tiles::map_archive::Zooms;
use delaunay_tiles::map_tiles::{GridKind, Layer};

use super::given::first_given;

/// Options for map tiles.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options for map tiles")]
pub struct MapArgs {
    /// What map tiles show: pictures, heights as colours, or vectors [default: shade]
    #[arg(long, value_name = "shade|terrarium|mesh")]
    pub layer: Option<Layer>,
    /// Grid of the map tiles; native is a quadtree over the coordinates of the file, which viewers show in
    /// place of the world [default: WebMercatorQuad if the file's coordinate reference system is known, else
    /// native]
    #[arg(long, value_name = "native|WebMercatorQuad")]
    pub grid: Option<GridKind>,
    /// Zooms to write, from 0 to 26, both ends included [default: from the first zoom that can be drawn to
    /// that at which a typical edge is 16 pixels long]
    #[arg(long, value_name = "FIRST..LAST")]
    pub zooms: Option<Zooms>,
    /// Maximum number of map tiles; more are an error that estimates their number and bytes [default:
    /// 1000000]
    #[arg(long, value_name = "COUNT")]
    pub max_tiles: Option<u64>,
    /// Maximum number of tiles of the file that a map tile may be drawn from, as for `tiletool serve`
    /// [default: 64]
    #[arg(long, value_name = "COUNT")]
    pub max_picture_tiles: Option<u32>,
    /// Number of map tiles that are drawn at once, as far as --memory suffices [default: two per processor]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub at_once: Option<u16>,
    /// Whom the data are of, as viewers show it
    #[arg(long, value_name = "TEXT")]
    pub attribution: Option<String>,
}

impl MapArgs {
    /// Returns the first option that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--layer", self.layer.is_some()),
            ("--grid", self.grid.is_some()),
            ("--zooms", self.zooms.is_some()),
            ("--max-tiles", self.max_tiles.is_some()),
            ("--max-picture-tiles", self.max_picture_tiles.is_some()),
            ("--at-once", self.at_once.is_some()),
            ("--attribution", self.attribution.is_some()),
        ];
        first_given(given)
    }
}
