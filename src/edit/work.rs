//! The input of an edit.

use std::sync::Arc;

use crate::constraints::polygons::check::{InvertedPolygons, Overlapping};
use crate::constraints::segment::Segment;
use crate::constraints::without_z::NO_Z;
use crate::edit::points::{PointCall, PointCalls};
use crate::edit::sites::SiteCalls;
use crate::edit::unconstrain::GoneLines;
use crate::geometry::Point;
use crate::input::MissingZ;
use crate::store::{LinePart, LineSource, PolygonLine};

/// A segment between two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// The numbers of the ends among the ends of all segments.
    pub(crate) ends: [u32; 2],
    pub(crate) source: LinePart,
}

/// The input of an edit.
#[derive(Clone, Default)]
pub(crate) struct Work {
    /// Changes of points.
    pub(crate) points: PointCalls,
    /// Changes of sites.
    pub(crate) sites: SiteCalls,
    /// The lines that go.
    pub(crate) gone: GoneLines,
    /// The segments, whose ends become vertices. Copies of the work share them.
    pub(crate) segments: Arc<Vec<Segment>>,
    /// What becomes constraints: the segments after obstacles were normalised; `None` if these are
    /// all segments as they are.
    pub(crate) pieces: Option<Arc<Vec<Piece>>>,
    /// z at some of the ends of all segments, or [`NO_Z`].
    pub(crate) z: Arc<Vec<f64>>,
    /// What to do with ends that have no z and become vertices, if the file has z.
    pub(crate) missing_z: MissingZ,
    /// New lines for the directory.
    pub(crate) lines: Vec<LineSource>,
    /// The new lines that belong to the polygon of a smaller line.
    pub(crate) polygon_lines: Vec<PolygonLine>,
    /// Number of record numbers for inserted points, then for the ends of the segments, in order, and
    /// then for changes of sites; 0 if the ends were vertices before.
    pub(crate) new_records: u64,
    /// Number of transactions that it consists of, besides the last one.
    pub(crate) earlier_transactions: u64,
    /// Whether the last one has been counted before.
    pub(crate) is_counted: bool,
    /// Obstacles that are inside out, if their rings cross at vertices only. In that case the edit
    /// fails and the file is unchanged.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// An obstacle that overlaps itself, under the same condition.
    pub(crate) overlapping: Option<Overlapping>,
    /// Whether the file is still a draft that nothing relies on, so that it need not be on the
    /// medium when the edit is done.
    pub(crate) is_draft: bool,
    /// Whether the file stays as it is.
    pub(crate) is_dry_run: bool,
    /// Number of threads that decode and encode tiles, if the memory allows it.
    pub(crate) threads: usize,
}

impl Work {
    /// Returns the same edit of a draft, which is synced to the medium later.
    pub(crate) fn for_draft(&self) -> Self {
        self.draft_with(self.points.clone())
    }

    /// Returns the edit of a draft with other changes of points.
    fn draft_with(&self, points: PointCalls) -> Self {
        Self {
            points,
            sites: self.sites.clone(),
            gone: self.gone.clone(),
            segments: Arc::clone(&self.segments),
            pieces: self.pieces.clone(),
            z: Arc::clone(&self.z),
            lines: self.lines.clone(),
            polygon_lines: self.polygon_lines.clone(),
            is_draft: true,
            is_dry_run: false,
            ..*self
        }
    }

    /// Returns the part of it that counts the transaction and the records of points, and names the
    /// sources of these.
    pub(crate) fn of_records(&self) -> Self {
        Self {
            points: self.points.without_calls(),
            new_records: self.points.records,
            earlier_transactions: self.earlier_transactions.saturating_add(1),
            is_counted: true,
            ..Self::default()
        }
    }

    /// Returns the rest of it, an edit of a draft in which points were changed and
    /// [counted](Self::of_records), with the calls that were `left`. Returns `None` if nothing is.
    pub(crate) fn after_points(&self, left: Vec<PointCall>) -> Option<Self> {
        let rest = Self {
            new_records: self.new_records.saturating_sub(self.points.records),
            earlier_transactions: 0,
            is_counted: true,
            ..self.draft_with(PointCalls::checked(left))
        };
        (!rest.is_empty()).then_some(rest)
    }

    /// Returns whether it changes nothing.
    pub(crate) fn is_empty(&self) -> bool {
        !self.changes_what_was_built() && self.segments.is_empty()
    }

    /// Returns whether it changes points, lines or sites that the file has, besides adding lines.
    pub(crate) fn changes_what_was_built(&self) -> bool {
        !self.points.is_empty() || !self.sites.all.is_empty() || !self.gone.is_empty()
    }

    /// Returns the number of segments that become constraints.
    pub(crate) fn piece_count(&self) -> u32 {
        self.pieces.as_ref().map_or(self.segments.len(), |pieces| pieces.len()) as u32
    }

    /// Returns a segment that becomes a constraint.
    pub(crate) fn piece(&self, number: u32) -> Piece {
        match &self.pieces {
            Some(pieces) => pieces[number as usize],
            None => Piece {
                ends: [2 * number, 2 * number + 1],
                source: self.segments[number as usize].source,
            },
        }
    }

    /// Returns the point of an end, by its number among all ends.
    pub(crate) fn point(&self, end: u32) -> Point {
        self.segments[end as usize / 2].ends[end as usize % 2]
    }

    /// Returns the z at an end, by its number among all ends, or [`NO_Z`].
    pub(crate) fn z_of(&self, end: u32) -> f64 {
        self.z.get(end as usize).copied().unwrap_or(NO_Z)
    }
}
