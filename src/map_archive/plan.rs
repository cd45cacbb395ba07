//! How many map tiles an archive will have, before any is drawn.

use crate::map_archive::descent::Descent;
use crate::map_archive::drawing::draw;
use crate::map_archive::error::{ArchiveError, TooMany};
use crate::map_archive::options::{ArchiveOptions, Zooms};
use crate::map_tiles::{LayerFacts, MapSource, TileCoord};

/// The number of map tiles that are drawn to estimate how large all are.
const SAMPLES: usize = 16;

/// The map tiles of an archive to write.
#[derive(Clone, Debug)]
pub struct ArchivePlan {
    pub(super) options: ArchiveOptions,
    pub(super) facts: LayerFacts,
    pub(super) zooms: Zooms,
    tiles: u64,
}

impl ArchivePlan {
    /// The bytes of memory that the directory of an archive takes for each map tile: of a list, and of a
    /// table of tiles by their content, both while they grow.
    pub const DIRECTORY: u64 = 192;

    /// Returns the zooms.
    #[must_use]
    pub fn zooms(&self) -> Zooms {
        self.zooms
    }

    /// Returns how many map tiles will be drawn. Some may prove to be empty.
    #[must_use]
    pub fn tiles(&self) -> u64 {
        self.tiles
    }
}

/// Counts the map tiles of an archive. Must be awaited within a tokio runtime.
///
/// This reads the directory of the file, and draws some map tiles if there are too many.
///
/// # Errors
/// If the file has no such layer or no tiles in the grid, if there are too many map tiles, if their
/// directory needs too much memory, or if the file cannot be read.
pub async fn plan(source: &MapSource, options: ArchiveOptions) -> Result<ArchivePlan, ArchiveError> {
    let facts = source.facts(options.grid, options.layer, options.limits()).await?;
    let proposed = || Zooms::new(facts.min_zoom, facts.max_zoom.min(Zooms::DEEPEST));
    let zooms = options.zooms.or_else(proposed).ok_or(ArchiveError::Deep)?;
    let mut count = Count::default();
    for zoom in zooms.first()..=zooms.last() {
        if !count.add(source, &options, zoom).await? {
            return Err(count.too_many(source, &options, &facts, zooms, zoom).await?);
        }
    }
    let (needed, allowed) = (count.tiles * ArchivePlan::DIRECTORY, options.directory_memory);
    if needed > allowed {
        let tiles = count.tiles;
        return Err(ArchiveError::Memory { tiles, needed, allowed });
    }
    Ok(ArchivePlan {
        tiles: count.tiles,
        options,
        facts,
        zooms,
    })
}

/// The map tiles that were counted.
#[derive(Default)]
struct Count {
    tiles: u64,
    /// Those of the last zoom.
    of_zoom: u64,
    /// Those of the zoom before.
    of_zoom_before: Option<u64>,
    /// Some tiles of the last zoom, each `step`th.
    some: Vec<TileCoord>,
    step: u64,
}

impl Count {
    /// Counts the tiles of a zoom. Returns false if there are too many.
    async fn add(&mut self, source: &MapSource, options: &ArchiveOptions, zoom: u8) -> Result<bool, ArchiveError> {
        self.of_zoom_before = (self.tiles > 0).then_some(self.of_zoom);
        self.of_zoom = 0;
        self.some.clear();
        self.step = 1;
        let mut descent = Descent::new(source, options.grid, options.layer, zoom);
        while let Some(at) = descent.next().await? {
            if self.of_zoom.is_multiple_of(self.step) {
                self.sample(at);
            }
            self.of_zoom += 1;
            self.tiles += 1;
            if self.tiles > options.max_tiles {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn sample(&mut self, at: TileCoord) {
        self.some.push(at);
        if self.some.len() == 2 * SAMPLES {
            let mut number = 0;
            self.some.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.step *= 2;
        }
    }

    /// Estimates the tiles of all zooms, of which `zoom` had too many.
    async fn too_many(
        self,
        source: &MapSource,
        options: &ArchiveOptions,
        facts: &LayerFacts,
        zooms: Zooms,
        zoom: u8,
    ) -> Result<ArchiveError, ArchiveError> {
        let mut bytes = 0;
        for at in &self.some {
            bytes += draw(source, options, facts.min_zoom, *at).await?.1.len();
        }
        // A zoom has up to four times the tiles of the one before.
        let of_zoom = self.of_zoom.max(self.of_zoom_before.map_or(0, |before| 4 * before));
        let deeper = (zoom..=zooms.last()).scan(of_zoom as f64, |tiles, _| {
            let these = *tiles;
            *tiles *= 4.0;
            Some(these)
        });
        let tiles = (self.tiles - self.of_zoom) as f64 + deeper.sum::<f64>();
        let size = bytes as f64 / self.some.len().max(1) as f64;
        Ok(ArchiveError::TooMany(Box::new(TooMany {
            zooms,
            tiles: tiles as u64,
            bytes: (tiles * size) as u64,
            allowed: options.max_tiles,
            fitting: (zoom > zooms.first()).then(|| zoom - 1),
        })))
    }
}
