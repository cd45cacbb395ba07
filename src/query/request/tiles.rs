//! The tiles of one query: the few that it needs at once, and its limits of tiles and time.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;
use std::sync::Arc;
use std::time::Instant;

use tokio::task::JoinSet;

use super::contradiction::Contradiction;
use super::error::QueryError;
use super::options::QueryOptions;
use super::star::half_edge_towards;
use super::tiles_used::TilesUsed;
use crate::collections::mix::Mix;
use crate::geometry::{HalfEdge, Point, Rect};
use crate::store::{Metadata, Page, Tile, TileId, TileReader, VertexId};

/// The number of tiles that a query holds, independently of the cache.
const HELD: usize = 2;
/// The maximum number of tiles that are prefetched at once.
const AHEAD: usize = 2;

/// The tiles of a file, as one query sees them.
pub(crate) struct Tiles {
    reader: TileReader,
    /// The tiles used last, the most recent first.
    held: [Option<Arc<Tile>>; HELD],
    /// The page of the directory that was used last, and its number. Most queries need one only.
    page: Option<(u32, Arc<Page>)>,
    /// All tiles that were requested or prefetched, and whether each was in memory.
    asked: HashMap<TileId, bool, BuildHasherDefault<Mix>>,
    max_tiles: u64,
    used: Option<TilesUsed>,
    deadline: Option<Instant>,
    /// The prefetches, if there are any; they end with the query.
    ahead: Option<JoinSet<()>>,
}

impl Tiles {
    pub(crate) fn new(reader: &TileReader, options: &QueryOptions) -> Self {
        Self {
            reader: reader.clone(),
            held: [const { None }; HELD],
            page: None,
            asked: HashMap::default(),
            max_tiles: options.max_tiles.unwrap_or(u64::MAX),
            used: options.tiles_used.clone(),
            deadline: options.max_time.and_then(|time| Instant::now().checked_add(time)),
            ahead: None,
        }
    }

    /// Returns the number of different tiles that were requested.
    pub(crate) fn count(&self) -> u64 {
        self.asked.len() as u64
    }

    /// Returns the tile whose cell contains `p`, or `None` if the file has no tiles.
    pub(crate) async fn tile_at(&mut self, p: Point) -> Result<Option<TileId>, QueryError> {
        let Some(number) = self.reader.page_at(p).await? else {
            return Ok(None);
        };
        let page = match &self.page {
            Some((held, page)) if *held == number => page,
            _ => &self.page.insert((number, self.reader.page(number).await?)).1,
        };
        Ok(Some(self.reader.tile_in(page, p)?))
    }

    /// Returns the metadata of the file.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.reader.metadata()
    }

    /// Returns whether the outside of the hull is free.
    pub(crate) fn outside_is_free(&self) -> bool {
        !self.metadata().exterior_is_hole
    }

    /// Returns the tiles whose bounds satisfy `is_wanted`.
    pub(crate) async fn ids_where(&self, is_wanted: impl Fn(Rect) -> bool) -> Result<Vec<TileId>, QueryError> {
        Ok(self.reader.tiles_where(is_wanted).await?)
    }

    /// Returns the number of free triangles per unit of area, as a tile and the whole file suggest;
    /// not a number if nothing is known.
    pub(crate) fn density_at(&self, id: TileId) -> f64 {
        let Some(entry) = self.reader.entry_in_memory(id) else {
            return f64::NAN;
        };
        let (width, height) = entry.bounds.size();
        let metadata = self.metadata();
        let free = 1.0 - metadata.hole_triangles as f64 / metadata.triangles.max(1) as f64;
        f64::from(entry.owned_triangles) * free / (width * height)
    }

    /// Returns the number of hull edges.
    pub(crate) fn hull_edges(&self) -> u64 {
        self.metadata().hull_edges
    }

    /// Returns a tile.
    pub(crate) async fn get(&mut self, id: TileId) -> Result<Arc<Tile>, QueryError> {
        if let Some(index) = self.held_index(id) {
            self.held[..=index].rotate_right(1);
            if let Some(tile) = &self.held[0] {
                return Ok(Arc::clone(tile));
            }
        }
        self.check_time()?;
        if self.count() >= self.max_tiles && !self.asked.contains_key(&id) {
            return Err(QueryError::OutOfBudget { lower_bound: 0.0 });
        }
        self.held.rotate_right(1);
        self.held[0] = None;
        let entry = self.page.as_ref().and_then(|(_, page)| page.entry(id));
        let tile = match entry {
            Some(entry) => self.reader.tile_of_entry(id, entry).await?,
            None => self.reader.tile(id).await?,
        };
        self.asked.insert(id, true);
        if let Some(used) = &self.used {
            used.add(id);
        }
        self.held[0] = Some(Arc::clone(&tile));
        Ok(tile)
    }

    /// Returns the index at which a tile is held.
    fn held_index(&self, id: TileId) -> Option<usize> {
        self.held
            .iter()
            .position(|tile| tile.as_ref().is_some_and(|tile| tile.id() == id))
    }

    /// Returns whether a tile is held or cached.
    fn is_here(&self, id: TileId) -> bool {
        self.held_index(id).is_some() || self.reader.is_cached(id)
    }

    /// Returns the width of a tile that was in memory, but has to be read again; otherwise `None`.
    pub(crate) fn width_of_lost(&self, id: TileId) -> Option<f64> {
        if !self.asked.get(&id).is_some_and(|&was_here| was_here) || self.is_here(id) {
            return None;
        }
        let entry = self.reader.entry_in_memory(id)?;
        let (width, height) = entry.bounds.size();
        Some(width.max(height))
    }

    /// Prefetches the likeliest next tiles, if they fit in the cache, so that they are read while
    /// the query waits for tile `id`. The guesses affect only the time. A query with a limit of
    /// tiles prefetches none, so that it reads none in vain.
    pub(crate) fn ask_ahead(&mut self, id: TileId, likely: impl FnOnce() -> Vec<TileId>) {
        if self.max_tiles < u64::MAX || self.is_here(id) {
            return;
        }
        let ahead = self.ahead.get_or_insert_default();
        while ahead.try_join_next().is_some() {}
        for tile in likely() {
            if ahead.len() >= AHEAD {
                return;
            }
            if !self.asked.contains_key(&tile) && self.reader.has_room_for(tile) {
                self.asked.insert(tile, false);
                let reader = self.reader.clone();
                // An error occurs again when the tile is needed.
                ahead.spawn(async move { drop(reader.tile(tile).await) });
            }
        }
    }

    /// Returns the tile that was used last, or any.
    pub(crate) async fn last(&mut self) -> Result<Arc<Tile>, QueryError> {
        match self.held.iter().flatten().next() {
            Some(tile) => Ok(Arc::clone(tile)),
            None => self.get(TileId(0)).await,
        }
    }

    /// Fails if the time limit is reached.
    pub(crate) fn check_time(&self) -> Result<(), QueryError> {
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(QueryError::OutOfBudget { lower_bound: 0.0 }),
            _ => Ok(()),
        }
    }

    /// Returns the half-edge from one vertex to another, which has its triangle on the left, and a
    /// tile that contains it. Returns `None` if the outside is there.
    pub(crate) async fn half_edge_between(
        &mut self,
        from: VertexId,
        to: VertexId,
    ) -> Result<Option<(Arc<Tile>, HalfEdge)>, QueryError> {
        let tile = self.get(to.tile).await?;
        if !tile.has_vertex(to.index) {
            return Err(self.damaged(to.tile, Contradiction::NoVertex(to.index)));
        }
        let half_edge = self.checked(to.tile, half_edge_towards(&tile, to.index, from))?;
        Ok(half_edge.map(|half_edge| (tile, half_edge)))
    }

    /// Returns the error for a tile that contradicts itself or others.
    pub(crate) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> QueryError {
        self.reader.damaged(tile, contradiction.to_string()).into()
    }

    /// Maps a contradiction in a tile to an error.
    #[inline]
    pub(crate) fn checked<T>(&self, tile: TileId, found: Result<T, Contradiction>) -> Result<T, QueryError> {
        found.map_err(|contradiction| self.damaged(tile, contradiction))
    }

    /// Returns the error for a file with break lines.
    pub(crate) fn break_lines(&self) -> QueryError {
        QueryError::BreakLines {
            file: self.reader.name().into(),
        }
    }

    /// Returns the error for a file without triangles.
    pub(crate) fn no_triangles(&self) -> QueryError {
        QueryError::NoTriangles {
            file: self.reader.name().into(),
        }
    }
}
