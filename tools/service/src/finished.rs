//! Finished map tiles, limited in bytes. Each is drawn once for all who wait.

use std::future::Future;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use delaunay_tiles::map_tiles::{GridKind, Layer, TerrainCoord, TileCoord};
use quick_cache::sync::Cache;
use quick_cache::{OptionsBuilder, Weighter};

use crate::problem::Problem;

/// The bytes that an entry takes besides its tile.
const ENTRY: usize = 200;
/// The expected size of a map tile.
const TYPICAL: usize = 20 << 10;

/// A map tile of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// A picture or a vector tile.
    Map(GridKind, Layer, TileCoord),
    /// A picture of heights without transparent pixels.
    OpaqueHeights(GridKind, TileCoord),
    /// A mesh for Cesium.
    Terrain(TerrainCoord),
}

/// A map tile of a state of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key {
    /// The number of the state.
    pub snapshot: u64,
    /// The tile.
    pub what: What,
}

#[derive(Clone)]
struct Bytewise;

impl Weighter<Key, Bytes> for Bytewise {
    fn weight(&self, _: &Key, tile: &Bytes) -> u64 {
        (tile.len() + ENTRY) as u64
    }
}

/// Finished map tiles.
pub struct Finished {
    tiles: Cache<Key, Bytes, Bytewise>,
    hits: AtomicU64,
    misses: AtomicU64,
}

impl Finished {
    /// Creates a cache of `capacity` bytes.
    pub fn new(capacity: usize) -> Self {
        let options = OptionsBuilder::new()
            .estimated_items_capacity((capacity / TYPICAL).max(16))
            .weight_capacity(capacity as u64)
            // A tile that is larger than its shard is not kept, so there are few.
            .shards(4)
            .build();
        let tiles = match options {
            Ok(options) => Cache::with_options(
                options,
                Bytewise,
                quick_cache::DefaultHashBuilder::default(),
                quick_cache::sync::DefaultLifecycle::default(),
            ),
            Err(_) => Cache::with_weighter(16, capacity as u64, Bytewise),
        };
        Self {
            tiles,
            hits: AtomicU64::new(0),
            misses: AtomicU64::new(0),
        }
    }

    /// Returns a tile. If others draw it, waits for them; if they leave, draws it.
    ///
    /// # Errors
    /// Returns the error of `draw`, which is not kept.
    pub async fn get<F>(&self, key: &Key, draw: impl FnOnce() -> F) -> Result<Bytes, Problem>
    where
        F: Future<Output = Result<Bytes, Problem>>,
    {
        match self.tiles.get_value_or_guard_async(key).await {
            Ok(tile) => {
                self.hits.fetch_add(1, Ordering::Relaxed);
                Ok(tile)
            }
            Err(guard) => {
                self.misses.fetch_add(1, Ordering::Relaxed);
                let tile = draw().await?;
                // It may have been evicted meanwhile.
                _ = guard.insert(tile.clone());
                Ok(tile)
            }
        }
    }

    /// Returns a tile if it is there.
    pub fn peek(&self, key: &Key) -> Option<Bytes> {
        self.tiles.get(key)
    }

    /// Returns the number of tiles that were there.
    pub fn hits(&self) -> u64 {
        self.hits.load(Ordering::Relaxed)
    }

    /// Returns the number of tiles that were drawn.
    pub fn misses(&self) -> u64 {
        self.misses.load(Ordering::Relaxed)
    }

    /// Returns the bytes of all tiles.
    pub fn bytes(&self) -> u64 {
        self.tiles.weight()
    }
}
