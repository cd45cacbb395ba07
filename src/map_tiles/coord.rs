//! Names of grids, and numbers of map tiles.

use std::fmt;
use std::str::FromStr;

use crate::geometry::Rect;

/// A grid of map tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GridKind {
    /// A quadtree over the coordinates of the file.
    Native,
    /// The quadtree of web maps, in EPSG:3857.
    WebMercatorQuad,
}

/// The text names no grid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no grid of this name; use native or WebMercatorQuad")]
pub struct UnknownGrid;

impl GridKind {
    /// All grids.
    pub const ALL: [Self; 2] = [Self::Native, Self::WebMercatorQuad];

    /// Returns the name: `native`, or `WebMercatorQuad` as the OGC names it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::WebMercatorQuad => "WebMercatorQuad",
        }
    }
}

impl fmt::Display for GridKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for GridKind {
    type Err = UnknownGrid;

    fn from_str(name: &str) -> Result<Self, UnknownGrid> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or(UnknownGrid)
    }
}

/// The number of a map tile. Row 0 is in the north, as in URLs with `{z}/{x}/{y}`.
///
/// ```
/// use delaunay_tiles::map_tiles::TileCoord;
///
/// let tile = TileCoord::new(2, 3, 0).unwrap();
/// assert_eq!((tile.z(), tile.x(), tile.y()), (2, 3, 0));
/// assert!(TileCoord::new(2, 4, 0).is_none() && TileCoord::new(31, 0, 0).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileCoord {
    z: u8,
    x: u32,
    y: u32,
}

impl TileCoord {
    /// The deepest zoom.
    pub const MAX_ZOOM: u8 = 30;

    /// Returns the tile of a zoom up to [`MAX_ZOOM`](Self::MAX_ZOOM), in a column and a row below
    /// 2ᶻ. `None` if there is no such tile.
    #[must_use]
    pub const fn new(z: u8, x: u32, y: u32) -> Option<Self> {
        if z <= Self::MAX_ZOOM && x < 1 << z && y < 1 << z {
            Some(Self { z, x, y })
        } else {
            None
        }
    }

    /// Returns the zoom.
    #[must_use]
    pub const fn z(self) -> u8 {
        self.z
    }

    /// Returns the column, from the west.
    #[must_use]
    pub const fn x(self) -> u32 {
        self.x
    }

    /// Returns the row, from the north.
    #[must_use]
    pub const fn y(self) -> u32 {
        self.y
    }
}

impl fmt::Display for TileCoord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.z, self.x, self.y)
    }
}

/// The number of a terrain tile in the grid that Cesium expects: longitude and latitude, two tiles
/// at zoom 0, and row 0 in the south.
///
/// ```
/// use delaunay_tiles::map_tiles::TerrainCoord;
///
/// let east = TerrainCoord::new(0, 1, 0).unwrap();
/// assert_eq!(east.bounds().min_x, 0.0);
/// assert!(TerrainCoord::new(0, 2, 0).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TerrainCoord {
    z: u8,
    x: u32,
    y: u32,
}

impl TerrainCoord {
    /// The deepest zoom.
    pub const MAX_ZOOM: u8 = 29;

    /// Returns the tile of a zoom up to [`MAX_ZOOM`](Self::MAX_ZOOM), in a column below 2ᶻ⁺¹ and a
    /// row below 2ᶻ. `None` if there is no such tile.
    #[must_use]
    pub const fn new(z: u8, x: u32, y: u32) -> Option<Self> {
        if z <= Self::MAX_ZOOM && x < 2 << z && y < 1 << z {
            Some(Self { z, x, y })
        } else {
            None
        }
    }

    /// Returns the zoom.
    #[must_use]
    pub const fn z(self) -> u8 {
        self.z
    }

    /// Returns the column, from the west.
    #[must_use]
    pub const fn x(self) -> u32 {
        self.x
    }

    /// Returns the row, from the south.
    #[must_use]
    pub const fn y(self) -> u32 {
        self.y
    }

    /// Returns the length of a side in degrees.
    #[must_use]
    pub fn side(self) -> f64 {
        180.0 / f64::from(1u32 << self.z)
    }

    /// Returns the longitudes and latitudes that the tile covers, in degrees.
    #[must_use]
    pub fn bounds(self) -> Rect {
        let [west, east] = [self.x, self.x + 1].map(|x| f64::from(x) * self.side() - 180.0);
        let [south, north] = [self.y, self.y + 1].map(|y| f64::from(y) * self.side() - 90.0);
        Rect::new(west, south, east, north)
    }
}

impl fmt::Display for TerrainCoord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.z, self.x, self.y)
    }
}
