//! A call of a transaction that concerns points.

use crate::geometry::Point;
use crate::store::TileId;

/// A call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PointCall {
    /// Inserts a point, with z or [`NO_Z`](crate::constraints::without_z::NO_Z), and its record
    /// number.
    Insert(Point, f64, u64),
    /// Deletes the point at a position.
    Delete(Point),
    /// Moves the point from one position to another, with its z and its record number.
    Move([Point; 2]),
    /// Gives the point at a position a z.
    SetZ(Point, f64),
}

impl PointCall {
    /// Returns the positions that it concerns.
    pub(crate) fn positions(self) -> [Option<Point>; 2] {
        match self {
            Self::Move([from, to]) => [Some(from), Some(to)],
            Self::Insert(point, ..) | Self::Delete(point) | Self::SetZ(point, _) => [Some(point), None],
        }
    }

    /// Returns the position whose point it changes, or that gets a point.
    pub(crate) fn position(self) -> Point {
        let (Self::Insert(point, ..) | Self::Delete(point) | Self::Move([point, _]) | Self::SetZ(point, _)) = self;
        point
    }

    /// Returns the z that it gives, which may be missing.
    pub(crate) fn z(self) -> Option<f64> {
        match self {
            Self::Insert(_, z, _) | Self::SetZ(_, z) => Some(z),
            Self::Delete(_) | Self::Move(_) => None,
        }
    }

    pub(crate) fn is_move(self) -> bool {
        matches!(self, Self::Move(_))
    }
}

/// A call by its number, with the tile in whose cell its position is.
pub(crate) type CallInTile = (TileId, u32);
