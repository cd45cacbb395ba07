//! The calls of a transaction that concern sites.

use crate::geometry::Point;
use crate::input::{SiteBatch, SiteId};
use crate::memory::EditShares;

/// A call.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SiteCall {
    /// Inserts a site with z or [`NO_Z`](crate::constraints::without_z::NO_Z).
    Insert(Point, f64, SiteId),
    /// Deletes all sites at a position.
    Delete(Point),
}

impl SiteCall {
    pub(crate) fn point(&self) -> Point {
        let (Self::Insert(point, ..) | Self::Delete(point)) = self;
        *point
    }
}

/// The calls of a transaction that concern sites, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct SiteCalls {
    pub(crate) all: Vec<SiteCall>,
    /// The number of sites that are inserted.
    pub(crate) inserted: u64,
    /// Whether to leave out deletions of sites that are not there.
    pub(crate) skip_missing: bool,
    /// Bytes of the ids.
    text: u64,
}

impl SiteCalls {
    pub(crate) fn push(&mut self, call: SiteCall) {
        if let SiteCall::Insert(_, _, id) = &call {
            self.inserted += 1;
            self.text += byte_size(id);
        }
        self.all.push(call);
    }

    /// Returns the bytes of memory that the calls take until they are carried out.
    pub(crate) fn memory(&self) -> u64 {
        self.memory_with(0, 0)
    }

    /// Returns the bytes of memory that they take with the sites of a batch.
    pub(crate) fn memory_with_batch(&self, batch: &SiteBatch) -> u64 {
        self.memory_with(batch.len(), batch.ids.iter().map(byte_size).sum())
    }

    /// Returns the bytes of memory that they take with `more` calls, whose ids take `text` bytes.
    pub(crate) fn memory_with(&self, more: usize, text: u64) -> u64 {
        EditShares::SITE_BYTES * (self.all.len() + more) as u64 + 2 * (self.text + text)
    }
}

/// Returns the bytes of an id that is not a number.
fn byte_size(id: &SiteId) -> u64 {
    match id {
        SiteId::Number(_) => 0,
        SiteId::Text(text) => text.len() as u64,
    }
}
