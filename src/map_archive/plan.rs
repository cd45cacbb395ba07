//! How many map tiles an archive will have, before any is drawn.

use crate::map_archive::descent::Descent;
use crate::map_archive::drawing::draw;
use crate::map_archive::error::{ArchiveError, TooMany};
use crate::map_archive::options::{ArchiveOptions, Zooms};
use crate::map_tiles::{LayerFacts, MapSource, TileCoord};

/// The number of map tiles that are drawn to estimate how large all are.
const SAMPLES: usize = 16;
/// The number of map tiles of a zoom from which on their growth is that of deeper zooms, or less.
const TYPICAL: u64 = 512;

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
        let fits = count.add(source, &options, zoom).await?;
        if !fits || count.is_hopeless(zooms.last() - zoom, options.max_tiles) {
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
    of_zoom_before: u64,
    /// Some tiles of the last zoom, each `step`th.
    some: Vec<TileCoord>,
    step: u64,
}

impl Count {
    /// Counts the tiles of a zoom. Returns false if there are too many; then the rest of them is estimated.
    async fn add(&mut self, source: &MapSource, options: &ArchiveOptions, zoom: u8) -> Result<bool, ArchiveError> {
        let expected = (self.of_zoom as f64 * self.growth()) as u64;
        self.of_zoom_before = self.of_zoom;
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
                let left = expected.saturating_sub(self.of_zoom);
                self.of_zoom += left;
                self.tiles += left;
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

    /// Returns how many times the tiles of a zoom the next one has, at least. The area of a file is convex,
    /// so the number of its tiles grows ever faster from zoom to zoom, up to four times.
    fn growth(&self) -> f64 {
        match self.of_zoom_before {
            0 => 1.0,
            before => (self.of_zoom as f64 / before as f64).clamp(1.0, 4.0),
        }
    }

    /// Returns about how many tiles there are with so many more zooms.
    fn expected(&self, zooms: u8) -> f64 {
        let growth = self.growth();
        let deeper = (1..=i32::from(zooms)).map(|zoom| self.of_zoom as f64 * growth.powi(zoom));
        self.tiles as f64 + deeper.sum::<f64>()
    }

    /// Returns whether there are by far too many tiles with so many more zooms. Counting them would
    /// take long.
    fn is_hopeless(&self, zooms: u8, allowed: u64) -> bool {
        self.of_zoom >= TYPICAL && self.expected(zooms) > 2.0 * allowed as f64
    }

    /// Returns the error of too many tiles, found at `zoom`.
    async fn too_many(
        &self,
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
        let tiles = self.expected(zooms.last() - zoom);
        let size = bytes as f64 / self.some.len().max(1) as f64;
        Ok(ArchiveError::TooMany(Box::new(TooMany {
            zooms,
            tiles: tiles as u64,
            bytes: (tiles * size) as u64,
            allowed: options.max_tiles,
            fitting: self.fitting(options, zooms, zoom),
        })))
    }

    /// Returns the last zoom down to which there are not too many tiles, if they were counted.
    fn fitting(&self, options: &ArchiveOptions, zooms: Zooms, zoom: u8) -> Option<u8> {
        if self.tiles > options.max_tiles {
            return (zoom > zooms.first()).then(|| zoom - 1);
        }
        let fits = |more: &u8| self.expected(*more) <= options.max_tiles as f64;
        (0..=zooms.last() - zoom)
            .take_while(fits)
            .last()
            .map(|more| zoom + more)
    }
}
