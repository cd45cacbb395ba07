//! Morton keys: positions along a curve that visits the quarters of a square one after the other.
//!
//! Source: Morton, "A computer oriented geodetic data base and a new technique in file sequencing"
//! (1966).

use crate::geometry::point::{Point, Rect};

/// A square around points, cut 2³² times along each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MortonSquare {
    min_x: f64,
    min_y: f64,
    scale: f64,
}

impl MortonSquare {
    /// Returns the square around the rectangle `bounds`. If the rectangle has no extent, all keys
    /// are 0.
    pub(crate) fn around(bounds: Rect) -> Self {
        let (width, height) = bounds.size();
        let side = width.max(height);
        Self {
            min_x: bounds.min_x,
            min_y: bounds.min_y,
            scale: if side > 0.0 { f64::from(u32::MAX) / side } else { 0.0 },
        }
    }

    /// Returns the key of a point of the rectangle: the bits of both coordinates, interleaved, with
    /// those of x at the odd positions.
    ///
    /// Rounding and saturating casts preserve the order: if the bits of one key place it left of
    /// another, its point is left of the other's point. The same holds for below.
    #[inline]
    pub(crate) fn key(self, p: Point) -> u64 {
        let (x, y) = ((p.x - self.min_x) * self.scale, (p.y - self.min_y) * self.scale);
        spread(x as u32) << 1 | spread(y as u32)
    }
}

/// Returns the indices of points, in an order in which points that follow each other are mostly near
/// each other.
///
/// Questions about points that are asked in this order find most of the tiles that they need in the
/// cache, because the questions before them needed the same.
///
/// # Examples
/// ```
/// use delaunay_tiles::geometry::{Point, curve_order};
///
/// let points = [[0.0, 0.0], [9.0, 9.0], [1.0, 0.0], [8.0, 9.0]].map(|[x, y]| Point::new(x, y));
/// assert_eq!(curve_order(&points), [0, 2, 3, 1]);
/// ```
#[must_use]
pub fn curve_order(points: &[Point]) -> Vec<usize> {
    let square = MortonSquare::around(Rect::around(points.iter().copied()));
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_cached_key(|&index| square.key(points[index]));
    order
}

/// Returns the bits of a number with a 0 before each.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    v = (v | v << 16) & 0x0000_ffff_0000_ffff;
    v = (v | v << 8) & 0x00ff_00ff_00ff_00ff;
    v = (v | v << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v | v << 2) & 0x3333_3333_3333_3333;
    (v | v << 1) & 0x5555_5555_5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_visit_the_quarters_of_the_square_in_order() {
        let square = MortonSquare::around(Rect::new(-1.0, -1.0, 3.0, 3.0));
        let quarter = |x, y| square.key(Point::new(x, y)) >> 62;
        assert_eq!(
            [
                quarter(-1.0, -1.0),
                quarter(-1.0, 3.0),
                quarter(3.0, -1.0),
                quarter(3.0, 3.0)
            ],
            [0, 1, 2, 3]
        );
        assert_eq!(square.key(Point::new(-1.0, -1.0)), 0);
        let point = MortonSquare::around(Rect::around([Point::new(7.0, 7.0)]));
        assert_eq!(point.key(Point::new(7.0, 7.0)), 0);
    }
}
