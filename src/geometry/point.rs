//! Points and rectangles.

use std::cmp::Ordering;

/// A point in the plane, in the units of the input.
///
/// The coordinates of every point in a triangulation are finite. Their magnitude is zero or within
/// [`Point::MIN_MAGNITUDE`]..=[`Point::MAX_MAGNITUDE`], and a zero is never negative
/// ([`Point::normalized`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Point {
    /// Easting, longitude or column.
    pub x: f64,
    /// Northing, latitude or row.
    pub y: f64,
}

impl Point {
    /// The smallest magnitude of a nonzero coordinate: 2⁻¹⁴². Below it the exact predicates
    /// could underflow.
    pub const MIN_MAGNITUDE: f64 = f64::from_bits((1023 - 142) << 52);
    /// The largest magnitude of a coordinate: 2²⁰⁰. Above it the exact predicates could
    /// overflow.
    pub const MAX_MAGNITUDE: f64 = f64::from_bits((1023 + 200) << 52);

    /// Creates a point from its coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Returns the same point with -0.0 replaced by 0.0, so that equal points have equal bits.
    #[must_use]
    pub fn normalized(self) -> Self {
        Self {
            x: self.x + 0.0,
            y: self.y + 0.0,
        }
    }

    /// Returns whether both coordinates are finite and within the limits of the exact predicates.
    #[must_use]
    pub fn is_valid(self) -> bool {
        fn ok(v: f64) -> bool {
            let magnitude = v.abs();
            magnitude == 0.0 || (Point::MIN_MAGNITUDE..=Point::MAX_MAGNITUDE).contains(&magnitude)
        }
        ok(self.x) && ok(self.y)
    }

    /// Returns a point that the exact predicates can take, for a point that is not from a
    /// triangulation: a coordinate closer to 0 than [`Point::MIN_MAGNITUDE`] becomes 0. Coordinates
    /// that are too large stay, because they are outside every triangulation.
    pub(crate) fn representable(self) -> Self {
        let coordinate = |v: f64| if v.abs() < Self::MIN_MAGNITUDE { 0.0 } else { v };
        Self::new(coordinate(self.x), coordinate(self.y)).normalized()
    }

    /// Returns the bits of its coordinates, by which equal points are found in tables.
    pub(crate) fn bits(self) -> [u64; 2] {
        [self.x, self.y].map(f64::to_bits)
    }

    /// Compares two points by x, then by y: the order that breaks ties. Coordinates must not be
    /// NaN.
    #[must_use]
    pub fn lex_cmp(self, other: Self) -> Ordering {
        if self.x < other.x {
            Ordering::Less
        } else if self.x > other.x {
            Ordering::Greater
        } else if self.y < other.y {
            Ordering::Less
        } else if self.y > other.y {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    }
}

/// An axis-parallel rectangle. It is empty if a minimum exceeds its maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// The left side.
    pub min_x: f64,
    /// The bottom side.
    pub min_y: f64,
    /// The right side.
    pub max_x: f64,
    /// The top side.
    pub max_y: f64,
}

impl Rect {
    /// The rectangle that contains no point.
    pub const EMPTY: Self = Self::new(f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
    /// The whole plane.
    pub const PLANE: Self = Self::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY);

    /// Creates a rectangle from its left, bottom, right and top side.
    #[must_use]
    pub const fn new(min_x: f64, min_y: f64, max_x: f64, max_y: f64) -> Self {
        Self {
            min_x,
            min_y,
            max_x,
            max_y,
        }
    }

    /// Returns the smallest rectangle around `points`.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Point>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::including)
    }

    /// Returns the smallest rectangle around this one and `p`.
    #[must_use]
    pub fn including(self, p: Point) -> Self {
        Self::new(
            self.min_x.min(p.x),
            self.min_y.min(p.y),
            self.max_x.max(p.x),
            self.max_y.max(p.y),
        )
    }

    /// Returns the smallest rectangle around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self::new(
            self.min_x.min(other.min_x),
            self.min_y.min(other.min_y),
            self.max_x.max(other.max_x),
            self.max_y.max(other.max_y),
        )
    }

    /// Returns whether the rectangle contains no point.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !(self.min_x <= self.max_x && self.min_y <= self.max_y)
    }

    /// Returns whether the closed rectangle contains `p`.
    #[must_use]
    pub fn contains(self, p: Point) -> bool {
        self.min_x <= p.x && p.x <= self.max_x && self.min_y <= p.y && p.y <= self.max_y
    }

    /// Returns whether the two closed rectangles have a point in common.
    #[must_use]
    pub fn intersects(self, other: Self) -> bool {
        self.min_x <= other.max_x && other.min_x <= self.max_x && self.min_y <= other.max_y && other.min_y <= self.max_y
    }

    /// Returns the width and the height.
    #[must_use]
    pub fn size(self) -> (f64, f64) {
        (self.max_x - self.min_x, self.max_y - self.min_y)
    }
}
