//! Grids of map tiles over the coordinates of a file.
//!
//! Places in a grid are *fractions*: shares of the side of the grid's square, from the west and
//! from the north. The pixel `k` of a zoom, counted over all tiles, has its centre at the fraction
//! `(k + 0.5) / 2^(z + 8)`. So the place of a pixel does not depend on the tile that asks for it.

use std::sync::Arc;

use crate::geometry::{Point, Rect};
use crate::map_tiles::coord::{GridKind, TileCoord};
use crate::map_tiles::drawn::NoGrid;
use crate::map_tiles::projection::{Projection, lon_lat_of_fraction};

/// The side of a map tile in pixels.
pub(super) const PIXELS: u32 = 256;
/// The typical length of an edge in pixels at the deepest zoom that a grid proposes.
const FINEST: f64 = 16.0;
/// The number of parts of a side for which a transformed rectangle is looked at.
const PARTS: u32 = 8;
/// How much larger a transformed rectangle is made, as a share of its size, because its sides are
/// curves between the places that were looked at.
const BULGE: f64 = 0.03;

/// A grid of map tiles over a file.
///
/// The grid [`Native`](GridKind::Native) is a square of the file's coordinates. Its side is the
/// smallest power of two for which a square contains all vertices and has its lower left corner at
/// multiples of a quarter of the side. So tiles stay where they are if the vertices change, unless
/// they leave the square.
#[derive(Clone)]
pub struct TileGrid {
    kind: GridKind,
    /// The square in coordinates of the grid.
    square: Rect,
    /// The bounds of the vertices, in fractions; somewhat larger if they are transformed.
    extent: Rect,
    /// The side of the square in units of the file, at the centre of the file.
    side: f64,
    spacing: f64,
    projection: Option<Arc<Projection>>,
    lon_lat: Option<Rect>,
}

impl TileGrid {
    /// Returns the grid over the file's own coordinates. `spacing` is the typical length of an
    /// edge.
    pub(super) fn native(bounds: Rect, spacing: f64, projection: Option<Arc<Projection>>) -> Result<Self, NoGrid> {
        if bounds.is_empty() {
            return Err(NoGrid::Empty);
        }
        let square = square_around(bounds);
        let side = square.max_x - square.min_x;
        let mut this = Self {
            kind: GridKind::Native,
            square,
            extent: Rect::EMPTY,
            side,
            spacing,
            lon_lat: projection
                .as_deref()
                .and_then(|projection| lon_lat_around(projection, bounds)),
            projection,
        };
        let [west, north] = this.native_fraction(Point::new(bounds.min_x, bounds.max_y));
        let [east, south] = this.native_fraction(Point::new(bounds.max_x, bounds.min_y));
        this.extent = Rect::new(west, north, east, south);
        Ok(this)
    }

    /// Returns the grid of Web Mercator over a file. `name` is that of its reference system.
    pub(super) fn mercator(
        bounds: Rect,
        spacing: f64,
        projection: &Arc<Projection>,
        name: String,
    ) -> Result<Self, NoGrid> {
        if bounds.is_empty() {
            return Err(NoGrid::Empty);
        }
        let outside = NoGrid::Outside { crs: name };
        let Some(lon_lat) = lon_lat_around(projection, bounds) else {
            return Err(outside);
        };
        let extent = around(bounds, |p| projection.to_mercator(p));
        let extent = Rect::new(extent.min_x, extent.min_y.max(0.0), extent.max_x, extent.max_y.min(1.0));
        let centre = Point::new(middle(bounds.min_x, bounds.max_x), middle(bounds.min_y, bounds.max_y));
        let side = projection.to_mercator(centre).and_then(|at| side_at(projection, at));
        let (Some(side), false) = (side, extent.is_empty()) else {
            return Err(outside);
        };
        let half = 20_037_508.342_789_244;
        Ok(Self {
            kind: GridKind::WebMercatorQuad,
            square: Rect::new(-half, -half, half, half),
            extent,
            side,
            spacing,
            projection: Some(Arc::clone(projection)),
            lon_lat: Some(lon_lat),
        })
    }

    /// Returns the kind of the grid.
    #[must_use]
    pub fn kind(&self) -> GridKind {
        self.kind
    }

    /// Returns the square that the tile of zoom 0 covers, in coordinates of the grid: those of the
    /// file, or metres of EPSG:3857.
    #[must_use]
    pub fn square(&self) -> Rect {
        self.square
    }

    /// Returns a rectangle around all vertices, in coordinates of the grid. In Web Mercator it is
    /// somewhat larger than the smallest one.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        let side = self.square.max_x - self.square.min_x;
        let x = |share: f64| self.square.min_x + side * share;
        let y = |share: f64| self.square.max_y - side * share;
        let extent = self.extent;
        Rect::new(x(extent.min_x), y(extent.max_y), x(extent.max_x), y(extent.min_y))
    }

    /// Returns a rectangle around all vertices in degrees of longitude and latitude, if the
    /// reference system of the file is known. It is somewhat larger than the smallest one.
    #[must_use]
    pub fn lon_lat_bounds(&self) -> Option<Rect> {
        self.lon_lat
    }

    /// Returns where a viewer of Web Mercator shows the vertices, in degrees of longitude and latitude:
    /// a rectangle around them. A viewer that is given tiles of the grid
    /// [`Native`](GridKind::Native) shows the square of the grid in place of the world.
    #[must_use]
    pub fn shown_bounds(&self) -> Rect {
        let extent = self.extent;
        let place = |x: f64, y: f64| {
            let [lon, lat] = lon_lat_of_fraction([x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)]);
            Point::new(lon, lat)
        };
        Rect::around([place(extent.min_x, extent.max_y), place(extent.max_x, extent.min_y)])
    }

    /// Returns the zoom at which a typical edge is 16 pixels long. Deeper tiles are drawn too.
    #[must_use]
    pub fn max_zoom(&self) -> u8 {
        let finest = |z: &u8| self.pixel_size(*z) * FINEST <= self.spacing;
        // Without a spacing, as in a file with one vertex, any zoom will do.
        let deepest = if self.spacing > 0.0 { TileCoord::MAX_ZOOM } else { 0 };
        (0..deepest).find(finest).unwrap_or(deepest)
    }

    /// Returns the place of a point of the file: shares of the side of the square, from the west
    /// and from the north. `None` if it has no place in the grid.
    #[must_use]
    pub fn fraction(&self, p: Point) -> Option<[f64; 2]> {
        match (self.kind, &self.projection) {
            (GridKind::WebMercatorQuad, Some(projection)) => projection.to_mercator(p),
            _ => Some(self.native_fraction(p)),
        }
    }

    /// Returns the point of the file at a place; the inverse of [`fraction`](Self::fraction), but
    /// for rounding.
    #[must_use]
    pub fn point_at(&self, fraction: [f64; 2]) -> Option<Point> {
        match (self.kind, &self.projection) {
            (GridKind::WebMercatorQuad, Some(projection)) => projection.of_mercator(fraction),
            _ => {
                let [x, y] = fraction;
                Some(Point::new(
                    self.square.min_x + self.side * x,
                    self.square.max_y - self.side * y,
                ))
            }
        }
    }

    /// Returns the points of the file at all places in these columns and rows, row by row. Where
    /// there is none, its coordinates are NaN.
    pub(super) fn points(&self, columns: &[f64], rows: &[f64]) -> Vec<Point> {
        match (self.kind, &self.projection) {
            (GridKind::WebMercatorQuad, Some(projection)) => projection.of_mercators(columns, rows),
            _ => {
                let x: Vec<f64> = columns.iter().map(|x| self.square.min_x + self.side * x).collect();
                let y = rows.iter().map(|y| self.square.max_y - self.side * y);
                y.flat_map(|y| x.iter().map(move |&x| Point::new(x, y))).collect()
            }
        }
    }

    /// Returns the size of a pixel in units of the file, at the centre of the file.
    pub(super) fn pixel_size(&self, zoom: u8) -> f64 {
        self.side / pixels_of(zoom)
    }

    /// Returns the typical length of a degree in units of the file, at the centre of the file. The
    /// grid is that of Web Mercator.
    pub(super) fn degree(&self) -> f64 {
        let lat = self.lon_lat.map_or(0.0, |bounds| middle(bounds.min_y, bounds.max_y));
        // The mean of a degree of longitude and one of latitude, which is longer.
        self.side / 360.0 / lat.to_radians().cos().max(1e-3).sqrt()
    }

    /// Returns the typical length of an edge in pixels.
    pub(super) fn edge_pixels(&self, zoom: u8) -> f64 {
        self.spacing / self.pixel_size(zoom)
    }

    /// Returns the bounds of the file in fractions.
    pub(super) fn extent(&self) -> Rect {
        self.extent
    }

    /// Returns how the file is on Earth, if it is known.
    pub(super) fn projection(&self) -> Option<&Arc<Projection>> {
        self.projection.as_ref()
    }

    /// Returns whether the points of the file at places in the grid take long to compute.
    pub(super) fn is_slow(&self) -> bool {
        match (self.kind, &self.projection) {
            (GridKind::WebMercatorQuad, Some(projection)) => projection.is_slow(),
            _ => false,
        }
    }

    /// Returns whether segments of the file are straight in the grid.
    pub(super) fn is_straight(&self) -> bool {
        match (self.kind, &self.projection) {
            (GridKind::WebMercatorQuad, Some(projection)) => projection.is_mercator(),
            _ => true,
        }
    }

    /// Returns the size of a pixel in metres, to the east and to the north, at the fraction `y`
    /// from the north. `plane` is the unit of the file in metres, `None` if it is a degree.
    pub(super) fn pixel_metres(&self, zoom: u8, y: f64, plane: Option<f64>) -> [f64; 2] {
        /// Of a degree on the sphere of Web Mercator.
        const DEGREE: f64 = 40_075_016.685_578_49 / 360.0;
        let share = 1.0 / pixels_of(zoom);
        let side = self.square.max_x - self.square.min_x;
        match (self.kind, plane) {
            (GridKind::WebMercatorQuad, _) => {
                let [_, lat] = lon_lat_of_fraction([0.5, y]);
                [share * side * lat.to_radians().cos(); 2]
            }
            (GridKind::Native, Some(unit)) => [share * side * unit; 2],
            (GridKind::Native, None) => {
                let lat = (self.square.max_y - side * y).clamp(-89.9, 89.9);
                [share * side * DEGREE * lat.to_radians().cos(), share * side * DEGREE]
            }
        }
    }

    /// Returns a rectangle of the file that contains all of its points in some tile and in a margin
    /// of pixels around it; an empty one if there are none.
    pub(super) fn rect_of(&self, at: TileCoord, margin: f64) -> Rect {
        let tile = fractions_of(at, margin);
        let cut = Rect::new(
            tile.min_x.max(self.extent.min_x),
            tile.min_y.max(self.extent.min_y),
            tile.max_x.min(self.extent.max_x),
            tile.max_y.min(self.extent.max_y),
        );
        if cut.is_empty() {
            return Rect::EMPTY;
        }
        if self.kind == GridKind::Native {
            // All of the tile, and not what it has of the extent, which is rounded.
            let corners = [[tile.min_x, tile.max_y], [tile.max_x, tile.min_y]];
            return Rect::around(corners.into_iter().filter_map(|corner| self.point_at(corner)));
        }
        around(cut, |p| self.point_at([p.x, p.y]).map(|p| [p.x, p.y]))
    }

    fn native_fraction(&self, p: Point) -> [f64; 2] {
        [
            (p.x - self.square.min_x) / self.side,
            (self.square.max_y - p.y) / self.side,
        ]
    }
}

/// Returns the number of pixels along a side of the square.
pub(super) fn pixels_of(zoom: u8) -> f64 {
    f64::from(PIXELS) * f64::from(1u32 << zoom)
}

/// Returns the fractions that a tile covers with a margin of pixels.
pub(super) fn fractions_of(at: TileCoord, margin: f64) -> Rect {
    let all = pixels_of(at.z());
    let [west, north] = [at.x(), at.y()].map(|number| f64::from(number) * f64::from(PIXELS));
    let side = f64::from(PIXELS) + margin;
    Rect::new(
        (west - margin) / all,
        (north - margin) / all,
        (west + side) / all,
        (north + side) / all,
    )
}

/// Returns the square of the native grid around bounds.
fn square_around(bounds: Rect) -> Rect {
    let (width, height) = bounds.size();
    let magnitude = [bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y]
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    // The side must be large enough that coordinates differ along it.
    let least = width.max(height).max(magnitude * f64::EPSILON * 256.0);
    let mut side = match least > 0.0 {
        true => 2f64.powi(least.log2().floor() as i32),
        false => 1.0,
    };
    loop {
        let step = side / 4.0;
        let [x, y] = [bounds.min_x, bounds.min_y].map(|v| (v / step).floor() * step);
        if x + side >= bounds.max_x && y + side >= bounds.max_y {
            return Rect::new(x, y, x + side, y + side);
        }
        side *= 2.0;
    }
}

fn middle(a: f64, b: f64) -> f64 {
    a + (b - a) / 2.0
}

/// Returns a rectangle around the image of a rectangle; an empty one if no place has an image.
pub(super) fn around(rect: Rect, image: impl Fn(Point) -> Option<[f64; 2]>) -> Rect {
    let (width, height) = rect.size();
    let share = |part: u32| f64::from(part) / f64::from(PARTS);
    let places = (0..=PARTS).flat_map(|row| (0..=PARTS).map(move |column| (share(column), share(row))));
    let places = places.map(|(x, y)| Point::new(rect.min_x + width * x, rect.min_y + height * y));
    let found = Rect::around(places.filter_map(|p| image(p).map(|[x, y]| Point::new(x, y))));
    let (width, height) = found.size();
    let bulge = BULGE * width.max(height);
    Rect::new(
        found.min_x - bulge,
        found.min_y - bulge,
        found.max_x + bulge,
        found.max_y + bulge,
    )
}

/// Returns a rectangle around bounds in longitude and latitude.
fn lon_lat_around(projection: &Projection, bounds: Rect) -> Option<Rect> {
    let found = match projection.is_geographic() {
        true => {
            let corners = [
                Point::new(bounds.min_x, bounds.min_y),
                Point::new(bounds.max_x, bounds.max_y),
            ];
            Rect::around(
                corners
                    .iter()
                    .filter_map(|&p| projection.to_lon_lat(p))
                    .map(|[x, y]| Point::new(x, y)),
            )
        }
        false => around(bounds, |p| projection.to_lon_lat(p)),
    };
    let found = Rect::new(found.min_x, found.min_y.max(-90.0), found.max_x, found.max_y.min(90.0));
    (!found.is_empty()).then_some(found)
}

/// Returns the side of the square of Web Mercator in units of the file, as it is near a place.
fn side_at(projection: &Projection, [x, y]: [f64; 2]) -> Option<f64> {
    const STEP: f64 = 1.0 / (1u64 << 24) as f64;
    let at = |dx: f64, dy: f64| projection.of_mercator([x + dx, y + dy]);
    let (west, east, north, south) = (at(-STEP, 0.0)?, at(STEP, 0.0)?, at(0.0, -STEP)?, at(0.0, STEP)?);
    let (ax, ay) = (east.x - west.x, east.y - west.y);
    let (bx, by) = (south.x - north.x, south.y - north.y);
    let side = (ax * by - ay * bx).abs().sqrt() / (2.0 * STEP);
    (side.is_finite() && side > 0.0).then_some(side)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn native(bounds: Rect) -> TileGrid {
        TileGrid::native(bounds, 1.0, None).unwrap()
    }

    #[test]
    fn the_native_square_contains_the_bounds_and_stays_when_they_change_a_little() {
        for bounds in [
            Rect::new(0.0, 0.0, 100.0, 50.0),
            Rect::new(-3.0, -2.0, 5.0, 1.0),
            Rect::new(635_577.79, 848_882.15, 639_003.73, 853_537.66),
            Rect::new(1e15, 1e15, 1e15 + 0.5, 1e15),
            Rect::new(7.0, 7.0, 7.0, 7.0),
            Rect::new(0.0, 0.0, 0.0, 0.0),
        ] {
            let square = native(bounds).square();
            assert!(
                square.min_x <= bounds.min_x && square.max_x >= bounds.max_x,
                "{bounds:?} {square:?}"
            );
            assert!(
                square.min_y <= bounds.min_y && square.max_y >= bounds.max_y,
                "{bounds:?} {square:?}"
            );
            let (side, height) = square.size();
            assert_eq!((side, side.log2().fract()), (height, 0.0));
        }
        let [one, other] = [0.0, 0.3].map(|more| native(Rect::new(10.2, 10.2, 70.0 + more, 40.0)).square());
        assert_eq!(one, other);
    }

    #[test]
    fn fractions_lead_back_to_their_points() {
        let bounds = Rect::new(100.0, 200.0, 400.0, 300.0);
        let projection = Arc::new(Projection::of(&crate::crs::Crs::new("EPSG:32632"), Rect::EMPTY).unwrap());
        let far = Rect::new(400_000.0, 5_000_000.0, 600_000.0, 5_100_000.0);
        let mercator = TileGrid::mercator(far, 10.0, &projection, String::new()).unwrap();
        for (grid, p) in [
            (native(bounds), Point::new(321.5, 222.25)),
            (mercator, Point::new(432_100.0, 5_054_321.0)),
        ] {
            let there = grid.point_at(grid.fraction(p).unwrap()).unwrap();
            assert!(
                (there.x - p.x).abs() < 1e-6 && (there.y - p.y).abs() < 1e-6,
                "{there:?}"
            );
        }
    }

    #[test]
    fn a_tile_has_the_points_that_are_in_it() {
        let projection = Arc::new(Projection::of(&crate::crs::Crs::new("EPSG:32632"), Rect::EMPTY).unwrap());
        let bounds = Rect::new(300_000.0, 5_000_000.0, 700_000.0, 5_600_000.0);
        let grid = TileGrid::mercator(bounds, 10.0, &projection, String::new()).unwrap();
        for i in 0..400 {
            let (column, row) = (f64::from(i % 20) / 19.0, f64::from(i / 20) / 19.0);
            let p = Point::new(300_000.0 + 400_000.0 * column, 5_000_000.0 + 600_000.0 * row);
            let [x, y] = grid.fraction(p).unwrap();
            for z in 0..20 {
                let number = |share: f64| (share * f64::from(1u32 << z)) as u32;
                let at = TileCoord::new(z, number(x), number(y)).unwrap();
                assert!(grid.rect_of(at, 0.0).contains(p), "{at} {p:?}");
            }
        }
        assert!(grid.rect_of(TileCoord::new(3, 0, 0).unwrap(), 0.0).is_empty());
    }

    #[test]
    fn a_degree_is_about_as_many_pixels_as_it_should_be() {
        let projection = Arc::new(Projection::of(&crate::crs::Crs::new("EPSG:4326"), Rect::EMPTY).unwrap());
        let grid = TileGrid::mercator(Rect::new(-1.0, -1.0, 1.0, 1.0), 1.0, &projection, String::new()).unwrap();
        assert!((grid.pixel_size(0) - 360.0 / 256.0).abs() < 1e-6);
    }
}
