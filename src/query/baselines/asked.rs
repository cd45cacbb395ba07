//! A question on its way to an answer.

use foldhash::{HashSet, HashSetExt};

use super::statistics::{Clock, Statistics};
use crate::query::edges::BreakLines;
use crate::query::free_space::Place;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::{TileReader, VertexId};

/// Which sites are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wanted {
    /// So many, the nearest.
    Nearest(usize),
    /// Those within a distance.
    Within(f64),
}

impl Wanted {
    pub(super) fn count(self) -> usize {
        match self {
            Self::Nearest(count) => count,
            Self::Within(_) => usize::MAX,
        }
    }

    pub(super) fn limit(self) -> f64 {
        match self {
            Self::Nearest(_) => f64::INFINITY,
            Self::Within(radius) => radius,
        }
    }
}

/// A question on its way.
pub(super) struct Asked {
    pub(super) reader: TileReader,
    pub(super) options: QueryOptions,
    pub(super) tiles: Tiles,
    pub(super) source: Place,
    pub(super) clock: Clock,
    pub(super) statistics: Statistics,
    /// Obstacle edges that were looked at, where they are not counted otherwise.
    pub(super) considered: HashSet<[VertexId; 2]>,
}

impl Asked {
    pub(super) fn new(reader: &TileReader, options: &QueryOptions, tiles: Tiles, source: Place, clock: Clock) -> Self {
        Self {
            reader: reader.clone(),
            options: options.clone(),
            tiles,
            source,
            clock,
            statistics: Statistics::default(),
            considered: HashSet::new(),
        }
    }

    /// Refuses files with break lines.
    pub(super) fn refuse_break_lines(&self) -> Result<(), QueryError> {
        match BreakLines::of(self.tiles.metadata()) {
            BreakLines::Yes => Err(self.tiles.break_lines()),
            // Those that a file does not tell of are met.
            BreakLines::No | BreakLines::Unknown => Ok(()),
        }
    }

    /// Lets others have their turn, and fails if the time is over.
    pub(super) async fn pause(&self) -> Result<(), QueryError> {
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Gives the tiles away for a while.
    pub(super) fn lend_tiles(&mut self) -> Tiles {
        std::mem::replace(&mut self.tiles, Tiles::new(&self.reader, &self.options))
    }

    pub(super) fn finish(self) -> Statistics {
        Statistics {
            tiles: self.tiles.count(),
            times: self.clock.times,
            ..self.statistics
        }
    }
}
