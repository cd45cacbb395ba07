//! The state that the steps of a method share.

use foldhash::{HashSet, HashSetExt};

use super::statistics::{Clock, Statistics};
use crate::query::edges::BreakLines;
use crate::query::free_space::QueryPoint;
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::{TileReader, VertexId};

/// The sites that are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wanted {
    /// This many nearest sites.
    Nearest(usize),
    /// The sites within a distance.
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

/// The state that the steps of a method share.
pub(super) struct QueryContext {
    pub(super) reader: TileReader,
    pub(super) options: QueryOptions,
    pub(super) tiles: Tiles,
    pub(super) source: QueryPoint,
    pub(super) clock: Clock,
    pub(super) statistics: Statistics,
    /// Obstacle edges that were examined, if they are not counted otherwise.
    pub(super) considered: HashSet<[VertexId; 2]>,
}

impl QueryContext {
    pub(super) fn new(
        reader: &TileReader,
        options: &QueryOptions,
        tiles: Tiles,
        source: QueryPoint,
        clock: Clock,
    ) -> Self {
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

    /// Fails if the file states that it has break lines.
    pub(super) fn refuse_break_lines(&self) -> Result<(), QueryError> {
        match BreakLines::of(self.tiles.metadata()) {
            BreakLines::Yes => Err(self.tiles.break_lines()),
            // Break lines that the file does not state are found on the way.
            BreakLines::No | BreakLines::Unknown => Ok(()),
        }
    }

    /// Yields to other tasks, and fails if the time limit is reached.
    pub(super) async fn pause(&self) -> Result<(), QueryError> {
        tokio::task::yield_now().await;
        self.tiles.check_time()
    }

    /// Lends the tiles to another search.
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
