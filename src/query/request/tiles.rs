//! Tiles for one query: the few that it needs at once, and how many it may read, for how long.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;
use std::sync::Arc;
use std::time::Instant;

use tokio::task::JoinSet;

use super::contradiction::Contradiction;
use super::error::QueryError;
use super::options::QueryOptions;
use super::star::side_towards;
use crate::collections::mix::Mix;
use crate::geometry::{HalfEdge, Rect};
use crate::store::{Directory, Metadata, Tile, TileId, TileReader, VertexId};

/// Tiles that a query keeps from the cache's whims.
const HELD: usize = 2;
/// Tiles that are asked for ahead at once.
const AHEAD: usize = 2;

/// The tiles of a file, as one query sees them.
pub(crate) struct Tiles {
    reader: TileReader,
    /// The last ones, the very last first.
    held: [Option<Arc<Tile>>; HELD],
    /// All that were asked for, ahead or not, and whether they were here.
    asked: HashMap<TileId, bool, BuildHasherDefault<Mix>>,
    max_tiles: u64,
    deadline: Option<Instant>,
    /// What is asked for ahead, if anything was; it ends with the query.
    ahead: Option<JoinSet<()>>,
}

impl Tiles {
    pub(crate) fn new(reader: &TileReader, options: &QueryOptions) -> Self {
        Self {
            reader: reader.clone(),
            held: [const { None }; HELD],
            asked: HashMap::default(),
            max_tiles: options.max_tiles.unwrap_or(u64::MAX),
            deadline: options.max_time.and_then(|time| Instant::now().checked_add(time)),
            ahead: None,
        }
    }

    /// How many different tiles were asked for.
    pub(crate) fn count(&self) -> u64 {
        self.asked.len() as u64
    }

    /// What is known of the whole file, and where its tiles lie.
    pub(crate) fn directory(&self) -> &Directory {
        self.reader.directory()
    }

    /// What is known of the whole file.
    pub(crate) fn metadata(&self) -> &Metadata {
        &self.directory().metadata
    }

    /// Whether the outside of the hull is free.
    pub(crate) fn outside_is_free(&self) -> bool {
        !self.metadata().exterior_is_hole
    }

    /// The tiles around whose triangles there are such rectangles.
    pub(crate) fn ids_where(&self, is_wanted: impl Fn(Rect) -> bool) -> Vec<TileId> {
        let tiles = self.directory().tiles.iter().zip(0..);
        let wanted = tiles.filter(|(entry, _)| is_wanted(entry.bounds));
        wanted.map(|(_, id)| TileId(id)).collect()
    }

    /// Edges of the hull.
    pub(crate) fn hull_edges(&self) -> u64 {
        self.metadata().hull_edges
    }

    /// A tile.
    pub(crate) async fn get(&mut self, id: TileId) -> Result<Arc<Tile>, QueryError> {
        if let Some(place) = self.place(id) {
            self.held[..=place].rotate_right(1);
            if let Some(tile) = &self.held[0] {
                return Ok(Arc::clone(tile));
            }
        }
        self.check_time()?;
        if self.count() >= self.max_tiles && !self.asked.contains_key(&id) {
            return Err(QueryError::OutOfBudget { at_least: 0.0 });
        }
        self.held.rotate_right(1);
        self.held[0] = None;
        let tile = self.reader.tile(id).await?;
        self.asked.insert(id, true);
        self.held[0] = Some(Arc::clone(&tile));
        Ok(tile)
    }

    /// Where a tile is held.
    fn place(&self, id: TileId) -> Option<usize> {
        self.held
            .iter()
            .position(|tile| tile.as_ref().is_some_and(|tile| tile.id() == id))
    }

    /// Whether a tile is held or cached.
    fn is_here(&self, id: TileId) -> bool {
        self.place(id).is_some() || self.reader.is_cached(id)
    }

    /// How wide a tile is that was here and is not any more, so that it has to be read again.
    pub(crate) fn width_of_lost(&self, id: TileId) -> Option<f64> {
        if !self.asked.get(&id).is_some_and(|&was_here| was_here) || self.is_here(id) {
            return None;
        }
        let entry = self.directory().tiles.get(id.0 as usize)?;
        let (width, height) = entry.bounds.size();
        Some(width.max(height))
    }

    /// Before a tile is waited for: asks for the likeliest of those that come after it, if they fit in the cache, so that they are read
    /// at the same time. Whether that comes true changes nothing but how long it takes. Who may read few tiles reads none in vain.
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
                // An error comes again when the tile is needed.
                ahead.spawn(async move { drop(reader.tile(tile).await) });
            }
        }
    }

    /// The tile that was asked for last, or any.
    pub(crate) async fn last(&mut self) -> Result<Arc<Tile>, QueryError> {
        match self.held.iter().flatten().next() {
            Some(tile) => Ok(Arc::clone(tile)),
            None => self.get(TileId(0)).await,
        }
    }

    /// Fails when the time is over.
    pub(crate) fn check_time(&self) -> Result<(), QueryError> {
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(QueryError::OutOfBudget { at_least: 0.0 }),
            _ => Ok(()),
        }
    }

    /// The side from one vertex to another, which has its triangle on the left, with a tile that holds it; none if that is the outside.
    pub(crate) async fn side_between(
        &mut self,
        from: VertexId,
        to: VertexId,
    ) -> Result<Option<(Arc<Tile>, HalfEdge)>, QueryError> {
        let tile = self.get(to.tile).await?;
        if !tile.has_vertex(to.index) {
            return Err(self.damaged(to.tile, Contradiction::NoVertex(to.index)));
        }
        let side = self.checked(to.tile, side_towards(&tile, to.index, from))?;
        Ok(side.map(|side| (tile, side)))
    }

    /// The error for a tile that contradicts itself or others.
    pub(crate) fn damaged(&self, tile: TileId, contradiction: Contradiction) -> QueryError {
        self.reader.damaged(tile, contradiction.to_string()).into()
    }

    /// What was found in a tile, or the error for a tile that contradicts itself or others.
    #[inline]
    pub(crate) fn checked<T>(&self, tile: TileId, found: Result<T, Contradiction>) -> Result<T, QueryError> {
        found.map_err(|contradiction| self.damaged(tile, contradiction))
    }

    /// The error for a file with break lines.
    pub(crate) fn break_lines(&self) -> QueryError {
        QueryError::BreakLines {
            file: self.reader.name().into(),
        }
    }

    /// The error for a file on which there is nowhere to walk.
    pub(crate) fn no_triangles(&self) -> QueryError {
        QueryError::NoTriangles {
            file: self.reader.name().into(),
        }
    }
}
