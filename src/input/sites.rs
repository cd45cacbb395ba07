//! The ids of sites, batches of sites, and the sink that numbers the sites and keeps z for all or
//! for none.

use crate::geometry::Point;
use crate::input::flaw::Flaw;
use crate::input::point_z::PointZ;
use crate::input::reader::{Batch, Sink, Totals};
use crate::shown;
use std::fmt;
use std::path::Path;

/// The id of a site, as its file has it; see [`SiteSource`](crate::input::SiteSource). Whether ids
/// are distinct is not checked.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteId {
    /// A number without a sign, fraction or leading zero.
    Number(u64),
    /// Anything else: at most [`SiteId::LONGEST`] bytes, and not empty.
    Text(String),
}

impl SiteId {
    /// The length limit of a text id, in bytes.
    pub const LONGEST: usize = 1024;

    /// Parses the id in a field that may be a number.
    pub(super) fn from_field(field: &[u8]) -> Result<Self, Flaw> {
        let text = std::str::from_utf8(field).map_err(|_| Flaw::IdNotUtf8)?;
        match text.parse::<u64>() {
            Ok(number) if number.to_string() == text => Ok(Self::Number(number)),
            _ => Self::from_text(text),
        }
    }

    /// Returns the text as an id, or what is wrong with it.
    pub(super) fn from_text(text: &str) -> Result<Self, Flaw> {
        match text.len() {
            0 => Err(Flaw::EmptyId),
            1..=Self::LONGEST => Ok(Self::Text(text.to_owned())),
            length => Err(Flaw::LongId {
                length,
                most: Self::LONGEST,
            }),
        }
    }
}

impl fmt::Display for SiteId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}

/// A batch of sites in input order, as produced by a [`SiteSource`](crate::input::SiteSource) and
/// accepted by a [`Builder`](crate::Builder).
#[derive(Clone, Debug, Default)]
pub struct SiteBatch {
    /// The positions of the sites, as valid and normalized points.
    pub points: Vec<Point>,
    /// The elevations of the sites: finite, or NaN where a site has none. Empty if the source has
    /// no z ([`has_z`](crate::input::SiteSource::has_z)), otherwise as long as `points`.
    pub z: Vec<f64>,
    /// The ids of the sites; as long as `points`.
    pub ids: Vec<SiteId>,
}

impl SiteBatch {
    /// Returns the number of sites.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns whether the batch has no sites.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Removes all sites and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.z.clear();
        self.ids.clear();
    }
}

/// The counts over all files of sites.
#[derive(Default)]
pub struct SiteTotals {
    /// The number of sites of the current file that had no z.
    padded: u64,
}

impl Batch for SiteBatch {
    /// The name of the field that has the id, if one is selected.
    type Options = Option<String>;
    type Totals = SiteTotals;
    type Tally = ();

    fn len(&self) -> usize {
        self.points.len()
    }

    fn clear(&mut self) {
        Self::clear(self);
    }
}

impl Totals<SiteBatch> for SiteTotals {
    fn end_file(&mut self, (): &(), handed_out: u64) -> u64 {
        handed_out
    }

    fn notes(&mut self, path: &Path) -> Vec<String> {
        match std::mem::take(&mut self.padded) {
            0 => Vec::new(),
            n => vec![format!("{}: {n} sites have no z, and others have", shown::path(path))],
        }
    }
}

impl Sink<'_, SiteBatch> {
    /// Takes a site. A site without an id gets its number as its id.
    pub fn site(&mut self, point_z: PointZ, id: Option<SiteId>) {
        let id = id.unwrap_or(SiteId::Number(self.next()));
        self.batch.ids.push(id);
        self.batch.points.push(point_z.point);
        if self.wants_z {
            self.totals.padded += u64::from(point_z.z.is_none());
            self.batch.z.push(point_z.z.unwrap_or(f64::NAN));
        }
    }
}
