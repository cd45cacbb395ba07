//! The calls of a transaction that concern points, in memory and on disk.

use std::io;
use std::path::Path;

use crate::edit::error::EditError;
use crate::edit::points::call::PointCall;
use crate::edit::points::spilled::SpilledCalls;
use crate::geometry::{Point, Rect};
use crate::input::MissingZ;
use crate::memory::EditShares;
use crate::store::Source;

/// The calls of a transaction that concern points, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointCalls {
    /// The calls, or those that follow the spilled ones.
    pub(crate) all: Vec<PointCall>,
    /// The calls before, on disk.
    pub(crate) spilled: Option<SpilledCalls>,
    /// The number of calls before `all`.
    first: u64,
    /// The number of record numbers for the points that are inserted.
    pub(crate) records: u64,
    /// The files from which the inserted points come.
    pub(crate) sources: Vec<Source>,
    /// Whether to leave out changes of points that are not there.
    pub(crate) skip_missing: bool,
    /// What to do with points that have no z, if the file has z.
    pub(crate) missing_z: MissingZ,
    /// Whether any of `all` is a move.
    has_moves: bool,
    /// The bytes that the largest spilled part takes when it is carried out.
    of_part: u64,
    given: GivenZ,
}

/// What calls say of z.
#[derive(Clone, Copy, Debug, Default)]
struct GivenZ {
    /// Whether any gives one.
    any: bool,
    /// The first position that lacks one, and the number of these.
    lacking: Option<(Point, u64)>,
}

impl PointCalls {
    /// Returns calls whose points are known to be there, or not, as the calls need it.
    pub(crate) fn checked(all: Vec<PointCall>) -> Self {
        let mut calls = Self {
            skip_missing: true,
            missing_z: MissingZ::Zero,
            ..Self::default()
        };
        all.into_iter().for_each(|call| calls.push(call));
        calls
    }

    /// Returns everything but the calls.
    pub(crate) fn without_calls(&self) -> Self {
        Self {
            records: self.records,
            sources: self.sources.clone(),
            ..Self::default()
        }
    }

    pub(crate) fn push(&mut self, call: PointCall) {
        self.has_moves |= call.is_move();
        match call.z() {
            Some(z) if z.is_nan() => {
                let (_, count) = self.given.lacking.get_or_insert((call.position(), 0));
                *count += 1;
            }
            Some(_) => self.given.any = true,
            None => {}
        }
        self.all.push(call);
    }

    /// Adds those of the next transaction, none of which are spilled.
    pub(crate) fn append(&mut self, next: Self) {
        self.records = self.records.saturating_add(next.records);
        next.all.into_iter().for_each(|call| self.push(call));
    }

    /// Returns the number of calls.
    pub(crate) fn len(&self) -> u64 {
        self.first + self.all.len() as u64
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Moves the calls in memory to disk, to a file in a folder, in parts that take up to `bytes` of
    /// memory when they are carried out.
    pub(crate) fn spill(&mut self, folder: &Path, bytes: u64) -> io::Result<()> {
        let of_call = self.memory_of_call(false);
        let in_part = (bytes / of_call).clamp(1, u32::MAX.into()) as usize;
        let spilled = match &mut self.spilled {
            Some(spilled) => spilled,
            none => none.insert(SpilledCalls::in_folder(folder)?),
        };
        while !self.all.is_empty() {
            let count = self.all.len().min(in_part);
            spilled.push(&self.all[..count])?;
            // If the next part cannot be written, this one is not written again.
            self.all.drain(..count);
            self.first += count as u64;
            self.of_part = self.of_part.max(of_call * count as u64);
        }
        // Parts that are read need the memory.
        self.all = Vec::new();
        self.has_moves = false;
        Ok(())
    }

    /// Reads a part of the spilled calls, of which there are some.
    pub(crate) fn part(&self, part: usize) -> io::Result<Self> {
        let spilled = self.spilled.as_ref().ok_or(io::ErrorKind::NotFound)?;
        let all = spilled.part(part)?;
        Ok(Self {
            has_moves: all.iter().any(|call| call.is_move()),
            all,
            first: spilled.first_of(part),
            missing_z: MissingZ::Zero,
            ..Self::default()
        })
    }

    /// Returns the number of one of the calls in memory among all calls.
    pub(crate) fn number(&self, in_memory: u32) -> u64 {
        self.first + u64::from(in_memory)
    }

    /// Returns a box around the positions that they concern.
    pub(crate) fn bounds(&self) -> Rect {
        let positions = self.all.iter().flat_map(|call| call.positions()).flatten();
        let spilled = self.spilled.as_ref().map_or(Rect::EMPTY, |spilled| spilled.bounds);
        Rect::around(positions).union(spilled)
    }

    /// Returns whether calls in memory may concern positions in several tiles.
    pub(crate) fn has_moves(&self) -> bool {
        self.has_moves
    }

    /// Returns the bytes of memory that the calls take until they are carried out.
    pub(crate) fn memory(&self) -> u64 {
        self.memory_with(0, false)
    }

    /// Returns the bytes of memory that they take with more of them.
    pub(crate) fn memory_with(&self, more: u64, are_moves: bool) -> u64 {
        let of_call = self.memory_of_call(are_moves);
        self.of_part.max(of_call * (self.all.len() as u64 + more))
    }

    fn memory_of_call(&self, are_moves: bool) -> u64 {
        match self.has_moves || are_moves {
            true => EditShares::MOVED_POINT_BYTES,
            false => EditShares::POINT_BYTES,
        }
    }

    /// Returns whether any point has z.
    pub(crate) fn have_z(&self) -> bool {
        self.given.any
    }

    /// Checks that points have z if the file has, and only then.
    pub(crate) fn check_z(&self, has_z: bool) -> Result<(), EditError> {
        match (has_z, self.given.lacking) {
            (false, _) if self.given.any => Err(EditError::HasNoZ),
            (true, Some((point, count))) if self.missing_z != MissingZ::Zero => {
                Err(EditError::PointWithoutZ { point, count })
            }
            _ => Ok(()),
        }
    }
}
