//! What was asked, and of which file.

use delaunay_tiles::crs::Crs;
use delaunay_tiles::store::TileReader;

use crate::answer::{Answer, QueryResult, Status};
use crate::ask::Ask;
use crate::units::{Measure, Unit, unit};

/// Why an answer is empty if its file has no sites.
pub const NO_SITES: &str = "the file has no sites; build it with --sites FILE";

/// A kind of query, and what its answers need to know of the file.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// The kind of query.
    pub ask: Ask,
    /// The unit of the file's coordinates.
    pub unit: Unit,
    /// Whether the file has sites.
    pub has_sites: bool,
}

impl Asked {
    /// Returns what the answers to `ask` need to know of a file with this coordinate reference
    /// system.
    pub fn new(ask: Ask, reader: &TileReader, crs: Option<&Crs>) -> Self {
        Self {
            ask,
            unit: unit(crs),
            has_sites: reader.metadata().sites > 0,
        }
    }

    /// Returns why an answer is empty, unless it is not or its status says why.
    pub fn note(self, answer: &Answer) -> Option<String> {
        let is_empty = match &answer.found {
            QueryResult::Near(near) => near.is_empty(),
            QueryResult::Sites(sites) => sites.is_empty(),
            QueryResult::Along(intervals) => {
                let mut free = intervals
                    .iter()
                    .filter_map(|interval| interval.sites.as_ref())
                    .peekable();
                free.peek().is_some() && free.all(Vec::is_empty)
            }
            QueryResult::Location(_) | QueryResult::Path(_) => false,
        };
        if !is_empty || answer.status != Status::Ok {
            return None;
        }
        Some(match self.ask {
            Ask::Nearest { .. } => "the file has no vertices".to_owned(),
            _ if !self.has_sites => NO_SITES.to_owned(),
            Ask::Range { radius, .. } => {
                format!("no site is within a walking distance of {}", self.unit.distance(radius))
            }
            _ => "no site can be reached".to_owned(),
        })
    }
}
