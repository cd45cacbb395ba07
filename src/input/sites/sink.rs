//! Where the readers of sites put them: numbered, with z for all or for none.

use super::{SiteBatch, SiteId};
use crate::input::spot::Spot;
use crate::input::{InputError, Place};
use std::path::Path;

/// Sites in a full batch.
const BATCH: usize = 8192;

/// The way from one file into one batch.
pub(super) struct Sink<'a> {
    pub batch: &'a mut SiteBatch,
    pub path: &'a Path,
    /// Whether the batches have z.
    pub wants_z: bool,
    /// Sites before this batch.
    pub first: u64,
    /// Sites that had no z.
    pub padded: &'a mut u64,
}

impl Sink<'_> {
    /// Whether the batch should be handed out before more is put in.
    pub fn is_full(&self) -> bool {
        self.batch.len() >= BATCH
    }

    /// Takes a site; without an id its number is its id.
    pub fn site(&mut self, spot: Spot, id: Option<SiteId>) {
        let id = id.unwrap_or(SiteId::Number(self.next()));
        self.batch.ids.push(id);
        self.batch.points.push(spot.point);
        if self.wants_z {
            *self.padded += u64::from(spot.z.is_none());
            self.batch.z.push(spot.z.unwrap_or(f64::NAN));
        }
    }

    /// The error of a site that is none; so many others still wait to be put in before it.
    pub fn wrong(&self, waiting: u64, place: Place, found: String) -> InputError {
        InputError::Site {
            path: self.path.to_owned(),
            site: self.next() + waiting,
            place,
            found,
        }
    }

    /// The number of the site that comes.
    fn next(&self) -> u64 {
        self.first + self.batch.len() as u64
    }
}
