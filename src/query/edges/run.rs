//! The search along edges, and its tiles.

use std::sync::Arc;

#[cfg(feature = "baselines")]
use super::corner::Corner;
use super::corner::End;
use super::node::Node;
use super::overlay::Overlay;
use super::search::{EdgeSearch, Step, Towards};
use crate::geometry::Point;
use crate::query::free_space::{Ground, Place};
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::{LineKind, Metadata, Tile, TileReader};

/// Nodes after which other tasks have their turn.
const PAUSE: u32 = 1 << 10;

/// A search along edges and its tiles.
pub(crate) struct EdgeRun {
    pub(crate) tiles: Tiles,
    pub(crate) search: EdgeSearch,
    tile: Arc<Tile>,
    source: Place,
    pause: u32,
    /// Whether to fail where there is a break line.
    refuses: bool,
}

/// Whether a file has break lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BreakLines {
    No,
    Yes,
    /// It does not say which lines it has.
    Unknown,
}

impl BreakLines {
    /// What the directory of a file says.
    pub(crate) fn of(metadata: &Metadata) -> Self {
        if metadata.constraint_edges == 0 {
            return Self::No;
        }
        match &metadata.lines[..] {
            [] => Self::Unknown,
            lines if lines.iter().any(|of_file| of_file.kind == LineKind::BreakLine) => Self::Yes,
            _ => Self::No,
        }
    }
}

impl EdgeRun {
    /// Starts at a free place, for all that is not farther away than `limit`, nearest first.
    pub(crate) async fn start(tiles: Tiles, source: Place, limit: f64) -> Result<Self, QueryError> {
        Ok(Self::begin(tiles, source, None, limit).await?.0)
    }

    /// Starts at a free place, towards another one; returns which vertex that is now. The way that is found to it is at most `haste` times as
    /// long as a shortest one, which is 1 or more.
    pub(crate) async fn towards(
        tiles: Tiles,
        source: Place,
        target: &Place,
        haste: f64,
    ) -> Result<(Self, End), QueryError> {
        Self::begin(tiles, source, Some((target, haste)), f64::INFINITY).await
    }

    /// Starts at a vertex in some of its wedges, on behalf of a place near it.
    #[cfg(feature = "baselines")]
    pub(crate) async fn from_corners(mut tiles: Tiles, source: Place, corners: &[Corner]) -> Result<Self, QueryError> {
        let search = EdgeSearch::from_corners(corners, tiles.outside_is_free());
        let tile = tiles.last().await?;
        Ok(Self {
            tiles,
            search,
            tile,
            source,
            pause: PAUSE,
            refuses: false,
        })
    }

    async fn begin(
        mut tiles: Tiles,
        source: Place,
        target: Option<(&Place, f64)>,
        limit: f64,
    ) -> Result<(Self, End), QueryError> {
        let mut overlay = Overlay::default();
        let start = overlay.put_in(&mut tiles, &source).await?;
        let mut end = start;
        let mut goal = None;
        if let Some((target, haste)) = target {
            let point = target.point;
            goal = Some(Towards { point, haste });
            end = overlay.put_in(&mut tiles, target).await?;
        }
        let outside_is_free = tiles.outside_is_free();
        let search = EdgeSearch::new((start, source.point), overlay, limit, goal, outside_is_free);
        let tile = tiles.last().await?;
        let this = Self {
            tiles,
            search,
            tile,
            source,
            pause: PAUSE,
            refuses: false,
        };
        Ok((this, end))
    }

    /// Starts at a point, which must be free.
    pub(crate) async fn from_point(
        reader: &TileReader,
        at: Point,
        limit: f64,
        options: &QueryOptions,
    ) -> Result<Self, QueryError> {
        let mut tiles = Tiles::new(reader, options);
        let source = Place::find_free(&mut tiles, at).await?;
        Self::start(tiles, source, limit).await
    }

    /// Fails if the file has break lines, or a tile that is come to shows one: the bound of the CDT distance does not hold then.
    pub(crate) fn refuse_break_lines(&mut self) -> Result<(), QueryError> {
        self.refuses = true;
        match BreakLines::of(self.tiles.metadata()) {
            BreakLines::Yes => Err(self.tiles.break_lines()),
            BreakLines::No | BreakLines::Unknown => self.check_tile(),
        }
    }

    fn check_tile(&self) -> Result<(), QueryError> {
        if self.refuses && Ground::of(&self.tiles, &self.tile).has_break_lines() {
            return Err(self.tiles.break_lines());
        }
        Ok(())
    }

    /// The next nearest node, by number; none if there is no more.
    ///
    /// # Errors
    /// If a tile cannot be read, or the budget is used up: with the length that all nodes to come have at least.
    pub(crate) async fn next(&mut self) -> Result<Option<u32>, QueryError> {
        self.pause -= 1;
        if self.pause == 0 {
            self.pause = PAUSE;
            tokio::task::yield_now().await;
            self.tiles
                .check_time()
                .map_err(|error| error.at_least(self.search.front()))?;
        }
        loop {
            let step = self.search.step(&self.tile);
            match self.tiles.checked(self.tile.id(), step)? {
                Step::Found(node) => return Ok(Some(node)),
                Step::Done => return Ok(None),
                Step::Need(id) => {
                    let tile = self.tiles.get(id).await;
                    self.tile = tile.map_err(|error| error.at_least(self.search.front()))?;
                    self.check_tile()?;
                }
            }
        }
    }

    /// The node of a vertex, of the file or put in, if there is a way to it.
    ///
    /// # Errors
    /// As [`next`](Self::next).
    pub(crate) async fn find(&mut self, vertex: End) -> Result<Option<u32>, QueryError> {
        while let Some(node) = self.next().await? {
            if self.search.node(node).vertex == vertex {
                return Ok(Some(node));
            }
        }
        Ok(None)
    }

    /// A node that was found.
    pub(crate) fn node(&self, number: u32) -> &Node {
        self.search.node(number)
    }

    /// The tile of the vertex of the file that was found last, with its whole star.
    pub(crate) fn tile(&self) -> &Arc<Tile> {
        &self.tile
    }

    /// Where it started.
    pub(crate) fn source(&self) -> &Place {
        &self.source
    }
}
