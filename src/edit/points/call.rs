//! The calls of a transaction that concern points.

use crate::edit::error::EditError;
use crate::geometry::Point;
use crate::input::MissingZ;
use crate::memory::EditShares;
use crate::store::{Source, TileId};

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

    fn is_move(self) -> bool {
        matches!(self, Self::Move(_))
    }
}

/// A call by its number, with the tile in whose cell its position is.
pub(crate) type CallInTile = (TileId, u32);

/// The calls of a transaction that concern points, in order.
#[derive(Clone, Debug, Default)]
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
    has_moves: bool,
}

impl PointCalls {
    /// Returns calls whose points are known to be there, or not, as the calls need it.
    pub(crate) fn checked(all: Vec<PointCall>) -> Self {
        Self {
            has_moves: all.iter().any(|call| call.is_move()),
            all,
            skip_missing: true,
            missing_z: MissingZ::Zero,
            ..Self::default()
        }
    }

    /// Returns everything but the calls.
    pub(crate) fn without_calls(&self) -> Self {
        Self {
            all: Vec::new(),
            sources: self.sources.clone(),
            ..*self
        }
    }

    pub(crate) fn push(&mut self, call: PointCall) {
        self.has_moves |= call.is_move();
        self.all.push(call);
    }

    /// Adds those of the next transaction.
    pub(crate) fn append(&mut self, mut next: Self) {
        self.records = self.records.saturating_add(next.records);
        self.has_moves |= next.has_moves;
        self.all.append(&mut next.all);
    }

    /// Returns whether calls may concern positions in several tiles.
    pub(crate) fn has_moves(&self) -> bool {
        self.has_moves
    }

    /// Returns the bytes of memory that the calls take until they are carried out.
    pub(crate) fn memory(&self) -> u64 {
        self.memory_with(0, false)
    }

    /// Returns the bytes of memory that they take with more of them.
    pub(crate) fn memory_with(&self, more: usize, are_moves: bool) -> u64 {
        let of_call = match self.has_moves || are_moves {
            true => EditShares::MOVED_POINT_BYTES,
            false => EditShares::POINT_BYTES,
        };
        of_call * (self.all.len() + more) as u64
    }

    /// Returns whether any point has z.
    pub(crate) fn have_z(&self) -> bool {
        self.given().any(|(_, z)| !z.is_nan())
    }

    /// Returns the positions to which z may be given, and z.
    fn given(&self) -> impl Iterator<Item = (Point, f64)> {
        self.all
            .iter()
            .filter_map(|call| call.z().map(|z| (call.position(), z)))
    }

    /// Checks that points have z if the file has, and only then.
    pub(crate) fn check_z(&self, has_z: bool) -> Result<(), EditError> {
        let given = self.given();
        if !has_z {
            return if self.have_z() { Err(EditError::HasNoZ) } else { Ok(()) };
        }
        if self.missing_z == MissingZ::Zero {
            return Ok(());
        }
        let mut without = given.filter(|(_, z)| z.is_nan());
        without.next().map_or(Ok(()), |(point, _)| {
            let count = 1 + without.count() as u64;
            Err(EditError::PointWithoutZ { point, count })
        })
    }
}
