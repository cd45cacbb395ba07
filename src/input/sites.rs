//! Sites: their ids, what a batch of them is, and how their readers number them, with z for all or for none.

use crate::geometry::Point;
use crate::input::flaw::Flaw;
use crate::input::reader::{Batch, Sink, Totals};
use crate::input::spot::Spot;
use crate::shown;
use std::fmt;
use std::path::Path;

/// The id of a site, as its file has it; see [`SiteSource`](crate::input::SiteSource). That ids differ is not checked.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteId {
    /// A number without a sign, fraction or leading zero.
    Number(u64),
    /// Anything else: at most [`SiteId::LONGEST`] bytes, and not empty.
    Text(String),
}

impl SiteId {
    /// The longest text, in bytes.
    pub const LONGEST: usize = 1024;

    /// The id in a field that may be a number, or what is wrong with it.
    pub(super) fn from_field(field: &[u8]) -> Result<Self, Flaw> {
        let text = std::str::from_utf8(field).map_err(|_| Flaw::IdNotUtf8)?;
        match text.parse::<u64>() {
            Ok(number) if number.to_string() == text => Ok(Self::Number(number)),
            _ => Self::from_text(text),
        }
    }

    /// The id as text, or what is wrong with it.
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

/// A batch of sites in input order: what a [`SiteSource`](crate::input::SiteSource) gives, and a [`Builder`](crate::Builder) takes.
#[derive(Clone, Debug, Default)]
pub struct SiteBatch {
    /// The places: valid and normalized points.
    pub points: Vec<Point>,
    /// Their elevations: finite, or NaN where a site has none. Empty if the source has none
    /// ([`has_z`](crate::input::SiteSource::has_z)), else as long as `points`.
    pub z: Vec<f64>,
    /// Their ids; as long as `points`.
    pub ids: Vec<SiteId>,
}

impl SiteBatch {
    /// The number of sites.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the batch has no sites.
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

/// What is counted over all files of sites.
#[derive(Default)]
pub struct SiteTotals {
    /// Sites of the file at hand that had no z.
    padded: u64,
}

impl Batch for SiteBatch {
    /// The name of the field that is the id, if one is chosen.
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
    /// Takes a site; without an id its number is its id.
    pub fn site(&mut self, spot: Spot, id: Option<SiteId>) {
        let id = id.unwrap_or(SiteId::Number(self.next()));
        self.batch.ids.push(id);
        self.batch.points.push(spot.point);
        if self.wants_z {
            self.totals.padded += u64::from(spot.z.is_none());
            self.batch.z.push(spot.z.unwrap_or(f64::NAN));
        }
    }
}
