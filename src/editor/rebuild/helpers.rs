//! Points that make triangles of a file without any, for the time of an edit.

use std::sync::Arc;

use crate::edit::{EditError, PointCall, PointCalls, PointCounts, SiteCall, Work};
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;

/// Three points around everything.
pub(super) struct Helpers([Point; 3]);

impl Helpers {
    /// The number of helpers.
    pub(super) const COUNT: u64 = 3;

    /// Returns helpers around the bounds of a file and all positions that an edit names.
    ///
    /// # Errors
    /// Fails if coordinates are so large that nothing lies around them.
    pub(super) fn around(bounds: Rect, work: &Work) -> Result<Self, EditError> {
        let of_segments = work.segments.iter().flat_map(|segment| segment.ends);
        let of_sites = work.sites.all.iter().map(SiteCall::point);
        let named = work.points.bounds().union(Rect::around(of_segments.chain(of_sites)));
        let all = bounds.union(named);
        let all = match all == Rect::EMPTY {
            true => Rect::around([Point::new(0.0, 0.0)]),
            false => all,
        };
        let (width, height) = all.size();
        let largest = [all.min_x, all.min_y, all.max_x, all.max_y].map(f64::abs);
        let largest = largest.into_iter().fold(0.0, f64::max);
        // Far enough that the sums are not rounded to the bounds.
        let away = width.max(height).max(largest / 1024.0).max(1.0);
        let helpers = [
            Point::new(all.min_x - away, all.min_y - away),
            Point::new(all.max_x + away, all.min_y - away),
            Point::new(all.min_x - away, all.max_y + away),
        ];
        match helpers.iter().find(|helper| !helper.is_valid()) {
            Some(&helper) => Err(EditError::InvalidPoint(helper)),
            None => Ok(Self(helpers.map(Point::normalized))),
        }
    }

    /// Returns them as points with record numbers from `first_record` on.
    pub(super) fn points(&self, has_z: bool, first_record: u64) -> PointBatch {
        PointBatch {
            points: self.0.to_vec(),
            z: if has_z { vec![0.0; self.0.len()] } else { Vec::new() },
            records: (first_record..).take(self.0.len()).collect(),
        }
    }

    /// Returns an edit that deletes them and does nothing else.
    pub(super) fn deletions(&self) -> Work {
        let mut work = Work::default();
        self.delete(&mut work.points);
        work
    }

    fn delete(&self, calls: &mut PointCalls) {
        let deletions = self.0.iter().map(|&helper| PointCall::Delete(helper));
        deletions.for_each(|call| calls.push(call));
    }

    /// Returns an edit of a draft that deletes them at the end.
    pub(super) fn deleted_in(&self, work: &Work) -> Arc<Work> {
        let mut work = work.for_draft();
        self.delete(&mut work.points);
        Arc::new(work)
    }

    /// Returns the counts of an edit that deleted them, as if they had not been there.
    pub(super) fn not_counted(&self, points: PointCounts) -> PointCounts {
        PointCounts {
            deleted: points.deleted.saturating_sub(Self::COUNT),
            ..points
        }
    }
}
