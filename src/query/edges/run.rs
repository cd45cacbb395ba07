//! A search along edges and the tiles that drive it.

use std::sync::Arc;

#[cfg(feature = "baselines")]
use super::corner::Corner;
use super::corner::GraphVertex;
use super::node::Node;
use super::overlay::Overlay;
use super::search::{EdgeSearch, EdgeSearchStep, Heuristic};
use crate::geometry::Point;
use crate::query::free_space::{FreeSpace, QueryPoint};
use crate::query::request::{QueryError, QueryOptions, Tiles};
use crate::store::{LineKind, Metadata, Tile, TileReader};

/// The number of nodes after which the search yields to other tasks.
const PAUSE: u32 = 1 << 10;

/// A search along edges and the tiles that drive it.
pub(crate) struct EdgeRun {
    pub(crate) tiles: Tiles,
    pub(crate) search: EdgeSearch,
    tile: Arc<Tile>,
    source: QueryPoint,
    pause: u32,
    /// Whether to fail at a break line.
    refuses: bool,
}

/// Whether a file has break lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BreakLines {
    No,
    Yes,
    /// The file does not state which lines it has.
    Unknown,
}

impl BreakLines {
    /// Returns what the directory of a file states.
    pub(crate) fn of(metadata: &Metadata) -> Self {
        if metadata.constraint_edges == 0 {
            return Self::No;
        }
        match metadata.has_lines(LineKind::BreakLine) {
            None => Self::Unknown,
            Some(true) => Self::Yes,
            Some(false) => Self::No,
        }
    }
}

impl EdgeRun {
    /// Starts at a free point, for all nodes, nearest first.
    pub(crate) async fn start(tiles: Tiles, source: QueryPoint) -> Result<Self, QueryError> {
        Ok(Self::begin(tiles, source, None).await?.0)
    }

    /// Starts at a free point, towards `target`. Returns the vertex of the target. The path to it
    /// is at most `weight` times as long as a shortest one; `weight` is at least 1.
    pub(crate) async fn towards(
        tiles: Tiles,
        source: QueryPoint,
        target: &QueryPoint,
        weight: f64,
    ) -> Result<(Self, GraphVertex), QueryError> {
        Self::begin(tiles, source, Some((target, weight))).await
    }

    /// Starts at a vertex in some of its wedges, instead of a point near it.
    #[cfg(feature = "baselines")]
    pub(crate) async fn from_corners(
        mut tiles: Tiles,
        source: QueryPoint,
        corners: &[Corner],
    ) -> Result<Self, QueryError> {
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
        source: QueryPoint,
        target: Option<(&QueryPoint, f64)>,
    ) -> Result<(Self, GraphVertex), QueryError> {
        let mut overlay = Overlay::default();
        let start = overlay.insert_point(&mut tiles, &source).await?;
        let mut end = start;
        let mut goal = None;
        if let Some((target, weight)) = target {
            let point = target.point;
            goal = Some(Heuristic { point, weight });
            end = overlay.insert_point(&mut tiles, target).await?;
        }
        let outside_is_free = tiles.outside_is_free();
        let search = EdgeSearch::new((start, source.point), overlay, goal, outside_is_free);
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

    /// Starts at `at`, which must be free.
    pub(crate) async fn from_point(reader: &TileReader, at: Point, options: &QueryOptions) -> Result<Self, QueryError> {
        let mut tiles = Tiles::new(reader, options);
        let source = QueryPoint::find_free(&mut tiles, at).await?;
        Self::start(tiles, source).await
    }

    /// Fails if the file has break lines. From now on also fails at a tile with break lines. The
    /// bound of the CDT distance does not hold with them.
    pub(crate) fn refuse_break_lines(&mut self) -> Result<(), QueryError> {
        self.refuses = true;
        match BreakLines::of(self.tiles.metadata()) {
            BreakLines::Yes => Err(self.tiles.break_lines()),
            BreakLines::No | BreakLines::Unknown => self.check_tile(),
        }
    }

    fn check_tile(&self) -> Result<(), QueryError> {
        if self.refuses && FreeSpace::of(&self.tiles, &self.tile).has_break_lines() {
            return Err(self.tiles.break_lines());
        }
        Ok(())
    }

    /// Returns the number of the next nearest node; `None` if there are no more.
    ///
    /// # Errors
    /// If a tile cannot be read, or a limit is reached. The error then has a lower bound of the
    /// lengths of all remaining nodes.
    pub(crate) async fn next(&mut self) -> Result<Option<u32>, QueryError> {
        self.pause -= 1;
        if self.pause == 0 {
            self.pause = PAUSE;
            tokio::task::yield_now().await;
            self.tiles
                .check_time()
                .map_err(|error| error.lower_bound(self.search.front()))?;
        }
        loop {
            let step = self.search.step(&self.tile);
            match self.tiles.checked(self.tile.id(), step)? {
                EdgeSearchStep::Found(node) => return Ok(Some(node)),
                EdgeSearchStep::Done => return Ok(None),
                EdgeSearchStep::Need(id) => {
                    let tile = self.tiles.get(id).await;
                    self.tile = tile.map_err(|error| error.lower_bound(self.search.front()))?;
                    self.check_tile()?;
                }
            }
        }
    }

    /// Returns the node of a vertex, or of an inserted point, if a path leads there.
    ///
    /// # Errors
    /// As [`next`](Self::next).
    pub(crate) async fn find(&mut self, vertex: GraphVertex) -> Result<Option<u32>, QueryError> {
        while let Some(node) = self.next().await? {
            if self.search.node(node).vertex == vertex {
                return Ok(Some(node));
            }
        }
        Ok(None)
    }

    /// Returns a node that was found.
    pub(crate) fn node(&self, number: u32) -> &Node {
        self.search.node(number)
    }

    /// Returns the tile of the file's vertex that was found last, which has the vertex's whole
    /// star.
    pub(crate) fn tile(&self) -> &Arc<Tile> {
        &self.tile
    }

    /// Returns the point where the search started.
    pub(crate) fn source(&self) -> &QueryPoint {
        &self.source
    }
}
