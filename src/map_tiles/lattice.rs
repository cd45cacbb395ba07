//! Points of the file between transformed ones.
//!
//! A projection takes microseconds, and a tile has tens of thousands of pixels. So points are
//! transformed 8 pixels apart, and in each square of 16 by 16 pixels, those between are on the
//! surface of second degree through nine of them. The squares are the same for all tiles of a zoom.
//! What a projection bends more than that, over 16 pixels of a zoom of at least [`FIRST`], is less
//! than a thousandth of a pixel; at deep zooms it is less than the rounding of coordinates.

use crate::geometry::Point;
use crate::map_tiles::coord::TileCoord;
use crate::map_tiles::grid::{PIXELS, TileGrid, pixels_of};

/// The first zoom at which a projection is straight enough.
const FIRST: u8 = 5;
/// The side of a square in pixels.
const SQUARE: u32 = 16;
/// The number of squares along a tile with one more on each side.
const SQUARES: u32 = PIXELS / SQUARE + 2;
/// The number of transformed points along the squares.
const NODES: usize = 2 * SQUARES as usize + 1;

/// The transformed points of a tile.
pub(super) struct Lattice<'g> {
    grid: &'g TileGrid,
    at: TileCoord,
    /// Row by row from the north. NaN where there is no point.
    nodes: Vec<Point>,
}

impl<'g> Lattice<'g> {
    /// Transforms the points of a tile. `None` if points of the grid are exact and quick.
    pub(super) fn of(grid: &'g TileGrid, at: TileCoord) -> Option<Self> {
        if !grid.is_slow() || at.z() < FIRST {
            return None;
        }
        let fractions = |number: u32| -> Vec<f64> {
            let first = f64::from(number) * f64::from(PIXELS) - f64::from(SQUARE);
            let node = |i: usize| (first + i as f64 * f64::from(SQUARE / 2)) / pixels_of(at.z());
            (0..NODES).map(node).collect()
        };
        let nodes = grid.points(&fractions(at.x()), &fractions(at.y()));
        Some(Self { grid, at, nodes })
    }

    /// Returns the point at a place in pixels of the tile, which is in the tile or at most 16
    /// pixels outside.
    pub(super) fn point(&self, [x, y]: [f64; 2]) -> Point {
        let ((column, along), (row, across)) = (position(x), position(y));
        let node = |i: usize, j: usize| self.nodes[(2 * row + j) * NODES + 2 * column + i];
        let (u, v) = (weights(along), weights(across));
        let mut sum = Point::new(0.0, 0.0);
        // The differences from the middle are small, so that little is rounded.
        let middle = node(1, 1);
        for (j, v) in v.iter().enumerate() {
            for (i, u) in u.iter().enumerate() {
                let at = node(i, j);
                sum.x += u * v * (at.x - middle.x);
                sum.y += u * v * (at.y - middle.y);
            }
        }
        if sum.x.is_nan() || sum.y.is_nan() {
            return self.exact([x, y]);
        }
        Point::new(middle.x + sum.x, middle.y + sum.y)
    }

    fn exact(&self, [x, y]: [f64; 2]) -> Point {
        let share = |number: u32, v: f64| (f64::from(number) * f64::from(PIXELS) + v) / pixels_of(self.at.z());
        let point = self.grid.point_at([share(self.at.x(), x), share(self.at.y(), y)]);
        point.unwrap_or(Point::new(f64::NAN, f64::NAN))
    }
}

/// Returns the number of the square of a place, and the place in it from -1 to 1.
fn position(pixel: f64) -> (usize, f64) {
    let squares = (pixel + f64::from(SQUARE)) / f64::from(SQUARE);
    let number = squares.floor().clamp(0.0, f64::from(SQUARES - 1));
    (number as usize, 2.0 * (squares - number) - 1.0)
}

/// Returns the weights of the values at -1, 0 and 1 of the parabola through them.
fn weights(t: f64) -> [f64; 3] {
    [t * (t - 1.0) / 2.0, (1.0 - t) * (1.0 + t), t * (t + 1.0) / 2.0]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::crs::Crs;
    use crate::geometry::Rect;
    use crate::map_tiles::projection::Projection;

    #[test]
    fn points_between_are_a_thousandth_of_a_pixel_near_and_neighbours_agree() {
        let bounds = Rect::new(300_000.0, 5_000_000.0, 700_000.0, 5_600_000.0);
        let projection = Arc::new(Projection::of(&Crs::new("EPSG:32632"), bounds).unwrap());
        let grid = TileGrid::mercator(bounds, 10.0, &projection, String::new()).unwrap();
        let [x, y] = grid.fraction(Point::new(650_000.0, 5_550_000.0)).unwrap();
        for zoom in [5, 8, 12, 18, 24] {
            let number = |share: f64| (share * f64::from(1u32 << zoom)) as u32;
            let at = TileCoord::new(zoom, number(x), number(y)).unwrap();
            let east = TileCoord::new(zoom, number(x) + 1, number(y)).unwrap();
            let lattice = Lattice::of(&grid, at).unwrap();
            let beside = Lattice::of(&grid, east).unwrap();
            for i in 0..200 {
                let pixel = [f64::from(i * 37 % 256) + 0.5, f64::from(i * 91 % 256) + 0.375];
                let (near, exact) = (lattice.point(pixel), lattice.exact(pixel));
                let far = (near.x - exact.x).hypot(near.y - exact.y);
                assert!(far < grid.pixel_size(zoom) / 1000.0 + 1e-8, "{zoom} {far}");
                let border = [256.0 + f64::from(i % 8), pixel[1]];
                assert_eq!(lattice.point(border), beside.point([border[0] - 256.0, border[1]]));
            }
        }
        assert!(Lattice::of(&grid, TileCoord::new(4, 8, 5).unwrap()).is_none());
    }
}
