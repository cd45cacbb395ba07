//! The calls of a transaction that concern points.

use crate::geometry::Point;
use crate::input::MissingZ;
use crate::store::Source;

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

/// The calls of a transaction that concern points, in order.
#[derive(Debug, Default)]
pub(crate) struct PointCalls {
    pub(crate) all: Vec<PointCall>,
    /// The number of record numbers for the points that are inserted.
    pub(crate) records: u64,
    /// The files from which the inserted points come.
    pub(crate) sources: Vec<Source>,
    /// Whether to leave out changes of points that are not there.
    pub(crate) skip_missing: bool,
    /// What to do with points that have no z, if the file has z.
    pub(crate) missing_z: MissingZ,
}
